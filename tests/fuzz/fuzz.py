#!/usr/bin/python3 -B
"""Runs one fuzzer: fuzz.py EXECUTABLE message|case SECONDS or RUNSx, e.g. 60 or 20000000x. Prints its seed; the corpus stays
beside the executable, and so does what it finds (crash-*).

It begins with every case file of the project; or with the messages of a captured run of cases/conformance
(./tern run conformance --until 0.003 --record) and one message of every kind that the coupler sends.
"""

import random
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def coupler_messages():
    """One message of every kind of the coupler, 2D, two surface points, one interface particle; each after its length."""
    from google.protobuf.internal.encoder import _VarintBytes

    from tern.participant.channel import PROTOCOL_VERSION
    from tern.participant.schema import wire
    bodies = [
        {"hello": wire.Hello(dimension=2)},  # so that the check knows the dimension
        {"welcome": wire.Welcome(surface_points=2)},
        {"begin_window": wire.BeginWindow(begin_ticks=0, duration_ticks=1 << 22)},
        {"surface": wire.Surface(position=[0, 0, 0, 1], velocity=[0] * 4, normal=[1, 0, 1, 0], area=[1, 1])},
        {"interface_particles": wire.InterfaceParticles(id=[7], position=[1, 1], velocity=[0, 0], mass=[1], volume=[1], divergence=[0],
                                                        image_of=[0], image_position=[-1, 1], covered=[1])},
        {"window_done": wire.WindowDone(proposed_step_s=1e-3, limit="gravity",
                                        extent=wire.Extent(low=[0, 0], high=[1, 1], largest_speed=1, reach=0.1))},
        {"surface": wire.Surface()},
        {"interface_condition": wire.InterfaceCondition(force=[0, 0], reference_pressure=[0, 0], lump=[0, 1], share=[1, 1],
                                                            lump_mass=[1, 1], repeats=True, answer_tolerance=0.01)},
        {"interface_force": wire.InterfaceForce(force=[1, 2])},
        {"surface_load": wire.SurfaceLoad(force=[1, 2, 3, 4], trial=True)},
        {"finish": wire.Finish()},
        {"abort": wire.Abort(exit_code=3, sentence="stop")},
    ]
    messages = [wire.Message(protocol_version=PROTOCOL_VERSION, sender=wire.COUPLER, sequence=n + 1, step=1, **body).SerializeToString()
                for n, body in enumerate(bodies)]
    return b"".join(_VarintBytes(len(message)) + message for message in messages)


def main():
    executable, subject, amount = Path(sys.argv[1]).resolve(), sys.argv[2], sys.argv[3]
    corpus = executable.parent / f"corpus-{subject}"
    corpus.mkdir(exist_ok=True)
    if subject == "case":
        for path in (ROOT / "cases").glob("*/case.toml"):
            shutil.copy(path, corpus / path.parent.name)
    else:
        for path in (Path(__file__).parent / "messages").iterdir():
            shutil.copy(path, corpus / path.name)
        (corpus / "coupler").write_bytes(coupler_messages())
    seed = random.randrange(1, 1 << 31)
    print(f"seed {seed}", flush=True)
    limit = f"-runs={amount[:-1]}" if amount.endswith("x") else f"-max_total_time={amount}"
    # The timeout: to fill a polygon with the most particles that a case may have takes 5 s, under the sanitizers many times as long.
    return subprocess.run([executable, limit, f"-seed={seed}", "-max_len=16384", "-rss_limit_mb=4096", "-timeout=120",
                           "-print_final_stats=1", "-verbosity=0", f"-artifact_prefix={executable.parent}/", corpus],
                          check=False).returncode


sys.exit(main())
