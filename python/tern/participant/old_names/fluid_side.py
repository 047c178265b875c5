"""The old name of tern.participant.fluid_side."""

import sys

from tern.participant import fluid_side

print("tern: `import fluid_side` is an old name; write `from tern.participant import fluid_side`.", file=sys.stderr)
sys.modules[__name__] = fluid_side
