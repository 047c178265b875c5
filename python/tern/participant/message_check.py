"""Checks of a message before its content is used (docs/PROTOCOL.md, section 4): lengths, finiteness, physical bounds."""

import numpy

MAX_MESSAGE_BYTES = 256 << 20
MAX_IMAGES = 7  # of an interface particle in walls


class BadMessage(Exception):
    """A message that must not be used; the text names field, index, value and limit."""


def _length(field, values, expected):
    if len(values) != expected:
        raise BadMessage(f"{field} has {len(values)} entries; it must have {expected}")


def _numbers(field, values, holds=lambda v: numpy.ones(v.shape, bool), limit="finite"):
    array = numpy.array(values, dtype=float)
    bad = ~(numpy.isfinite(array) & holds(array))
    if bad.any():
        index = int(numpy.argmax(bad))
        raise BadMessage(f"{field}[{index}] is {array[index]:g}; it must be {limit}")


def _positive(field, values):
    _numbers(field, values, lambda v: v > 0, "finite and above 0")


def _response(body, surface_points):
    """Lumps of an InterfaceCondition: as many for every point, each of which there is."""
    entries, lumps = len(body.lump), len(body.lump_mass)
    if entries % surface_points if surface_points else entries:
        raise BadMessage(f"lump has {entries} entries; it must have as many for each of the {surface_points} surface points")
    _length("share", body.share, entries)
    if lumps > entries:
        raise BadMessage(f"lump_mass has {lumps} entries; lump names at most {entries}")
    for entry, lump in enumerate(body.lump):
        if lump >= lumps:
            raise BadMessage(f"lump[{entry}] is {lump}, but {lumps} masses of lumps were sent")
    _numbers("share", body.share, lambda v: v >= 0, "finite and 0 or more")
    _positive("lump_mass", body.lump_mass)


def _surface(body, dimension, surface_points):
    for field in ("position", "velocity", "normal"):
        _length(field, getattr(body, field), dimension * surface_points)
        _numbers(field, getattr(body, field))
    _length("area", body.area, surface_points)
    _positive("area", body.area)
    lengths = numpy.linalg.norm(numpy.array(body.normal).reshape(-1, dimension), axis=1)
    _numbers("length of normal", lengths, lambda v: abs(v - 1) <= 1e-6, "1 to within 1e-6")


def _account(account, hello):
    for field in ("energy", "gauge"):
        if hello is not None:
            _length(f"account.{field}", getattr(account, field), len(getattr(hello.account, field)))
        _numbers(f"account.{field}", getattr(account, field))
    _length("account.undefined", account.undefined, len(account.gauge))
    for index, (value, undefined) in enumerate(zip(account.gauge, account.undefined)):
        if undefined and value != 0:
            raise BadMessage(f"account.gauge[{index}] is {value:g} although undefined; it must be 0")


def _extent(extent, dimension):
    for field in ("low", "high"):
        _length(f"extent.{field}", getattr(extent, field), dimension)
        _numbers(f"extent.{field}", getattr(extent, field))
    for axis, (low, high) in enumerate(zip(extent.low, extent.high)):
        if low > high:
            raise BadMessage(f"extent.low[{axis}] is {low:g}, above extent.high[{axis}] = {high:g}")
    for field in ("largest_speed", "reach"):
        _numbers(f"extent.{field}", [getattr(extent, field)], lambda v: v >= 0, "finite and 0 or more")


