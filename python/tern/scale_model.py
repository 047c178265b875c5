"""What a step of the fluid costs in many processes: the model of docs/SCALE.md, used by ./tern explain --ranks and bench/scale_model.py.

Of every rank the same number of particles, in a block as long as it is wide. Copies of the particles of others, the ghosts, come to it in
exchanges. All ranks meet in sums. Counted and measured figures go in; latency, bandwidth and imbalance of a cluster are assumptions.
Nothing here has been measured on many machines.
"""

import tomllib
from dataclasses import dataclass, replace
from math import ceil, log2
from pathlib import Path

from tern.errors import BAD_INPUT, Error

COARSEST = 150  # nodes of the multigrid's last grid at most, as in fluid/pressure/multigrid.cpp
SUPPORT = 3     # of the kernel, in spacings
PARTS = ("own particles", "ghosts", "whole grids", "messages", "bytes", "sums over all", "cuts", "imbalance")
PROCESS_BYTES = 30e6  # of a rank without particles, as scene/estimate.cpp has it
PARTICLE_BYTES = {2: 2000, 3: 6000}
GHOST_BYTES = 300  # assumed
# Patches of walls that a rank holds: of half a spacing, up to 11 spacings beyond its particles (fluid/boundary/held_walls.cpp).
PATCH_BYTES = 200  # from the memory of 8 ranks with all patches and with their own (docs/SCALE.md)
PATCHES_BEYOND = 11


@dataclass(frozen=True)
class Fluid:
    """What a window costs."""
    dimension: int
    iterations: float   # of both pressure solves
    particle_s: float   # CPU for a particle, in one process
    ghost_s: float      # for a copy of a particle, with the nodes around it
    node_s: float       # for a node of a grid that every rank has
    ghost_bytes: float  # of a ghost in each exchange, in the mean

    @property
    def particle_exchanges(self):
        return 11 + 2 * self.iterations

    @property
    def node_exchanges(self):
        """Of each divided grid."""
        return 4 + 3 * self.iterations

    @property
    def sums(self):
        """Over all ranks, without those of further divided grids."""
        return 19.3 + 4 * self.iterations


OTHER_EXCHANGES, SUMS_PER_GRID = 2, 3
# At most every 20 windows space is cut anew: 50 bisections and 3 sums for each doubling of the ranks (fluid/domain.cpp).
WINDOWS_BETWEEN_CUTS, BISECTIONS, SUMS_PER_CUT = 20, 50, 53
COMPARED_S = 1.5e-9  # a particle with a cut

# Iterations, bytes: bench/scale_model.py --count 8. CPU of a particle: bench/fluid_cpu.py (docs/SPEED.md). CPU of a ghost: docs/SCALE.md.
# CPU of a node: what multigrid and conjugate gradients take of a step (docs/SPEED.md), over the nodes of the finest grid.
MEASURED = {
    2: Fluid(2, 3.9, 0.95e-6, 0.2e-6, 0.34e-6, 12),
    3: Fluid(3, 5.2, 4.4e-6, 0.9e-6, 3.2e-6, 15),
}


@dataclass(frozen=True)
class Cluster:
    """Machines of so many cores, a rank on each, and the network between them."""
    cores: int = 32
    latency_s: float = 1.5e-6
    message_s: float = 0.5e-6          # of the processor, for each message at each end
    machine_bytes_per_s: float = 10e9  # between machines, of all ranks of one together
    memory_bytes_per_s: float = 5e9    # of a rank, to others of its machine
    imbalance: float = 0.05            # most over mean, less 1


def grids(dimension, particles):
    """Nodes of the grids that are divided among ranks, the finest first, and of the first grid that is not."""
    cell = 2 ** dimension
    divided = [particles / cell]
    while divided[-1] > COARSEST * cell:
        divided.append(divided[-1] / cell)
    return divided, divided[-1] / cell


def around(inside, ranks, dimension, width):
    """Places within `width` of a part that others have, in the mean over parts: a part is a cube of so many, one of as many to each side
    as make `ranks`. Of the two faces across each side 2 (k-1)/k have a neighbour."""
    if ranks == 1:
        return 0.0
    side, k = inside ** (1 / dimension), ranks ** (1 / dimension)
    return (side + width * 2 * (k - 1) / k) ** dimension - inside


def neighbours(ranks, dimension):
    """Ranks around a part, in the mean over parts at the edge and inside."""
    return min(ranks - 1, (3 - 2 / ranks ** (1 / dimension)) ** dimension - 1)


