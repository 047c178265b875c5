"""What ./tern starts: the command line."""

import sys

from tern.command_line import main

sys.exit(main(sys.argv[1:]))
