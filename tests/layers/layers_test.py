"""The rooms of docs/ARCHITECTURE.md see what they may see, and nothing else.

A room is a CMake target; its include directories lead to its own headers and to those of the rooms it needs (cmake/rooms.cmake). In each
room the preprocessor is asked for every header of the tree: it must find those of the rooms in reach, and no others. What lies in one
directory of the system for all (ZeroMQ, Protobuf, HDF5, CLI11) is found by reading the includes.

Environment: TERN_ROOMS, a file of lines "room<TAB>directory;...<TAB>include directory;..." written by CMake; TERN_SOURCE, TERN_COMPILER.
"""

import os
import re
import subprocess
import unittest
from pathlib import Path

SOURCE = Path(os.environ["TERN_SOURCE"])
ROOMS = Path(os.environ["TERN_ROOMS"])
COMPILER = os.environ.get("TERN_COMPILER", "c++")

NUMERICS = ("fluid", "structure", "coupler")
# What a room needs by itself; the rooms in reach follow from it. The house as it is meant to be, not read from CMake.
NEEDS = {
    "base": (),
    "sph": ("base",),
    "material": ("base",),  # the laws alone: the case file takes their names from them
    "scene": ("base", "material"),
    "run": ("base", "scene"),
    "interface": ("base",),
    "meeting": ("scene", "interface"),
    "wire": ("interface", "scene"),
    "transport": ("wire",),
    "participant": ("transport", "run"),
    "ranks": ("base",),
    "fluid": ("sph", "scene", "interface", "ranks"),
    **{numerics: ("sph", "scene", "interface", "meeting") for numerics in ("structure", "coupler")},
    **{f"{numerics}_process": (numerics, "participant") for numerics in NUMERICS},
    "fixtures": (),  # of the tests
}
FOREIGN = re.compile(r"^\s*#\s*include\s*[<\"]((?:zmq|google/protobuf|hdf5|H5|CLI/)[^>\"]*|[^>\"]*\.pb\.h)[>\"]")
QUOTED = re.compile(r"^\s*#\s*include\s*\"([^\"]+)\"")


def reach(room):
    """`room` and every room below it."""
    found = {room}
    for below in NEEDS[room]:
        found |= reach(below)
    return found


def rooms():
    """Room -> (its directories, include directories of its target)."""
    table = {}
    for line in ROOMS.read_text(encoding="utf-8").splitlines():
        room, *lists = line.split("\t")
        table[room] = tuple([word for word in dict.fromkeys(one.split(";")) if word] for one in lists)
    return table


def headers(directories):
    """The headers directly in `directories`, as they are included."""
    return sorted(f"{directory}/{path.name}" for directory in directories for path in (SOURCE / directory).glob("*.hpp"))


def seen(directories, names):
    """Those of the headers `names` that the compiler finds in `directories`."""
    page = "".join(f'#if __has_include("{name}")\nseen {name}\n#endif\n' for name in names)
    options = [word for directory in directories for word in ("-I", directory)]
    answer = subprocess.run([COMPILER, "-std=c++20", "-E", "-P", "-x", "c++", *options, "-"], input=page, stdout=subprocess.PIPE,
                            cwd="/", text=True, check=True)
    return {line.split()[1] for line in answer.stdout.splitlines() if line.startswith("seen ")}


class Layers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.rooms = rooms()

    def test_every_room_of_the_build_stands_in_the_table_of_this_test(self):
        self.assertEqual(set(self.rooms), set(NEEDS))

    def test_a_room_finds_the_headers_of_the_rooms_in_reach_and_no_others(self):
        everything = [header for own, _ in self.rooms.values() for header in headers(own)]
        self.assertGreater(len(everything), 50)
        for room, (_, directories) in self.rooms.items():
            allowed = {header for other in reach(room) for header in headers(self.rooms[other][0])}
            with self.subTest(room=room):
                found = seen(directories, everything)
                self.assertEqual(sorted(found - allowed), [], "headers of rooms out of reach")
                self.assertEqual(sorted(allowed - found), [], "headers of rooms in reach that are not found")

    def test_a_file_names_headers_from_the_root_and_of_rooms_in_reach_only(self):
        # A file may otherwise reach its neighbours on disk ("process/output.hpp", "../run/progress.hpp") past the include directories.
        for room in sorted(set(NEEDS) - {"fixtures"}):  # whose readers choose the rooms
            known = {header for other in reach(room) for header in headers(self.rooms[other][0])}
            for path, line, text in self.lines(room):
                quoted = QUOTED.match(text)
                if quoted and not quoted[1].endswith(".pb.h") and quoted[1] != "base/version.hpp":
                    with self.subTest(file=path, line=line):
                        self.assertIn(quoted[1], known)

    def test_base_sph_scene_and_the_numerics_include_no_sockets_no_messages_no_files_of_hdf5_and_no_command_line(self):
        for room in ("base", "sph", "scene", "interface", *NUMERICS):
            for path, line, text in self.lines(room):
                with self.subTest(file=path, line=line):
                    self.assertIsNone(FOREIGN.match(text), text.strip())

    def lines(self, room):
        """(file, line number, line) of the includes in all files of `room`."""
        paths = [path for folder in self.rooms[room][0] for path in sorted((SOURCE / folder).glob("*.[ch]pp"))]
        self.assertGreater(len(paths), 0, f"no file of {room} was read")
        for path in paths:
            for number, text in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
                if "include" in text:
                    yield path.relative_to(SOURCE), number, text


if __name__ == "__main__":
    unittest.main()
