"""Which of the programs that take a robot's velocity have come back. No ROS here."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

NAMED_S = 2.0
"""How long to wait for the name of a program that is new in the ROS graph, s."""

LISTENERS = re.compile(r"/(hitab|rosbag2_recorder|foxglove_bridge|(_ros2cli|rqt_gui_py_node)_\d+)")
"""Programs that only listen, whenever they are started."""


class Bases:
    """The programs that take a robot's velocity: its base, and others that only listen.

    A base that was started again has the name of the one before, and another subscription.

    Attributes:
        missing: whether all of them only listen, or may.
        unnamed: whether a new base has no name yet, and may be one that came back.
    """

    def __init__(self) -> None:
        self.missing, self.unnamed = True, False
        self._known: dict[bytes, str] = {}
        self._names: set[str] = set()
        self._settled = 0.0

    def look(self, takers: Mapping[bytes, str], now: float) -> set[str]:
        """Return the names of those that came back since the last look; call this often.

        Args:
            takers: names by identity of the subscription; empty if the name is not known yet.
            now: s; any steady clock.
        """
        # One may be named late: then it is new once more.
        new = {name for identity, name in takers.items() if self._known.get(identity) != name}
        self.unnamed = "" in new and now - self._settled < NAMED_S
        # One without a name yet may only listen: a robot that is armed now would stop at its name.
        self.missing = all(
            LISTENERS.fullmatch(name) or (self.unnamed and not name) for name in takers.values()
        )
        if self.unnamed:
            return set()
        back = {name for name in new & self._names if not LISTENERS.fullmatch(name)}
        self._settled = now
        self._known = dict(takers)
        self._names |= new
        return back


def name_of(info: Any) -> str:
    """Return the full name of an endpoint's node; empty if the graph does not know it yet."""
    if "_UNKNOWN_" in info.node_name:
        return ""
    return f"{info.node_namespace.rstrip('/')}/{info.node_name}"
