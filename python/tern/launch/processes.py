"""The processes of one run: started in groups of their own, reaped in the order of their end, never left behind."""

import contextlib
import os
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path

from tern import paths
from tern.launch import process_state
from tern.launch.ranks import Ranks, shared_memory

GRACE_AFTER_FAILURE_S = 5.0    # the others notice a lost peer by themselves: killed < 1 s, frozen < 10 s at the same time
GRACE_NEVER_JOINED_S = 1.0     # the coupler, if it was it that refused the foreign program, ends with the cause
GRACE_AFTER_SUCCESS_S = 60.0   # the others write their last frame
SILENT_AFTER_SUCCESS_S = 5.0   # of these
GRACE_AFTER_INTERRUPT_S = 1.6  # Ctrl-C ends everything within 2 s
GRACE_OF_COUPLER_S = 1.0       # of these: it completes a window, has a checkpoint made and ends the others
GRACE_AFTER_TERMINATE_S = 2.0
GUARDIAN_S = 5.0  # it ends when its pipe does, unless it is stopped
SPINS = 1000  # some 20 us: what a thread waits for the next loop before it sleeps. The compiler's 300 000 keep busy cores from others
LONGEST_STOP_S = 9.0  # by SIGSTOP; connected peers notice after 5 s, but nobody misses a process that has not joined yet


@dataclass
class Process:
    """One started executable and how it ended."""

    role: str
    program: str                  # how sentences call it
    handle: subprocess.Popen
    pidfd: int
    exit_code: int | None = None  # negative: killed by that signal; None: still running
    ended_at: float = 0.0         # unix seconds
    cpu_s: float = 0.0
    ended_by_launcher: bool = False
    stopped_since: float | None = None  # monotonic seconds
    stopped_ranks: list = field(default_factory=list)  # their numbers
    frozen: bool = False                # stopped for so long that the launcher ended the run
    never_joined: bool = False    # a foreign program that ended before the run began
    ranks: Ranks | None = None    # what it started in its turn

    @property
    def foreign(self):
        return self.program != f"tern-{self.role}"

    def stopped(self):
        """Whether the process, or one of its ranks, is frozen by SIGSTOP (state T)."""
        return process_state.of(self.handle.pid) == "T" or bool(self.ranks and self.ranks.stopped()[0])

    def paused(self):
        """Whether all of it is."""
        return self.stopped() and (self.ranks is None or self.ranks.stopped()[1])


