"""Publishes the field as standard markers, for RViz and Foxglove."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from builtin_interfaces.msg import Duration
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from hitab_msgs import msg
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from hitab_client import RosLink
from hitab_ros import qos
from hitab_ros.messages.stamps import time_of
from hitab_ros.timing import DISCOVERY_S, UPDATE_S
from hitab_studio.field.scene import NO_COLOR, STATE_COLORS, Appearance, Scene

MARKERS_TOPIC = "/studio/markers"
FRAME = "field"

MARKER_SHAPES = {
    msg.Look.DISC: Marker.CYLINDER,
    msg.Look.SQUARE: Marker.CUBE,
    msg.Look.BALL: Marker.SPHERE,
}


Doing = Mapping[str, tuple[str, str]]
"""Mode and active state of agents, by name."""


class Markers:
    """Publishes the field while there are subscribers."""

    def __init__(self, link: RosLink) -> None:
        self._publisher = link.node.create_publisher(MarkerArray, MARKERS_TOPIC, qos.LATCHED)
        self._heard = False
        self._last = -math.inf

    def look(self, scene: Scene | None, doing: Doing, colors: Mapping[str, int]) -> None:
        """Check for subscribers, and publish the last scene again for them.

        A paused world publishes nothing, but markers expire after `DISCOVERY_S`. Call this
        several times within that time.

        Args:
            scene: the last scene; None before the first one.
            doing: mode and active state of each agent, by name.
            colors: colors of states, by name.
        """
        self._heard = self._publisher.get_subscription_count() > 0
        if self._heard and scene is not None:
            self._publisher.publish(self._array(scene, doing, colors))

    def show(self, scene: Scene, doing: Doing, colors: Mapping[str, int]) -> None:
        """Publish a scene if there are subscribers and the period has passed.

        Args:
            scene: the scene to show.
            doing: mode and active state of each agent, by name.
            colors: colors of states, by name; agents in other states keep the agents' color.
        """
        paused = scene.mode == msg.WorldState.PAUSED  # published only on a change
        # Rounding may make a cycle of exactly this length a little shorter.
        due = abs(scene.seconds - self._last) > 0.9 * UPDATE_S
        if self._heard and (paused or due):
            self._last = scene.seconds
            self._publisher.publish(self._array(scene, doing, colors))

    def _array(self, scene: Scene, doing: Doing, colors: Mapping[str, int]) -> MarkerArray:
        header = Header(frame_id=FRAME, stamp=time_of(scene.seconds))
        markers = [_outline(header, scene)]
        for i, name in enumerate(scene.names):
            state = doing.get(name, ("", ""))[1]
            color = colors.get(state, NO_COLOR)
            look = scene.looks[scene.kinds[i]]
            if color != NO_COLOR:
                look = replace(look, color=STATE_COLORS[color])
            x, y, heading = scene.places[i, :3].tolist()
            markers += _thing(header, i, name, look, (x, y, heading), scene.radii[i])
        for marker in markers:
            marker.lifetime = Duration(sec=int(DISCOVERY_S))
        # Remove the markers of things that have gone.
        return MarkerArray(markers=[Marker(header=header, action=Marker.DELETEALL), *markers])


def _color(text: str, alpha: float = 1.0) -> ColorRGBA:
    r, g, b = (int(text[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return ColorRGBA(r=r, g=g, b=b, a=alpha)


def _outline(header: Header, scene: Scene) -> Any:
    w, h = scene.size[0] / 2, scene.size[1] / 2
    corners = [(-w, -h), (w, -h), (w, h), (-w, h), (-w, -h)]
    return Marker(
        header=header,
        ns="field",
        type=Marker.LINE_STRIP,
        pose=Pose(orientation=Quaternion(w=1.0)),
        scale=Vector3(x=0.08),
        color=_color("#8a93a3"),
        points=[Point(x=x, y=y) for x, y in corners],
    )


def _thing(
    header: Header,
    number: int,
    name: str,
    look: Appearance,
    place: tuple[float, float, float],
    radius: float,
) -> list[Any]:
    x, y, heading = place
    turn = Quaternion(z=math.sin(heading / 2), w=math.cos(heading / 2))
    size = 2 * max(radius, 0.1)

    def marker(ns: str, kind: int, scale: Vector3, color: ColorRGBA, **more: Any) -> Any:
        pose = more.pop("pose", Pose(position=Point(x=x, y=y), orientation=turn))
        return Marker(
            header=header, ns=ns, id=number, type=kind, pose=pose, scale=scale, color=color, **more
        )

    high = size if look.shape == msg.Look.BALL else 0.4
    shape = MARKER_SHAPES.get(look.shape, Marker.CYLINDER)
    color = _color(look.color, look.opacity)
    body = marker("things", shape, Vector3(x=size, y=size, z=high), color)
    if not look.faces:
        return [body]
    ink = _color("#20262e")
    above = Pose(position=Point(x=x, y=y, z=1.0), orientation=Quaternion(w=1.0))
    scale = Vector3(x=2.2 * size, y=0.2 * size, z=0.2 * size)
    arrow = marker("headings", Marker.ARROW, scale, ink)
    text = Marker.TEXT_VIEW_FACING
    return [body, arrow, marker("names", text, Vector3(z=0.5), ink, pose=above, text=name)]
