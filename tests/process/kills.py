#!/usr/bin/python3 -B
"""Kills processes of runs at random moments, lets ./tern go on from the newest checkpoint, and compares the end with a run that nobody
touched: every table, frame, index and entry of run.json, byte for byte.

    TERN_BUILD=build/release tests/process/kills.py --kills 100 --seed 1      (prints the table of docs/ROBUSTNESS.md)
"""

import argparse
import os
import random
import signal
import subprocess
import tempfile
import time
from pathlib import Path

from fake_build import ROOT, is_alive, wait_until
from same_results import differences

VICTIMS = ("fluid", "structure", "coupler", "launcher", "all")
PLATE = ROOT / "tests" / "process" / "cases" / "splash_plate"
TANK = ROOT / "cases" / "hydrostatic_tank"
BEAM = ROOT / "cases" / "gray_cantilever"
SETTINGS = ["--set", "output.checkpoint_interval=0.05", "--set", "output.gauge_interval=0.003"]
# Name -> case and its options; each takes some seconds.
SCENES = {
    "plate": (PLATE, ["--set", "output.frame_interval=0.02", "--until", "0.6"]),
    "plate, iterated": (PLATE, ["--set", "coupling.tolerance=1e-4", "--set", "output.frame_interval=0.02", "--until", "0.3"]),
    "tank alone": (TANK, ["--set", "output.frame_interval=0.1", "--until", "4"]),
    "beam alone": (BEAM, ["--set", "output.frame_interval=0.01", "--until", "0.4"]),
}


class Killed:
    """One run that is killed again and again."""

    def __init__(self, build, path, scene, threads=1):
        self.case, self.options = SCENES[scene]
        self.out, self.threads = path, threads
        self.environment = os.environ | {"TERN_BUILD": str(build), "TMPDIR": str(path.parent)}

    def start(self, resume):
        words = ["--resume", "auto", "--force"] if resume else []
        return subprocess.Popen([ROOT / "tern", "run", self.case, "--out", self.out, "--quiet", "--threads", str(self.threads), *SETTINGS,
                                 *self.options, *words], env=self.environment, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                stderr=subprocess.PIPE, text=True, start_new_session=True)

    def processes(self):
        """{role: process id} of what runs for this directory; the launcher is one of them."""
        found = {}
        for entry in Path("/proc").glob("[0-9]*"):
            try:
                words = (entry / "cmdline").read_bytes().decode(errors="replace").split("\0")
            except OSError:
                continue
            if str(self.out) in words and is_alive(int(entry.name)):
                program = Path(words[0]).name
                found[program.removeprefix("tern-") if program.startswith("tern-") else "launcher"] = int(entry.name)
        return found

    def kill(self, victim, launcher):
        """Kills one or all; waits until nothing of the run lives. Returns who was killed, None when the run was over already."""
        living = self.processes()
        names = list(living) if victim == "all" else [victim] if victim in living else []
        for name in names:
            try:
                os.kill(living[name], signal.SIGKILL)
            except ProcessLookupError:
                pass
        if not names:
            return None
        if not wait_until(lambda: not self.processes(), 20):
            raise AssertionError(f"{', '.join(self.processes())} still runs 20 s after {victim} was killed")
        launcher.wait()
        launcher.stderr.close()
        return victim


def uninterrupted(build, path, scene):
    """The results of the scene that nobody touched."""
    run = Killed(build, path, scene)
    launcher = run.start(resume=False)
    errors = launcher.communicate()[1]
    assert launcher.returncode == 0, errors
    return path


def torment(build, folder, scene, whole, kills, generator):
    """Kills a run so many times, then lets it end; returns ({victim: how often}, what differs from `whole`)."""
    run = Killed(build, folder / "killed", scene, generator.choice((1, 2)))
    counts = dict.fromkeys(VICTIMS, 0)
    begun = False
    while sum(counts.values()) < kills:
        launcher = run.start(begun)
        begun = True
        time.sleep(generator.uniform(0.2, 1.6))
        victim = run.kill(generator.choice(VICTIMS), launcher)
        if victim is None and launcher.poll() is not None:
            if launcher.returncode != 0:
                return counts, [f"exit code {launcher.returncode}: {launcher.stderr.read()}"]
            launcher.stderr.close()
            break  # it was faster than we
        if victim is None:  # there is no such process
            launcher.terminate()
            launcher.communicate()
            continue
        counts[victim] += 1
    launcher = run.start(begun)
    errors = launcher.communicate()[1]
    if launcher.returncode != 0:
        return counts, [f"exit code {launcher.returncode} at the end: {errors}"]
    return counts, differences(whole, run.out)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--each", type=int, default=5, help="kills of one run")
    parser.add_argument("--seed", type=int, default=random.randrange(10**6))
    arguments = parser.parse_args()
    build = Path(os.environ.get("TERN_BUILD", ROOT / "build" / "release")).resolve()
    generator = random.Random(arguments.seed)
    print(f"seed {arguments.seed}", flush=True)
    total, bad, runs = dict.fromkeys(VICTIMS, 0), 0, dict.fromkeys(SCENES, 0)
    with tempfile.TemporaryDirectory(prefix="tern-kills-") as folder:
        whole = {}
        while sum(total.values()) < arguments.kills:
            scene = generator.choice(list(SCENES))
            if scene not in whole:
                whole[scene] = uninterrupted(build, Path(folder) / f"whole{len(whole)}", scene)
            place = Path(folder) / f"run{sum(runs.values())}"
            place.mkdir()
            counts, found = torment(build, place, scene, whole[scene], arguments.each, generator)
            runs[scene] += 1
            for victim, count in counts.items():
                total[victim] += count
            if found:
                bad += 1
                print(f"{scene}: {'; '.join(found)}", flush=True)
    print("| killed | " + " | ".join(VICTIMS) + " | runs | with the results of an untouched run |")
    print("|---|" + "---|" * (len(VICTIMS) + 2))
    print(f"| {sum(total.values())} | " + " | ".join(str(total[victim]) for victim in VICTIMS)
          + f" | {sum(runs.values())} | {sum(runs.values()) - bad} |")
    raise SystemExit(1 if bad else 0)


if __name__ == "__main__":
    main()
