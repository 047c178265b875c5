"""Stands between a participant and its coupler, and reads what the two libraries of ZeroMQ say to each other beside the messages."""

import socket
import threading
import urllib.parse

PING = b"\x04PING"  # name of the command, after its length (ZMTP 3.1)


class Relay:
    """Listens at `address` (ipc://PATH or tcp://HOST:PORT) and hands every byte of one connection on to the socket file `behind`."""

    def __init__(self, address, behind):
        if address.startswith("ipc://"):
            self._listener = socket.socket(socket.AF_UNIX)
            self._listener.bind(address.removeprefix("ipc://"))
        else:
            where = urllib.parse.urlsplit(address)
            host = where.hostname if where.hostname not in (None, "*") else ""
            self._listener = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET)
            self._listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            self._listener.bind((host, where.port))
        self._listener.listen(1)
        self._behind, self._ends = behind, []
        self.pinged = threading.Event()
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self):
        try:
            participant, _ = self._listener.accept()
            coupler = socket.socket(socket.AF_UNIX)
            self._ends = [participant, coupler]
            coupler.connect(self._behind)
        except OSError:
            return
        threading.Thread(target=self._carry, args=(coupler, participant), daemon=True).start()
        self._carry(participant, coupler, self.pinged)

    @staticmethod
    def _carry(reader, writer, pinged=None):
        last = b""
        try:
            while chunk := reader.recv(65536):
                if pinged and PING in last + chunk:
                    pinged.set()
                last = chunk[-len(PING):]
                writer.sendall(chunk)
        except OSError:
            pass
        for end in (reader, writer):
            try:
                end.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass

    def close(self):
        for end in [self._listener, *self._ends]:
            try:
                end.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
            end.close()

