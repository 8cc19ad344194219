"""A generation that is being made goes on through what is over soon."""

import asyncio
from typing import Any

from hitab_studio.generations import GenerationMaker, Making
from hitab_studio.swarm_state import SwarmState


class Link:
    """Stands for the link to the swarm; notes whose silence would end a job."""

    def __init__(self) -> None:
        self.needed: list[str] = []

    async def do(self, job: Any, line: str = "", needs: str = "") -> None:
        self.needed.append(needs)

    def refresh(self, agent: str) -> None:
        return None


def test_a_short_silence_of_the_agent_does_not_end_it_with_nothing_in_training():
    link, making = Link(), Making("keeper_1", "ApproachBall")

    async def make() -> None:
        maker = GenerationMaker(link, lambda: None)  # type: ignore[arg-type]
        maker.begin(making, lambda steps: steps, SwarmState(world=object()), who="anna")  # type: ignore
        while maker.why_busy:
            await asyncio.sleep(0)

    asyncio.run(make())
    assert not making.doing
    assert not making.problem
    assert link.needed == [""]
