"""One robot: listens to its sensors and says where it is and what its scanners see."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hitab_client import RosLink
from hitab_studio.robots.frames import Frames, Matrix, applied, planar
from hitab_studio.robots.listening import Listening, SensorState
from hitab_studio.robots.messages import (
    PICTURE_BYTES,
    SCAN_BYTES,
    Placed,
    Refused,
    Scanned,
    odometry_of,
    picture_of,
    scan_of,
)
from hitab_studio.robots.mounts import Mounts
from hitab_studio.robots.state import CameraState
from hitab_studio.robots.topics import CAMERA, HEAVY, SCAN, RobotTopics


class Reading:
    """The newest message of a topic, read once.

    Attributes:
        listening: to the topic.
        value: what was read last; None: nothing, or it was refused.
        number: of that message.
        trouble: why it was refused; "": it was not.
    """

    def __init__(self, listening: Listening, read: Callable[[Any], Any]) -> None:
        self.listening = listening
        self.value: Any = None
        self.number = 0
        self.trouble = ""
        self._read = read

    @property
    def refusal(self) -> str:
        """Why what its topic sends is not shown; "": it is."""
        return self.listening.trouble or self.trouble

    def look(self) -> bool:
        """Read the newest message; return whether it is another one than before."""
        self.listening.look()
        if self.listening.number == self.number:
            return False
        self.number = self.listening.number
        try:
            message = self.listening.message()
            self.value, self.trouble = None if message is None else self._read(message), ""
        except Refused as error:
            self.value, self.trouble = None, str(error)
        return True


def none(message: Any) -> None:
    """Read nothing of a message of which only the age is shown."""


class Robot:
    """One robot, while a page shows it.

    Attributes:
        topics: of it.
    """

    def __init__(self, link: RosLink, topics: RobotTopics) -> None:
        self.topics = topics
        self._link = link
        self._readings: dict[str, Reading] = {}
        for topic, kind in topics.sensors.items():
            if kind not in HEAVY:
                scans = kind == SCAN
                listening = Listening(link, topic, kind, *([SCAN_BYTES] if scans else []))
                read = scan_of if scans else odometry_of if topic == topics.odometry else none
                self._readings[topic] = Reading(listening, read)
        self._mounts = Mounts(link, topics.node) if topics.node else None
        self._camera: Reading | None = None

    def close(self) -> None:
        """Listen no more."""
        for reading in self._readings.values():
            reading.listening.close()
        self.watch_camera(on=False)
        if self._mounts is not None:
            self._mounts.close()

    def watch_camera(self, *, on: bool) -> None:
        """Listen to the camera from now on, or no longer."""
        if on and self._camera is None and self.topics.camera:
            listening = Listening(self._link, self.topics.camera, CAMERA, PICTURE_BYTES)
            self._camera = Reading(listening, picture_of)
        elif not on and self._camera is not None:
            self._camera.listening.close()
            self._camera = None

    def look(self) -> None:
        """Read what has come."""
        if self._mounts is not None:
            self._mounts.look()
        if self._camera is not None:
            self._camera.look()
        for reading in self._readings.values():
            reading.look()

    # -- what is known ----------------------------------------------------------------------

    @property
    def placed(self) -> Placed | None:
        """Where it is, by its odometry; None: that is not known."""
        reading = self._readings.get(self.topics.odometry)
        return reading.value if reading is not None else None

    def base(self, agent: str, *, alone: bool) -> tuple[str, ...]:
        """Return what the robot's own frame may be called."""
        known = self._mounts.base_frame if self._mounts is not None else ""
        names = ("base_footprint", "base_link")
        return (
            *([known] if known else []),
            *(f"{agent}/{name}" for name in names),
            *(names if alone else ()),
        )

    def points(
        self, frames: Frames, fixed: str, way: Matrix | None, now: float
    ) -> tuple[list[Matrix], list[str]]:
        """Return what its scanners see, in the frame in which all is drawn, and notes.

        Args:
            frames: tell where its sensors sit, if its agent does not.
            fixed: name of the frame in which all is drawn.
            way: from the frame of its odometry to that one; None: it has no odometry.
            now: s, on the monotonic clock.
        """
        found, notes = [], []
        for topic, reading in self._readings.items():
            scan = reading.value
            if not isinstance(scan, Scanned) or self.state_of(topic).is_silent(now):
                continue
            if way is None or self.placed is None:
                motion = frames.way(fixed, scan.frame)
            elif (mount := self._mount(topic, scan.frame, self.placed.child, frames)) is None:
                motion = way @ self.placed.pose
                notes.append(
                    f"Nobody says where {scan.frame or 'the scanner'} sits on the robot: {topic} "
                    "is drawn as if it sat in the middle and faced ahead."
                )
            else:
                motion = way @ self.placed.pose @ mount
            if motion is not None:
                found.append(applied(motion, scan.points))
        return found, notes

    def _mount(self, topic: str, frame: str, base: str, frames: Frames) -> Matrix | None:
        """Return where a scanner sits on the robot, as its agent believes it."""
        by_tf = self._mounts.base_frame if self._mounts is not None else ""
        told = self._mounts.of(topic) if self._mounts is not None and not by_tf else None
        return told if told is not None else frames.way(by_tf or base, frame)

    def pose_by_tf(self, frames: Frames, fixed: str, bases: tuple[str, ...]) -> Matrix | None:
        """Return where it is by tf alone, in the plane; None: tf does not know."""
        ways = (frames.way(fixed, base) for base in bases)
        way = next((way for way in ways if way is not None), None)
        return planar(way) if way is not None else None

    def state_of(self, topic: str) -> SensorState:
        """Return what is known of a sensor."""
        kind = self.topics.sensors[topic]
        publishers = self._link.node.count_publishers(topic)
        if (reading := self._readings.get(topic)) is None:
            return SensorState(topic, kind.rsplit("/", 1)[-1], publishers)
        return reading.listening.state(kind, publishers, reading.trouble)

    def readings(self) -> list[Reading]:
        """Return what is listened to."""
        return [*self._readings.values(), *([self._camera] if self._camera is not None else [])]

    def sensors(self) -> tuple[SensorState, ...]:
        """Return what is known of all sensors."""
        return tuple(map(self.state_of, self.topics.sensors))

    def camera(self, before: CameraState) -> CameraState:
        """Return what is known of the camera.

        Args:
            before: what was known; its picture is numbered on.
        """
        if not self.topics.camera:
            return CameraState(choices=self.topics.cameras)
        topic = self.topics.camera
        publishers = self._link.node.count_publishers(topic)
        if (reading := self._camera) is None:
            sensor = SensorState(topic, CAMERA.rsplit("/", 1)[-1], publishers)
            return CameraState(sensor, before.number)
        sensor = reading.listening.state(CAMERA, publishers, reading.trouble)
        number = before.number + (reading.value is not before.picture)
        return CameraState(sensor, number, reading.value)
