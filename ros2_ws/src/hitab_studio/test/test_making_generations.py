"""A generation that is being made goes on through what is over soon."""

import asyncio
from types import SimpleNamespace
from typing import Any

from hitab_studio import unavailable
from hitab_studio.actions.bootstrapping import generation_next
from hitab_studio.page_state import StudioState


class Link:
    """Stands for the link to the swarm; notes whose silence would end a job."""

    def __init__(self) -> None:
        self.needed: list[str] = []

    async def do(self, job: Any, line: str = "", needs: str = "") -> None:
        self.needed.append(needs)


def test_a_short_silence_of_the_agent_does_not_end_it(monkeypatch):
    monkeypatch.setattr(unavailable, "agent", lambda session: "")
    link: Any = Link()
    session: Any = SimpleNamespace(
        shared=StudioState(link),
        dialog={"agent": "keeper_1", "behavior": "ApproachBall"},
        agent="keeper_1",
        demonstrator="anna",
        look_at=lambda agent: None,
        hold=lambda agent: None,
    )
    asyncio.run(generation_next(session, {"values": {"episodes": "0"}}))
    assert link.needed == [""]
    assert session.shared.making.agent == "keeper_1"
    assert not session.shared.why_busy