def costs(fluid, cluster, ranks, particles):
    """Seconds of a window on one rank, by part; `particles`: of a rank."""
    D = fluid.dimension
    parts = dict.fromkeys(PARTS, 0.0) | {"own particles": fluid.particle_s * particles}
    if ranks == 1:
        return parts
    peers = neighbours(ranks, D)
    divided, whole = grids(D, ranks * particles)
    ghosts = around(particles, ranks, D, SUPPORT)
    foreign = sum(around(max(1.0, nodes / ranks), ranks, D, 1) for nodes in divided)
    exchanges = fluid.particle_exchanges + fluid.node_exchanges * len(divided) + OTHER_EXCHANGES
    sums = fluid.sums + SUMS_PER_GRID * (len(divided) - 1)
    # The ranks of a machine are a block: what goes to another machine is what passes its sides.
    machines = min(1.0, ranks / cluster.cores - 1) if ranks > cluster.cores else 0.0
    through_network = machines * cluster.cores ** (-1 / D)
    seconds_of_byte = 1 / cluster.memory_bytes_per_s + through_network * cluster.cores / cluster.machine_bytes_per_s
    sent = fluid.ghost_bytes * fluid.particle_exchanges * ghosts + 4 * fluid.node_exchanges * foreign
    doublings = ceil(log2(ranks))
    sum_s = 2 * cluster.latency_s * doublings
    parts |= {
        "ghosts": fluid.ghost_s * ghosts,
        "whole grids": fluid.node_s * whole * 2 ** D / (2 ** D - 1),
        "messages": exchanges * (cluster.latency_s + 2 * cluster.message_s * peers),
        "bytes": sent * seconds_of_byte,
        "sums over all": sums * sum_s,
        "cuts": doublings * (SUMS_PER_CUT * sum_s + BISECTIONS * COMPARED_S * particles) / WINDOWS_BETWEEN_CUTS,
    }
    return parts | {"imbalance": cluster.imbalance * sum(parts.values())}


def efficiency(fluid, cluster, ranks, particles):
    """Of each rank, over a fluid of as many particles in one process."""
    return fluid.particle_s * particles / sum(costs(fluid, cluster, ranks, particles).values())


def memory(dimension, ranks, particles):
    """Bytes that a rank of so many particles holds."""
    held = PROCESS_BYTES + PARTICLE_BYTES[dimension] * particles
    if ranks > 1:
        held += GHOST_BYTES * around(particles, ranks, dimension, SUPPORT)
        side = particles ** (1 / dimension) + 2 * PATCHES_BEYOND  # in a corner of a tank, where they are most
        held += PATCH_BYTES * dimension * (2 * side) ** (dimension - 1)
    return held


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
    return Cluster(cores=int(contents["cores"]), latency_s=contents["latency_us"] * 1e-6,
                   machine_bytes_per_s=contents["bandwidth_gb_per_s"] * 1e9)


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
    fluid = replace(MEASURED[dimension], particle_s=expected["fluid_cpu_s"] / (particles * steps))
    others = (expected["structure_cpu_s"] + expected["coupler_cpu_s"]) / steps
    network = f"latency {1e6 * cluster.latency_s:.3g} us, {cluster.machine_bytes_per_s / 1e9:.3g} GB/s"
    lines = [f"In {ranks} ranks, on machines of {cluster.cores} cores, {network} (a model, docs/SCALE.md)",
             "  ranks  particles     ghosts  fluid's step  ghosts' work  exchanges  sums  whole grids  efficiency  memory of a rank"]
    seconds = []
    for n in sorted({*(2**k for k in range(ranks.bit_length()) if 2**k < ranks), ranks}):
        own = particles / n
        parts = costs(fluid, cluster, n, own)
        seconds.append(sum(parts.values()))
        share = [f"{100 * sum(parts[part] for part in of) / seconds[-1]:3.0f} %" for of in
                 (("ghosts",), ("messages", "bytes"), ("sums over all", "cuts"), ("whole grids",))]
        ghosts = around(own, n, dimension, SUPPORT)
        lines.append(f"  {n:5}  {own:9.0f}  {ghosts:9.0f}  {_seconds(seconds[-1]):>12}  {share[0]:>12}  {share[1]:>9}  {share[2]}  "
                     f"{share[3]:>12}  {100 * parts['own particles'] / seconds[-1]:8.0f} %  {_size(memory(dimension, n, own)):>16}")
    whole, alone = ((of + others) * steps for of in (seconds[-1], seconds[0]))
    if others > 0:
        lines.append(f"Structure and coupler are one process each: {_seconds(others)} of each step, "
                     f"{100 * others / (seconds[-1] + others):.0f} % of it with {ranks} ranks.")
    lines.append(f"The run: {_seconds(whole)} in place of {_seconds(alone)}, {alone / whole:.3g} times as fast.")
    return "\n".join(lines)
