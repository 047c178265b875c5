#!/usr/bin/python3
"""Runs one fuzzer: fuzz.py EXECUTABLE message|case SECONDS|RUNSx, e.g. 60 or 20000000x. Prints the seed; the corpus is kept
beside the executable, what it finds as crash-* there too.

Seeds: every case file of the project; for messages, the recorded interface of cases/conformance.
"""

import random
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def main():
    executable, subject, amount = Path(sys.argv[1]), sys.argv[2], sys.argv[3]
    corpus = executable.parent / f"corpus-{subject}"
    corpus.mkdir(exist_ok=True)
    seeds = sorted((ROOT / "cases").glob("*/case.toml")) if subject == "case" else sorted((Path(__file__).parent / "messages").glob("*"))
    if not seeds:
        sys.exit(f"no seeds for {subject}")
    for seed in seeds:
        shutil.copy(seed, corpus / f"{seed.parent.name}-{seed.name}")
    number = random.randrange(1, 1 << 31)
    limit = f"-runs={amount[:-1]}" if amount.endswith("x") else f"-max_total_time={amount}"
    print(f"seed {number}", flush=True)
    return subprocess.run([executable, limit, f"-seed={number}", "-max_len=16384", "-rss_limit_mb=4096", "-timeout=10",
                           "-print_final_stats=1", f"-artifact_prefix={executable.parent}/", corpus], check=False).returncode


sys.exit(main())
