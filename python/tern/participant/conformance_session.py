"""One life of a participant under ./tern conform, and the stand-in for the coupler that it talks to."""

import contextlib
import os
import shutil
import signal
import subprocess
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import zmq
from zmq.utils.monitor import recv_monitor_message

from tern.participant.message_check import MAX_MESSAGE_BYTES, BadMessage, check_from_participant
from tern.participant.channel import HEARTBEAT_INTERVAL_MS, LINGER_MS, PROTOCOL_VERSION
from tern.participant.conformance_relay import Relay
from tern.participant.schema import wire

TICKS_PER_S = 1 << 32
ANSWER_S = 20.0      # for any answer to an order
START_S = 60.0       # for the first message of a participant
BY_HAND_S = 600.0    # the same when a person starts it
LEAVE_S = 2.0        # from an Abort, a fault or Ctrl-C to the end of the process (5.5)
ROLES = {"fluid": wire.FLUID, "structure": wire.STRUCTURE}


class Breach(Exception):
    """The participant broke the protocol; `paragraph` of docs/PROTOCOL.md."""

    def __init__(self, paragraph, sentence):
        super().__init__(sentence)
        self.paragraph = paragraph


class CannotBind(Exception):
    """The address that was given cannot be used."""


@dataclass
class Subject:
    """What is tested: a role of a case, played by a command, or by whoever connects to `address`."""

    role: str
    scene: dict            # tern-case json
    command: list | None   # the words to start it with, CASE --out DIR --endpoint ADDRESS --quiet and options are appended
    options: list          # --set, --preset
    environment: dict      # of the command
    address: str | None = None
    lives: dict = field(default_factory=dict)  # what several checks look at, by name


