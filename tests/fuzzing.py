"""Sends well-typed messages with random contents to all topics and services of a swarm.

What there is to be sent to is taken from the ROS graph, so that a new topic or service is tried as
well. Half of what is sent is a real message of the swarm with a field or two changed, which gets
further than one that is all random.
"""

from __future__ import annotations

import copy
import importlib
import random
import time
from collections import Counter
from collections.abc import Sequence
from typing import Any

from rosidl_parser.definition import AbstractSequence, Array, BasicType, NamespacedType

from hitab_client.connecting.ros_link import RosLink
from hitab_ros import qos

PACKAGES = ("hitab_msgs/", "rosgraph_msgs/", "rcl_interfaces/")
PENDING_MAX = 10
UNANSWERED_S = 10.0
LOOK_S = 3.0
READ_AT_ONCE = 50
PERIOD_S = 0.005
"""Between two messages: what is sent has to be read, or nothing is tried but queues."""

INTEGERS = (0, 1, 2, 3, 255, 2**31 - 1, 2**31, 2**32 - 1, 2**53 + 1, 2**63 - 1, 2**63, 2**64 - 1)
REALS = (0.0, -0.0, 1.0, -1.0, 1e-300, 1e308, -1e308, float("nan"), float("inf"), float("-inf"))
TEXTS = (
    "",
    " ",
    ".",
    "..",
    "../fuzzed",
    "../../fuzzed",
    "/fuzzed",
    "/tmp/fuzzed",
    "/",
    "~",
    "~/fuzzed",
    "~root",
    "$HOME/fuzzed",
    "C:\\fuzzed",
    "fuzzed",
    "fuzzed.hfa.yaml",
    "a b",
    "a\x00b",
    "\x1b[31mred\x1b[0m\x07",
    "line\nline\r\n",
    "%s%n%d",
    "{0.__class__}",
    "!!python/object:os.system",
    "\u202edesrever",
    "名前",
    "\U0001f916" * 50,
    "Start",
    "Done",
    "Failed",
    "A(",
    "A(B, C, D)",
    "A" * 101,
    "tree",
    "sklearn.svm.SVC",
    "DecisionTreeClassifier",
    "training",
    "testing",
    "idle",
)


def type_of(name: str) -> Any:
    """Return the class of a message or service, such as of ``hitab_msgs/msg/Command``."""
    package, kind, attribute = name.split("/")
    return getattr(importlib.import_module(f"{package}.{kind}"), attribute)


class Contents:
    """Makes contents, from a seed and from the words of the swarm."""

    def __init__(self, seed: int, words: Sequence[str]) -> None:
        self.random = random.Random(seed)
        self.words = list(words)

    def message(self, kind: Any, depth: int = 0) -> Any:
        """Return a message with random contents."""
        made = kind()
        for field, slot in zip(kind.get_fields_and_field_types(), kind.SLOT_TYPES, strict=True):
            if self.random.random() < 0.85:
                setattr(made, field, self.value(kind, slot, depth))
        return made

    def changed(self, message: Any) -> Any:
        """Return a copy of a message with a field or two changed."""
        made = copy.deepcopy(message)
        kind = type(made)
        slots = dict(zip(kind.get_fields_and_field_types(), kind.SLOT_TYPES, strict=True))
        for field in self.random.sample(
            sorted(slots), min(len(slots), self.random.choice((1, 2)))
        ):
            setattr(made, field, self.value(kind, slots[field], 0))
        return made

    def value(self, kind: Any, slot: Any, depth: int) -> Any:
        """Return a value for a field of a type of message."""
        if isinstance(slot, AbstractSequence | Array):
            item = slot.value_type
            length = slot.size if isinstance(slot, Array) else self._length(depth, item)
            if length > 50:  # the same few, since making each would take the whole time
                few = [self.value(kind, item, 2) for _ in range(5)]
                return [few[i % 5] for i in range(length)]
            return [self.value(kind, item, depth + 1) for _ in range(length)]
        if isinstance(slot, NamespacedType):
            return self.message(type_of("/".join([*slot.namespaces, slot.name])), depth + 1)
        if isinstance(slot, BasicType):
            return self._basic(slot.typename)
        return self.text(kind, depth)

    def text(self, kind: Any, depth: int) -> str:
        """Return a text: a constant of the type, a word of the swarm, or something nasty."""
        # Not in lists: messages of gigabytes are a matter of the network, not of what they say.
        if depth < 2 and self.random.random() < 0.03:
            return "x" * 100_000
        chance = self.random.random()
        if chance < 0.25:
            constants = [
                v for n in dir(kind) if n.isupper() and isinstance(v := getattr(kind, n), str)
            ]
            if constants:
                return self.random.choice(constants)
        if chance < 0.6:
            return self.random.choice(self.words)
        if chance < 0.95:
            return self.random.choice(TEXTS)
        codes = (self.random.choice((0x20, 0x41, 0x61, 0xE4, 0x4E00)) for _ in range(20))
        return "".join(chr(code + self.random.randrange(25)) for code in codes)

    def _length(self, depth: int, item: Any) -> int:
        chance = self.random.random()
        if depth or chance < 0.9:
            return self.random.choice((0, 0, 1, 1, 2, 3, 10))
        return 30_000 if chance > 0.998 else self.random.choice((100, 1000))

    def _basic(self, kind: str) -> Any:
        if kind == "boolean":
            return self.random.random() < 0.5
        if kind in ("double", "float"):
            value = (
                self.random.choice(REALS) if self.random.random() < 0.6
                else self.random.gauss(0.0, 10.0)
            )  # fmt: skip
            return value if kind == "double" or abs(value) < 1e38 else 0.0
        if kind == "octet":
            return b"\x00"
        bits = int(kind.removeprefix("u").removeprefix("int") or 8)
        low, high = (
            (0, 2**bits - 1) if kind.startswith("u") else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
        )
        chance = self.random.random()
        if chance < 0.3:
            return min(self.random.randrange(10), high)
        if chance < 0.4:
            return min(
                max(time.time_ns() + self.random.choice((-1, 1, 10**9, 10**12, 10**18)), low), high
            )
        if chance < 0.9:
            return min(max(self.random.choice(INTEGERS), low), high)
        return self.random.randint(low, high)


