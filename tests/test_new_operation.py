"""A new operation is one dataclass; its service, its call and its step of a lesson follow."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hitab_msgs import srv

from hitab_agent import agent_main
from hitab_client import RosLink, SwarmClient, domain_ids
from hitab_core.operations import OPERATIONS
from hitab_core.training.operation import Operation, Outcome

LESSON = "lesson: Praises\nagent: one\nsteps:\n  - praise: [4, 5]\n"


@dataclass(frozen=True)
class Praise(Operation):
    """Praise examples.

    Attributes:
        numbers: numbers of the examples.
    """

    numbers: Sequence[int]

    def apply(self, agent: Any) -> Outcome:
        """Praise them."""
        print(f"{self.by} praises {agent.name} for {list(self.numbers)}", flush=True)
        return Outcome("praised")


def play(domain_id: int) -> None:
    """Have the agent praised by a call, and by a lesson."""
    from hitab_client.lessons import LessonPlayer
    from hitab_client.lessons.lesson import parse_lesson

    with RosLink(domain_id) as link:
        swarm = SwarmClient(link, ["one"], demonstrator="ann")
        assert swarm.do("one", Praise([3])).message == "praised"
        LessonPlayer(parse_lesson(LESSON, Path("praises.yaml")), swarm, None).play()


def test_an_operation_has_a_service_a_call_and_a_step(tmp_path):
    command = [sys.executable, __file__]
    given = f"-r __ns:=/one -p domain:=keepaway -p state_dir:={tmp_path}"
    with domain_ids.reserved() as number:
        environment = {**os.environ, "ROS_DOMAIN_ID": str(number)}
        agent = subprocess.Popen(
            [*command, "--ros-args", *given.split()],
            env=environment,
            stdout=subprocess.PIPE,
            text=True,
        )
        try:
            subprocess.run(command, env=environment, timeout=60, check=True)
        finally:
            agent.terminate()
        done, _ = agent.communicate(timeout=30)
    assert done.splitlines() == ["ann praises one for [3]", "ann praises one for [4, 5]"]


if __name__ == "__main__":
    OPERATIONS[Praise.name] = Praise
    srv.Praise = srv.DeleteExamples  # a stand-in, which has the same fields
    if "--ros-args" in sys.argv:
        agent_main.main()
    else:
        play(int(os.environ["ROS_DOMAIN_ID"]))
