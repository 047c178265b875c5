#!/usr/bin/python3 -B
"""A structure by GetFEM: quadratic finite elements, the compressible neo-Hookean solid of tern's structure, plane strain.

    ./tern run cases/dam_break_plate --structure getfem_structure.py

One body that is a box in 2D, clamps that are boxes and do not move, gravity. Elements of nine nodes (4 x 4 Gauss points), two
across the thinner side; lines of the mesh follow the clamps, and what they hold is not meshed. In time TR-BDF2: the trapezoidal
rule to t + g dt, g = 2 - sqrt(2), then the backward formula to t + dt, second order and damping what the step does not resolve.
Both stages solve M (u - u*)/h^2 = f(u) with h = g dt/2, by Newton's method with a factor of M/h^2 + K that serves for many steps.

A surface point is carried by the shape functions of the element behind it, and the force on it goes to the nodes by the same
functions. Normal and area follow from the deformed ends of its piece of the face.
"""

import getfem as gf
import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import splu

from tern.participant import NumericalFailure, Surface, bad_input, cut_box, run_structure

GAMMA = 2 - np.sqrt(2)
ELEMENTS_ACROSS = 2
TOLERANCE = 1e-8  # of a Newton step, in elements
MOST_STEPS = 16   # a window is divided into, when Newton's method fails


class NotConverged(Exception):
    pass


def matrix(spmat):
    """A matrix of GetFEM as one of SciPy."""
    starts, rows = spmat.csc_ind()
    return sparse.csc_matrix((spmat.csc_val(), rows, starts), shape=spmat.size())


def mesh_lines(low, high, size, cuts):
    """Coordinates from low to high in steps of about `size` that contain all `cuts`."""
    corners = sorted({low, high, *(cut for cut in cuts if low < cut < high)})
    return np.unique(np.concatenate([np.linspace(a, b, max(1, round((b - a) / size)) + 1) for a, b in zip(corners, corners[1:])]))


class Solid:
    """Mesh, mass and internal force of the free part of the body."""

    def __init__(self, low, high, clamps, density, lame, size):
        lines = [mesh_lines(low[a], high[a], size, [box[side][a] for box in clamps for side in (0, 1)]) for a in (0, 1)]
        mesh = gf.Mesh("cartesian", *lines)
        held = [element for element in mesh.cvid() if self._inside(clamps, mesh.pts_from_cvid([element])[0].mean(axis=1)[:, None])[0]]
        mesh.del_convex(held)
        if mesh.nbcvs() == 0:
            raise bad_input("No part of the body is free: its clamps contain all of it.")
        self.space, self.scalar = gf.MeshFem(mesh, 2), gf.MeshFem(mesh, 1)
        for space in (self.space, self.scalar):
            space.set_fem(gf.Fem("FEM_QK(2,2)"))
        integration = gf.MeshIm(mesh, gf.Integ("IM_GAUSS_PARALLELEPIPED(2,7)"))
        self.nodes = self.scalar.basic_dof_nodes()
        self.clamped = self._inside(clamps, self.nodes)
        self.free = np.flatnonzero(~self._inside(clamps, self.space.basic_dof_nodes()))
        self.lame = lame
        self.mass = density * matrix(gf.asm_mass_matrix(integration, self.space))
        self.mass_free = self.mass[self.free][:, self.free].tocsc()
        gf.util_trace_level(1)
        self._model = gf.Model("real")
        self._model.add_fem_variable("u", self.space)
        self._model.add_initialized_data("la", lame[0])
        self._model.add_initialized_data("mu", lame[1])
        self._model.add_macro("F", "Id(2) + Grad_u")
        self._model.add_nonlinear_term(integration, "(mu*(F - Inv(F)') + la*log(Det(F))*Inv(F)'):Grad_Test_u")
        self._integration = integration

    @staticmethod
    def _inside(boxes, points):
        hair = 1e-9
        return np.array([any((a - hair <= x).all() and (x <= b + hair).all() for a, b in boxes) for x in points.T])

    def force(self, u):
        """Elastic force on the free unknowns [N/m]; not finite where an element is turned inside out."""
        self._model.set_variable("u", u)
        self._model.assembly("build_rhs")
        return self._model.rhs()[self.free]

    def stiffness(self, u):
        self._model.set_variable("u", u)
        self._model.assembly("build_matrix")
        return matrix(self._model.tangent_matrix())[self.free][:, self.free]

    def strain_energy(self, u):
        self._model.set_variable("u", u)
        return gf.asm_generic(self._integration, 0, "mu/2*(Norm_sqr(F) - 2) - mu*log(Det(F)) + la/2*sqr(log(Det(F)))", -1, self._model)

    def carried(self, points):
        """Matrix from the nodal displacements to those of material points, x0 y0 x1 y1 ..."""
        return matrix(gf.asm_interpolation_matrix(self.space, points.T))

    def shear_stress(self, u):
        """Cauchy stress sigma_xy at the nodes [Pa]."""
        gradient = gf.compute_gradient(self.space, u, self.scalar)
        f = np.eye(2)[:, :, None] + gradient
        j = f[0, 0] * f[1, 1] - f[0, 1] * f[1, 0]
        return self.lame[1] / j * (f[0, 0] * f[1, 0] + f[0, 1] * f[1, 1])


