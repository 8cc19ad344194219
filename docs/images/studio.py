"""Takes the pictures of the studio, studio-*.png.

scripts/python docs/images/studio.py

A person at a real browser trains ApproachBall by clicking, has a look at what would be learned
from another feature, is asked which of two commands holds, stops all robots, makes a generation of
the team, arranges a scenario by dragging, and looks into what the shipped keepers have learned,
while they play. Then the person trains a robot that is in no simulated world.

With ``--only robot`` (or ``keepers``) it takes only these pictures.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from hitab_bringup.processes.bringing_up import RunningSwarm, temporary_swarm
from hitab_client import RosLink, SwarmClient, domain_ids

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
LIBRARY = ROOT / "ros2_ws/src/keepaway_world/libraries/keepaway"
SIZE = {"width": 1280, "height": 720}
TABLET = {"width": 820, "height": 1180}
TEACHER = "keeper_1"
ROBOT = "robot_1"

sys.path.insert(0, str(ROOT / "tests"))


@contextmanager
def page(chrome: Any, url: str, *, dark: bool = False, agent: str = TEACHER) -> Iterator[Any]:
    """Open the studio in a window."""
    from browsing import Person

    window = chrome.new_page(viewport=SIZE, color_scheme="dark" if dark else "light")
    person = Person(window, url)
    person.sees_field()
    person.click(f"agent-{agent}")
    yield person
    window.close()


def arrange(swarm: RunningSwarm) -> None:
    """Put everything where a training of ApproachBall begins."""
    things = {
        TEACHER: {"x": -8.0, "y": 0.0, "heading": 0.0},
        "keeper_2": {"x": 7.0, "y": 7.0, "heading": -2.4},
        "keeper_3": {"x": 7.0, "y": -7.0, "heading": 2.4},
        "taker_1": {"x": -8.0, "y": 8.5, "heading": 0.0},
        "taker_2": {"x": -6.5, "y": 8.5, "heading": 0.0},
        "ball": {"x": 0.0, "y": 0.0},
    }
    still = {name: {"vx": 0.0, "vy": 0.0, **place} for name, place in things.items()}
    swarm.world.shown(swarm.world.place(still))


def train(person: Any, swarm: RunningSwarm) -> None:
    """Train ApproachBall by clicking, up to where it is about to be tested."""
    arrange(swarm)
    person.click("new")
    person.type("new-name", "ApproachBall")
    person.tick("feature-DistanceTo(ball)")
    person.click("begin")
    person.sees("mode", "Training")
    for x, behavior, examples in ((-8.0, "GoFast", 2), (-4.5, "GoMedium", 4), (-2.4, "GoSlow", 6)):
        person.drags(TEACHER, x, 0.0)
        person.click(f"do-{behavior}")
        person.sees("counts", f"{examples} examples")
    person.page.wait_for_timeout(5500)  # messages have gone, curves are there
    person.page.screenshot(path=HERE / "studio-train.png")
    person.page.mouse.move(2, 2)
    person.page.set_viewport_size(TABLET)
    person.page.wait_for_timeout(500)
    person.page.screenshot(path=HERE / "studio-tablet.png")
    person.page.set_viewport_size(SIZE)
    person.click("features-change")
    person.page.uncheck('[data-test="feature-DistanceTo(ball)"]')
    person.tick("feature-DistanceTo(closest_keeper)")
    person.sees("features-effect", "DistanceTo(closest_keeper)")
    person.page.locator('[data-test="features-effect"]').scroll_into_view_if_needed()
    person.page.wait_for_timeout(300)
    person.page.screenshot(path=HERE / "studio-features.png")
    person.page.keyboard.press("Escape")
    person.does_not_see("features-dialog")
    for behavior, examples in (("GoMedium", 8), ("Stop", 10)):  # here it was to go slowly
        person.click(f"do-{behavior}")
        person.sees("counts", f"{examples} examples")
    person.sees("questions", "which holds?")
    person.page.wait_for_timeout(5500)
    person.page.locator('[data-test="questions"]').scroll_into_view_if_needed()
    person.page.screenshot(path=HERE / "studio-questions.png")
    person.click("stop-robots")
    person.sees("stopped")
    person.page.wait_for_timeout(300)
    person.page.screenshot(path=HERE / "studio-stopped.png")
    person.click("release")
    person.click("release-now")
    person.does_not_see("stopped")
    for examples in (8, 6):
        person.page.wait_for_selector('[data-test="undo"]:not([aria-disabled])')
        person.click("undo")
        person.sees("counts", f"{examples} examples")
    person.click("tab-examples")
    person.page.wait_for_timeout(300)
    generations(person)
    # In the middle of dragging, two things at once.
    mouse = person.page.mouse
    mouse.click(*person.on_screen(*person.place_of("taker_1")))
    person.page.wait_for_timeout(200)
    person.page.keyboard.down("Shift")
    mouse.click(*person.on_screen(*person.place_of("taker_2")))
    person.page.keyboard.up("Shift")
    person.page.wait_for_timeout(200)
    mouse.move(*person.on_screen(*person.place_of("taker_1")))
    mouse.down()
    mouse.move(*person.on_screen(-2.0, 3.5), steps=5)
    person.page.wait_for_timeout(200)
    person.page.screenshot(path=HERE / "studio-arrange.png")
    mouse.up()


def generations(person: Any) -> None:
    """Make a generation, which the team performs from then on."""
    person.click("tab-teach")
    person.click("generations-teach")
    person.type("generation-note", "runs to the ball")
    person.type("generation-episodes", "5")
    person.click("generation-next")
    person.sees("making", "Done")
    person.page.wait_for_timeout(300)
    person.page.screenshot(path=HERE / "studio-generations.png")
    person.page.keyboard.press("Escape")
    person.does_not_see("generations-dialog")
    person.click("tab-examples")


def look(person: Any, swarm: RunningSwarm) -> None:
    """Look into what was learned, while it plays."""
    person.page.click("#trails")
    person.click("tab-learned")
    person.sees("level-ControlBall")
    person.waits_until(
        lambda: swarm.link.spin(0.01) or len(swarm.agents.statuses[TEACHER].active_path) > 2,
        "the keeper has the ball",
        60.0,
    )
    person.page.wait_for_timeout(250)
    person.page.screenshot(path=HERE / "studio-learned.png")


def robot() -> None:
    """Train a robot of examples/diff_drive to wander, up to its second turn."""
    from browsing import browser, studio

    paths = [str(ROOT / "examples/diff_drive"), os.environ.get("PYTHONPATH", "")]
    with ExitStack() as stack:
        number = stack.enter_context(domain_ids.reserved())
        os.environ |= {"ROS_DOMAIN_ID": str(number), "PYTHONPATH": os.pathsep.join(paths)}
        home = Path(os.environ["HITAB_HOME"])
        for program in (
            ("-m", "diff_drive.simulated_robot"),
            (str(HERE / "robot_in_a_room.py"),),
            ("-m", "hitab_agent.agent_main"),
        ):
            options = ["--ros-args", "-r", f"__ns:=/{ROBOT}"]
            if program[-1] == "hitab_agent.agent_main":
                options += ["-p", "domain:=diff_drive.domain:DOMAIN", "-p", f"state_dir:={home}"]
            process = subprocess.Popen([sys.executable, *program, *options])
            stack.callback(process.wait)
            stack.callback(process.kill)
        link = stack.enter_context(RosLink(number))
        agents = SwarmClient(link, [ROBOT])
        agents.await_agent(ROBOT, 60.0)
        chrome = stack.enter_context(browser())
        url = stack.enter_context(studio(home / "robot.log"))
        person = stack.enter_context(page(chrome, url, agent=ROBOT))
        person.page.wait_for_function(
            "studioField.robots.map?.canvas && studioField.robots.points.length"
        )
        person.click("new")
        person.type("new-name", "Wander")
        person.tick("feature-RangeAhead")
        person.click("begin")
        person.sees("mode", "Training")
        for behavior, examples, true in (
            ("Forward", 2, "p[0] > 1.2"),
            ("TurnLeft", 4, "Math.abs(p[2]) > 1.9"),
            ("Forward", 6, "p[0] < 0.8"),
        ):
            person.click(f"do-{behavior}")
            person.sees("counts", f"{examples} examples")
            person.page.wait_for_function(
                f"(() => {{ const p = studioField.now.places; return {true}; }})()"
            )
        person.page.screenshot(path=HERE / "studio-robot.png")


def keepers() -> None:
    """Train keepers, and look into what trained ones have learned."""
    from browsing import browser, studio

    parameters = {"taker_speed": 0.25}
    for library, behavior in ((None, ""), (LIBRARY, "Keepaway")):
        from keepers import trained_keepers

        description = trained_keepers(library, behavior, parameters)
        with temporary_swarm(description) as swarm, browser() as chrome:
            log = Path(os.environ["HITAB_HOME"], "studio.log")
            with studio(log, "--run-dir", str(swarm.folder.path)) as url:
                swarm.world.control("pace", pace="realtime", factor=1.0)
                if library is None:
                    with page(chrome, url) as person:
                        train(person, swarm)
                else:
                    swarm.world.control("resume")
                    with page(chrome, url, dark=True) as person:
                        person.page.wait_for_timeout(8000)
                        look(person, swarm)


def main() -> None:
    """Take the pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", choices=("keepers", "robot"), help="take only these")
    only = parser.parse_args().only
    os.environ["HITAB_HOME"] = tempfile.mkdtemp(prefix="hitab-studio-")
    if only != "robot":
        keepers()
    if only != "keepers":
        robot()


if __name__ == "__main__":
    main()
