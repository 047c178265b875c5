#!/usr/bin/python3 -B
"""A TCP connection with a set delay, a set bandwidth, or cut: stands between a participant and its coupler.

    with Relay(port, delay_s=0.010, bits_per_s=10e6) as relay:    # relay.port is where the participant connects
        relay.cut(); ...; relay.heal()

What it cannot do: lose packets. It receives bytes of one TCP connection and sends them on another, after the kernel has repaired
whatever was lost; a loss would have to be put below TCP.
"""

import asyncio
import collections
import selectors
import socket
import threading
import time

CHUNK_BYTES = 16384
MOST_WAITING_BYTES = 1 << 20  # beyond, the sender has to wait, as with the buffers of a router


class _Direction:
    """Bytes from one socket to another, in order, each chunk `delay_s` after the line has taken it up."""

    def __init__(self, relay, reader, writer):
        self._relay, self._reader, self._writer = relay, reader, writer
        self._waiting = collections.deque()
        self._waiting_bytes = 0
        self._changed = asyncio.Event()

    async def take_up(self):
        free_at = 0.0
        while True:
            try:
                chunk = await self._reader.read(CHUNK_BYTES)
            except OSError:
                chunk = b""
            if self._relay.bits_per_s:
                free_at = max(free_at, time.monotonic()) + 8 * len(chunk) / self._relay.bits_per_s
            else:
                free_at = time.monotonic()
            self._waiting.append((free_at + self._relay.delay_s, chunk))
            self._waiting_bytes += len(chunk)
            self._changed.set()
            if not chunk:
                return
            while self._waiting_bytes > MOST_WAITING_BYTES:
                await asyncio.sleep(0.001)

    async def deliver(self):
        while True:
            while not self._waiting:
                self._changed.clear()
                await self._changed.wait()
            due, chunk = self._waiting[0]
            if due > time.monotonic():
                await asyncio.sleep(due - time.monotonic())
            await self._relay.whole.wait()
            self._waiting.popleft()
            self._waiting_bytes -= len(chunk)
            if not chunk:
                self._writer.close()
                return
            try:
                self._writer.write(chunk)
                await self._writer.drain()
            except OSError:
                return
            self._relay.bytes += len(chunk)


class Relay:
    """Listens on a free loopback port and forwards to 127.0.0.1:`port`; runs in a thread of its own."""

    def __init__(self, port, delay_s=0.0, bits_per_s=None):
        self.delay_s, self.bits_per_s = delay_s, bits_per_s
        self.bytes = 0
        self._target = port
        # select() takes its timeout in microseconds, epoll in milliseconds: a delay of 1 ms has to be one of 1 ms.
        self._loop = asyncio.SelectorEventLoop(selectors.SelectSelector())
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._ready = threading.Event()

    def __enter__(self):
        self._thread.start()
        self._ready.wait(10)
        return self

    def __exit__(self, *_):
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(10)

    def cut(self):
        """From now on nothing arrives, in either direction, not even the end of a connection."""
        self._loop.call_soon_threadsafe(self.whole.clear)

    def heal(self):
        """What was held back arrives."""
        self._loop.call_soon_threadsafe(self.whole.set)

    def _run(self):
        asyncio.set_event_loop(self._loop)
        self._loop.run_until_complete(self._listen())
        self._ready.set()
        self._loop.run_forever()
        for task in asyncio.all_tasks(self._loop):
            task.cancel()
        self._loop.run_until_complete(asyncio.sleep(0))
        self._server.close()
        self._loop.close()

    async def _listen(self):
        self.whole = asyncio.Event()
        self.whole.set()
        self._server = await asyncio.start_server(self._forward, "127.0.0.1", 0)
        self.port = self._server.sockets[0].getsockname()[1]

    async def _forward(self, reader, writer):
        try:
            far_reader, far_writer = await asyncio.open_connection("127.0.0.1", self._target)
        except OSError:
            writer.close()
            return
        for end in (writer, far_writer):
            end.get_extra_info("socket").setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        directions = [_Direction(self, reader, far_writer), _Direction(self, far_reader, writer)]
        await asyncio.gather(*(part for way in directions for part in (way.take_up(), way.deliver())))
