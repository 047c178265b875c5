"""What ./tern starts, without site: Ctrl-C before the command line is there ends it at once and without a traceback."""

import _signal
import posix

_signal.signal(_signal.SIGINT, lambda *_: posix._exit(130))

import site  # noqa: E402
import sys  # noqa: E402

site.main()

from tern.command_line import main  # noqa: E402

try:
    _signal.signal(_signal.SIGINT, _signal.default_int_handler)
    sys.exit(main(sys.argv[1:]))
except KeyboardInterrupt:
    sys.exit(130)
