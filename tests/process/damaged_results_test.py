#!/usr/bin/python3 -B
"""What ./tern says of a run whose files were cut short or changed: one sentence with the file, what is wrong in it, and what to do."""

import contextlib
import io
import json
import tempfile
import unittest
from pathlib import Path

import made_up_run

import tern
from tern import command_line
from tern.errors import BAD_INPUT
from tern.launch import epilogue
from tern.results import summary
from tern.verify import bands, expected

REMEDY = "It was cut short or changed: restore it from a copy, or run the case again."


class DamagedResultsTest(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory(prefix="tern-test-")
        self.addCleanup(directory.cleanup)
        self.run_directory = Path(directory.name)
        made_up_run.write_tables(self.run_directory)
        made_up_run.write_case(self.run_directory)
        self.path = self.run_directory / "run.json"

    def tern(self, command):
        """Exit code and what is said on standard error."""
        errors = io.StringIO()
        with contextlib.redirect_stderr(errors), contextlib.redirect_stdout(io.StringIO()):
            code = command_line.main([command, str(self.run_directory)])
        return code, errors.getvalue()

    def assert_refused(self, command, sentence):
        code, errors = self.tern(command)
        self.assertEqual((code, errors), (BAD_INPUT, f"tern: {sentence}\n"), command)

    def changed(self, **entries):
        """run.json as text, with these entries in place of its own."""
        made_up_run.write_case(self.run_directory, **entries)
        return self.path.read_text()

    # Seen to fail: with what json.loads() gives taken as it is (an AttributeError, KeyError, TypeError or ValueError of each command).
    def test_a_damaged_run_json_is_refused_by_every_command_that_reads_it(self):
        whole = self.path.read_text()
        for text, said in (("[]", ": it is a list, not a table."), ("null", ": it is null, not a table."), ("{}", ": there is no status."),
                           (whole[:40], " is no JSON: Unterminated string starting at: line 1 column 34 (char 33)."),
                           ("", " is no JSON: Expecting value: line 1 column 1 (char 0)."),
                           (whole.replace("3.0", "9" * 400, 1), ": wall_s is a number of too many digits, not a number."),
                           (self.changed(settings=[]), ": settings is a list, not a table."),
                           (self.changed(processes={"fluid": {"timing_s": {"wait": "long"}}}),
                            ': processes.fluid.timing_s.wait is "long", not a number.'),
                           (self.changed(steps=None), ": steps is null, not a number."),
                           (self.changed(started="yesterday"), ': started is "yesterday", not a date with a time.')):
            self.path.write_text(text)
            for command in ("report", "status", "plot", "resume"):
                self.assert_refused(command, f"{self.path}{said} {REMEDY}")

    # Seen to fail: with errors of bytes told as those of the disk, and without RecursionError (a traceback).
    def test_what_is_no_text_and_what_is_too_deep_is_refused(self):
        for content in (b"\xff\xfe{}", b"[" * 100000):
            self.path.write_bytes(content)
            code, errors = self.tern("status")
            self.assertEqual(code, BAD_INPUT)
            self.assertRegex(errors, rf"^tern: {self.path} is no JSON: .*{REMEDY}\n$")

    # Seen to fail: without demand() (a KeyError).
    def test_what_a_command_needs_has_to_be_there(self):
        self.changed(status="running")
        self.assert_refused("status", f"{self.path}: there is no started. {REMEDY}")
        self.changed(launch={"only": "fluid"}, commands={}, options=[])
        self.assert_refused("resume", f"{self.path}: there is no case_hash. {REMEDY}")

    # Seen to fail: with what json.loads() gives taken as it is (an AttributeError; nobody hears the guardian).
    def test_the_guardian_of_a_killed_launcher_leaves_a_damaged_run_json_alone(self):
        for text in ("[]", "null", json.dumps({"status": "running", "launcher": 999999999, "spent": 3})):
            self.path.write_text(text)
            epilogue.close(self.run_directory)
            self.assertEqual(self.path.read_text(), text)

    def damage(self, name, content):
        """Puts this in place of a table, and gives its path."""
        made_up_run.write_tables(self.run_directory)
        path = self.run_directory / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    # Seen to fail: with read_cells() and read_table() as they were (a ValueError), and without `needed` in Table (a KeyError).
    def test_a_damaged_table_is_refused_with_line_column_and_value(self):
        line, counts = "Restore the file from a copy, or correct that line.", ", line 3: it has 2 cells, and there are 3 columns."
        columns = "It was changed: restore it from a copy, or run the case again."
        for name, content, said in (
                ("gauges.csv", "t_s,P.ux_m\n0,0\n# word\n\n0.1,none\n0.2,1\n", f", line 5, column P.ux_m: 'none' is no number. {line}"),
                ("gauges.csv", b"t_s,P.ux_m\n0,0\n0.1,\xff\x00\n0.2,1\n", rf", line 3, column P.ux_m: '\ufffd\x00' is no number. {line}"),
                ("gauges.csv", "t_s,P.ux_m,front_m\n0,0,0\n0.1,0.\n0.2,1,0\n", f"{counts} {line}"),
                ("gauges.csv", "0,0\n0.1,0.01\n", f": its first line, which has the names of the columns, lacks t_s. {columns}"),
                ("gauges.csv", b"t_s,P.\x00_m\n0,0\n", rf", line 1: the name of column 2, 'P.\x00_m', is no text. {columns}"),
                ("gauges.csv", 't_s,P.ux_m\n0,"0\n0.1,0\n0.2,0', f", line 2, column P.ux_m: '0\\n0.1,0\\n0.2,0' is no number. {line}"),
                ("energy.csv", "t_s,fluid_kinetic_J\n0,1\nlate,2\n", f", line 3, column t_s: 'late' is no number. {line}"),
                ("energy.csv", "fluid_kinetic_J\n0\n1\n", f": its first line, which has the names of the columns, lacks t_s. {columns}"),
                ("steps.csv", "t_s,dt_s,limit\n0.1,long,gravity\n0.2,0.1,gravity\n", f", line 2, column dt_s: 'long' is no number. {line}"),
                ("steps.csv", "t_s,limit\n0.1,gravity\n0.2,gravity\n",
                 f": its first line, which has the names of the columns, lacks dt_s. {columns}"),
                ("steps.csv", 't_s,dt_s,limit\n0.1,0.1,"' + "x" * 200_000 + "\n",
                 f", line 2: field larger than field limit (131072). {line}")):
            path = self.damage(name, content)
            for command in ("report", "plot"):
                self.assert_refused(command, f"{path}{said}")

    # Seen to fail: with the last line of the right length taken as it is (a ValueError of "1e-").
    def test_a_last_line_that_was_cut_short_is_left_out(self):
        for last, rows in (("0.2,", 2), ("0.2,0.03,1e-", 2), ("0.2,0.03,-", 2), ("0.2,0.03,0.1", 3), ('0.2,"', 2)):
            self.damage("gauges.csv", "t_s,P.ux_m,front_m\n0,0,1\n0.1,1,1\n" + last)
            self.assertEqual(len(tern.Run(self.run_directory).gauges["t_s"]), rows, last)
        for content in ("", "t_s,dt"):
            self.damage("steps.csv", content)
            self.assertEqual(len(tern.Run(self.run_directory).steps.get("dt_s", [])), 0)
        self.assertEqual(self.tern("report"), (0, ""))

    # Seen to fail: with UnreadableRun not caught in series.read() and _energies().
    def test_a_quantity_of_a_damaged_table_fails_and_the_end_of_a_run_is_told(self):
        path = self.damage("gauges.csv", "t_s,P.ux_m\n0,0\n0.1,nothing\n0.2,1\n")
        rows = bands.judge(self.run_directory, expected.read(self.run_directory / "expected.toml"))
        self.assertIn(f"{path}, line 3, column P.ux_m: 'nothing' is no number", rows[0]["why"])
        self.damage("energy.csv", "t_s,interface_work_on_structure_J,interface_staggering_J\n0,0,0\n0.1,much,0\n")
        contents = json.loads(self.changed(processes={"coupler": {"exit_code": 0}}))
        self.assertIn("made_up: done", summary.text(contents, self.run_directory))


if __name__ == "__main__":
    unittest.main()
