"""What a step of the fluid costs in many processes: a model. Used by ./tern explain --ranks; docs/SCALE.md says how far it is measured.

A rank computes its particles; copies of those of others, the ghosts, come to it in exchanges. All ranks meet in collectives (sums and
extremes). From the second grid of the multigrid on, all ranks have the whole grid: what it costs does not become less with more ranks.
"""

import dataclasses
import math
import tomllib
from pathlib import Path

from tern.errors import BAD_INPUT, Error

SUPPORT = 3                # width of the ghosts, in spacings
COARSE = 4                 # width of a cell of the second grid, in spacings: that of the first is two
MESSAGE_S = 0.5e-6         # of the processor, for each message at both ends: assumed
LOCAL_S = 0.5e-6           # latency between ranks of one machine: assumed
IMBALANCE = 1.05           # the fullest rank over the mean between two cuts, at 1.1 of which space is cut anew: assumed
PROCESS_BYTES = 30e6       # of a rank without particles, as scene/estimate.cpp has it
GHOST_BYTES = 300          # assumed
START_BYTES = {2: 50, 3: 66}  # of each particle of the whole start: every rank makes it (fields of fluid/state.hpp)


@dataclasses.dataclass(frozen=True)
class Counts:
    """Of one step. The defaults are reckoned from the order of a step, not counted."""

    particle_exchanges: float = 45.0
    ghost_bytes: float = 700.0     # of each ghost, in all of these together
    node_exchanges: float = 40.0
    collectives: float = 150.0
    cycles: float = 10.0           # of the multigrid, in the solves of a step
    coarse_node_s: float = 1.0e-7  # of each node of the second grid in a cycle, with all grids below it


@dataclasses.dataclass(frozen=True)
class Cluster:
    """Machines of so many cores, and the network between them."""

    cores: int
    latency_s: float = 1.5e-6
    bandwidth: float = 10e9  # of a machine [bytes/s]


@dataclasses.dataclass(frozen=True)
class Step:
    """One step of one rank: seconds by part, and what the rank holds."""

    ranks: int
    particles: float
    ghosts: float
    compute_s: float    # its own particles
    imbalance_s: float  # waiting for the fullest rank
    exchange_s: float   # ghosts and nodes around its part
    collective_s: float  # sums and extremes over all ranks
    coarse_s: float     # the grids that all ranks have whole, and their sums
    memory: float       # bytes

    @property
    def seconds(self):
        return self.compute_s + self.imbalance_s + self.exchange_s + self.collective_s + self.coarse_s

    @property
    def communication(self):
        """Share of a step in which nothing is computed for the particles."""
        return 1 - self.compute_s / self.seconds

    efficiency = property(lambda self: self.compute_s / self.seconds)


def ghosts(particles, ranks, dimension):
    """Of a rank of so many particles, in the mean: its part is a cube, one of as many to each side as make `ranks`. Of the two faces across
    each side 2 (k-1)/k have a neighbour, which adds the width of a support there."""
    if ranks == 1:
        return 0.0
    side, k = particles ** (1 / dimension), ranks ** (1 / dimension)
    return (side + SUPPORT * 2 * (k - 1) / k) ** dimension - particles


def neighbours(ranks, dimension):
    """Ranks around a part, in the mean over parts at the edge and inside."""
    k = ranks ** (1 / dimension)
    return min(ranks - 1, (3 - 2 / k) ** dimension - 1)


