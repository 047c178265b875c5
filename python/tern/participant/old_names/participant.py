"""The old name of tern.participant.channel."""

import sys

from tern.participant import channel

print("tern: `import participant` is an old name; write `from tern.participant import channel`.", file=sys.stderr)
sys.modules[__name__] = channel