class Fuzzer:
    """Listens to a swarm, and sends.

    Attributes:
        sent: how many messages of each topic, and requests of each service.
        unanswered: services that have not answered in time.
        answered: how many requests were answered.
    """

    def __init__(self, link: RosLink, seed: int, agents: Sequence[str]) -> None:
        self.link = link
        self.agents = tuple(agents)
        self.contents = Contents(seed, (*agents, "world", "ball", "home"))
        self.sent: Counter[str] = Counter()
        self.unanswered: Counter[str] = Counter()
        self.answered = 0
        self._publishers: dict[str, Any] = {}
        self._services: dict[str, Any] = {}
        self._clients: dict[str, Any] = {}
        self._pending: list[tuple[float, str, Any]] = []
        self._last: dict[str, Any] = {}
        self._heard: list[Any] = []

    def learn(self, words: Sequence[str]) -> None:
        """Use words of the swarm, too, such as names of behaviors."""
        self.contents.words += [word for word in words if word]

    def look(self) -> None:
        """Find all topics and services; listen to all, so that what is watched is published."""
        for topic, kinds in self.link.node.get_topic_names_and_types():
            if kinds[0].startswith(PACKAGES) and topic not in self._publishers:
                kind = type_of(kinds[0])
                # Latched, as the strictest of the swarm's subscribers want it.
                self._publishers[topic] = self.link.node.create_publisher(
                    kind, topic, qos.LATCHED, temporary=True
                )
                self._heard.append(
                    self.link.node.create_subscription(
                        kind,
                        topic,
                        lambda message, topic=topic: self._last.__setitem__(topic, message),
                        qos.STREAM,
                        checked=False,
                        temporary=True,
                    )
                )
        for service, kinds in self.link.node.get_service_names_and_types():
            if kinds[0].startswith("hitab_msgs/"):
                self._services[service] = type_of(kinds[0])
        # An agent of a host offers its services when somebody asks: all have the same.
        for service, kind in list(self._services.items()):
            owner, _, leaf = service.rpartition("/")
            if owner.lstrip("/") in self.agents:
                for agent in self.agents:
                    self._services.setdefault(f"/{agent}/{leaf}", kind)

    def run(self, seconds: float) -> None:
        """Send for so long."""
        end, next_look = time.monotonic() + seconds, 0.0
        while time.monotonic() < end:
            if time.monotonic() >= next_look:
                self.look()
                next_look = time.monotonic() + LOOK_S
            if self._publishers:
                self._publish()
                self.link.spin(PERIOD_S)
                for _ in range(READ_AT_ONCE):  # much more is said by the swarm itself
                    self.link.spin(0.0)
            if self._services and self.contents.random.random() < 0.3:
                self._ask()

    def _publish(self) -> None:
        contents = self.contents
        topic = contents.random.choice(sorted(self._publishers))
        publisher = self._publishers[topic]
        last = self._last.get(topic)
        if last is not None and contents.random.random() < 0.5:
            message = contents.changed(last)
        else:
            message = contents.message(publisher.msg_type)
        publisher.publish(message)
        self.sent[topic] += 1

    def _ask(self) -> None:
        now = time.monotonic()
        still: list[tuple[float, str, Any]] = []
        for since, service, future in self._pending:
            if future.done():
                self.answered += 1
            elif now - since > UNANSWERED_S:
                self.unanswered[service] += 1
                self._clients[service].remove_pending_request(future)
            else:
                still.append((since, service, future))
        self._pending = still
        if len(still) >= PENDING_MAX:
            return
        service = self.contents.random.choice(sorted(self._services))
        kind = self._services[service]
        if service not in self._clients:
            self._clients[service] = self.link.node.create_client(kind, service)
        client = self._clients[service]
        if client.service_is_ready():
            future = client.call_async(self.contents.message(kind.Request))
            self._pending.append((now, service, future))
            self.sent[service] += 1

    def close(self) -> None:
        """Leave, with all that was latched."""
        for publisher in self._publishers.values():
            self.link.node.destroy_publisher(publisher)
        for subscription in self._heard:
            self.link.node.destroy_subscription(subscription)
        for client in self._clients.values():
            self.link.node.destroy_client(client)