def check_from_participant(message, role, dimension, surface_points, interface_particles, hello):
    """Raises BadMessage when the body of a message of a participant cannot be used; `hello` is None before it was sent."""
    kind = message.WhichOneof("body")
    body = getattr(message, kind)
    if kind == "hello":
        _account(body.account, None)
        _numbers("proposed_step_s", [body.proposed_step_s], lambda v: v >= 0, "finite and 0 or more")
        points = len(body.surface.body)
        if (points > 0) != (role == "structure"):
            raise BadMessage(f"surface.body has {points} entries; a structure must have at least one, a fluid none")
        for field in ("section_mass", "impedance", "least_mass"):
            _length(f"surface.{field}", getattr(body.surface, field), points)
            _positive(f"surface.{field}", getattr(body.surface, field))
    elif kind == "surface":
        _surface(body, dimension, surface_points)
        _account(body.account, hello)
    elif kind == "surface_velocity":
        _length("velocity", body.velocity, dimension * surface_points)
        _numbers("velocity", body.velocity)
    elif kind == "interface_particles":
        particles = len(body.id)
        if len(set(body.id)) != particles:
            raise BadMessage("id has the same label twice; labels must be distinct")
        for field in ("position", "velocity"):
            _length(field, getattr(body, field), dimension * particles)
            _numbers(field, getattr(body, field))
        for field in ("mass", "volume"):
            _length(field, getattr(body, field), particles)
            _positive(field, getattr(body, field))
        _length("divergence", body.divergence, particles if body.divergence else 0)
        _numbers("divergence", body.divergence)
        if len(body.image_of) > MAX_IMAGES * particles:
            raise BadMessage(f"image_of has {len(body.image_of)} entries; the limit is {MAX_IMAGES} per particle")
        _length("image_position", body.image_position, dimension * len(body.image_of))
        _numbers("image_position", body.image_position)
        for entry, particle in enumerate(body.image_of):
            if particle >= particles:
                raise BadMessage(f"image_of[{entry}] is {particle}, but {particles} particles were sent")
        for entry, point in enumerate(body.covered):
            if point >= surface_points or (entry > 0 and point <= body.covered[entry - 1]):
                raise BadMessage(f"covered[{entry}] is {point}; it must be above the one before and below {surface_points}, "
                                 "the number of surface points")
    elif kind == "interface_pressure":
        _length("pressure", body.pressure, interface_particles)
        _numbers("pressure", body.pressure)
        _length("velocity", body.velocity, dimension * interface_particles)
        _numbers("velocity", body.velocity)
    elif kind == "window_done":
        _positive("proposed_step_s", [body.proposed_step_s])
        _account(body.account, hello)
        if body.HasField("extent"):
            _extent(body.extent, dimension)
    elif kind == "finished":
        _account(body.account, hello)
    elif kind == "abort":
        if body.exit_code not in (2, 3, 4, 5, 130):
            raise BadMessage(f"exit_code is {body.exit_code}; it must be 2, 3, 4, 5 or 130")
        if not 1 <= len(body.sentence.encode()) <= 4096:
            raise BadMessage(f"sentence has {len(body.sentence.encode())} bytes; it must have 1 to 4096")


def check_body(message, dimension, surface_points, interface_particles, projected=False, extent=False):
    """Raises BadMessage when the body of a message of the coupler cannot be used by a participant.

    `projected`: this participant has sent an interface_pressure in this window, so that an interface_condition repeats it.
    `extent`: its last window_done had one, so that a surface may be empty.
    """
    kind = message.WhichOneof("body")
    body = getattr(message, kind)
    if kind == "begin_window":
        if body.begin_ticks < 0 or body.duration_ticks <= 0:
            raise BadMessage(f"begin_ticks is {body.begin_ticks} and duration_ticks is {body.duration_ticks}; "
                             "they must be at least 0 and 1")
    elif kind == "surface":
        _surface(body, dimension, 0 if extent and not body.area else surface_points)
    elif kind == "interface_condition":
        _length("force", body.force, dimension * interface_particles)
        _length("reference_pressure", body.reference_pressure, surface_points)
        _response(body, surface_points)
        _length("surface_velocity", body.surface_velocity, dimension * surface_points if projected else 0)
        _numbers("surface_velocity", body.surface_velocity)
        if body.answered_change:
            _length("answered_change", body.answered_change, 0 if projected else dimension * surface_points)
        _numbers("answered_change", body.answered_change)
        _numbers("force", body.force)
        _numbers("reference_pressure", body.reference_pressure)
        _numbers("answer_tolerance", [body.answer_tolerance], lambda v: (v >= 0) & (v <= 1), "from 0 to 1")
    elif kind == "interface_force":
        _length("force", body.force, dimension * interface_particles)
        _numbers("force", body.force)
    elif kind == "surface_load":
        _length("force", body.force, dimension * surface_points)
        _numbers("force", body.force)
