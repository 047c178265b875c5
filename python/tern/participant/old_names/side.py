"""The old name of tern.participant.side."""

import sys

from tern.participant import side

print("tern: `import side` is an old name; write `from tern.participant import side`.", file=sys.stderr)
sys.modules[__name__] = side
