"""The fluid's side of a run: the loop of docs/PROTOCOL.md around a solver.

    run_fluid(MySolver)                # MySolver(case, options): case is side.Case, options the command line

A solver has
    propose_step()                     (largest length of the next window [s], the name of what limits it)
    begin_window(time_s, duration_s)   predicts velocity and position without pressure
    see_surface(surface)               Surface, halfway through the window, with the velocity at its end; returns InterfaceParticles
    solve_pressure(load)               load: wire.InterfaceCondition; returns their (pressure, velocity). When asked again in a
                                       window, it undoes the last answer and takes the surface to move as load.surface_velocity says;
                                       of what the pressure changes by it may miss the part load.answer_tolerance
    end_window(force)                  the force of the interface on each interface particle: moves to the end of the window
    energies()                         (kinetic, potential) [J/m^(3-D)]
    gauge(gauge)                       values of a gauge of the case, None if it has none at this instant
    fields()                           dict for a frame: position, velocity, pressure of its points, and scalars of any name
    iterations                         of the last pressure solve, for steps.csv
and may have
    extent()                           wire.Extent of the fluid at the end of the window: while the surface is out of its reach none
                                       is sent, and in place of the three calls after begin_window() there is
    pass_window()                      moves to the end of the window without a surface
and, so that a run with it can be continued from a checkpoint (./tern resume),
    save()                             dict of arrays by name from which it goes on after the present window, with the same bits
    restore(saved)                     goes back to what save() has given, in a solver that was just made
"""

import sys
from dataclasses import dataclass

import numpy

from tern.participant.frames import FrameWriter
from tern.participant.schema import wire
from tern.participant.side import TICKS_PER_SECOND, finite, run_participant
from tern.participant.structure_side import Surface


@dataclass
class InterfaceParticles:
    """The particles near the surface, one row each: predicted position and velocity, and the divergence of the velocity."""

    id: numpy.ndarray
    position: numpy.ndarray
    velocity: numpy.ndarray
    mass: numpy.ndarray
    volume: numpy.ndarray
    divergence: numpy.ndarray
    image_of: numpy.ndarray = ()  # rows of which walls have an image before the surface, and the places of the images
    image_position: numpy.ndarray = ()
    covered: numpy.ndarray = ()  # surface points that look into a wall, ascending


def _obey(run, make_solver):
    case = run.case
    with run.timed("compute"):
        solver = make_solver(case, run.options)
    frames = FrameWriter(run.options.out, "fluid", case.dimension, anew=not run.resumes)
    written = -1
    saves = hasattr(solver, "save") and hasattr(solver, "restore")

    def account():
        return run.account(dict(zip(("kinetic", "potential"), solver.energies())), solver.gauge)

    def write_frame():
        nonlocal written
        if written != run.report.steps:
            with run.timed("output"):
                frames.write(run.report.time_s, run.report.steps, solver.fields())
            written = run.report.steps

    def vectors(values):
        return numpy.array(values).reshape(-1, case.dimension)

    def flat(name, values):
        return finite(f"{name} of the interface particles", values, run.channel.step)

    def end_window(order):
        with run.timed("compute"):
            proposed, limit = solver.propose_step()
            extent = solver.extent() if hasattr(solver, "extent") else None
        run.send(window_done=wire.WindowDone(proposed_step_s=proposed, limit=limit, iterations=solver.iterations, account=account(),
                                             extent=extent))
        run.step_done(order)
        if order.begin_window.write_frame:
            write_frame()

    def keep():
        return {f"solver.{name}": values for name, values in solver.save().items()} | {"frames": frames.mark(), "written": written}

    if not run.resumes:
        write_frame()
    proposed, limit = solver.propose_step()
    welcome = run.handshake(wire.Hello(particles=len(solver.fields()["position"]), proposed_step_s=proposed, limit=limit,
                                       account=account()), saves)
    if run.resumes:
        kept = run.restored(welcome)
        solver.restore({name.removeprefix("solver."): values for name, values in kept.items() if name.startswith("solver.")})
        frames.go_back(kept["frames"])
        written = int(kept["written"])
    while (order := run.next_order(keep if saves else None)).WhichOneof("body") == "begin_window":
        window = order.begin_window
        with run.timed("compute"):
            solver.begin_window(window.begin_ticks / TICKS_PER_SECOND, window.duration_ticks / TICKS_PER_SECOND)
        surface = run.receive("surface").surface
        if not surface.area:
            with run.timed("compute"):
                solver.pass_window()
            end_window(order)
            continue
        with run.timed("compute"):
            particles = solver.see_surface(Surface(vectors(surface.position), vectors(surface.velocity), vectors(surface.normal),
                                              numpy.array(surface.area)))
        run.send(interface_particles=wire.InterfaceParticles(id=[int(label) for label in particles.id],
                                position=flat("position", particles.position),
                                velocity=flat("velocity", particles.velocity), mass=flat("mass", particles.mass),
                                volume=flat("volume", particles.volume), divergence=flat("divergence", particles.divergence),
                                image_of=[int(row) for row in particles.image_of],
                                image_position=flat("image_position", particles.image_position),
                                covered=[int(point) for point in particles.covered]))
        message = run.receive("interface_condition")
        while message.WhichOneof("body") == "interface_condition":
            with run.timed("compute"):
                pressure, velocity = solver.solve_pressure(message.interface_condition)
            run.send(interface_pressure=wire.InterfacePressure(pressure=flat("pressure", pressure), velocity=flat("velocity", velocity)))
            message = run.receive("interface_condition", "interface_force")
        with run.timed("compute"):
            solver.end_window(vectors(message.interface_force.force))
        end_window(order)
    write_frame()
    run.finish(order, account())


def run_fluid(make_solver, add_options=None):
    """The whole main() of a fluid: ends the process. `add_options(parser)` may add options of the solver's own."""
    sys.exit(run_participant("fluid", lambda run: _obey(run, make_solver), add_options))
