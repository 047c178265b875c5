"""Checks of a received message before its content is used (docs/PROTOCOL.md): lengths, finiteness, physical bounds."""

import numpy

MAX_MESSAGE_BYTES = 256 << 20


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


def check_body(message, dimension, surface_points, band_particles, projected=False):
    """Raises BadMessage when the body of a message of the coupler cannot be used by a participant.

    `projected`: this participant has sent a band_pressure in this window, so that a dissipative_load repeats it.
    """
    kind = message.WhichOneof("body")
    body = getattr(message, kind)
    if kind == "begin_window":
        if body.begin_ticks < 0 or body.duration_ticks <= 0:
            raise BadMessage(f"begin_ticks is {body.begin_ticks} and duration_ticks is {body.duration_ticks}; "
                             "they must be at least 0 and 1")
    elif kind == "surface":
        for field in ("position", "velocity", "normal"):
            _length(field, getattr(body, field), dimension * surface_points)
            _numbers(field, getattr(body, field))
        _length("area", body.area, surface_points)
        _positive("area", body.area)
        lengths = numpy.linalg.norm(numpy.array(body.normal).reshape(-1, dimension), axis=1)
        _numbers("length of normal", lengths, lambda v: abs(v - 1) <= 1e-6, "1 to within 1e-6")
    elif kind == "dissipative_load":
        _length("force", body.force, dimension * band_particles)
        _length("reference_pressure", body.reference_pressure, surface_points)
        _length("robin_mass", body.robin_mass, surface_points)
        _length("surface_velocity", body.surface_velocity, dimension * surface_points if projected else 0)
        _numbers("surface_velocity", body.surface_velocity)
        _numbers("force", body.force)
        _numbers("reference_pressure", body.reference_pressure)
        _numbers("robin_mass", body.robin_mass, lambda v: v >= 0, "finite and 0 or more")
    elif kind == "band_force":
        _length("force", body.force, dimension * band_particles)
        _numbers("force", body.force)
    elif kind == "surface_load":
        _length("force", body.force, dimension * surface_points)
        _numbers("force", body.force)
