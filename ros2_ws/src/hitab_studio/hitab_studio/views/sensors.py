"""The sensors of the viewed agent's robot: whether each is connected, and how old its news are."""

from __future__ import annotations

import time
from dataclasses import dataclass

from hitab_client.commands import called
from hitab_core import quantity, some
from hitab_ros import fault_texts
from hitab_studio.robots.listening import SensorState
from hitab_studio.robots.state import CameraState, RobotState
from hitab_studio.session import Session


@dataclass(frozen=True)
class Row:
    """One sensor for people.

    Attributes:
        topic, kind: of it.
        age: how old its last message is, or how it is absent.
        bad: whether a person should look after it.
        about: more words, if something is wrong.
    """

    topic: str
    kind: str
    age: str
    bad: bool = False
    about: str = ""


def robot(session: Session) -> RobotState | None:
    """Return what is known of the viewed agent's robot; None: there is none, or in a replay."""
    robots = session.shared.store.known.robots
    if robots is None or session.player is not None or session.agent not in robots.robots:
        return None
    return robots.of(session.agent)


def row(sensor: SensorState, now: float) -> Row:
    """Return a sensor for people; `now` is on the monotonic clock, s."""
    if sensor.trouble:
        return Row(sensor.topic, sensor.kind, "not usable", True, f"It {sensor.trouble}.")
    if not sensor.publishers:
        words = f"{fault_texts.NOT_PUBLISHED.capitalize()}: start the robot's driver."
        if sensor.heard is not None:
            ago = f"{now - sensor.heard:.0f} s ago"
            words = f"Its publisher is gone (last message {ago}): start the robot's driver again."
        return Row(sensor.topic, sensor.kind, "no publisher", True, words)
    if sensor.since is None:
        return Row(sensor.topic, sensor.kind, "connected")
    if sensor.is_silent(now):
        seconds = round(now - (sensor.heard if sensor.heard is not None else sensor.since))
        words = f"{fault_texts.SILENT.capitalize()}."
        age = f"silent for {quantity(seconds, 'second')}"
        return Row(sensor.topic, sensor.kind, age, True, words)
    if sensor.heard is None:
        return Row(sensor.topic, sensor.kind, "waiting for it")
    return Row(sensor.topic, sensor.kind, f"{max(0.0, now - sensor.heard):.1f} s ago")


def rows(session: Session) -> list[Row]:
    """Return the sensors, the camera and the map, as the tab lists them."""
    state, known = robot(session), session.shared.store.known.robots
    if state is None or known is None:
        return []
    now = time.monotonic()
    listed = [row(sensor, now) for sensor in state.sensors]
    if state.camera.sensor is not None:
        listed.append(row(state.camera.sensor, now))
    if (sensor := known.map.sensor) is not None:
        # A map that does not change says nothing: it is latched.
        age = row(sensor, now)
        fine = not sensor.trouble and sensor.publishers and sensor.heard is not None
        listed.append(Row(sensor.topic, sensor.kind, "known") if fine else age)
    return listed


def notes(session: Session) -> list[str]:
    """Return what has to be known to read what is drawn, and what has to be chosen."""
    state, known = robot(session), session.shared.store.known.robots
    if state is None or known is None:
        return []
    found = list(state.notes)
    for topics, one in (
        (state.camera.choices, f"camera: choose one with `{called()} studio --camera TOPIC`"),
        (known.map.choices, f"map: choose one with `{called()} studio --map TOPIC`"),
    ):
        if topics:
            found.append(f"There is more than one {one}, of {some(topics)}.")
    if not state.sensors:
        found.append("The agent listens to no sensor with a standard message.")
    return found


def silent(session: Session) -> str:
    """Return which sensors the viewed robot does without at present; "" if all are heard."""
    state = robot(session)
    now = time.monotonic()
    absent = [
        f"{one.topic} ({one.age})"
        for one in (row(sensor, now) for sensor in (state.sensors if state is not None else ()))
        if one.bad
    ]
    return some(absent) if absent else ""


@dataclass(frozen=True)
class CameraShown:
    """What the page needs for the picture; without a topic there is none."""

    topic: str
    caption: str
    silent: bool


def camera(session: Session) -> CameraShown | None:
    """Return what is shown of the camera of the viewed robot; None: it has none."""
    state = robot(session)
    return _camera(state.camera) if state is not None else None


def _camera(state: CameraState) -> CameraShown | None:
    if state.sensor is None:
        if not state.choices:
            return None
        return CameraShown("", f"Several cameras: {some(state.choices)}", True)
    shown = row(state.sensor, time.monotonic())
    about = shown.about if state.sensor.trouble else shown.age
    return CameraShown(state.sensor.topic, f"{shown.topic} · {about}", shown.bad)
