"""A command counts for what its person saw when it was due, in the world's time."""

import asyncio
import json
from types import SimpleNamespace
from typing import Any

import pytest
from hitab_msgs.msg import WorldStatus

from hitab_client import SwarmError, reaction_time
from hitab_studio.actions import perform
from hitab_studio.reactions import EARLIER_SECONDS, Due, Reactions, due, earlier
from hitab_studio.studio import Studio


def world(mode: str = "running", pace: str = "realtime", factor: float = 1.0) -> Any:
    status = WorldStatus(mode=mode, pace=pace, factor=factor)
    return SimpleNamespace(status=status, speed=3.0)


def test_a_reaction_time_is_scaled_by_the_pace_of_the_world_and_is_nothing_while_it_is_paused():
    assert due(world(), 0.3, 70) == Due(0.3, 70)
    assert due(world(factor=2.0), 0.3, 70) == Due(pytest.approx(0.6), 70)
    assert due(world(pace="lockstep"), 0.3, 70) == Due(pytest.approx(0.9), 70)
    assert due(world("paused"), 0.3, 70) == Due(0.0, 0)
    without = SimpleNamespace(status=None, speed=1.0)
    assert due(without, 0.3, 0) == Due(0.3, 0), "a robot's time is that of the person"


def test_a_command_is_put_earlier_by_the_pace_of_the_world_even_while_it_is_paused():
    assert earlier(world(factor=2.0)) == pytest.approx(2 * EARLIER_SECONDS)
    assert earlier(world("paused", factor=2.0)) == pytest.approx(2 * EARLIER_SECONDS)
    still = SimpleNamespace(status=WorldStatus(mode="paused", pace="lockstep"), speed=0.0)
    assert earlier(still) == EARLIER_SECONDS


def test_what_is_kept_elsewhere_counts_at_once(tmp_path, monkeypatch):
    monkeypatch.setenv("HITAB_HOME", str(tmp_path))
    reactions = Reactions()
    assert reactions.of("anna") == 0.0
    reaction_time.keep("anna", 0.25)
    assert reactions.of("anna") == 0.25
    assert reactions.of("ben") == 0.0
    reaction_time.file().write_text("nonsense")
    with pytest.raises(SwarmError, match="delete it"):
        reactions.of("anna")


def test_a_reaction_time_is_kept_for_whom_the_page_is_used_by(tmp_path, monkeypatch):
    monkeypatch.setenv("HITAB_HOME", str(tmp_path))

    async def run() -> None:
        session = Studio(lambda: None).open()  # type: ignore[arg-type,return-value]
        values = {"demonstrator": "Änne", "seconds": "0.4"}
        await perform(session, {"do": "reaction-set", "values": values})
        assert reaction_time.kept() == {"Änne": 0.4}
        assert session.demonstrator == "Änne"
        told = [json.loads(message) for message in session.outgoing]
        assert {"t": "demonstrator", "name": "Änne"} in told, "the browser remembers it"
        for seconds in ("soon", "-1", "nan", "90"):
            await perform(session, {"do": "reaction-set", "values": values | {"seconds": seconds}})
            assert session.messages.shown[-1].kind == "bad"
        await perform(session, {"do": "reaction-measured", "seconds": 0.256})
        assert reaction_time.kept() == {"Änne": 0.26}
        await perform(session, {"do": "reaction-set", "values": values | {"seconds": ""}})
        assert reaction_time.kept() == {}

    asyncio.run(run())
