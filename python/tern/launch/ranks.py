"""The fluid in many processes: how they are started, whom a signal reaches, and which of them stopped or died first.

Open MPI has no keys, and its mpirun listens at all addresses of the machine whatever it is told. On one machine it therefore gets a
network of its own, in which there is nothing but itself. Where that cannot be, because the coupler is reached over a network, or the
kernel does not allow it, a library that is loaded first lets it listen at one address (ranks/listen/). The ranks of one machine speak
through shared memory.
"""

import contextlib
import os
import re
import signal
import socket
import subprocess
import sys
import threading
from pathlib import Path

from tern.errors import BAD_INPUT, Error
from tern.launch import process_state

KILLED = re.compile(r"process rank (\d+) .*?on node (\S+)\s+exited on\s+signal (\d+)", re.DOTALL)
# What mpirun says of ends that the report of the first rank explains, or the launcher.
EXPLAINED = re.compile(r"exited on\s+signal|MPI_ABORT was invoked|job\s+terminated normally|exited with non-zero status")
WOKEN = re.compile(r"mpirun: Forwarding signal \d+ to job\s*")  # what it has been told by the launcher
OF_ONE = re.compile(r"tern-fluid, rank (\d+): (.+)")  # as fluid/process/ranks.cpp has it
ALONE_IN_A_NETWORK = ["unshare", "--map-root-user", "--net", "sh", "-c", 'ip link set lo up && exec "$@"', "sh"]
LISTENER = "libtern_listen_on.so"


def shared_memory(directory):
    """Where the ranks of a run, whose private directory this is, have what they share."""
    return Path("/dev/shm") / Path(directory).name


def check_count(count, oversubscribe, on_hosts):
    """Raises Error where that many ranks cannot run on this machine."""
    if count < 1:
        raise Error(BAD_INPUT, f"--ranks {count}: has to be 1 or more.")
    cores = len(os.sched_getaffinity(0))
    if count > cores and not oversubscribe and not on_hosts:
        raise Error(BAD_INPUT, f"--ranks {count}: this machine has {cores} cores for it, and ranks that share one wait for each other; "
                               "give fewer, or --oversubscribe.")


def check(roles, foreign):
    """Raises Error with the first thing of a run that several ranks cannot do. `foreign`: the roles that have a solver of their own."""
    if "fluid" not in roles:
        raise Error(BAD_INPUT, f"Not with --ranks: {' and '.join(roles)} alone. It is the fluid that runs in many processes.")
    if "fluid" in foreign:
        raise Error(BAD_INPUT, "Not with --ranks: a foreign fluid (--fluid, or --command of ./tern join). It is tern's own that runs in "
                               "many processes.")


