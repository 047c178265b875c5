"""Keys of a participant, and what the handshake of a connection says about them: as proto/transport/keys.hpp and
participant_channel.cpp."""

import ipaddress
import os
import socket
import stat
import sys
import time

import zmq

EVENTS = (zmq.EVENT_CONNECTED | zmq.EVENT_HANDSHAKE_SUCCEEDED | zmq.EVENT_DISCONNECTED | zmq.EVENT_HANDSHAKE_FAILED_AUTH |
          zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL | zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL)
BROKEN_OFF_PATIENCE_S = 4.0
SILENT_S = 2.5  # of a handshake that ends after as long a silence nothing is known of keys: who should answer stands still
CONNECT_TIMEOUT_MS = 3000
HANDSHAKE_TIMEOUT_MS = 5000
MECHANISM_MISMATCH = 0x11000002  # ZMQ_PROTOCOL_ERROR_ZMTP_MECHANISM_MISMATCH


class CannotConnect(Exception):
    """Keys or address cannot be used; the text is a sentence with a remedy, the exit code 2."""


def _resolved(endpoint):
    """(endpoint with a number for its host, whether that is this machine); ipc stays."""
    if not endpoint.startswith("tcp://"):
        return endpoint, True
    host, _, port = endpoint[len("tcp://"):].rpartition(":")
    try:
        found = socket.getaddrinfo(host.strip("[]"), port, type=socket.SOCK_STREAM)
    except OSError as error:
        raise CannotConnect(f'The host of the endpoint "{endpoint}" cannot be found: {error.strerror}; give its name or address as '
                            "other machines know it, an IPv6 address in brackets.") from None
    family, *_, address = min(found, key=lambda entry: entry[0] != socket.AF_INET)
    number = f"[{address[0]}]" if family == socket.AF_INET6 else address[0]
    return f"tcp://{number}:{port}", ipaddress.ip_address(address[0].split("%")[0]).is_loopback


def _read_key(path):
    try:
        with open(path, encoding="ascii") as file:
            key = file.read().strip()
        if len(key) != 40:
            raise ValueError
        zmq.curve_public(key.encode())  # refuses what is not Z85
        return key.encode()
    except OSError as error:
        raise CannotConnect(f"The key file {path} cannot be read: {error.strerror}; ./tern keys makes the keys and says which file "
                            "belongs on which machine.") from None
    except (ValueError, zmq.ZMQError):
        raise CannotConnect(f"{path} holds no key of 40 characters in Z85; copy it again, or make new keys with ./tern keys.") from None


class Handshake:
    """Connects a DEALER socket, with keys where there are some, and turns the events of its monitor into sentences."""

    def __init__(self, endpoint, role, keys, insecure):
        self._endpoint, self._role, self._keys = endpoint, role, keys
        self._number, local = _resolved(endpoint)
        self._first_broken_off = None
        self._reached = None
        if keys and insecure:
            raise CannotConnect("keys and insecure contradict each other; leave out one of them.")
        if keys:
            secret = os.path.join(keys, f"{role}.secret")
            if os.path.exists(secret) and os.stat(secret).st_mode & (stat.S_IRWXG | stat.S_IRWXO):
                raise CannotConnect(f"The secret key {secret} can be read or changed by others on this machine; run chmod 600 {secret}.")
            self._secret, self._coupler = _read_key(secret), _read_key(os.path.join(keys, "coupler.public"))
        elif not local and not insecure:
            raise CannotConnect(f'The endpoint "{endpoint}" can be reached from the network, and without keys messages are neither '
                                "encrypted nor authenticated: make keys with ./tern keys DIR and give keys=DIR. In a network you "
                                "trust entirely, insecure=True does without.")
        elif not local:
            print(f"warning: insecure: messages at {endpoint} are neither encrypted nor authenticated; everybody in the network can "
                  "read them, join this run, or end it.", file=sys.stderr)

    def connect(self, dealer):
        dealer.setsockopt(zmq.CONNECT_TIMEOUT, CONNECT_TIMEOUT_MS)
        dealer.setsockopt(zmq.HANDSHAKE_IVL, HANDSHAKE_TIMEOUT_MS)
        dealer.setsockopt(zmq.IPV6, self._number.startswith("tcp://["))
        if self._keys:
            dealer.curve_secretkey, dealer.curve_publickey = self._secret, zmq.curve_public(self._secret)
            dealer.curve_serverkey = self._coupler
        dealer.connect(self._number)

    def hear(self, event, value):
        """Takes one event from before the connection stands. Raises CannotConnect when waiting is of no use."""
        now = time.monotonic()
        if event == zmq.EVENT_CONNECTED:
            self._reached = now
        if event == zmq.EVENT_HANDSHAKE_FAILED_AUTH:
            raise CannotConnect(f"The coupler at {self._endpoint} refused the key {self._keys}/{self._role}.secret: its public key is not "
                                "in the coupler's list (participants.allowed).")
        if event == zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL and value == MECHANISM_MISMATCH:
            raise CannotConnect(f"The coupler at {self._endpoint} " + (
                f"was started without keys, and this {self._role} has some: give both keys, or neither." if self._keys else
                f"demands keys, and this {self._role} was started without: give keys=DIR."))
        if event in (zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL, zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL):
            if event == zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL and self._reached is not None and now - self._reached > SILENT_S:
                return
            self._first_broken_off = self._first_broken_off or now
            if now - self._first_broken_off > BROKEN_OFF_PATIENCE_S:
                reason = (f"{self._keys}/coupler.public is not the key of the coupler there, it was started without keys" if self._keys
                          else "the coupler there demands keys (give keys=DIR)")
                raise CannotConnect(f"What answers at {self._endpoint} ends every connection during the handshake: {reason}, or it is no "
                                    "tern coupler.")
