#!/usr/bin/python3 -B
"""What ./tern says of a run whose files were cut short or changed: one sentence with the file, what is wrong in it, and what to do."""

import contextlib
import io
import json
import tempfile
import unittest
from pathlib import Path

import made_up_run

from tern import command_line
from tern.errors import BAD_INPUT
from tern.launch import epilogue

REMEDY = "It was cut short or changed: restore it from a copy, or run the case again."


class DamagedResultsTest(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory(prefix="tern-test-")
        self.addCleanup(directory.cleanup)
        self.run_directory = Path(directory.name)
        made_up_run.write_sides(self.run_directory)
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


if __name__ == "__main__":
    unittest.main()
