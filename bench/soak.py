#!/usr/bin/python3 -B
"""Many windows and frames of tern's three processes with little to compute: do memory, descriptors and latency stay flat?

    TERN_BUILD=build/release bench/soak.py                100 000 windows and 10 000 frames: a little water that sloshes against a plate
    TERN_BUILD=build/release bench/soak.py 5000           as many windows as you like, a tenth as many frames

A checkpoint is made every second. Prints a Markdown table of ten parts of the run; ends with exit code 3 when a process has grown by
more than 2 % and 2 MB, or holds more descriptors, from the second part to the last, or when a window takes more than 1.5 times as long
in each of the last three parts.
"""

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
CASE = ROOT / "tests" / "process" / "cases" / "small_plate"
WINDOWS_PER_FRAME = 10
FRAME_S = 0.0335  # ten windows
PARTS = 10


def processes(out):
    """{role: process id} from the reports that the three leave while they run."""
    found = {}
    for path in out.glob("report.*.json"):
        try:
            found[path.name.split(".")[1]] = json.loads(path.read_text())["process_id"]
        except (OSError, ValueError, KeyError):
            continue  # just being replaced
    return found


def size(number):
    """(resident memory [MB], open descriptors) of a process."""
    pages = int(Path(f"/proc/{number}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6, len(list(Path(f"/proc/{number}/fd").iterdir()))


def windows_done(out):
    try:
        with open(out / "steps.csv", "rb") as file:
            return sum(block.count(b"\n") for block in iter(lambda: file.read(1 << 20), b"")) - 1
    except OSError:
        return 0


def main():
    windows = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    samples = []
    with tempfile.TemporaryDirectory(prefix="tern-soak-") as directory:
        out = Path(directory) / "run"
        run = subprocess.Popen([
            ROOT / "tern", "run", CASE, "--out", out, "--quiet", "--until", repr(windows / WINDOWS_PER_FRAME * FRAME_S),
            "--set", f"output.frame_interval={FRAME_S}", "--set", "output.gauge_interval=0.1", "--set", "output.checkpoint_interval=1"])
        while run.poll() is None:
            time.sleep(0.2)
            done, alive = windows_done(out), processes(out)
            if len(alive) == 3 and done >= windows * (len(samples) + 1) / PARTS:
                try:
                    samples.append((done, {role: size(number) for role, number in alive.items()}))
                except OSError:
                    break  # it has just ended
        code = run.wait()
        if code != 0:
            sys.exit(f"the run ended with exit code {code}")
        with open(out / "steps.csv", encoding="utf-8") as file:
            walls = [float(line.rsplit(",", 1)[1]) for line in list(file)[1:]]

    print("| windows | window, median and mean [ms] | "
          + " | ".join(f"{role} [MB], descriptors" for role in sorted(samples[0][1])) + " |")
    print("|---" * (2 + len(samples[0][1])) + "|")
    latencies, before = [], 0
    for done, sizes in samples:
        latencies.append(statistics.median(walls[before:done]))
        mean = statistics.mean(walls[before:done])
        before = done
        print(f"| {done} | {latencies[-1]:.2f}, {mean:.2f} | "
              + " | ".join(f"{mb:.1f}, {fds}" for _, (mb, fds) in sorted(sizes.items())) + " |")
    faults = []
    for role in samples[-1][1]:
        (mb_first, fds_first), (mb_last, fds_last) = samples[1][1][role], samples[-1][1][role]
        if mb_last > 1.02 * mb_first and mb_last > mb_first + 2:
            faults.append(f"{role} has grown from {mb_first:.1f} to {mb_last:.1f} MB")
        fds_last = min(sizes[role][1] for _, sizes in samples[-3:])  # one more while a file is being written
        if fds_last > fds_first:
            faults.append(f"{role} holds {fds_last} descriptors instead of {fds_first}")
    if min(latencies[-3:]) > 1.5 * latencies[1]:  # other work on the machine may slow down one of them
        faults.append(f"a window takes {min(latencies[-3:]):.2f} ms instead of {latencies[1]:.2f}")
    print("\n" + ("; ".join(faults) if faults else f"{len(walls)} windows: nothing grows"))
    sys.exit(3 if faults else 0)


main()
