"""Small made-up results of a run: frames of a block of water and a plate, tables, run.json, for the tests of what shows them."""

import json
import sys

import h5py
import numpy as np


def write_frames(path, position, frames=3, **fields):
    """A frame every 0.1 s, all particles 10 mm further to the right each time."""
    with h5py.File(path, "w") as file:
        for number in range(frames):
            group = file.create_group(f"frame_{number:06d}")
            group.attrs["time_s"], group.attrs["step"] = 0.1 * number, number
            group["position"] = position + [0.01 * number, 0, 0]
            for name, values in fields.items():
                group[name] = values


def block(x, y, width, height, spacing):
    grid = np.mgrid[x:x + width:spacing, y:y + height:spacing].reshape(2, -1).T + 0.5 * spacing
    return np.column_stack([grid, np.zeros(len(grid))])


def write_sides(directory, fluid=True, structure=True, frames=3):
    if fluid:
        water = block(0, 0, 0.2, 0.1, 0.01)
        write_frames(directory / "fluid.h5", water, frames, pressure=9810 * (0.1 - water[:, 1]), velocity=0 * water + [1, 0, 0])
    if structure:
        plate = block(0.3, -0.01, 0.008, 0.06, 0.002)
        write_frames(directory / "structure.h5", plate, frames, stress_xy=1e3 * plate[:, 1],
                     clamped=(plate[:, 1] < 0).astype(np.int32), surface_position=block(0.299, 0, 0.001, 0.05, 0.002))


def write_3d(directory):
    """Frames and run.json of water in the lower half of a tank of 1 m; in its middle a column of 0.2 x 0.6 x 0.2 m that sticks out."""
    for name, low, high, spacing in (("fluid", (0, 0, 0), (1, 0.5, 1), 0.05), ("structure", (0.4, 0.3, 0.4), (0.6, 0.9, 0.6), 0.04)):
        axes = [np.arange(a + spacing / 2, b, spacing) for a, b in zip(low, high)]
        place = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
        if name == "fluid":
            place = place[np.any(np.abs(place - [0.5, 0.6, 0.5]) > [0.1, 0.3, 0.1], axis=1)]
        fields = {"pressure": 9810 * (0.5 - place[:, 1])} if name == "fluid" else {"von_mises": 1e5 * (place[:, 1] - 0.3)}
        write_frames(directory / f"{name}.h5", place, 5, velocity=0 * place, **fields)
    (directory / "run.json").write_text(json.dumps({"case": "made_up", "title": "A made-up scene", "status": "done", "settings": {
        "dimension": 3, "gravity": [0, -9.81, 0], "wall": [
            {"name": "tank", "container": {"box": {"min": [0, 0, 0], "max": [1, 1, 1]}}, "open": ["y_max"]}]}}))


def write_tables(directory):
    (directory / "gauges.csv").write_text("t_s,P.ux_m,front_m\n0,0,\n0.1,0.01,0.2\n0.2,0.02,0.3\n")
    (directory / "energy.csv").write_text("t_s,fluid_kinetic_J,fluid_potential_J\n0,0,5\n0.1,1,4\n")
    (directory / "steps.csv").write_text("t_s,dt_s,limit,pressure_iterations,wall_ms\n0.1,0.1,gravity,5,2\n0.2,0.1,velocity,,3\n")


def write_case(directory, **more):
    """run.json of a run that ended well, with an expected.toml and its reference beside it."""
    (directory / "expected.toml").write_text(
        '[[quantity]]\nname = "end of P"\nkind = "value"\ncolumn = "P.ux_m"\nat = 0.2\nunit = "m"\nreference = 0.021\n'
        'band = [0.019, 0.022]\nsource = "made up"\nconfidence = "A"\n'
        '[[quantity]]\nname = "curve of P"\nkind = "max_difference"\ncolumn = "P.ux_m"\ncsv = "r.csv"\ncsv_column = "u_m"\n'
        'unit = "m"\nat_most = 0.001\nsource = "Reference code, 1 mm"\nconfidence = "B"\n')
    (directory / "r.csv").write_text("# source\nt_s,u_m\n0,0\n0.1,0.02\n0.2,0.03\n")
    (directory / "run.json").write_text(json.dumps({
        "case": "made_up", "case_path": str(directory / "case.toml"), "title": "A made-up run", "status": "done", "first_cause": "",
        "wall_s": 3.0, "cpu_s": 2.5, "steps": 2, "settings": {
            "dimension": 2, "end_time": 0.2, "fluid": {"spacing": 0.01, "numerics": {"courant": 0.1, "shifting": 1.0}},
            "wall": [{"name": "tank", "container": {"box": {"min": [0, 0], "max": [0.4, 0.2]}}, "open": ["y_max"]}]},
        "processes": {"fluid": {"status": "done", "exit_code": 0, "cpu_s": 2.0, "wall_s": 3.0, "time_s": 0.2,
                                "timing_s": {"compute": 2.0, "compute.boundary": 0.5, "wait": 0.7, "exchange": 0.2, "output": 0.1},
                                "measures": {"volume_drift": 0.001}}}} | more))


if __name__ == "__main__":
    sys.exit("This module holds what the tests beside it share; run those.")
