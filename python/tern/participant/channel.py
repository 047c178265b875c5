"""One participant (fluid or structure) in Python: the counterpart of ParticipantChannel in proto/transport/channel.hpp.

    channel = Participant("ipc:///tmp/x/tern.sock", wire.FLUID)
    channel.handshake(hello)                       # wire.Hello
    message = channel.receive("begin_window", "finish")
    channel.send(interface_particles=wire.InterfaceParticles(...))

Over a network: Participant("tcp://HOST:PORT", wire.FLUID, keys="DIR"), with the keys that ./tern keys made for this role.
Needs python3-zmq, python3-protobuf, python3-numpy and protobuf-compiler. See docs/PROTOCOL.md for who sends what when.
"""

import os
import time

import zmq
from zmq.utils.monitor import recv_monitor_message

from tern.errors import NUMERICAL_FAILURE
from tern.participant.message_check import MAX_MESSAGE_BYTES, BadMessage, check_body
from tern.participant.schema import wire
from tern.participant.security import EVENTS, CannotConnect, Handshake
from tern.participant.silence import LONGEST_TURN_S, Silence

PROTOCOL_VERSION = 6
HEARTBEAT_INTERVAL_MS = 1000
LINGER_MS = 500


class RunEnded(Exception):
    """The run cannot go on. `exit_code` is what the process should end with: 2, 3, 4, 5 or 130."""

    def __init__(self, exit_code, sentence):
        super().__init__(sentence)
        self.exit_code = exit_code


class NumericalFailure(RunEnded):
    """The solver has found no answer. ./tern run has the windows repeated at half their length."""

    def __init__(self, sentence):
        super().__init__(NUMERICAL_FAILURE, sentence)


