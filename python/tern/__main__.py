"""Entry point of ./tern: makes the repository importable and hands over to the command line."""

import sys
from pathlib import Path

sys.path[0] = str(Path(__file__).resolve().parent.parent)

from launcher.command_line import main  # noqa: E402  (the path has to be set first)

sys.exit(main(sys.argv[1:]))
