"""A network for tests: namespaces joined by a switch that delays and loses what passes.

Run by `lossy_network` in a network namespace of its own. Each host is a namespace of its own with
one veth to this one; frames are forwarded here, in Python, since not every kernel can delay and
lose by itself. It tells the hosts' process ids in a line of JSON, then obeys lines on its input:
``cut 2`` cuts host 2 off, ``heal`` joins all again, ``unicast`` drops multicast from now on,
``stop`` ends it.
"""

from __future__ import annotations

import contextlib
import heapq
import json
import os
import random
import selectors
import socket
import subprocess
import sys
import time

ETH_P_ALL = 3
IPV4, UDP = b"\x08\x00", 17
WHOLE, FIRST = b"\x40\x00", b"\x20\x00"
"""Flags and offset of packets that begin with a UDP header."""

MULTICAST = b"\x01\x00\x5e"
"""First bytes of the Ethernet addresses to which IPv4 multicast is sent."""

PREFIX = "10.77.0."
BUFFER_BYTES = 4_194_304


def ip(*arguments: str, inside: int | None = None) -> None:
    """Run ``ip``, here or in the namespace of a process."""
    enter = ["nsenter", "-t", str(inside), "-n"] if inside else []
    subprocess.run([*enter, "ip", *arguments], check=True)


def join(number: int, holder: int) -> socket.socket:
    """Connect a host; return the socket of the switch's end of its cable."""
    cable = f"host{number}"
    ip("link", "add", "name", cable, "type", "veth", "peer", "name", "eth0", "netns", str(holder))
    ip("link", "set", cable, "up")
    ip("link", "set", "lo", "up", inside=holder)
    ip("address", "add", f"{PREFIX}{number}/24", "dev", "eth0", inside=holder)
    ip("link", "set", "eth0", "up", inside=holder)
    ip("route", "add", "224.0.0.0/4", "dev", "eth0", inside=holder)
    end = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ETH_P_ALL))
    # Frames that come in a burst must not be lost beyond those that are to be lost.
    end.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER_BYTES)
    end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, BUFFER_BYTES)
    end.bind((cable, 0))
    end.setblocking(False)
    return end


def without_checksum(frame: bytes) -> bytes:
    """Return a frame without a UDP checksum, which a veth leaves to hardware that is not there."""
    if frame[12:14] != IPV4 or frame[23] != UDP or frame[20:22] not in (WHOLE, FIRST, b"\0\0"):
        return frame
    place = 14 + (frame[14] & 0xF) * 4 + 6
    return frame[:place] + b"\0\0" + frame[place + 2 :]


class Switch:
    """Forwards each frame to all other ends, some time later, unless it is lost."""

    def __init__(self, ends: list[socket.socket], delay_s: float, loss: float) -> None:
        self.ends = ends
        self.cut: set[int] = set()
        self.multicast = True
        self.passed = self.lost = 0
        self._delay_s = delay_s
        self._loss = loss
        self._random = random.Random(1)
        self._queue: list[tuple[float, int, int, bytes]] = []

    def take(self, source: int) -> None:
        """Take in what has come from one host."""
        while True:
            try:
                frame, address = self.ends[source].recvfrom(65535)
            except BlockingIOError:
                return
            if address[2] == socket.PACKET_OUTGOING:
                continue
            if not self.multicast and frame.startswith(MULTICAST):
                continue
            for target in range(len(self.ends)):
                if target == source or source in self.cut or target in self.cut:
                    continue
                if self._random.random() < self._loss:
                    self.lost += 1
                    continue
                due = time.monotonic() + self._delay_s
                heapq.heappush(self._queue, (due, self.passed, target, without_checksum(frame)))
                self.passed += 1

    def deliver(self) -> float | None:
        """Deliver what is due; return the time until the next is, s."""
        while self._queue:
            left = self._queue[0][0] - time.monotonic()
            if left > 0:
                return left
            _, _, target, frame = heapq.heappop(self._queue)
            with contextlib.suppress(OSError):  # the cable is full: lost as well
                self.ends[target].send(frame)
        return None


def main(hosts: int, delay_s: float, loss: float) -> None:
    """Make the network and run it until told to stop."""
    ip("link", "set", "lo", "up")
    holders = [subprocess.Popen(["unshare", "-n", "sleep", "3600"]) for _ in range(hosts)]
    try:
        ours = _namespace("self")
        deadline = time.monotonic() + 5.0
        while any(_namespace(str(holder.pid)) == ours for holder in holders):
            if time.monotonic() > deadline:
                raise SystemExit("the hosts have no namespaces of their own")
            time.sleep(0.01)
        switch = Switch([join(i + 1, h.pid) for i, h in enumerate(holders)], delay_s, loss)
        print(json.dumps([holder.pid for holder in holders]), flush=True)
        selector = selectors.DefaultSelector()
        for number, end in enumerate(switch.ends):
            selector.register(end, selectors.EVENT_READ, number)
        selector.register(sys.stdin, selectors.EVENT_READ, None)
        while True:
            for key, _ in selector.select(switch.deliver()):
                if key.data is not None:
                    switch.take(key.data)
                    continue
                match sys.stdin.readline().split():
                    case ["cut", number]:
                        switch.cut.add(int(number) - 1)
                    case ["unicast"]:
                        switch.multicast = False
                    case ["heal"]:
                        switch.cut.clear()
                    case _:
                        return
                print(json.dumps({"passed": switch.passed, "lost": switch.lost}), flush=True)
    finally:
        for holder in holders:
            holder.kill()


def _namespace(process: str) -> str:
    return os.readlink(f"/proc/{process}/ns/net")


if __name__ == "__main__":
    main(int(sys.argv[1]), float(sys.argv[2]), float(sys.argv[3]))