class Participant:
    def __init__(self, endpoint, role, start_deadline_s=300.0, progress_deadline_s=300.0, keys=None, insecure=False):
        self._role = role
        self._endpoint = endpoint
        self._deadlines = (start_deadline_s, progress_deadline_s)
        self._sent = self._received = 0
        self._dimension = self._surface_points = self._interface_particles = 0
        self._next_begin_ticks = None
        self._lost = self._projected = self._extent = False
        self._silence = Silence()
        self.step = 0
        try:
            self._handshake = Handshake(endpoint, wire.Role.Name(role).lower(), keys, insecure)
        except CannotConnect as fault:
            raise RunEnded(2, str(fault)) from None
        self._context = zmq.Context()
        self._socket = self._context.socket(zmq.DEALER)
        for option, value in ((zmq.LINGER, LINGER_MS), (zmq.HEARTBEAT_IVL, HEARTBEAT_INTERVAL_MS), (zmq.HEARTBEAT_TIMEOUT, 0),
                              (zmq.RECONNECT_IVL, 20), (zmq.MAXMSGSIZE, 2 * MAX_MESSAGE_BYTES)):
            self._socket.setsockopt(option, value)
        self._monitor = self._socket.get_monitor_socket(EVENTS)
        self._handshake.connect(self._socket)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        """Leaves; messages on their way get at most 0.5 s."""
        self._socket.disable_monitor()
        self._monitor.close(0)
        self._socket.close()
        self._context.term()

    def handshake(self, hello):
        """Says hello, returns wire.Welcome. Raises RunEnded with exit code 2 when the two do not fit."""
        hello.process_id = os.getpid()
        self._dimension = hello.dimension
        self.send(hello=hello)
        welcome = self._receive(("welcome",), connected=False).welcome
        own = len(hello.surface.body)
        if own and own != welcome.surface_points:
            self._fail(f"surface_points is {welcome.surface_points}; it must be {own} as in Hello")
        self._surface_points = welcome.surface_points
        if welcome.resume_step:
            self.step, self._next_begin_ticks, self._extent = welcome.resume_step, welcome.resume_ticks, welcome.extent
        return welcome

    def send(self, **body):
        """send(interface_particles=wire.InterfaceParticles(...)): completes the envelope and sends it."""
        self._sent += 1
        if "interface_particles" in body:
            self._interface_particles = len(body["interface_particles"].id)
        self._projected = "interface_pressure" in body
        if "saved" not in body:
            self._extent = "window_done" in body and body["window_done"].HasField("extent")
        message = wire.Message(protocol_version=PROTOCOL_VERSION, sender=self._role, sequence=self._sent, step=self.step, **body)
        self._socket.send(message.SerializeToString(), zmq.DONTWAIT)

    def abort(self, exit_code, sentence):
        """Tells the coupler why this process ends, once; its own Abort is not sent back."""
        if not self._lost:
            self._lost = True
            self.send(abort=wire.Abort(exit_code=exit_code, sentence=sentence))

    def receive(self, *kinds):
        """Waits for the coupler's next message, checks it and returns it. Raises RunEnded."""
        return self._receive(kinds, connected=True)

    def _fail(self, reason):
        sentence = f"The coupler process sent a message that cannot be used at step {self.step}: {reason}."
        self.abort(4, sentence)
        raise RunEnded(4, sentence)

    def _receive(self, kinds, connected):
        looked, present_s, deadline_s = time.monotonic(), 0.0, self._deadlines[connected]
        while True:
            if self._socket.poll(0):
                return self._take(kinds)
            if self._lost:
                raise RunEnded(4, f"The coupler process was lost at step {self.step}.")
            while self._monitor.poll(0):
                message = recv_monitor_message(self._monitor)
                if message["event"] == zmq.EVENT_CONNECTED:
                    self._silence.connection = message["value"]
                if connected:
                    self._lost |= message["event"] == zmq.EVENT_DISCONNECTED
                elif message["event"] == zmq.EVENT_HANDSHAKE_SUCCEEDED:
                    # The coupler answers when everybody has come, and is the first to give up.
                    connected, present_s, deadline_s = True, 0.0, 2 * self._deadlines[0]
                else:
                    try:
                        self._handshake.hear(message["event"], message["value"])
                    except CannotConnect as fault:
                        raise RunEnded(2, str(fault)) from None
            if self._lost:
                continue  # its last words may have arrived before the end of the connection
            # Only the time counts in which this process was there: a turn that took longer than it asked for counts as long as that.
            before, looked = looked, time.monotonic()
            present_s += min(looked - before, LONGEST_TURN_S)
            self._lost |= connected and self._silence.too_long(present_s)
            if present_s > deadline_s:
                raise RunEnded(4, f"No message of the coupler at {self._endpoint} at step {self.step} "
                                  f"for {deadline_s:g} s.")
            poller = zmq.Poller()
            poller.register(self._socket, zmq.POLLIN)
            poller.register(self._monitor, zmq.POLLIN)
            poller.poll(1000 * LONGEST_TURN_S)

    def _take(self, kinds):
        frames = self._socket.recv_multipart()
        if len(frames) != 1 or len(frames[0]) > MAX_MESSAGE_BYTES:
            self._fail(f"{len(frames)} frames of {len(frames[0])} bytes")
        try:
            message = wire.Message.FromString(frames[0])
        except Exception as error:  # DecodeError; its module differs between versions of protobuf
            self._fail(f"{len(frames[0])} bytes that are not a message ({error})")
        kind = message.WhichOneof("body")
        if kind == "abort" and message.sender == wire.COUPLER:
            self._lost = True
            raise RunEnded(message.abort.exit_code, f"The coupler process stopped: {message.abort.sentence}")
        self._received += 1
        expected = {"protocol_version": PROTOCOL_VERSION, "sender": wire.COUPLER, "sequence": self._received,
                    "step": self.step + (kind == "begin_window")}
        for field, value in expected.items():
            if getattr(message, field) != value:
                self._fail(f"{field} is {getattr(message, field)}; it must be {value}")
        if kind not in kinds:
            self._fail(f"body is {kind}; it must be {' or '.join(kinds)} now")
        try:
            check_body(message, self._dimension, self._surface_points, self._interface_particles, self._projected, self._extent)
        except BadMessage as fault:
            self._fail(f"{kind}: {fault}")
        if kind == "begin_window":
            window = message.begin_window
            if self._next_begin_ticks not in (None, window.begin_ticks):
                self._fail(f"begin_ticks is {window.begin_ticks}; it must be {self._next_begin_ticks}")
            self._next_begin_ticks = window.begin_ticks + window.duration_ticks
            self.step = message.step
        return message