class GetfemStructure:
    def __init__(self, case, options):
        body, (low, high) = case.only_body(), case.body_box()
        structure = case.settings["structure"]
        clamps = body["clamp"] + [clamp["region"] for clamp in structure.get("clamp", [])]
        for sentence, refused in {
                "it is not in 2D": case.dimension != 2,
                "a clamp is not a box": any("box" not in shape for shape in clamps),
                "a clamp moves": any(key in clamp for clamp in structure.get("clamp", [])
                                     for key in ("displacement", "rotation", "motion_file")),
                "it has loads": structure.get("load"), "the body has mass_damping": body.get("mass_damping"),
                f"the material is {body['material']}": body["material"] != "neo_hookean",
                "it is in plane stress": body.get("plane") == "stress", "the body moves at the start": body.get("velocity"),
                "no clamp holds the body": not clamps}.items():
            if refused:
                raise bad_input(f"{case.path}: this solver cannot take the case, for {sentence}.")
        boxes = [(np.array(shape["box"]["min"]), np.array(shape["box"]["max"])) for shape in clamps]
        e, nu, density = body["young_modulus"], body["poisson_ratio"], body["density"]
        lame = (e * nu / ((1 + nu) * (1 - 2 * nu)), e / (2 * (1 + nu)))
        self.size = min(high - low) / options.across
        self.solid = Solid(low, high, boxes, density, lame, self.size)
        self.position, self.normal, self.area, thickness, wet = cut_box(low, high, case.face_length(body), boxes)
        along = 0.5 * self.area[:, None] * np.column_stack([-self.normal[:, 1], self.normal[:, 0]])
        self.middle, self.first, self.second = (self.solid.carried(self.position + shift) for shift in (0 * along, -along, along))
        self.ends = self.position - along, self.position + along
        self.gauges = {gauge["name"]: self.solid.carried(np.array([gauge["at"]])) for gauge, _ in case.gauges("structure")
                       if gauge["kind"] == "displacement"}
        points = len(self.area)
        self.report = {"body": [0] * points, "section_mass": density * thickness / wet, "least_mass": [density * self.size / 2] * points,
                       "impedance": [np.sqrt(density * (lame[0] + 2 * lame[1]))] * points}
        unknowns = self.solid.space.nbdof()
        self.weight = self.solid.mass @ np.tile(case.gravity, unknowns // 2)
        self.state = (np.zeros(unknowns), np.zeros(unknowns))
        self.factor = self.factor_h = self.factored_at = None

    def properties(self):
        return self.report

    def surface(self):
        u, v = self.state
        first, second = (end + (carried @ u).reshape(-1, 2) for end, carried in zip(self.ends, (self.first, self.second)))
        along = second - first
        area = np.linalg.norm(along, axis=1)
        return Surface(self.position + (self.middle @ u).reshape(-1, 2), (self.middle @ v).reshape(-1, 2),
                       np.column_stack([along[:, 1], -along[:, 0]]) / area[:, None], area)

    def advance(self, time_s, duration_s, force):
        load = (self.middle.T @ force.ravel() + self.weight)[self.solid.free]
        steps = 1
        while True:
            state = self.state
            try:
                for _ in range(steps):
                    state = self._step(*state, load, duration_s / steps)
            except NotConverged as fault:
                steps *= 2
                if steps > MOST_STEPS:
                    raise NumericalFailure(f"Newton's method failed at t = {time_s:.6g} s, in {MOST_STEPS} steps of "
                                           f"{duration_s / MOST_STEPS:.3g} s as well ({fault}): the body is deformed too much.") from fault
                continue
            self.state = state
            return

    def _step(self, u, v, load, dt):
        """TR-BDF2 over dt, with velocities v1 = (u1 - u)/h - v and v2 = (u2 - a u1 + b u)/h."""
        solid, free, h = self.solid, self.solid.free, GAMMA * dt / 2
        a, b = 1 / (GAMMA * (2 - GAMMA)), (1 - GAMMA)**2 / (GAMMA * (2 - GAMMA))
        at_begin = solid.force(u) + load
        u1 = self._solve(u + 2 * h * v, u[free] + 2 * h * v[free], load + at_begin, h)
        v1 = v.copy()
        v1[free] = (u1 - u)[free] / h - v[free]
        u2 = self._solve(u1 + (1 - GAMMA) * dt * v1, (a * u1 - b * u)[free] + h * (a * v1 - b * v)[free], load, h)
        v2 = np.zeros_like(v)
        v2[free] = (u2 - a * u1 + b * u)[free] / h
        return u2, v2

    def _solve(self, guess, target, load, h):
        """u with M (u - target)/h^2 = f(u) + load."""
        solid, free = self.solid, self.solid.free
        u, last = guess.copy(), np.inf
        for iteration in range(30):
            residual = solid.force(u) + load - solid.mass_free @ (u[free] - target) / h**2
            if not np.isfinite(residual).all():
                raise NotConverged("an element was turned inside out")
            if self.factor is None or abs(self.factor_h / h - 1) > 0.1:
                self._renew_factor(u, h)
            step = self.factor.solve(residual)
            size = abs(step).max()
            if size > 0.2 * last:  # an old factor: one of this state
                self._renew_factor(u, h)
                step = self.factor.solve(residual)
                size = abs(step).max()
            u[free] += step
            last = size
            if size < TOLERANCE * self.size:
                return u
        raise NotConverged(f"a step of {size:.2g} m is left after 30 iterations")

    def _renew_factor(self, u, h):
        self.factor, self.factor_h = splu((self.solid.mass_free / h**2 + self.solid.stiffness(u)).tocsc()), h
        self.factored_at = u.copy()

    def save(self):
        saved = {"state": self.state}
        return saved if self.factor is None else saved | {"factored_at": self.factored_at, "factor_h": self.factor_h}

    def restore(self, saved):
        self.state = tuple(saved["state"])
        if "factor_h" in saved:  # with another factor the iterations would end at other bits
            self._renew_factor(saved["factored_at"], float(saved["factor_h"]))

    def energies(self):
        u, v = self.state
        return {"kinetic": v @ (self.solid.mass @ v) / 2, "strain": self.solid.strain_energy(u), "potential": -self.weight @ u}

    def gauge(self, gauge):
        return list(self.gauges[gauge["name"]] @ self.state[0]) if gauge["name"] in self.gauges else None

    def fields(self):
        u, v = (values.reshape(-1, 2) for values in self.state)
        return {"position": self.solid.nodes.T + u, "displacement": u, "velocity": v, "clamped": self.solid.clamped,
                "stress_xy": self.solid.shear_stress(self.state[0])}


if __name__ == "__main__":
    run_structure(GetfemStructure, lambda parser: parser.add_argument(
        "--across", metavar="N", type=int, default=ELEMENTS_ACROSS, help=f"elements across the thinner side (default {ELEMENTS_ACROSS})"))
