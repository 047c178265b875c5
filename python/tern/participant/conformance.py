"""Does a participant keep the protocol? A stand-in for the coupler that asks for everything a coupler may ask for, breaks
the rules on purpose, and says of every deviation which paragraph of docs/PROTOCOL.md it breaks. ./tern conform runs it.

Most checks start the participant anew: as a command, or, where there is none, by asking the user to start it.
"""

import numpy

from tern.participant import conformance_load as load
from tern.participant import conformance_motion as motion
from tern.participant.channel import PROTOCOL_VERSION
from tern.participant.conformance_orders import ORDERS, FluidOrders, StructureOrders
from tern.participant.conformance_session import Breach, CannotBind, Session, Subject
from tern.participant.message_check import MAX_MESSAGE_BYTES
from tern.participant.schema import wire

__all__ = ["CHECKS", "CannotBind", "Subject", "run", "surface_of"]
LARGEST_S = 10.0     # for 256 MiB on their way to it, on a busy machine


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
    "heartbeat": motion.sends_heartbeats,
    "shape": motion.has_the_shape_of_the_case,
    "last load": motion.keeps_the_last_load,
    "trial": motion.answers_the_last_load_as_its_surface,
    "motion": motion.goes_where_its_velocity_says,
    "middle": motion.is_halfway_through_the_window,
    "faces": load.moves_along_with_the_load,
    "work": load.accounts_for_the_work,
    "energy": load.gains_no_energy_of_its_own,
    "account": motion.accounts_for_the_begin,
    "gauge": motion.gauges_its_own_motion,
}
NEEDS_PROCESS = {"interrupt"}
OF_FLUID = {"extent"}
OF_STRUCTURE = {"shape", "last load", "trial", "motion", "middle", "faces", "work", "energy", "account", "gauge"}


def run(subject, names, surface_at_rest, say):
    """Runs the named checks. Returns {name: None or Breach}, and tells `say` the outcome of each as it comes."""
    findings = {}
    for name in names:
        if name in (OF_STRUCTURE if subject.role == "fluid" else OF_FLUID):
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
