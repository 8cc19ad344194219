"""Verbs for recordings: making one, and training from one."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hitab_bringup.verbs.connection import connection
from hitab_client import SwarmError, console
from hitab_client.command_options import SwarmName
from hitab_client.commands import with_commands
from hitab_client.interruptions import not_interrupted
from hitab_core import Do, quantity

if TYPE_CHECKING:
    from hitab_client import RosLink
    from hitab_client.recording import Recorder

STATUS_S = 1.0
"""How long to wait for the status of the world, s."""

LOOK_S = 0.5
"""Between two looks for new topics."""


def record(
    output: Annotated[Path | None, typer.Option("--output", "-o", metavar="PATH")] = None,
    topics: Annotated[list[str] | None, typer.Option("--topics", "-t", metavar="TOPIC")] = None,
    robots: Annotated[bool, typer.Option("--robots")] = False,
    seconds: Annotated[float | None, typer.Option("--seconds", min=0.1)] = None,
    swarm: SwarmName = None,
) -> None:
    """Record to a bag (MCAP) what a swarm perceives and does, until Ctrl-C.

    The studio, Foxglove and `ros2 bag play` show it again; `hitab library from-recording` trains
    from it.

    Args:
        output: The file to write; .mcap is added. Default: one among the recordings that the
            studio shows.
        topics: Also record this topic, such as /robot_1/scan. Repeatable.
        robots: Also record all topics with messages that robots use: those of sensor_msgs,
            nav_msgs, geometry_msgs and tf2_msgs, so also images and point clouds.
        seconds: End by itself after so many seconds. Default: with Ctrl-C.

    Examples:
      hitab record
      hitab record -o session.mcap -t /robot_1/scan -t /robot_1/odom
      hitab record -o session --robots
    """
    with connection(swarm, reads=True) as there:
        from hitab_client.recording import Recorder

        path = _path(output, there.record.swarm if there.record else "")
        chosen = [topic if topic.startswith("/") else f"/{topic}" for topic in topics or ()]
        recorder = Recorder(there.link, path, also=chosen, robots=robots)
        if there.has_world:
            there.link.spin_until(lambda: there.world.status is not None, STATUS_S)
        if there.world.is_paused:
            console.note(
                with_commands("the world is paused: nothing changes", [Do.RESUME_WORLD()])
            )
        began = time.monotonic()
        try:
            _record(there.link, recorder, seconds)
        except KeyboardInterrupt:
            pass  # how it ends
        finally:
            with not_interrupted():
                recorder.close()
        lasted = time.monotonic() - began
    for topic in recorder.missing:
        console.note(f"{topic} is not in it: nobody has published it in this ROS domain")
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
    from hitab_client.recording.recordings import SUFFIX, new_recording

    if output is None:
        return new_recording(swarm)
    return output if output.suffix == SUFFIX else output.with_name(f"{output.name}{SUFFIX}")


def _record(link: RosLink, recorder: Recorder, seconds: float | None) -> None:
    """Record until the time is over, or the file cannot be written any more."""
    console.note(f"recording to {recorder.bag.path}; Ctrl-C ends it")
    began = time.monotonic()
    told: list[str] = []
    with console.err().status("recording") as status:
        looked = began
        while not recorder.problem:
            link.spin(0.1)
            now = time.monotonic()
            if seconds is not None and now - began >= seconds:
                return
            if now - looked < LOOK_S:
                continue
            looked = now
            recorder.look()
            far = f"{quantity(recorder.bag.count, 'message')}, {now - began:.0f} s"
            status.update(f"recording: {far}")
            if recorder.sessions != told and not recorder.awaited:
                told = recorder.sessions
                agents = ", ".join(agent.removeprefix("/") for agent in told)
                console.note(f"from now on it can be trained from: {agents}")


def from_recording(
    recording: Path,
    folder: Path,
    agent: Annotated[str, typer.Option("--agent", "-a", show_default=False)] = "",
    save: Annotated[bool, typer.Option("--save")] = False,
) -> None:
    """Train from a recording: give an agent again all that the recorded one took in.

    No swarm has to be up. What is learned equals what was learned then, example by example and bit
    by bit; if not, an error says where they part.

    Args:
        recording: A file that `hitab record` or the studio wrote.
        folder: For the library; a new folder.
        agent: Whose training. Default: of the only one.
        save: Also save the training that the recording ends in.

    Examples:
      hitab library from-recording session.mcap trained
      hitab library from-recording session.mcap trained --agent keeper_1 --save
    """
    from hitab_bringup.from_recording import train_from_recording

    console.note(f"training from {recording}")
    recorded, done, unsaved = train_from_recording(recording, folder, agent, save=save)
    agrees = (
        f"; it agrees with the recorded one in all {done.compared} statuses and changes of state"
    )
    console.say(
        f"{recorded} took in {quantity(done.percepts, 'percept')}, "
        f"{quantity(done.commands, 'command')} and {quantity(done.requests, 'request')}"
        + (agrees if done.compared else "")
    )
    for name in done.saved:
        console.say(f"saved {name} in {folder}")
    if unsaved:
        name, examples = unsaved
        console.say(
            f'the training of "{name}" with {quantity(examples, "example")} was not saved; '
            "--save saves it"
        )
    elif not done.saved:
        console.say("nothing was trained in it")
