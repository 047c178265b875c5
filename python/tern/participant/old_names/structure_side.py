"""The old name of tern.participant.structure_side."""

import sys

from tern.participant import structure_side

print("tern: `import structure_side` is an old name; write `from tern.participant import structure_side`.", file=sys.stderr)
sys.modules[__name__] = structure_side
