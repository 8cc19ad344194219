"""The reaction times of the people at the pages are those that are kept on this machine."""

import asyncio
import json

import pytest

from hitab_client import SwarmError, reaction_time
from hitab_studio.actions import perform
from hitab_studio.reactions import Reactions
from hitab_studio.studio import Studio


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