def step(particles, ranks, dimension, particle_s, cluster, counts=Counts()):
    """`particles`: of all ranks. `particle_s`: cost of one in a step without ranks [CPU s]."""
    own = particles / ranks
    around = ghosts(own, ranks, dimension)
    peers = neighbours(ranks, dimension)
    machines = math.ceil(ranks / cluster.cores)
    latency = cluster.latency_s if machines > 1 else LOCAL_S
    per_machine = min(ranks, cluster.cores)
    bytes_per_s = cluster.bandwidth / per_machine
    exchanges = counts.particle_exchanges + counts.node_exchanges
    # The first grid has a node for two spacings; a part gives and takes a layer of them around it.
    nodes_around = ghosts(own / 2**dimension, ranks, dimension) / SUPPORT
    exchange = (exchanges * (latency + 2 * MESSAGE_S * peers)
                + (counts.ghost_bytes * around + 8 * counts.node_exchanges * nodes_around) / bytes_per_s) if ranks > 1 else 0.0
    hops = LOCAL_S * math.log2(per_machine) + cluster.latency_s * math.log2(machines)
    collective = 2 * counts.collectives * hops
    coarse_nodes = particles / COARSE**dimension
    stencil = 3**dimension
    coarse = 0.0
    if ranks > 1:
        # Once a step the matrix of the second grid is summed over all ranks, and in each cycle its right-hand side.
        summed = 4 * coarse_nodes * (stencil + counts.cycles)
        coarse = counts.coarse_node_s * coarse_nodes * counts.cycles + 2 * summed / bytes_per_s
    compute = own * particle_s
    memory = PROCESS_BYTES + own * (6000 if dimension == 3 else 2000) + GHOST_BYTES * around
    if ranks > 1:
        memory += particles * START_BYTES[dimension] + coarse_nodes * 4 * (stencil + 10)
    return Step(ranks, own, around, compute, (IMBALANCE - 1) * compute if ranks > 1 else 0.0, exchange, collective, coarse, memory)


def read_cluster(path):
    """Three lines of TOML: cores of a machine, latency_us and bandwidth_gb_per_s of the network. Raises Error."""
    try:
        contents = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise Error(BAD_INPUT, f"--cluster {path} cannot be read: {error}.") from None
    wanted = ("cores", "latency_us", "bandwidth_gb_per_s")
    for name in (*wanted, *contents):
        value = contents.get(name)
        if name not in wanted or isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 < value < 1e9:
            raise Error(BAD_INPUT, f"--cluster {path}: {name} = {value!r}; it has three lines with numbers above 0, as cores = 32, "
                                   "latency_us = 1.5, bandwidth_gb_per_s = 10.")
    if contents["cores"] != int(contents["cores"]):
        raise Error(BAD_INPUT, f"--cluster {path}: cores = {contents['cores']} is not a whole number.")
    return Cluster(int(contents["cores"]), contents["latency_us"] * 1e-6, contents["bandwidth_gb_per_s"] * 1e9)


def _size(value):
    for unit, factor in (("GB", 1e9), ("MB", 1e6)):
        if value >= factor:
            return f"{value / factor:.3g} {unit}"
    return f"{value / 1e3:.0f} kB"


def _seconds(value):
    return f"{value:.3g} s" if value >= 1 else f"{1e3 * value:.3g} ms"


def text(expected, ranks, cluster):
    """`expected`: what tern-case says of the case. A table for 1, 2, 4 ... ranks up to those asked for."""
    particles, steps, dimension = expected["fluid_particles"], expected["steps"], expected["dimension"]
    particle_s = expected["fluid_cpu_s"] / (particles * steps)
    others = (expected["structure_cpu_s"] + expected["coupler_cpu_s"]) / steps
    rows = [step(particles, n, dimension, particle_s, cluster) for n in sorted({*(2**k for k in range(ranks.bit_length()) if 2**k < ranks),
                                                                                ranks})]
    network = f"latency {1e6 * cluster.latency_s:.3g} us, {cluster.bandwidth / 1e9:.3g} GB/s"
    lines = [f"In {ranks} ranks, on machines of {cluster.cores} cores, {network} (a model, docs/SCALE.md)",
             "  ranks  particles     ghosts  fluid's step  exchanges  sums  grids of all  efficiency  memory of a rank"]
    for row in rows:
        share = [f"{100 * part / row.seconds:3.0f} %" for part in (row.exchange_s, row.collective_s, row.coarse_s)]
        lines.append(f"  {row.ranks:5}  {row.particles:9.0f}  {row.ghosts:9.0f}  {_seconds(row.seconds):>12}  {share[0]:>9}  {share[1]}  "
                     f"{share[2]:>12}  {100 * row.efficiency:8.0f} %  {_size(row.memory):>16}")
    last = rows[-1]
    whole = (last.seconds + others) * steps
    alone = (rows[0].seconds + others) * steps
    if others > 0:
        share = 100 * others / (last.seconds + others)
        lines.append(f"Structure and coupler are one process each: {_seconds(others)} of each step, {share:.0f} % of it with {ranks} "
                     "ranks.")
    lines.append(f"The run: {_seconds(whole)} in place of {_seconds(alone)}, {alone / whole:.3g} times as fast.")
    return "\n".join(lines)