class Start:
    """How the ranks of a run are started. `directory`: private to the run, for process ids and the list of hosts. `endpoint`: where the
    coupler listens; one at ipc:// is reached from any network."""

    def __init__(self, build, directory, count, oversubscribe, endpoint, hosts=None):
        self._directory, self._count, self._oversubscribe = directory, count, oversubscribe
        self._hosts = hosts
        self._listener = build / LISTENER
        self._alone = hosts is None and endpoint.startswith("ipc://") and subprocess.run(
            [*ALONE_IN_A_NETWORK, "true"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False).returncode == 0
        if not self._alone and (not self._listener.exists() or re.search(r"[\s:]", str(self._listener))):
            # The loader would pass over it with a warning, and mpirun listen everywhere.
            raise Error(BAD_INPUT, f"--ranks needs {self._listener}, in a path without blank or colon, so that Open MPI listens at "
                                   f"{self._listens_on} alone; build there, or move the clone.")

    @property
    def _listens_on(self):
        return self._hosts.network if self._hosts else "lo"

    def command(self, words):
        """`words` in that many processes."""
        cores = ["--oversubscribe", "--bind-to", "none", "--mca", "mpi_yield_when_idle", "1"] if self._oversubscribe else ["--bind-to",
                                                                                                                     "core"]
        # Who is told to end has ended his own work: mpirun need not wait for the others.
        start = ["mpirun", "-n", str(self._count), *cores, "--mca", "btl", "self,vader,tcp" if self._hosts else "self,vader", "--mca",
                 "btl_vader_single_copy_mechanism", "none", "--mca", "oob_tcp_if_include", self._listens_on, "--mca",
                 "odls_base_sigkill_timeout", "0"]
        if not self._hosts:  # what mpirun would leave behind when it is killed goes with the directories of the run
            start += ["--mca", "orte_tmpdir_base", str(self._directory)]
            memory = shared_memory(self._directory)
            with contextlib.suppress(OSError):
                memory.mkdir(mode=0o700, exist_ok=True)
                start += ["--mca", "btl_vader_backing_directory", str(memory)]
        if self._hosts:
            path = self._directory / "hosts"
            self._hosts.write(path)
            passed = self._passed_on()
            start += [*self._hosts.options(path), "--mca", "orte_launch_agent",
                      " ".join(["env", *(f"{name}={value}" for name, value in passed.items()), "orted"])]
            start += [word for name in passed for word in ("-x", name)]
        return [*(ALONE_IN_A_NETWORK if self._alone else []), *start, *words]

    def _passed_on(self):
        """What mpirun and those whom it starts on other machines find in their environment. As root (of its own network) it has to be
        told twice."""
        passed = {"TERN_RANK_DIRECTORY": str(self._directory)}
        if self._alone or os.geteuid() == 0:
            passed |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
        if not self._alone:
            passed |= {"TERN_LISTEN_ON": self._listens_on, "LD_PRELOAD": str(self._listener)}
        if self._hosts and self._hosts.ports:
            passed["TERN_LISTEN_PORTS"] = "-".join(map(str, self._hosts.ports))
        return passed

    def environment(self):
        passed = self._passed_on()
        if before := os.environ.get("LD_PRELOAD"):
            passed["LD_PRELOAD"] = f"{passed['LD_PRELOAD']}:{before}" if "LD_PRELOAD" in passed else before
        return os.environ | passed


class Ranks:
    """Those of one run: process ids, and what mpirun says of them."""

    def __init__(self, directory, pipe):
        self._directory = directory
        self.killed = None  # (rank, signal, machine or "") of the first that was
        self.alone = None  # what happened to one rank alone, in a sentence
        self._reader = threading.Thread(target=self._pass_on, args=(pipe,), daemon=True)
        self._reader.start()

    def here(self):
        """(number, process id) of those on this machine."""
        found = []
        for path in self._directory.glob("rank.*[0-9]"):
            with contextlib.suppress(OSError, ValueError):
                pid, _, machine = path.read_text(encoding="utf-8").strip().partition(" ")
                if machine == socket.gethostname():
                    found.append((int(path.suffix[1:]), int(pid)))
        return sorted(found)

    def stopped(self):
        """Numbers of those that are frozen by SIGSTOP, of this machine, and whether these are all."""
        ranks = self.here()
        stopped = [rank for rank, pid in ranks if process_state.of(pid) == "T"]
        return stopped, len(stopped) == len(ranks)

    def signal(self, number):
        """To the first rank, which decides when all end; what kills, stops or wakes goes to all. Whether there was one."""
        ranks = self.here()
        reached = False
        for _, pid in ranks if number in (signal.SIGKILL, signal.SIGCONT) else ranks[:1]:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, number)
                reached = True
        return reached

    def finish(self):
        """All of what mpirun says has been read."""
        self._reader.join(timeout=2)

    def _pass_on(self, pipe):
        """Standard error of all of them, without the boxes in which mpirun says what first_cause says."""
        box = None
        with pipe:
            for line in pipe:
                if line.startswith("-----"):
                    if box and not EXPLAINED.search("".join(box)):
                        self._print("".join(box))
                    box = [] if box is None else None
                elif box is None:
                    if found := OF_ONE.fullmatch(line.strip()):
                        self.alone = self.alone or f"Rank {found[1]} of tern-fluid: {found[2]}"
                    if not WOKEN.fullmatch(line):
                        self._print(line)
                else:
                    box.append(line)
                    if found := KILLED.search("".join(box)):
                        machine = "" if found[2] == socket.gethostname() else found[2]
                        self.killed = self.killed or (int(found[1]), int(found[3]), machine)

    @staticmethod
    def _print(text):
        with contextlib.suppress(OSError):
            sys.stderr.write(text)
            sys.stderr.flush()