class Session:
    """One life of the participant and the stand-in for the coupler that it talks to."""

    def __init__(self, subject, say):
        self._subject = subject
        self._say = say
        self.role = subject.role
        self.dimension = subject.scene["dimension"]
        self.step = self.begin_ticks = 0
        self.hello = None
        self.points = self.interface_particles = 0
        self.on_its_way_s = 0.0  # of what was sent last, beside the time that an answer takes
        self._sent = self._received = 0
        self._peer = None
        self._left = False
        self._process = self.relay = None
        self._directory = Path(tempfile.mkdtemp(prefix="tern-conform-"))
        self._context = zmq.Context()
        self._socket = self._context.socket(zmq.ROUTER)
        for option, value in ((zmq.LINGER, LINGER_MS), (zmq.HEARTBEAT_IVL, HEARTBEAT_INTERVAL_MS), (zmq.HEARTBEAT_TIMEOUT, 0),
                              (zmq.MAXMSGSIZE, 2 * MAX_MESSAGE_BYTES), (zmq.ROUTER_MANDATORY, 1)):
            self._socket.setsockopt(option, value)
        self._monitor = self._socket.get_monitor_socket(zmq.EVENT_DISCONNECTED)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self._process is not None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self._process.pid, signal.SIGKILL)  # and what it has started
            self._process.wait()
            self._errors.close()
        self.vanish()
        shutil.rmtree(self._directory, ignore_errors=True)

    def start(self, bind_after_s=0.0, relayed=False):
        """Starts the participant, binds, and returns its Hello once it has been found to be in order. `relayed`: through self.relay."""
        address = self._subject.address or f"ipc://{self._directory}/tern.sock"
        if self._subject.command is None:
            self._say(f"  start the {self.role} now, with --endpoint {address}")
        else:
            self.words = [*self._subject.command, self._subject.scene["path"], "--out", str(self._directory / "out"),
                          "--endpoint", address, "--quiet", *self._subject.options]
            self._errors = open(self._directory / "stderr", "w+", encoding="utf-8", errors="replace")
            self._process = subprocess.Popen(self.words, stdin=subprocess.DEVNULL, stdout=self._errors, stderr=self._errors,
                                             env=self._subject.environment, process_group=0)
            time.sleep(bind_after_s)
        try:
            if relayed:
                self._socket.bind(f"ipc://{self._directory}/behind.sock")
                self.relay = Relay(address, f"{self._directory}/behind.sock")
            else:
                self._socket.bind(address)
        except (zmq.ZMQError, OSError) as error:
            raise CannotBind(f"The address {address} cannot be used: {error}.") from None
        self.hello = self.receive("hello", deadline_s=START_S if self._subject.command else BY_HAND_S, paragraph="3.1").hello
        self._check_hello()
        return self.hello

    def _check_hello(self):
        scene, hello = self._subject.scene, self.hello
        wanted = scene["account"][self.role]
        for name, has, expected in (("case_hash", hello.case_hash, scene["hash"]),
                                    ("dimension", hello.dimension, scene["dimension"]),
                                    ("number of account.energy", len(hello.account.energy), len(wanted["energy"])),
                                    ("number of account.gauge", len(hello.account.gauge), len(wanted["gauge"]))):
            if has != expected:
                raise Breach("4, Hello", f"{name} is {has}; it must be {expected} as the case says")
        bodies = len(scene["settings"]["structure"]["body"]) if self.role == "structure" else 0
        for point, body in enumerate(hello.surface.body):
            if body >= bodies:
                raise Breach("4, Hello", f"surface.body[{point}] is {body}; the case has {bodies} elastic bodies, counted from 0")
        if self.role == "fluid" and hello.proposed_step_s <= 0:
            raise Breach("4, Hello", f"proposed_step_s is {hello.proposed_step_s:g}; the fluid must propose a step above 0")

    # Messages out.

    def send(self, frames=None, envelope=None, **body):
        """The next message of the coupler. `envelope` falsifies its fields; `frames` are sent instead, as they are."""
        if frames is None:
            self._sent += 1
            if "begin_window" in body:
                self.step += 1
            fields = {"protocol_version": PROTOCOL_VERSION, "sender": wire.COUPLER, "sequence": self._sent, "step": self.step}
            frames = [wire.Message(**(fields | (envelope or {})), **body).SerializeToString()]
        try:
            self._socket.send_multipart([self._peer, *frames])
        except zmq.ZMQError:
            raise Breach("3", f"the participant left at step {self.step}, before the run was over{self._last_words()}") from None

    @property
    def subject(self):
        return self._subject

    @property
    def last_sequence(self):
        return self._sent

    def welcome(self, points, **options):
        self.points = points
        self.send(welcome=wire.Welcome(surface_points=points, version="tern conform"), **options)

    def begin(self, duration_s, write_frame=False):
        duration = max(1, round(duration_s * TICKS_PER_S))
        self.send(begin_window=wire.BeginWindow(begin_ticks=self.begin_ticks, duration_ticks=duration, write_frame=write_frame))
        self.begin_ticks += duration

    # Messages in.

    def receive(self, kind, deadline_s=ANSWER_S, paragraph="3.3"):
        """The next message of the participant, which must be of this kind and in order. Raises Breach."""
        frames = self._next_frames(deadline_s, kind, paragraph)
        if len(frames) != 2:
            raise Breach("1.1", f"a message of {len(frames) - 1} frames; it must be one")
        if len(frames[1]) > MAX_MESSAGE_BYTES:
            raise Breach("1.4", f"a message of {len(frames[1])} bytes; the limit is {MAX_MESSAGE_BYTES}")
        try:
            message = wire.Message.FromString(frames[1])
        except Exception:  # DecodeError; its module differs between versions of protobuf
            raise Breach("2", f"{len(frames[1])} bytes that are not a message of proto/wire/tern.proto") from None
        self._peer = frames[0]
        self._received += 1
        has = message.WhichOneof("body")
        if has == "abort" and kind != "abort":
            raise Breach("3", f"the participant stopped where {kind} was due: {message.abort.sentence}")
        envelope = {"sender": ROLES[self.role]}
        if has != "abort":  # who stops may be behind or of another version
            envelope |= {"protocol_version": PROTOCOL_VERSION, "sequence": self._received, "step": self.step}
        for field, value in envelope.items():
            if getattr(message, field) != value:
                raise Breach("2", f"{field} of {has} is {getattr(message, field)}; it must be {value}")
        if has != kind:
            raise Breach(paragraph, f"{has} came where {kind} was due")
        try:
            check_from_participant(message, self.role, self.dimension, self.points, self.interface_particles, self.hello)
        except BadMessage as fault:
            raise Breach("4, " + "".join(word.capitalize() for word in kind.split("_")), f"{kind}: {fault}") from None
        if kind == "interface_particles":
            self.interface_particles = len(message.interface_particles.id)
        return message

    def _next_frames(self, deadline_s, kind, paragraph):
        end = time.monotonic() + deadline_s
        while not self._socket.poll(50):
            if self._process is not None and self._process.poll() is not None and not self._socket.poll(200):
                raise Breach(paragraph, f"the process ended with exit code {self._process.returncode} where {kind} was due"
                             + self._last_words())
            if time.monotonic() > end:
                raise Breach(paragraph, f"no {kind} within {deadline_s:g} s")
        return self._socket.recv_multipart()

    def quiet_for(self, seconds, paragraph, after):
        if self._socket.poll(int(1000 * seconds)):
            kind = wire.Message.FromString(self._socket.recv_multipart()[1]).WhichOneof("body")
            raise Breach(paragraph, f"{kind} came after {after}, which has no answer")

    # Ends.

    def vanish(self):
        """The coupler is gone, without a word."""
        if self._socket.closed:
            return
        self._socket.disable_monitor()
        self._monitor.close(0)
        self._socket.close(0)
        self._context.term()
        if self.relay:
            self.relay.close()

    def interrupt(self):
        self._process.send_signal(signal.SIGINT)

    def expect_end(self, exit_code, within_s=LEAVE_S, paragraph="5.5"):
        """The process ends in time with this exit code; of one started by hand only the end of its connection is seen."""
        end = time.monotonic() + within_s
        if self._process is None:
            while not self._socket.closed and not self._left and time.monotonic() < end:
                if self._monitor.poll(50):
                    self._left |= recv_monitor_message(self._monitor)["event"] == zmq.EVENT_DISCONNECTED
            if not self._socket.closed and not self._left:
                raise Breach(paragraph, f"still connected {within_s:g} s later")
            return
        try:
            has = self._process.wait(max(0.0, end - time.monotonic()))
        except subprocess.TimeoutExpired:
            raise Breach(paragraph, f"the process still runs {within_s:g} s later") from None
        if has != exit_code:
            raise Breach(paragraph, f"the process ended with exit code {has}; it must be {exit_code}{self._last_words()}")

    def expect_abort(self, exit_code):
        """Abort with this code and a sentence, then the end with the same code."""
        abort = self.receive("abort", deadline_s=LEAVE_S + self.on_its_way_s, paragraph="5.2").abort
        if abort.exit_code != exit_code:
            raise Breach("5.2", f"Abort has exit_code {abort.exit_code}; it must be {exit_code} ({abort.sentence})")
        self.expect_end(exit_code)

    def _last_words(self):
        if self._process is None:
            return ""
        self._errors.flush()
        lines = [line for line in (self._directory / "stderr").read_text(errors="replace").splitlines() if line.strip()]
        return f" (its last line: {lines[-1]})" if lines else ""