class Interrupts:
    """Counts SIGINT, SIGTERM and SIGHUP while a run lasts, and wakes the supervisor through a pipe.

    Signals go to the main thread: a run that a script has started in another one is not interrupted by them.
    """

    def __enter__(self):
        self.count = 0
        self.read_end, self.write_end = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)
        self._before = {}
        if threading.current_thread() is threading.main_thread():
            self._wakeup = signal.set_wakeup_fd(self.write_end, warn_on_full_buffer=False)
            self._before = {number: signal.signal(number, self._handle)
                            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
        return self

    def _handle(self, _number, _frame):
        self.count += 1

    def __exit__(self, *_):
        for number, handler in self._before.items():
            signal.signal(number, handler)
        if self._before:
            signal.set_wakeup_fd(self._wakeup)
        os.close(self.read_end)
        os.close(self.write_end)


def _patient(environment):
    """With how long threads wait for each other (GCC's libgomp), and without threads of OpenBLAS, which nothing uses and which do not end
    where memory is short; unless the user has said it."""
    said = {"GOMP_SPINCOUNT", "OMP_WAIT_POLICY"} & environment.keys()
    return {"OPENBLAS_NUM_THREADS": "1"} | ({} if said else {"GOMP_SPINCOUNT": str(SPINS)}) | {**environment}


class Group:
    """All processes of a run, their private socket directory, and the guardian that cleans up should the launcher die."""

    def __init__(self, out):
        """`out`: directory of the results, in which the guardian writes how the run ended."""
        self.processes = []
        self.directory = tempfile.mkdtemp(prefix="tern-")  # mode 700: only this user can reach the sockets
        guardian = Path(__file__).with_name("guardian.sh")
        self._guardian = subprocess.Popen(["/bin/sh", guardian, self.directory, out, paths.python()], stdin=subprocess.PIPE,
                                          stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                          start_new_session=True, text=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for process in self.running():
            self._signal(process, signal.SIGKILL)
            process.handle.wait()
        for directory in (self.directory, shared_memory(self.directory)):
            shutil.rmtree(directory, ignore_errors=True)
        self._tell("finished")
        with contextlib.suppress(BrokenPipeError):  # what _tell() could not
            self._guardian.stdin.close()
        try:
            self._guardian.wait(GUARDIAN_S)
        except subprocess.TimeoutExpired:  # stopped by a signal; nothing is left for it to do
            self._guardian.kill()
            self._guardian.wait()

    def start(self, role, command, program=None, environment=None, in_ranks=False):
        """Starts one executable; standard output and error are the launcher's. `program`: a foreign one, by its name. `in_ranks`: the
        command starts many processes (ranks.py)."""
        environment = _patient(environment or os.environ) | {"TERN_LAUNCHER": str(os.getpid())}  # with whom it ends (base/interrupt.hpp)
        handle = subprocess.Popen(command, stdin=subprocess.DEVNULL, process_group=0, env=environment,
                                  **({"stderr": subprocess.PIPE, "text": True, "errors": "replace"} if in_ranks else {}))
        self._tell(f"started {handle.pid}")
        ranks = Ranks(Path(self.directory), handle.stderr) if in_ranks else None
        self.processes.append(Process(role, program or f"tern-{role}", handle, os.pidfd_open(handle.pid), ranks=ranks))

    def running(self):
        return [process for process in self.processes if process.exit_code is None]

    def supervise(self, interrupts, has_begun=lambda: True):
        """Waits until all have ended. The first failure gives the others time to end by themselves, then ends them.

        `has_begun`: whether all have joined. The coupler does not notice a foreign program that ends before that.
        """
        terminate_at = kill_at = interrupt_others_at = float("inf")
        say_at = None
        seen_interrupts = 0
        while self.running():
            for process in self._reap(interrupts, min(terminate_at, kill_at, interrupt_others_at)):
                process.never_joined = process.foreign and not process.ended_by_launcher and not has_begun()
            now = time.monotonic()
            if interrupts.count > seen_interrupts:
                if seen_interrupts == 0:
                    begun, running = has_begun(), self.running()
                    leaders = [process for process in running if begun and process.role == "coupler"]
                    # An interpreter that still imports modules has a traceback for SIGINT.
                    importing = [process for process in running if not begun and process.foreign]
                    self._signal_all(signal.SIGTERM, importing)
                    self._signal_all(signal.SIGINT, leaders or [process for process in running if process not in importing])
                    self._signal_all(signal.SIGCONT)
                    terminate_at, kill_at = float("inf"), now + GRACE_AFTER_INTERRUPT_S
                    interrupt_others_at = now + GRACE_OF_COUPLER_S if leaders else float("inf")
                seen_interrupts = interrupts.count
                if seen_interrupts > 1:
                    kill_at = now
            elif seen_interrupts == 0 and len(self.running()) < len(self.processes):
                failed = any(process.exit_code not in (None, 0) for process in self.processes)
                frozen = failed and all(process.stopped() for process in self.running())
                unjoined = any(process.never_joined for process in self.processes)
                grace = (0.0 if frozen else GRACE_NEVER_JOINED_S if unjoined or (failed and not has_begun()) else
                         GRACE_AFTER_FAILURE_S if failed else GRACE_AFTER_SUCCESS_S)
                if kill_at == float("inf"):
                    terminate_at = min(terminate_at, now + grace)
                    if grace == GRACE_AFTER_SUCCESS_S and say_at is None:
                        say_at = now + SILENT_AFTER_SUCCESS_S
            if say_at is not None and now >= say_at and terminate_at < float("inf") and self.running():
                say_at = float("inf")
                names = " and ".join(process.program for process in self.running())
                print(f"tern: the run is done, but {names} has not ended; it is ended in {terminate_at - now:.0f} s.", file=sys.stderr,
                      flush=True)
            if now >= interrupt_others_at:
                interrupt_others_at = float("inf")
                self._signal_all(signal.SIGINT)
            if seen_interrupts == 0 and kill_at == float("inf") and self._one_is_frozen(now):
                terminate_at = now
            if now >= terminate_at:
                terminate_at, kill_at = float("inf"), now + GRACE_AFTER_TERMINATE_S
                self._signal_all(signal.SIGTERM)
                self._signal_all(signal.SIGCONT)
            if now >= kill_at:
                self._signal_all(signal.SIGKILL)
                kill_at = now + 1.0

    def _one_is_frozen(self, now):
        """Whether a process has been stopped for too long while others go on; all of them together may pause."""
        running = self.running()
        for process in running:
            if not process.stopped():
                process.stopped_since = None
            elif process.stopped_since is None:
                process.stopped_since = now
                process.stopped_ranks = process.ranks.stopped()[0] if process.ranks else []
        stopped = [process for process in running if process.stopped_since is not None]
        pause = all(process.paused() for process in running)
        for process in stopped:
            if pause:
                process.stopped_since = now  # a pause: when they are woken one by one, the others are not late
            process.frozen = now - process.stopped_since > LONGEST_STOP_S
        return any(process.frozen for process in stopped)

    def _reap(self, interrupts, deadline):
        """Waits for an end, an interrupt or the deadline; collects and returns those that have ended."""
        by_fd = {process.pidfd: process for process in self.running()}
        timeout = max(0.0, min(deadline - time.monotonic(), 0.5))
        ready, _, _ = select.select([*by_fd, interrupts.read_end], [], [], timeout)
        if interrupts.read_end in ready:
            os.read(interrupts.read_end, 4096)
        ended = []
        for descriptor in ready:
            process = by_fd.get(descriptor)
            if process is None:
                continue
            self._signal(process, signal.SIGKILL)  # what a foreign command has left running in its group
            _, status, usage = os.wait4(process.handle.pid, 0)
            process.exit_code = process.handle.returncode = os.waitstatus_to_exitcode(status)
            process.ended_at = time.time()
            process.cpu_s = usage.ru_utime + usage.ru_stime
            os.close(process.pidfd)
            if process.ranks:
                process.ranks.finish()
            self._tell(f"ended {process.handle.pid}")
            ended.append(process)
        return ended

    def _signal_all(self, number, only=None):
        """Signals all that run, or those of `only`; all of them then end because the launcher wants it."""
        for process in self.running():
            process.ended_by_launcher = True
            if only is None or process in only:
                self._signal(process, number)

    @staticmethod
    def _signal(process, number):
        if process.ranks and process.ranks.signal(number) and number not in (signal.SIGKILL, signal.SIGCONT):
            return  # mpirun ends with them
        try:
            os.killpg(process.handle.pid, number)
        except ProcessLookupError:
            pass  # it has just ended by itself; the next round reaps it

    def _tell(self, line):
        try:
            self._guardian.stdin.write(line + "\n")
            self._guardian.stdin.flush()
        except BrokenPipeError:
            pass  # the guardian itself was killed: nothing to protect with
