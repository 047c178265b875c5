"""The old name of tern.participant.schema."""

import sys

from tern.participant import schema

print("tern: `import schema` is an old name; write `from tern.participant import schema`.", file=sys.stderr)
sys.modules[__name__] = schema
