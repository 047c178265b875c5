"""Documents and sources can be read: short lines, and links, paths and commands that exist."""

import os
import pathlib
import re
import subprocess
import unittest

ROOT = pathlib.Path(os.environ.get("TERN_SOURCE") or pathlib.Path(__file__).resolve().parents[2])
LONGEST_LINE = 140

# Folders that are no part of the sources: builds, results, and what tools leave behind.
LEFT_OUT = {".git", "build", "runs", "__pycache__", ".pytest_cache", ".cache"}
SOURCES = {".md", ".cpp", ".hpp", ".py", ".proto", ".cmake"}

# Tables that a program writes: rows have the width of what they say. {document: marker of the tables in it; "" for all of its tables}
GENERATED = {
    "docs/PARAMETERS.md": "",  # tern-case parameters
    "docs/TRADE.md": "",  # ./tern study --write-docs
    "docs/STABILITY.md": "extremes",  # ./tern extremes --page
    "README.md": "trade",  # ./tern study --write-docs
}

LINK = re.compile(r"\[[^\][]*\]\(([^()\s]+)\)")
CODE = re.compile(r"(?<!`)`([^`]+)`(?!`)")
FENCE = re.compile(r"^```.*?^```", re.M | re.S)
# In backticks: a path with folders, or the name of a source file.
PATH = re.compile(r"(?:[\w-]+/)*[\w-]+\.(?:cpp|hpp|py|md|proto|cmake|toml|txt)|(?:[\w-]+/)+|"
                  r"(?:bench|cases|docs|proto|python|tests)/[\w./-]+")
IN_COMMENT = re.compile(r"(?<![\w/.<$}-])((?:[\w-]+/)*[\w-]+\.(?:cpp|hpp|py|md|proto|cmake))(?![\w/*])")
# Made by a build or a run, given by a user, or part of another program.
NOT_OURS = re.compile(r"^(build|runs|plots|my_)|_pb2\.py$|^tern/_installed\.py$|^study\.md$")


def tree():
    """All files of the sources, relative to the root."""
    files = []
    for folder, folders, names in os.walk(ROOT):
        folders[:] = sorted(f for f in folders if f not in LEFT_OUT and not f.startswith("build"))
        files += [pathlib.Path(folder, name).relative_to(ROOT) for name in names]
    return sorted(files)


FILES = tree()
DOCUMENTS = [f for f in FILES if f.suffix == ".md"]
NAMES = {f.name for f in FILES}
FOLDERS = {"/" + str(f.parent) + "/" for f in FILES}


def text(file):
    return (ROOT / file).read_text(encoding="utf-8")


def exists(path, document):
    """A path from the root or from the document; a name or a folder without its parents may be anywhere in the tree."""
    if (ROOT / path).exists() or (ROOT / document.parent / path).exists():
        return True
    if path.endswith("/"):
        return any(("/" + path) in folder for folder in FOLDERS)
    if "/" in path:
        return any(str(file).endswith("/" + path) for file in FILES)
    return path in NAMES


def comments(file):
    """The comments of a C++ file; of a Python file comments and docstrings."""
    source = text(file)
    if file.suffix == ".py":
        return "\n".join(re.findall(r'"""(.*?)"""', source, re.S) + re.findall(r"#(.*)", source))
    return "\n".join(re.findall(r"//(.*)", source))


def commands(document):
    """The first word after ./tern, wherever a document shows a command."""
    return set(re.findall(r"\./tern ([a-z]\w*)", text(document)))


class Documents(unittest.TestCase):
    def test_no_line_is_longer_than_a_screen_is_wide(self):
        # Seen to fail: with a sentence of THEORY on one line; with a comment of 150 characters; with a wide table outside the markers.
        wide = []
        for file in FILES:
            if file.suffix not in SOURCES and file.name != "CMakeLists.txt":
                continue
            marker, inside = GENERATED.get(str(file)), False
            for number, line in enumerate(text(file).split("\n"), 1):
                if marker and line.startswith(f"<!-- {marker}: "):
                    inside = not inside
                if len(line) <= LONGEST_LINE or (line.startswith("|") and (marker == "" or inside)):
                    continue
                wide.append(f"{file}:{number}: {len(line)} characters")
        self.assertFalse(wide, f"longer than {LONGEST_LINE}:\n" + "\n".join(wide))

    def test_every_link_of_a_document_leads_somewhere(self):
        # Seen to fail: with a link to docs/THEORIE.md; with a picture that was moved.
        broken = []
        for document in DOCUMENTS:
            for target in LINK.findall(FENCE.sub("", text(document))):
                target = target.split("#")[0]
                # What is in docs/trade becomes part of docs/TRADE.md.
                folder = document.parent.parent if document.parent.name == "trade" else document.parent
                if target and ":" not in target and not (ROOT / folder / target).exists():
                    broken.append(f"{document}: {target}")
        self.assertFalse(broken, "\n".join(broken))

    def test_every_path_that_a_document_names_exists(self):
        # Seen to fail: with `fluid/sealed.cpp`, which is called something else now; with the name of a folder of before.
        missing = []
        for document in DOCUMENTS:
            for code in CODE.findall(FENCE.sub("", text(document))):
                word = code.split(" ")[0] if code.startswith("cases/") else code
                if PATH.fullmatch(word) and not NOT_OURS.search(word) and not exists(word, document):
                    missing.append(f"{document}: `{word}`")
        self.assertFalse(missing, "\n".join(missing))

    def test_every_path_that_a_comment_names_exists(self):
        # Seen to fail: with particles/convex_corner.hpp in a comment of a test.
        missing = []
        for file in FILES:
            if file.suffix not in (".cpp", ".hpp", ".py") or file.name == pathlib.Path(__file__).name:
                continue
            for path in IN_COMMENT.findall(comments(file)):
                if not NOT_OURS.search(path) and not exists(path, file):
                    missing.append(f"{file}: {path}")
        self.assertFalse(missing, "\n".join(missing))

    def test_every_command_of_the_documents_is_one_of_terns(self):
        # Seen to fail: with ./tern runs in the README.
        offered = subprocess.run([ROOT / "tern", "--help"], capture_output=True, text=True, check=True).stdout
        offered = set(re.findall(r"^\s+([a-z]\w*)\b", offered, re.M)) | set(re.split(r"[{},]", "".join(re.findall(r"\{[^}]*\}", offered))))
        self.assertIn("./tern run", text(pathlib.Path("README.md")))
        for document in DOCUMENTS:
            with self.subTest(document=str(document)):
                self.assertFalse(commands(document) - offered)


if __name__ == "__main__":
    unittest.main()
