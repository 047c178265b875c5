"""The fluid in many processes: how they are started on this machine, whom a signal reaches, and which of them died first.

Open MPI has no keys, and its mpirun listens on all networks of the machine whatever it is told. It therefore gets a network of its own,
in which there is nothing but itself; the ranks speak through shared memory.
"""

import contextlib
import os
import re
import signal
import subprocess
import sys
import threading

from tern.errors import BAD_INPUT, Error

KILLED = re.compile(r"process rank (\d+) .*exited on\s+signal (\d+)")
ALONE_IN_A_NETWORK = ["unshare", "--map-root-user", "--net", "sh", "-c", 'ip link set lo up && exec "$@"', "sh"]


def check_count(count, oversubscribe):
    """Raises Error where that many ranks cannot run on this machine."""
    if count < 1:
        raise Error(BAD_INPUT, f"--ranks {count}: has to be 1 or more.")
    cores = len(os.sched_getaffinity(0))
    if count > cores and not oversubscribe:
        raise Error(BAD_INPUT, f"--ranks {count}: this machine has {cores} cores for it, and ranks that share one wait for each other; "
                               "give fewer, or --oversubscribe.")


def check(roles, foreign):
    """Raises Error with the first thing of a run that several ranks cannot do. `foreign`: the roles that have a solver of their own."""
    if "fluid" not in roles:
        raise Error(BAD_INPUT, f"Not with --ranks: {' and '.join(roles)} alone. It is the fluid that runs in many processes.")
    if "fluid" in foreign:
        raise Error(BAD_INPUT, "Not with --ranks: --fluid. It is tern's own fluid that runs in many processes.")


def command(words, count, oversubscribe, endpoint=None):
    """`words` in that many processes. `endpoint`: where the coupler listens; one at ipc:// is reached from any network."""
    cores = ["--oversubscribe", "--bind-to", "none", "--mca", "mpi_yield_when_idle", "1"] if oversubscribe else ["--bind-to", "core"]
    # Who is told to end has ended his own work: mpirun need not wait for the others.
    start = ["mpirun", "-n", str(count), *cores, "--mca", "btl", "self,vader", "--mca", "btl_vader_single_copy_mechanism", "none",
             "--mca", "oob_tcp_if_include", "lo", "--mca", "odls_base_sigkill_timeout", "0", *words]
    if endpoint and not endpoint.startswith("ipc://"):
        why = f"a coupler at {endpoint} is not reached from a network of mpirun's own"
    elif subprocess.run([*ALONE_IN_A_NETWORK, "true"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False).returncode == 0:
        return [*ALONE_IN_A_NETWORK, *start]
    else:
        why = "this machine gives mpirun no network of its own"
    print(f"tern: warning: {why}; while the run lasts its ports are open to the networks the machine is on.", file=sys.stderr, flush=True)
    return start


def environment(directory):
    """In which they write their process ids into `directory`. As root (of its own network) mpirun has to be told twice."""
    return os.environ | {"TERN_RANK_DIRECTORY": str(directory), "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}


class Ranks:
    """Those of one run: process ids, and what mpirun says of them."""

    def __init__(self, directory, pipe):
        self._directory = directory
        self.killed = None  # (rank, signal) of the first that was
        self._reader = threading.Thread(target=self._pass_on, args=(pipe,), daemon=True)
        self._reader.start()

    def signal(self, number):
        """To the first rank, which decides when all end; what kills, stops or wakes goes to all. Whether there was one."""
        numbers = range(10**6) if number in (signal.SIGKILL, signal.SIGCONT) else range(1)
        reached = False
        for rank in numbers:
            try:
                pid = int((self._directory / f"rank.{rank}").read_text(encoding="utf-8"))
            except (OSError, ValueError):
                break
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, number)
                reached = True
        return reached

    def finish(self):
        """All of what mpirun says has been read."""
        self._reader.join(timeout=2)

    def _pass_on(self, pipe):
        """Standard error of all of them, without the boxes in which mpirun says what first_cause says."""
        boxed = False
        with pipe:
            for line in pipe:
                if line.startswith("-----"):
                    boxed = not boxed
                elif not boxed:
                    with contextlib.suppress(OSError):
                        sys.stderr.write(line)
                        sys.stderr.flush()
                elif found := KILLED.search(line):
                    self.killed = self.killed or (int(found[1]), int(found[2]))
