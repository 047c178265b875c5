#!/usr/bin/python3 -B
"""What may import what in python/tern, read from the sources: the layers of its docstring, no circle, no search path made by hand."""

import ast
import re
import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "python" / "tern"
EVERYTHING = {"errors", "paths", "expression", "scale_model", "results", "participant", "launch", "verify", "plot", "studies",
              "extremes", "report"}
ALLOWED = {
    "errors": set(),
    "paths": {"errors"},
    "expression": {"errors"},
    "scale_model": {"errors"},
    "results": {"errors"},
    "participant": {"errors", "paths", "expression", "results"},
    "launch": {"errors", "paths", "results", "participant"},
    "verify": {"errors", "expression", "results", "launch"},
    "plot": {"errors", "results"},
    "studies": {"errors", "paths", "results", "launch", "verify", "plot"},
    "extremes": {"errors", "paths", "results", "launch"},
    "report": {"errors", "paths", "results", "verify", "plot"},
    "command_line": EVERYTHING,
    "api": EVERYTHING,
    "": EVERYTHING,          # tern/__init__.py
    "__main__": {"command_line"},
    "start": {"command_line"},
}
PLAIN = {"errors", "paths", "expression", "scale_model", "results", "launch", "verify", "api", "command_line", "__main__", "start", ""}


def name_of(path):
    """`tern.launch.run` of tern/launch/run.py, `tern.launch` of its __init__.py."""
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def part_of(module):
    return (module.split(".") + [""])[1]


MODULES = {name_of(path): path for path in PACKAGE.rglob("*.py")}


def imports(tree):
    """{module}: what a tree imports, `from tern.launch import run` as tern.launch.run where that is a module."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            for alias in node.names:
                whole = f"{node.module}.{alias.name}"
                found.add(whole if whole in MODULES else node.module)
    return found


def at_import(path):
    """What is imported when the module is: not what stands inside a function."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            node.body = []
    return imports(tree)


def anywhere(path):
    return imports(ast.parse(path.read_text(encoding="utf-8")))


def own(modules):
    return {module for module in modules if module == "tern" or module.startswith("tern.")}


class LayersTest(unittest.TestCase):
    # Seen to fail: with `from tern.plot import style` in results/run.py, also inside a function.
    def test_a_part_imports_only_what_stands_above_it(self):
        for module, path in MODULES.items():
            part = part_of(module)
            wrong = {other for other in own(anywhere(path)) if part_of(other) not in ALLOWED[part] | {part}}
            self.assertEqual(wrong, set(), f"imported by {module}")

    # Seen to fail: with `from tern.studies import report` in studies/front.py.
    def test_there_is_no_circle(self):
        graph = {module: own(anywhere(path)) & set(MODULES) for module, path in MODULES.items()}
        while ends := [module for module, others in graph.items() if not others]:
            for module in ends:
                del graph[module]
            graph = {module: others - set(ends) for module, others in graph.items()}
        self.assertEqual(graph, {})

    # Seen to fail: with `import numpy` at the head of results/tables.py.
    def test_a_run_needs_the_standard_library_only(self):
        for module, path in MODULES.items():
            if part_of(module) in PLAIN:
                foreign = {name.split(".")[0] for name in at_import(path)} - sys.stdlib_module_names - {"tern"}
                self.assertEqual(foreign, set(), f"imported by {module}")

    # Seen to fail: with `from tern.plot import pictures` at the head of command_line.py.
    def test_the_command_line_imports_no_part_that_needs_more(self):
        seen, rest = set(), {"tern.command_line"}
        while rest:
            module = rest.pop()
            seen.add(module)
            rest |= own(at_import(MODULES[module])) & set(MODULES) - seen
        self.assertEqual({part_of(module) for module in seen} - PLAIN, set())

    # Seen to fail: with such a line in bench/soak.py.
    def test_nobody_makes_a_search_path_by_hand(self):
        by_hand = re.compile(r"\bsys\s*\.\s*path\b|\bfrom sys import\b.*\bpath\b")
        for folder in ("python", "tests", "bench", "cases"):
            for path in (ROOT / folder).rglob("*.py"):
                if path != Path(__file__).resolve() and by_hand.search(path.read_text(encoding="utf-8")):
                    self.fail(f"{path} changes the search path: PYTHONPATH is set by who starts it (docs/ARCHITECTURE.md)")

    # Seen to fail: with a row of ALLOWED changed.
    def test_the_docstring_says_the_same(self):
        text = ast.get_docstring(ast.parse((PACKAGE / "__init__.py").read_text(encoding="utf-8")))
        rows = {row[0]: set(row[1].split(", ")) for row in re.findall(r"^    (\w+)  +([a-z, ]+)$", text, re.MULTILINE)}
        self.assertEqual(set(rows), EVERYTHING - {"errors", "paths", "expression"})
        for part, names in rows.items():
            self.assertEqual(names, ALLOWED[part], part)


if __name__ == "__main__":
    unittest.main()
