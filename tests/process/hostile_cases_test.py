#!/usr/bin/python3 -B
"""tern-case check and explain answer any case file, also absurd ones: soon, in little memory, with exit code 0 or with 2 and one sentence.

TERN_MUTANTS=5000 tests more mutants than the default suite does, TERN_SEED=N those of an earlier run; the seed is printed.
"""

import os
import random
import re
import resource
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

from fake_build import ROOT
from real_run import build_directory

CASES = sorted((ROOT / "cases").glob("*/case.toml"))
MUTANTS = int(os.environ.get("TERN_MUTANTS", "150"))
MEMORY = 500 << 20  # of address space
SECONDS = 2         # of CPU time; on the clock ten times as much, because the machine may be busy

NUMBER = re.compile(r"(?<![\w.\"])[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?(?![\w.\"])")
TEXT = re.compile(r"\"[^\"\n]*\"")
ABSURD_NUMBERS = ("0", "-1", "1", "1e-300", "1e300", "-1e300", "1e9", "-1e9", "1e6", "1e5", "1e-6", "nan", "inf", "-inf", "9223372036854775807",
                  "99999999999999999999", "0.5", "1e-12", "3", "100")
ABSURD_TEXTS = ('""', '"x"', '"\\u0000"', '"\\n\\u001b[31m"', '"' + "a" * 3000 + '"', '"../../../etc/passwd"', '"/dev/zero"', '"1/0"', '"1/t"',
                '"1e300*t"', '"1/x"', '"x+"', '"t=1"', '"0*sqrt(x-0.3)"', '"y_max"', '"1,2"', '"exp(1000*x)"', '"(((((((("', '"nan"', '"ü€"')
OTHER_TYPES = ("true", '"text"', "7", "0.25", "[]", "[[]]", "{}", "1979-05-27", "[1, 2]", "[0, 0, 0, 0]", "{ box = {} }", '["", ""]')
# A number in what a program prints: not in a word, and not in a name or text of the case.
NOT_A_NUMBER = re.compile(r"(?<![\w'\"])[-+]?(?:nan|inf)(?![\w'\"])", re.IGNORECASE)


def replace_one(pattern, text, values, choose):
    places = list(pattern.finditer(text))
    if not places:
        return text
    place = choose.choice(places)
    return text[:place.start()] + choose.choice(values) + text[place.end():]


def mutant(text, choose):
    """The text with one to three things changed in it, mostly one."""
    for _ in range(choose.choice((1, 1, 1, 2, 3))):
        lines = text.splitlines(keepends=True)
        keys = [n for n, line in enumerate(lines) if re.match(r"\w+ *=", line)]
        heads = [n for n, line in enumerate(lines) if line.startswith("[")]
        kind = choose.choice(("number",) * 8 + ("scaled", "scaled", "text", "text", "type", "remove", "double", "table", "move", "letter"))
        if kind == "number":
            text = replace_one(NUMBER, text, ABSURD_NUMBERS, choose)
        elif kind == "scaled":
            place = choose.choice(list(NUMBER.finditer(text)))
            scaled = f"{float(place.group()) * choose.choice((-1, 1e-6, 1e-3, 0.1, 10, 1e3, 1e6)):g}"
            text = text[:place.start()] + scaled + text[place.end():]
        elif kind == "text":
            text = replace_one(TEXT, text, ABSURD_TEXTS, choose)
        elif kind == "type" and keys:
            n = choose.choice(keys)
            lines[n] = lines[n].split("=")[0] + "= " + choose.choice(OTHER_TYPES) + "\n"
            text = "".join(lines)
        elif kind == "remove" and keys:
            del lines[choose.choice(keys)]
            text = "".join(lines)
        elif kind == "double" and keys:
            n = choose.choice(keys)
            text = "".join(lines[:n + 1] + lines[n:])
        elif kind in ("table", "move") and heads:
            begin = choose.choice(heads)
            end = next((n for n in heads if n > begin), len(lines))
            table, rest = lines[begin:end], lines[:begin] + lines[end:]
            text = "".join(rest if kind == "table" else rest + table + table * choose.choice((0, 1)))
        elif kind == "letter":
            n = choose.randrange(len(text))
            text = text[:n] + choose.choice("[]{}=\",.#-\\ \n\t\x01é0") + text[n + choose.choice((0, 1)):]
    return text


class HostileCases(unittest.TestCase):
    def setUp(self):
        self.program = build_directory() / "tern-case"
        folder = tempfile.TemporaryDirectory(prefix="tern-test-")
        self.addCleanup(folder.cleanup)
        self.path = Path(folder.name) / "case.toml"
        # The sanitizers reserve more address space than any limit, and take their time.
        self.limited = b"__asan_init" not in self.program.read_bytes()
        self.largest = {"memory": (0, ""), "time": (0, "")}

    def run_limited(self, *words):
        def limit():
            resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
            resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 1))
        process = subprocess.Popen([self.program, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL,
                                   preexec_fn=limit if self.limited else None)
        try:
            output, errors = process.communicate(timeout=10 * SECONDS)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            return None, "", "no answer"
        return process.returncode, output.decode(), errors.decode(errors="replace")

    def judge(self, text, *words, command="check"):
        """What is wrong with the answer to this case; empty if nothing is."""
        self.path.write_text(text)
        before = time.monotonic()
        code, output, errors = self.run_limited(command, self.path, *words)
        took = time.monotonic() - before
        self.largest["time"] = max(self.largest["time"], (took, errors or output.partition("\n")[0]))
        if code == 0:
            found = NOT_A_NUMBER.search("\n".join(line for line in output.splitlines() if not line.startswith("* The")))
            return f"prints {found.group()}: {output}" if found else f"says {errors}" if errors else ""
        if code != 2:
            return f"exit code {code}: {errors}"
        if output or errors.count("\n") != 1 or not errors.endswith("\n") or any(ord(c) < 32 for c in errors[:-1]) or len(errors) > 2500:
            return f"not one sentence: {output!r} {errors!r}"
        return ""

    def expect_refused(self, text, *parts):
        for command in ("check", "explain"):
            self.assertEqual(self.judge(text, command=command), "")
            code, _, errors = self.run_limited(command, self.path)
            self.assertEqual(code, 2)
            for part in parts:
                self.assertIn(part, errors)

    @staticmethod
    def changed(name, old, new):
        text = (ROOT / "cases" / name / "case.toml").read_text()
        assert old in text, (name, old)
        return text.replace(old, new, 1)

    def test_mutants_of_all_cases(self):
        seed = int(os.environ.get("TERN_SEED", random.randrange(1 << 31)))
        print(f"seed {seed}, {MUTANTS} mutants", flush=True)
        choose = random.Random(seed)
        faults = 0
        for number in range(MUTANTS):
            case = choose.choice(CASES)
            text = mutant(case.read_text(), choose)
            command, words = choose.choice(("check", "explain")), choose.choice(((), (), (), ("--preset", "draft"), ("--preset", "reference")))
            fault = self.judge(text, *words, command=command)
            if fault:
                faults += 1
                kept = Path(os.environ.get("TERN_MUTANTS_KEPT", tempfile.gettempdir())) / f"tern-mutant-{seed}-{number}.toml"
                kept.write_text(text)
                print(f"{case.parent.name} {command} {' '.join(words)} {kept}: {fault[:600]}", flush=True)
        memory = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
        print(f"most memory {memory:.0f} MB, longest {self.largest['time'][0]:.2f} s: {self.largest['time'][1].strip()[:300]}", flush=True)
        self.assertEqual(faults, 0, f"seed {seed}")


if __name__ == "__main__":
    unittest.main()
