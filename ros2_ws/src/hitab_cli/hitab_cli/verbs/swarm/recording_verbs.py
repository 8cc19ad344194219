"""Verb that records a swarm: record."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hitab_cli.verbs.verb_connection import connection
from hitab_client import SwarmError, console
from hitab_client.terminal.cli_options import SwarmName
from hitab_client.terminal.cli_remedies import with_commands
from hitab_client.terminal.interruptions import not_interrupted
from hitab_core import Fix, quantity
from hitab_ros.timing import HEARTBEAT_S, SETTLE_S

if TYPE_CHECKING:
    from hitab_client import RosLink
    from hitab_client.recording import Recorder


def record(
    output: Annotated[Path | None, typer.Option("--output", "-o", metavar="PATH")] = None,
    topics: Annotated[list[str] | None, typer.Option("--topics", "-t", metavar="TOPIC")] = None,
    robots: Annotated[bool, typer.Option("--robots")] = False,
    seconds: Annotated[float | None, typer.Option("--seconds", min=0.1)] = None,
    swarm: SwarmName = None,
) -> None:
    """Record the percepts and actions of a swarm to a bag (MCAP), until Ctrl-C.

    The studio replays recordings; `hitab library label` trains from recorded actions.

    Args:
        output: The file to write; .mcap is added. Default: a new file among the recordings that
            the studio shows.
        topics: Also record this topic, such as /robot_1/scan. Repeatable.
        robots: Also record all topics with messages that robots use: those of sensor_msgs,
            nav_msgs, geometry_msgs and tf2_msgs, so also images and point clouds.
        seconds: End after this time, s. Default: with Ctrl-C.

    Examples:
      hitab record
      hitab record -o session.mcap -t /robot_1/scan -t /robot_1/odom
      hitab record -o session --robots
    """
    with connection(swarm, reads=True) as swarm_up:
        from hitab_client.recording import Recorder

        path = _path(output, swarm_up.record.swarm if swarm_up.record else "")
        chosen = [topic if topic.startswith("/") else f"/{topic}" for topic in topics or ()]
        recorder = Recorder(swarm_up.link, path, also=chosen, robots=robots)
        if swarm_up.has_world:
            swarm_up.link.spin_until(lambda: swarm_up.world.status is not None, SETTLE_S)
        if swarm_up.world.is_paused:
            console.note(
                with_commands("the world is paused: nothing changes", [Fix.RESUME_WORLD()])
            )
        began = time.monotonic()
        try:
            _record(swarm_up.link, recorder, seconds)
        except KeyboardInterrupt:
            pass  # Ctrl-C ends the recording
        finally:
            with not_interrupted():
                recorder.close()
        lasted = time.monotonic() - began
    for topic in recorder.missing:
        console.note(f"{topic} is not in it: no node has published it in this ROS domain")
    for topic, why in recorder.left_out.items():
        console.note(f"{topic} is not in it: {why}")
    if recorder.problem:
        raise SwarmError(recorder.problem)
    size = path.stat().st_size
    shown = f"{size / 1e3:.0f} kB" if size < 1e6 else f"{size / 1e6:.1f} MB"
    console.say(
        f"recorded {quantity(recorder.bag.count, 'message')} in {lasted:.0f} s to {path} ({shown})"
    )


def _path(output: Path | None, swarm: str) -> Path:
    """Return the file to write."""
    from hitab_client.recording.recordings import RECORDING_SUFFIX, new_recording

    if output is None:
        return new_recording(swarm)
    return (
        output
        if output.suffix == RECORDING_SUFFIX
        else output.with_name(f"{output.name}{RECORDING_SUFFIX}")
    )


def _record(link: RosLink, recorder: Recorder, seconds: float | None) -> None:
    """Record until the time is over, or the file can no longer be written."""
    console.note(f"recording to {recorder.bag.path}; Ctrl-C ends it")
    began = time.monotonic()
    shown: list[str] = []
    with console.err().status("recording") as status:
        looked = began
        while not recorder.problem:
            link.spin(0.1)
            now = time.monotonic()
            if seconds is not None and now - began >= seconds:
                return
            if now - looked < HEARTBEAT_S:
                continue
            looked = now
            recorder.look()
            far = f"{quantity(recorder.bag.count, 'message')}, {now - began:.0f} s"
            status.update(f"recording: {far}")
            if recorder.perceiving != shown and not recorder.awaited:
                shown = recorder.perceiving
                agents = ", ".join(agent.removeprefix("/") for agent in shown)
                console.note(f"from now on it has the percepts of: {agents}")
