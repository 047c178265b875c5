"""What ./tern starts: the command line."""

import signal

signal.signal(signal.SIGINT, lambda *_: exit(130))  # until main() is there to say it

import sys  # noqa: E402

from tern.command_line import main  # noqa: E402

signal.signal(signal.SIGINT, signal.default_int_handler)
sys.exit(main(sys.argv[1:]))
