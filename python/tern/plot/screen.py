"""A display for VTK on any machine: Debian's VTK draws through X only, so an Xvfb of our own stands in for a screen."""

import atexit
import contextlib
import os
import shutil
import subprocess

from tern.errors import INPUT_OUTPUT, Error

_servers = []


def start():
    """Starts the Xvfb of this process, once, and ends it with the process."""
    if _servers:
        return
    if shutil.which("Xvfb") is None:
        raise Error(INPUT_OUTPUT, "The picture of a 3D scene needs the Debian packages python3-vtk9 and xvfb: ./tern plot installs "
                                  "them; or draw a slice, which needs neither, with --slice.")
    read_end, write_end = os.pipe()
    server = subprocess.Popen(["Xvfb", "-displayfd", str(write_end), "-screen", "0", "64x64x24", "-nolisten", "tcp", "-noreset"],
                              pass_fds=[write_end], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                              start_new_session=True)
    os.close(write_end)
    number = b""
    while (part := os.read(read_end, 16)):
        number += part
        if number.endswith(b"\n"):
            break
    os.close(read_end)
    if not number.strip():
        raise Error(INPUT_OUTPUT, f"Xvfb did not start: {server.stderr.read().decode(errors='replace').strip()}")
    os.environ["DISPLAY"] = f":{number.decode().strip()}"
    _servers.append(server)
    atexit.register(_stop)


def _stop():
    for server in _servers:
        server.terminate()
        with contextlib.suppress(subprocess.TimeoutExpired):
            server.wait(5)
        server.stderr.close()
    _servers.clear()
