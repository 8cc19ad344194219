"""Where a robot's scanners sit, by the parameters of its agent's node.

An agent that `hitab_robots` links has parameters such as ``scan.x`` and ``scan.yaw``, by which it
places what its scanner sees; with ``base_frame``, tf tells it instead.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.parameter import parameter_value_to_python

from hitab_client import RosLink
from hitab_studio.robots.frames import Matrix, in_plane

FIELDS = ("x", "y", "yaw", "upside_down")
BASE_FRAME = "base_frame"
AGAIN_SECONDS = 5.0
"""Until an agent that has not answered is asked again."""


class Mounts:
    """Asks one agent's node, without ever waiting for an answer.

    Attributes:
        base_frame: the robot's frame, if tf tells where its sensors sit; "": they do not ask tf.
    """

    def __init__(self, link: RosLink, node: str) -> None:
        self.base_frame = ""
        self._link = link
        create = link.node.create_client
        self._listing = create(ListParameters, f"{node}/list_parameters")
        self._getting = create(GetParameters, f"{node}/get_parameters")
        self._mounts: dict[str, Matrix] = {}
        self._asked = -AGAIN_SECONDS
        self._known = False

    def look(self) -> None:
        """Ask, if that is due."""
        now = time.monotonic()
        if self._known or now < self._asked + AGAIN_SECONDS:
            return
        if not self._listing.service_is_ready():
            return
        self._asked = now
        self._call(self._listing, ListParameters.Request(), self._take_names)

    def _call(self, client: Any, request: Any, take: Callable[[Any], None]) -> None:
        future = client.call_async(request)
        future.add_done_callback(lambda done: take(done.result()))

    def _take_names(self, answer: Any) -> None:
        there = set(answer.result.names)
        scanners = sorted(n.removesuffix(".yaw") for n in there if n.endswith(".yaw"))
        wanted = [f"{s}.{f}" for s in scanners for f in FIELDS if f"{s}.{f}" in there]
        wanted += [BASE_FRAME] if BASE_FRAME in there else []
        if not wanted:
            self._known = True
            return
        self._call(
            self._getting,
            GetParameters.Request(names=wanted),
            lambda values: self._take_values(wanted, values),
        )

    def _take_values(self, names: Sequence[str], answer: Any) -> None:
        values = {
            name: parameter_value_to_python(value)
            for name, value in zip(names, answer.values, strict=True)
        }
        self.base_frame = str(values.pop(BASE_FRAME, "") or "")
        for scanner in {name.rpartition(".")[0] for name in values}:
            x, y, yaw = (float(values.get(f"{scanner}.{f}") or 0.0) for f in FIELDS[:3])
            down = bool(values.get(f"{scanner}.upside_down"))
            self._mounts[scanner] = in_plane(x, y, yaw, upside_down=down)
        self._known = True

    def of(self, topic: str) -> Matrix | None:
        """Return where the scanner with a topic sits on the robot; None: that is not known.

        The parameters are named after the sensor, which is called as its topic unless that was
        chosen otherwise. The only scanner is the one that is meant, whatever its topic.
        """
        named = self._mounts.get(topic.rsplit("/", 1)[-1])
        if named is None and len(self._mounts) == 1:
            return next(iter(self._mounts.values()))
        return named

    def close(self) -> None:
        """Ask no more."""
        for client in (self._listing, self._getting):
            self._link.node.destroy_client(client)
