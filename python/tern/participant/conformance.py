"""Does a participant keep the protocol? A stand-in for the coupler that asks for everything a coupler may ask for, breaks
the rules on purpose, and says of every deviation which paragraph of docs/PROTOCOL.md it breaks. ./tern conform runs it.

Every check starts the participant anew: as a command, or, where there is none, by asking the user to start it.
"""

import contextlib
import os
import shutil
import signal
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy
import zmq
from zmq.utils.monitor import recv_monitor_message

from tern.participant.message_check import MAX_MESSAGE_BYTES, BadMessage, check_from_participant
from tern.participant.channel import HEARTBEAT_INTERVAL_MS, HEARTBEAT_TIMEOUT_MS, LINGER_MS, PROTOCOL_VERSION
from tern.participant.schema import wire

TICKS_PER_S = 1 << 32
ANSWER_S = 20.0      # for any answer to an order
START_S = 60.0       # for the first message of a participant
BY_HAND_S = 600.0    # the same when a person starts it
LEAVE_S = 2.0        # from an Abort, a fault or Ctrl-C to the end of the process (5.5)
LARGEST_S = 10.0     # for 256 MiB on their way to it, on a busy machine
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
        self._process = None
        self._directory = Path(tempfile.mkdtemp(prefix="tern-conform-"))
        self._context = zmq.Context()
        self._socket = self._context.socket(zmq.ROUTER)
        for option, value in ((zmq.LINGER, LINGER_MS), (zmq.HEARTBEAT_IVL, HEARTBEAT_INTERVAL_MS),
                              (zmq.HEARTBEAT_TIMEOUT, HEARTBEAT_TIMEOUT_MS), (zmq.HEARTBEAT_TTL, HEARTBEAT_TIMEOUT_MS),
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

    def start(self, bind_after_s=0.0):
        """Starts the participant, binds, and returns its Hello once it has been found to be in order."""
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
            self._socket.bind(address)
        except zmq.ZMQError as error:
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


# What the stand-in orders. Loads and motions are small: the scene stays where it is.

class StructureOrders:
    """Windows for a structure: loads along the normals that would change the velocity by 1 cm/s, if nothing held the surface."""

    def __init__(self, session):
        self.session = session
        hello = session.start()
        session.welcome(len(hello.surface.body))
        self.duration_s = 2.0**-11
        self.mass = numpy.array(hello.surface.section_mass)

    def load(self, surface, factor):
        normal = numpy.array(surface.normal).reshape(-1, self.session.dimension)
        pressure = factor * 0.01 * self.mass / self.duration_s * numpy.array(surface.area)
        return wire.SurfaceLoad(force=(-pressure[:, None] * normal).ravel())

    def begin(self, write_frame=False):
        self.session.begin(self.duration_s, write_frame)
        return self.session.receive("surface", paragraph="3.3.2").surface

    def first_message(self):
        """A window's begin, and the message that is due then."""
        return {"surface_load": self.load(self.begin(), 1.0)}

    def trial(self, surface, factor):
        load = self.load(surface, factor)
        load.trial = True
        self.session.send(surface_load=load)
        velocity = self.session.receive("surface_velocity", paragraph="3.3.6").surface_velocity.velocity
        return numpy.array(velocity).reshape(-1, self.session.dimension)

    def window(self, factor=1.0, trials=(), write_frame=False):
        """One window; returns its surface and the answers to the trials."""
        surface = self.begin(write_frame)
        answers = [self.trial(surface, trial) for trial in trials]
        self.session.send(surface_load=self.load(surface, factor))
        return surface, answers

    def state(self):
        """Something of the state at the begin of a window that is compared between two lives."""
        surface = self.begin()
        self.session.send(surface_load=self.load(surface, 0.0))
        return numpy.array(surface.position)

    def sense(self):
        """More load along a direction moves the surface more along it."""
        surface = self.begin()
        still, pressed = self.trial(surface, 0.0), self.trial(surface, 1.0)
        self.session.send(surface_load=self.load(surface, 0.0))
        force = numpy.array(self.load(surface, 1.0).force).reshape(-1, self.session.dimension)
        if not numpy.sum(force * (pressed - still)) > 0:
            raise Breach("4, SurfaceLoad", "a load along -normal does not move the surface along -normal")

    trial_tolerance = 1e-9
    trial_unit = "m/s"


class FluidOrders:
    """Windows for a fluid beside the surface that the case's own structure has at rest."""

    def __init__(self, session):
        self.session = session
        hello = session.start()
        self.duration_s = hello.proposed_step_s
        self.rest, self.mass = session.surface_at_rest
        session.welcome(len(self.rest.area))

    def begin(self, write_frame=False):
        self.session.begin(self.duration_s, write_frame)

    def first_message(self):
        self.begin()
        return {"surface": self.rest}

    def solve(self, velocity=None, repeats=True):
        points, dimension = len(self.rest.area), self.session.dimension
        load = wire.InterfaceCondition(force=[0.0] * (dimension * self.session.interface_particles), reference_pressure=[0.0] * points,
                                    robin_mass=self.mass, repeats=repeats)
        if velocity is not None:
            load.surface_velocity.extend(velocity * numpy.array(self.rest.normal))
        self.session.send(interface_condition=load)
        return numpy.array(self.session.receive("interface_pressure", paragraph="3.3.6").interface_pressure.pressure)

    def window(self, factor=1.0, trials=(), write_frame=False):
        """One window; `trials` are velocities of the surface along its normals [cm/s]."""
        del factor
        self.begin(write_frame)
        self.session.send(surface=self.rest)
        particles = self.session.receive("interface_particles", paragraph="3.3.4").interface_particles
        if not particles.id:
            raise Breach("4, InterfaceParticles", "no interface particle; the case must have fluid beside its structure")
        first = self.solve(repeats=bool(trials))
        answers = [self.solve(0.01 * trial) for trial in trials] or [first]
        self.session.send(interface_force=wire.InterfaceForce(force=[0.0] * len(particles.position)))
        self.end()
        return particles, answers

    def end(self):
        self.done = self.session.receive("window_done", paragraph="3.3.9").window_done
        self.duration_s = self.done.proposed_step_s

    def state(self):
        return numpy.array(self.window()[0].position)

    def sense(self):
        """A surface that moves into the fluid raises its pressure."""
        _, (still, pushed) = self.window(trials=(0.0, 1.0))
        if not numpy.sum(pushed - still) > 0:
            raise Breach("4, InterfaceCondition", "a surface that moves along its normal, into the fluid, does not raise the pressure")

    trial_tolerance = 1e-3  # a pressure is solved to a tolerance, from another first guess
    trial_unit = "Pa"


ORDERS = {"structure": StructureOrders, "fluid": FluidOrders}


# The checks. Each gets a fresh session; its docstring is what the report says when it passes.

def says_hello(s):
    """says hello as the case demands, and leaves with the coupler's exit code when it is refused"""
    s.start()
    s.send(abort=wire.Abort(exit_code=2, sentence="tern conform refuses this participant on purpose."))
    s.expect_end(2)


def waits_for_a_late_coupler(s):
    """waits for a coupler that starts later"""
    s.start(bind_after_s=1.0)


def keeps_the_order(s):
    """keeps the order of calls over six windows of different lengths, and the lengths of its arrays and accounts"""
    orders = ORDERS[s.role](s)
    first = orders.duration_s
    for n, part in enumerate((1.0, 1.0, 0.9, 0.8, 0.9, 1.0)):
        orders.duration_s = part * first
        orders.window(write_frame=n == 2)


def answers_nothing_unasked(s):
    """says nothing that was not asked for"""
    orders = ORDERS[s.role](s)
    orders.window()
    s.quiet_for(0.5, "3.3.8" if s.role == "structure" else "3.3.9", "the end of a window")


def restores_its_state(s):
    """repeats a window from the state it had at its begin: the same trial gets the same answer"""
    orders = ORDERS[s.role](s)
    orders.window()
    _, (first, other, again) = orders.window(trials=(1.0, -2.0, 1.0))
    size = max(numpy.abs(first - other).max(), 1e-300)
    if numpy.abs(first - other).max() == 0:
        raise Breach("3.3.6", "the answer is the same whatever is tried")
    worst = int(numpy.abs(first - again).ravel().argmax())
    if numpy.abs(first - again).max() > orders.trial_tolerance * size:
        raise Breach("3.3.6", f"the same trial got {again.ravel()[worst]:.6g} {orders.trial_unit} instead of "
                              f"{first.ravel()[worst]:.6g} the second time (entry {worst})")


def leaves_no_trace_of_trials(s):
    """is where it would be without the trials that were taken back"""
    orders = ORDERS[s.role](s)
    orders.window(1.0)
    orders.window(1.0, trials=(5.0, -3.0, 0.0) if s.role == "structure" else (1.0, -1.0, 0.0))
    with_trials = orders.state()
    s.vanish()  # its address is needed once more
    with s.another_life() as second:
        orders = ORDERS[s.role](second)
        orders.window(1.0)
        orders.window(1.0, trials=() if s.role == "structure" else (0.0,))
        without = orders.state()
    difference = numpy.abs(with_trials - without).max()
    if difference > 1e-9:
        raise Breach("3.3.6", f"trials that were taken back moved it by {difference:.3g} m")


def has_the_right_sense(s):
    """moves and presses in the right direction"""
    orders = ORDERS[s.role](s)
    orders.window()
    orders.sense()


def passes_a_window(s):
    """has all its particles in its extent, and moves on without a surface, or never offers that"""
    orders = FluidOrders(s)
    orders.window()
    if not orders.done.HasField("extent"):
        return
    extent, farthest = orders.done.extent, 0.5 * orders.done.extent.largest_speed * orders.duration_s
    particles = numpy.array(orders.window()[0].position).reshape(-1, s.dimension)
    outside = numpy.maximum(numpy.array(extent.low) - particles, particles - numpy.array(extent.high)).max(initial=0)
    if outside > 1.001 * farthest:
        raise Breach("4, WindowDone", f"an interface particle is {outside:.3g} m outside extent, {farthest:.3g} m at most at its "
                                      "largest_speed")
    orders.begin()
    s.send(surface=wire.Surface())
    orders.end()
    orders.window()


def _finish(s, interrupted, exit_code):
    orders = ORDERS[s.role](s)
    orders.window()
    orders.window()
    s.send(finish=wire.Finish(interrupted=interrupted))
    s.receive("finished", paragraph="3.4")
    s.expect_end(exit_code, within_s=10.0, paragraph="3.4")


def finishes(s):
    """finishes on order, with exit code 0"""
    _finish(s, interrupted=False, exit_code=0)


def finishes_when_interrupted(s):
    """finishes an interrupted run, with exit code 130"""
    _finish(s, interrupted=True, exit_code=130)


def passes_on_an_abort(s):
    """ends with the exit code of the coupler's Abort"""
    orders = ORDERS[s.role](s)
    orders.window()
    s.send(abort=wire.Abort(exit_code=3, sentence="tern conform stops on purpose."))
    s.expect_end(3)


def notices_a_lost_coupler(s):
    """notices that the coupler is gone, and ends with exit code 4"""
    orders = ORDERS[s.role](s)
    orders.first_message()
    s.vanish()
    s.expect_end(4)


def can_be_interrupted(s):
    """tells the coupler when it is interrupted (Ctrl-C), and ends with exit code 130"""
    orders = ORDERS[s.role](s)
    orders.first_message()
    s.interrupt()
    s.expect_abort(130)


def _refuses(what, change):
    """A check that a message with one fault is answered with Abort 4."""

    def check(s):
        orders = ORDERS[s.role](s)
        orders.window()
        body = orders.first_message()
        change(s, body)
        s.expect_abort(4)

    check.__doc__ = f"refuses {what}, with a sentence and exit code 4"
    return check


def _array(body):
    """The message that is due, and the array of numbers in it that is spoilt."""
    kind, message = next(iter(body.items()))
    copy = type(message)()
    copy.CopyFrom(message)
    return kind, copy, copy.force if kind == "surface_load" else copy.velocity


def _with_value(value):
    def change(s, body):
        kind, message, array = _array(body)
        array[len(array) // 2] = value
        s.send(**{kind: message})
    return change


def _shorter(s, body):
    kind, message, array = _array(body)
    del array[-1]
    s.send(**{kind: message})


def _with_envelope(**envelope):
    return lambda s, body: s.send(envelope=envelope, **body)


def _twice(s, body):
    s.send(envelope={"sequence": s.last_sequence}, **body)


def _other_kind(s, body):
    del body
    s.send(welcome=wire.Welcome(surface_points=s.points))


def _frames(*frames):
    return lambda s, body: s.send(frames=list(frames))


def _oversized(s, body):
    del body
    s.on_its_way_s = LARGEST_S
    s.send(frames=[bytes(MAX_MESSAGE_BYTES + 1)])


def _gap_in_time(s):
    orders = ORDERS[s.role](s)
    orders.window()
    s.begin_ticks += 1000
    s.begin(orders.duration_s)
    s.expect_abort(4)


_gap_in_time.__doc__ = "refuses a window that does not begin where the last one ended, with a sentence and exit code 4"


def _wrong_version_at_welcome(s):
    hello = s.start()
    s.welcome(len(hello.surface.body) or 1, envelope={"protocol_version": PROTOCOL_VERSION + 7})
    s.expect_abort(4)


_wrong_version_at_welcome.__doc__ = "refuses a coupler of another protocol version, with a sentence and exit code 4"

CHECKS = {
    "hello": says_hello,
    "late coupler": waits_for_a_late_coupler,
    "version": _wrong_version_at_welcome,
    "order": keeps_the_order,
    "silence": answers_nothing_unasked,
    "restore": restores_its_state,
    "trace": leaves_no_trace_of_trials,
    "sense": has_the_right_sense,
    "extent": passes_a_window,
    "finish": finishes,
    "finish interrupted": finishes_when_interrupted,
    "abort": passes_on_an_abort,
    "lost coupler": notices_a_lost_coupler,
    "interrupt": can_be_interrupted,
    "not finite": _refuses("a number that is not finite", _with_value(float("nan"))),
    "infinite": _refuses("an infinite number", _with_value(float("inf"))),
    "short array": _refuses("an array that is too short", _shorter),
    "other step": _refuses("a message of another step", _with_envelope(step=99)),
    "lost message": _refuses("a gap in the sequence", _with_envelope(sequence=999)),
    "duplicate": _refuses("a message that came before", _twice),
    "other sender": _refuses("a message in the name of another", _with_envelope(sender=wire.FLUID)),
    "out of turn": _refuses("a message that is not due", _other_kind),
    "no body": _refuses("a message without a body", lambda s, body: s.send()),
    "garbage": _refuses("bytes that are no message", _frames(b"\xff\xfe\xfd\xfc" * 8)),
    "two frames": _refuses("a message of two frames", _frames(b"", b"")),
    "oversized": _refuses("a message above the size limit, unread", _oversized),
    "gap in time": _gap_in_time,
}
NEEDS_PROCESS = {"interrupt"}
OF_FLUID = {"extent"}


def run(subject, names, surface_at_rest, say):
    """Runs the named checks. Returns {name: None or Breach}, and tells `say` the outcome of each as it comes."""
    findings = {}
    for name in names:
        if name in OF_FLUID and subject.role != "fluid":
            continue
        if subject.command is None and name in NEEDS_PROCESS:
            say(f"  -    {name}: not checked, it needs a command instead of an address")
            continue
        with _session(subject, surface_at_rest, say) as session:
            try:
                CHECKS[name](session)
                findings[name] = None
                say(f"  ok   {name}: {CHECKS[name].__doc__}")
            except Breach as breach:
                findings[name] = breach
                say(f"  NO   {name}: {breach} [docs/PROTOCOL.md, {breach.paragraph}]")
    return findings


def _session(subject, surface_at_rest, say):
    session = Session(subject, say)
    session.surface_at_rest = surface_at_rest
    session.another_life = lambda: _session(subject, surface_at_rest, say)
    return session


def surface_of(structure_subject, say):
    """The surface that the case's own structure has in its first window, and the mass behind it: what a fluid is shown."""
    with _session(structure_subject, None, say) as session:
        orders = StructureOrders(session)
        surface = orders.begin()
        surface.ClearField("account")
        return surface, list(orders.mass)
