#!/usr/bin/python3 -B
"""What delay and bandwidth between the machines cost a coupled run. Table of docs/NETWORK.md:

    PYTHONPATH=tests/process TERN_BUILD=build/release bench/network_delay.py [--until T] [CASE]

Three processes on this machine; each participant's connection goes through a relay (tests/process/relay.py) that delays every byte by
a set time per direction, or limits the bits per second. The relay's own delay is measured first, with a byte to and fro. A window
costs what it computes plus N one-way delays; N is the slope, (time per window - that of the row with relay and no delay) / delay.
Losses of packets cannot be had this way: the relay forwards bytes that TCP has already repaired.
"""

import argparse
import csv
import json
import os
import socket
import statistics
import subprocess
import tempfile
import threading
import time
from pathlib import Path

from network_run import NetworkRun, make_keys
from relay import Relay

ROOT = Path(__file__).resolve().parent.parent


def one_way_delay(**words):
    """Median over 50 bytes, half of there and back [s]."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        def echo():
            with server.accept()[0] as connection:
                while data := connection.recv(64):
                    connection.sendall(data)
        threading.Thread(target=echo, daemon=True).start()
        with Relay(server.getsockname()[1], **words) as relay, socket.create_connection(("127.0.0.1", relay.port)) as connection:
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            times = []
            for _ in range(50):
                began = time.perf_counter()
                connection.sendall(b"x")
                connection.recv(1)
                times.append(time.perf_counter() - began)
    return statistics.median(times) / 2


def figures(out):
    """(windows, median wall time of a window [s], mean bytes per window, to and from both participants) of a run's coupler."""
    with open(out / "steps.csv", newline="", encoding="utf-8") as file:
        walls = [float(row["wall_ms"]) for row in csv.DictReader(file)]
    counts = json.loads((out / "run.json").read_text())["processes"]["coupler"]["counts"]
    return len(walls), 1e-3 * statistics.median(walls), (counts["bytes_sent"] + counts["bytes_received"]) / len(walls)


def local(path, build, case, options):
    subprocess.run([ROOT / "tern", "run", case, "--out", path / "out-coupler", "--quiet", *options], check=True,
                   env=os.environ | {"TERN_BUILD": str(build)})
    return figures(path / "out-coupler")


def distributed(path, build, case, options, keys, relays):
    """`relays`: role -> settings of the relay to it; without one it connects directly."""
    with NetworkRun(path, build, case, options, keys) as run:
        port = run.start_coupler()
        opened = {role: Relay(port, **words).__enter__() for role, words in relays.items()}
        try:
            for role in ("fluid", "structure"):
                run.join(role, f"tcp://127.0.0.1:{opened[role].port if role in opened else port}")
            codes = run.codes(3000)
        finally:
            for relay in opened.values():
                relay.__exit__()
        if set(codes.values()) != {0}:
            raise SystemExit(run.everything_said())
        return figures(run.out("coupler"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case", nargs="?", default=ROOT / "cases" / "dam_break_plate")
    parser.add_argument("--until", default="0.04")
    parser.add_argument("--set", action="append", default=[])
    words = parser.parse_args()
    options = ["--until", words.until, *(part for key in words.set for part in ("--set", key))]
    build = Path(os.environ.get("TERN_BUILD", ROOT / "build" / "release")).resolve()
    print("| link | one way, measured [ms] | windows | window, median [ms] | kB per window | N |\n|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory(prefix="tern-bench-") as directory:
        keys = Path(directory) / "keys"
        keys.mkdir()
        make_keys(keys)
        both = ("fluid", "structure")
        plain = [("one machine, ipc", lambda path: local(path, build, words.case, options)),
                 ("tcp without keys", lambda path: distributed(path, build, words.case, options, None, {})),
                 ("tcp with keys", lambda path: distributed(path, build, words.case, options, keys, {}))]
        for number, (label, run) in enumerate(plain):
            path = Path(directory) / f"plain{number}"
            path.mkdir()
            windows, window, size = run(path)
            print(f"| {label} | | {windows} | {1e3 * window:.1f} | {size / 1e3:.1f} | |", flush=True)
        relayed = [("relay without delay", both, {})]
        relayed += [(f"{delay} ms, both", both, {"delay_s": 1e-3 * delay}) for delay in (1, 10, 50)]
        relayed += [(f"50 ms, {role} only", (role,), {"delay_s": 0.050}) for role in both]
        relayed += [("10 Mbit/s, both", both, {"bits_per_s": 10e6})]
        base_window = base_delay = 0.0
        for number, (label, roles, settings) in enumerate(relayed):
            path = Path(directory) / f"relayed{number}"
            path.mkdir()
            delay = one_way_delay(**settings)
            windows, window, size = distributed(path, build, words.case, options, keys, {role: settings for role in roles})
            if not settings:
                base_window, base_delay = window, delay
            slope = f"{(window - base_window) / (delay - base_delay):.1f}" if "delay_s" in settings else ""
            print(f"| {label} | {1e3 * delay:.2f} | {windows} | {1e3 * window:.1f} | {size / 1e3:.1f} | {slope} |", flush=True)


if __name__ == "__main__":
    main()
