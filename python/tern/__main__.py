"""python3 -m tern: as ./tern."""

import sys

from tern.command_line import main

sys.exit(main(sys.argv[1:]))
