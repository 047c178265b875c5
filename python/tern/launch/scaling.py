"""What a fluid in many processes is expected to cost: the model of docs/SCALE.md.

Of every rank the same number of particles, in a block as long as it is wide. Counted and measured figures go in; latency, bandwidth and
imbalance of a cluster are assumptions. Nothing here has been measured on many machines.
"""

from dataclasses import dataclass
from math import ceil, log2

COARSEST = 150  # nodes of the multigrid's last grid at most, as in fluid/pressure/multigrid.cpp
SUPPORT = 3     # of the kernel, in spacings
PARTS = ("own particles", "ghosts", "whole grids", "patches of walls", "messages", "bytes", "sums over all", "cuts", "imbalance")


@dataclass(frozen=True)
class Fluid:
    """What a window costs."""
    dimension: int
    iterations: float   # of both pressure solves
    particle_s: float   # CPU for a particle, in one process
    ghost_s: float      # for a copy of a particle, with the nodes around it
    node_s: float       # for a node of a grid that every rank has
    patch_s: float      # for a patch of a wall, of which every rank has all
    patches: float      # over the particles to the power of (D - 1)/D
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
        return 18 + 4 * self.iterations


OTHER_EXCHANGES, SUMS_PER_GRID = 2, 3
# At most every 20 windows space is cut anew: 50 bisections and 3 sums for each doubling of the ranks (fluid/domain.cpp).
WINDOWS_BETWEEN_CUTS, BISECTIONS, SUMS_PER_CUT = 20, 50, 53
COMPARED_S = 1.5e-9  # a particle with a cut

# Iterations, bytes: bench/scale_model.py --count 8. CPU of a particle: bench/fluid_cpu.py (SPEED.md). CPU of a ghost: docs/SCALE.md.
# CPU of a node: what multigrid and conjugate gradients take of a step (SPEED.md), over the nodes of the finest grid.
# Patches: of dam_break_3d, and of dam_break_front; a patch is eight bytes to be set to zero.
MEASURED = {
    2: Fluid(2, 3.9, 0.95e-6, 0.2e-6, 0.34e-6, 0.5e-9, 20, 12),
    3: Fluid(3, 5.2, 4.4e-6, 0.9e-6, 3.2e-6, 0.5e-9, 136, 15),
}


@dataclass(frozen=True)
class Cluster:
    latency_s: float = 1.5e-6
    message_s: float = 0.5e-6          # of the processor, for each message at each end
    ranks_of_machine: int = 32
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


def shell(dimension, inside, thickness):
    """Places in a shell of this thickness around a block of so many."""
    return (inside ** (1 / dimension) + 2 * thickness) ** dimension - inside


def costs(fluid, cluster, ranks, particles):
    """Seconds of a window on one rank, by part; `particles`: of a rank."""
    D = fluid.dimension
    parts = dict.fromkeys(PARTS, 0.0) | {"own particles": fluid.particle_s * particles}
    if ranks == 1:
        return parts
    neighbours = min(3 ** D - 1, ranks - 1)
    sides = neighbours / (3 ** D - 1)  # a rank among few has others on few of its sides
    divided, whole = grids(D, ranks * particles)
    ghosts = sides * shell(D, particles, SUPPORT)
    foreign = sum(sides * shell(D, max(1.0, nodes / ranks), 1) for nodes in divided)
    exchanges = fluid.particle_exchanges + fluid.node_exchanges * len(divided) + OTHER_EXCHANGES
    sums = fluid.sums + SUMS_PER_GRID * (len(divided) - 1)
    # The ranks of a machine are a block: what goes to another machine is what passes its sides.
    machines = min(1.0, ranks / cluster.ranks_of_machine - 1) if ranks > cluster.ranks_of_machine else 0.0
    through_network = machines * cluster.ranks_of_machine ** (-1 / D)
    seconds_of_byte = 1 / cluster.memory_bytes_per_s + through_network * cluster.ranks_of_machine / cluster.machine_bytes_per_s
    sent = fluid.ghost_bytes * fluid.particle_exchanges * ghosts + 4 * fluid.node_exchanges * foreign
    doublings = ceil(log2(ranks))
    sum_s = 2 * cluster.latency_s * doublings
    parts |= {
        "ghosts": fluid.ghost_s * ghosts,
        "whole grids": fluid.node_s * whole * 2 ** D / (2 ** D - 1),
        "patches of walls": fluid.patch_s * fluid.patches * (ranks * particles) ** ((D - 1) / D),
        "messages": exchanges * (cluster.latency_s + 2 * cluster.message_s * neighbours),
        "bytes": sent * seconds_of_byte,
        "sums over all": sums * sum_s,
        "cuts": doublings * (SUMS_PER_CUT * sum_s + BISECTIONS * COMPARED_S * particles) / WINDOWS_BETWEEN_CUTS,
    }
    return parts | {"imbalance": cluster.imbalance * sum(parts.values())}


def efficiency(fluid, cluster, ranks, particles):
    """Of each rank, over a fluid of as many particles in one process."""
    return fluid.particle_s * particles / sum(costs(fluid, cluster, ranks, particles).values())
