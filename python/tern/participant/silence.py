"""Whether the coupler still reads and speaks, seen from this side of the connection: as proto/transport/silence.hpp, which says why this
is not left to ZeroMQ."""

import fcntl
import os
import socket
import struct
import termios

LONGEST_TURN_S = 0.1
LONGEST_SILENCE_S = 5.0
SIOCOUTQ = termios.TIOCOUTQ
# tcp_info of the kernel: bytes acknowledged, bytes received, bytes not sent yet.
BYTES_ACKED, BYTES_RECEIVED, NOT_SENT, KNOWN_BYTES = 120, 128, 144, 148


class Silence:
    def __init__(self):
        self.connection = -1  # file descriptor
        self._heard_s = self._looked_s = 0.0
        self._received = self._taken = self._unread = 0

    def too_long(self, present_s):
        """Whether nothing has been heard for too long; `present_s` is how long this wait has been there, and counts from 0 in each."""
        begins = present_s < self._looked_s
        if not begins and present_s - self._looked_s < LONGEST_TURN_S:
            return False
        self._looked_s = present_s
        if self._heard() or begins:
            self._heard_s = present_s
        return present_s - self._heard_s > LONGEST_SILENCE_S

    def _heard(self):
        try:
            with socket.socket(fileno=os.dup(self.connection)) as connection:
                if connection.family != socket.AF_UNIX:
                    return self._answers(connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, 256))
                unread, = struct.unpack("i", fcntl.ioctl(connection.fileno(), SIOCOUTQ, bytes(4)))
        except OSError:  # no connection any more; its end is told otherwise
            return True
        before, self._unread = self._unread, unread
        return unread < before or unread == 0

    def _answers(self, info):
        if len(info) < KNOWN_BYTES:  # a kernel that does not say
            return True
        before = self._received, self._taken
        self._received, = struct.unpack_from("Q", info, BYTES_RECEIVED)
        self._taken, = struct.unpack_from("Q", info, BYTES_ACKED)
        not_sent, = struct.unpack_from("I", info, NOT_SENT)
        return self._received != before[0] or (self._taken != before[1] and not_sent > 0)
