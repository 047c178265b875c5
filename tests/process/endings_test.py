#!/usr/bin/python3 -B
"""However a run ends, run.json says so and why, tables end at a whole line, and nothing temporary stays.

Seen to fail: see each test.
"""

import os
import random
import shutil
import signal
import subprocess
import sys
import time
import unittest
import unittest.mock
from pathlib import Path

from fake_build import ROOT, is_alive, wait_until
from real_run import SCENE, RealRunTest, find_damage
from same_results import differences

CASE = ROOT / "tests" / "process" / "cases" / "splash_plate"
ONE_PASS = ("--set", "coupling.max_iterations=1")  # and one pressure a window, so that messages can be counted


class EndingsTest(RealRunTest):
    def environment(self):
        return os.environ | {"TERN_BUILD": str(self.build), "TMPDIR": str(self.path / "tmp")}

    def pids_of_run(self):
        """Process ids of all that has the results directory among its words, but the guardian."""
        found = []
        for entry in os.listdir("/proc"):
            if entry.isdigit():
                try:
                    words = Path(f"/proc/{entry}/cmdline").read_bytes().decode(errors="replace").split("\0")
                except OSError:
                    continue
                if str(self.out) in words and not words[0].endswith("sh") and is_alive(int(entry)):
                    found.append(int(entry))
        return found

    def guardian(self, launcher):
        for entry in os.listdir("/proc"):
            if entry.isdigit():
                try:
                    parent = int(Path(f"/proc/{entry}/stat").read_text().rsplit(")", 1)[1].split()[1])
                    words = Path(f"/proc/{entry}/cmdline").read_bytes().decode(errors="replace")
                except OSError:
                    continue
                if parent == launcher.pid and "guardian.sh" in words:
                    return int(entry)
        return None

    # Seen to fail: without overwrite_json() ("running", and run.tmp is left).
    def test_a_full_disk_is_told_in_run_json(self):
        where = self.path / "disk"
        where.mkdir()
        script = (f"mount -t tmpfs -o size=700k none {where} && {ROOT}/tern run {SCENE} --out {where}/run --quiet --until 60; "
                  f"cp -r {where}/run {self.out}")
        words = ["unshare", "--mount", "--map-root-user"]
        if subprocess.run([*words, "mount", "-t", "tmpfs", "none", where], stderr=subprocess.DEVNULL, check=False).returncode != 0:
            self.skipTest("no mount namespaces for this user")
        answer = subprocess.run([*words, "sh", "-c", script], env=self.environment(), stderr=subprocess.PIPE, text=True, timeout=120,
                                check=False)
        contents = self.contents()
        self.assertEqual((contents["status"], contents["exit_code"]), ("input/output failure", 5), answer.stderr)
        self.assertIn("No space left on device", contents["first_cause"])
        self.assertEqual(find_damage(self.out), [])

    # Seen to fail: without the guardian's last words ("running" for ever).
    def test_a_killed_launcher_leaves_the_end_in_run_json(self):
        process = self.start("--quiet")
        pids = self.wait_until_running(process)
        os.kill(process.pid, signal.SIGKILL)
        process.communicate(timeout=20)
        self.assertTrue(wait_until(lambda: self.contents()["status"] != "running" and not list(self.out.glob("report.*")), 8))
        contents = self.contents()
        self.assertEqual((contents["status"], contents["exit_code"], contents["first_cause_role"]), ("peer lost", 4, "launcher"))
        self.assertEqual(set(contents["processes"]), {"fluid", "structure", "coupler"})
        self.assertGreater(contents["steps"], 10)
        self.assertEqual(find_damage(self.out), [])
        self.assertFalse(any(is_alive(pid) for pid in pids.values()))
        # All three were told to end at once, and had a checkpoint made.
        self.assertTrue(list((self.out / "checkpoint").glob("manifest.*")))

    # Seen to fail: without end_with_launcher() (they run on).
    def test_without_launcher_and_guardian_the_three_end(self):
        process = self.start("--quiet")
        pids = self.wait_until_running(process)
        guardian = self.guardian(process)
        os.kill(guardian, signal.SIGKILL)
        os.kill(process.pid, signal.SIGKILL)
        process.communicate(timeout=20)
        self.assertTrue(wait_until(lambda: not any(is_alive(pid) for pid in pids.values()), 3))
        for left in (self.path / "tmp").iterdir():  # nobody is there any more to remove the socket's directory
            shutil.rmtree(left)

    # Seen to fail: with Python's own handler while modules are imported (a traceback).
    def test_ctrl_c_in_the_first_third_of_a_second_leaves_no_traceback(self):
        generator = random.Random(1)
        for _ in range(12):
            wait = generator.uniform(0.06, 0.3)
            process = subprocess.Popen([ROOT / "tern", "run", SCENE, "--out", self.out, "--quiet", "--force"], env=self.environment(),
                                       stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True)
            time.sleep(wait)
            process.send_signal(signal.SIGINT)
            errors = process.communicate(timeout=10)[1]
            self.assertNotIn("Traceback", errors, f"after {wait:.3f} s")
            # Before the interpreter's first line nothing can answer: the signal itself ends it, which a shell reports as 130 too.
            self.assertIn(process.returncode, (130, -signal.SIGINT), f"after {wait:.3f} s: {errors}")
            self.assertTrue(wait_until(lambda: not self.pids_of_run(), 3))

    # Seen to fail: with 5 s for the others also where none of them can have noticed.
    def test_a_part_that_is_terminated_is_named_within_two_seconds(self):
        for role in ("fluid", "structure", "coupler"):
            for joined in (False, True):
                with self.subTest(role, joined=joined):
                    shutil.rmtree(self.out, ignore_errors=True)
                    process = self.start("--quiet")
                    if joined:
                        victim = self.wait_until_running(process)[role]
                    else:
                        self.assertTrue(wait_until(lambda: role in self.children(process), 5))
                        victim = self.children(process)[role]
                    began = time.monotonic()
                    os.kill(victim, signal.SIGTERM)
                    _, errors = process.communicate(timeout=20)
                    self.assertLess(time.monotonic() - began, 3.5 if not joined else 2.5)  # 2 s and a busy machine
                    contents = self.contents()
                    self.assertNotEqual(contents["exit_code"], 0, errors)
                    self.assertRegex(contents["first_cause"], rf"tern-{role}|{role} process", f"{errors} {contents['processes']}")
                    self.assertEqual(contents["first_cause_role"], role)
                    self.assertEqual(find_damage(self.out), [])

    # Seen to fail: with a run taken to have begun because steps.csv of its first part is there (5 s for the others).
    def test_a_part_that_is_terminated_before_it_has_joined_again_is_noticed_as_soon(self):
        first = self.start("--quiet", "--until", "0.02")
        self.assertEqual(first.wait(timeout=60), 0)
        for role in ("fluid", "structure"):
            with self.subTest(role):
                process = subprocess.Popen([ROOT / "tern", "resume", self.out, "--quiet", "--until", "60"], env=self.environment(),
                                           stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True)
                self.addCleanup(process.stderr.close)
                self.assertTrue(wait_until(lambda: role in self.children(process), 5))
                began = time.monotonic()
                os.kill(self.children(process)[role], signal.SIGKILL)
                errors = process.communicate(timeout=20)[1]
                self.assertLess(time.monotonic() - began, 3.5, errors)  # 2 s and a busy machine
                self.assertEqual(process.returncode, 4, errors)

    def stuck_run(self, role, *words):
        """A run in which the main thread of this process does nothing from the 20th window on; its heartbeats go on."""
        library = self.build / "tests" / "libfault_injection.so"
        self.assertTrue(library.exists(), f"{library} is missing: ninja fault_injection makes it")
        shutil.rmtree(self.out, ignore_errors=True)
        # Before the pressure, the surface, or the condition of the 20th window is sent (bodies of proto/wire/tern.proto).
        fault = {"LD_PRELOAD": str(library), "ASAN_OPTIONS": "verify_asan_link_order=0", "TERN_FAULT_PROCESS": f"tern-{role}",
                 "TERN_FAULT_AT": {"fluid": "send:16:20", "structure": "send:13:20", "coupler": "send:15:20"}[role],
                 "TERN_FAULT_DO": "stuck"}
        with unittest.mock.patch.dict(os.environ, fault):
            process = self.start("--quiet", *ONE_PASS, *words, case=CASE)
        self.assertTrue(wait_until(lambda: any(Path(f"/proc/{pid}/comm").read_text() == "stuck\n" for pid in self.pids_of_run()), 30))
        return process

    # Seen to fail: with 6 s after Ctrl-C for those that do not end.
    def test_ctrl_c_in_a_window_that_does_not_end_leaves_the_checkpoint_before(self):
        words = ["--set", "output.frame_interval=0.02", "--set", "output.checkpoint_interval=0.02", "--until", "0.1"]
        whole = self.path / "whole"
        subprocess.run([ROOT / "tern", "run", CASE, "--out", whole, "--quiet", *ONE_PASS, *words], env=self.environment(), check=True)
        for role in ("fluid", "structure", "coupler"):
            with self.subTest(role):
                process = self.stuck_run(role, *words)
                pids = self.pids_of_run()
                began = time.monotonic()
                process.send_signal(signal.SIGINT)
                errors = process.communicate(timeout=20)[1]
                self.assertLess(time.monotonic() - began, 2.5, errors)  # 2 s and a busy machine
                self.assertEqual(process.returncode, 130, errors)
                self.assertEqual((self.contents()["status"], self.contents()["exit_code"]), ("interrupted", 130))
                self.assertEqual(find_damage(self.out), [])
                self.assertFalse(any(is_alive(pid) for pid in pids))
                self.assertRegex(errors, r"tern resume run goes on from step \d+, t = ")
                subprocess.run([ROOT / "tern", "resume", self.out, "--quiet"], env=self.environment(), check=True)
                self.assertEqual(differences(whole, self.out), [])

    # Seen to fail: with 12 s for the stuck part to end by itself. bench/noticing.py has structure and coupler as well.
    def test_a_stuck_part_is_named_at_the_deadline_on_a_busy_machine(self):
        busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(2 * os.cpu_count())]
        try:
            process = self.stuck_run("fluid", "--deadline", "2")
            began = time.monotonic()
            errors = process.communicate(timeout=40)[1]
        finally:
            for other in busy:
                other.kill()
                other.wait()
        self.assertLess(time.monotonic() - began, 11, errors)  # the deadline, 7 s, and a busy machine
        self.assertEqual(process.returncode, 4, errors)
        self.assertRegex(self.contents()["first_cause"], r"^The coupler process waited 2[.\d]* s for fluid at step 20")
        self.assertEqual(find_damage(self.out), [])

    # Seen to fail: with print() alone ("tern: [Errno 32] Broken pipe" and exit code 5).
    def test_who_reads_one_line_only_is_not_complained_to(self):
        answer = subprocess.run(["bash", "-c", f"{ROOT}/tern run {CASE} --out {self.out} --until 0.03 | head -1; exit ${{PIPESTATUS[0]}}"],
                                env=self.environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=60, check=False)
        self.assertEqual((answer.returncode, answer.stderr), (0, ""))
        self.assertEqual(answer.stdout.count("\n"), 1)
        self.assertEqual(self.contents()["status"], "done")

    # Seen to fail: with any folder taken that holds no run (files of a run between those of "/").
    def test_a_folder_with_other_things_is_no_place_for_a_run(self):
        own = self.path / "mine"
        own.mkdir()
        (own / "thesis.tex").write_text("")
        for place in ("/", own):
            for words in ([], ["--force"]):
                answer = subprocess.run([ROOT / "tern", "run", CASE, "--out", place, *words], env=self.environment(),
                                        stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True, check=False)
                self.assertEqual(answer.returncode, 2, answer.stderr)
                self.assertRegex(answer.stderr, r"^tern: .* is a folder that holds other things than a run; choose a new or an empty one")
        self.assertEqual([path.name for path in own.iterdir()], ["thesis.tex"])


if __name__ == "__main__":
    sys.exit(unittest.main())
