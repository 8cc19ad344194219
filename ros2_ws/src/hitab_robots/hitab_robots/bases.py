"""The subscribers of a robot's velocity: whether one is a base, and was restarted. No ROS here."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from hitab_ros.timing import PROMPT_S

LISTENERS = re.compile(r"/(hitab|rosbag2_recorder|foxglove_bridge|(_ros2cli|rqt_gui_py_node)_\d+)")
"""Names of nodes that only listen and are no base."""


class Bases:
    """The subscribers of a robot's velocity: its base, and programs that only listen.

    A base that was started again has its old name and a new subscription.

    Attributes:
        missing: whether there is no subscriber that is surely a base.
        unnamed: whether a new subscriber has no name yet, and may be a base that was restarted.
    """

    def __init__(self) -> None:
        self.missing, self.unnamed = True, False
        self._known: dict[bytes, str] = {}
        self._names: set[str] = set()
        self._settled = 0.0

    def look(self, takers: Mapping[bytes, str], now: float) -> set[str]:
        """Return the names of bases that were restarted since the last look; call this often.

        Args:
            takers: the subscribers' names, by identity of the subscription; an empty name is not
                known yet.
            now: time on any steady clock, s.
        """
        # A subscriber that gets its name late counts as new again.
        new = {name for identity, name in takers.items() if self._known.get(identity) != name}
        self.unnamed = "" in new and now - self._settled < PROMPT_S
        # A subscriber without a name may only listen. It counts as no base, since a robot that is
        # armed now would stop as soon as the name shows that a base was restarted.
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
