"""Who does not answer is called the same everywhere, in the words of the command line."""

import asyncio
import os
import signal
import subprocess
import sys
import time
from types import MappingProxyType, SimpleNamespace
from typing import Any

import pytest
from hitab_msgs.msg import AgentStatus, WorldStatus

from hitab_client.run_processes import Silence
from hitab_studio import processes
from hitab_studio.actions import perform
from hitab_studio.known import JOINING_SECONDS, Known
from hitab_studio.processes import Processes
from hitab_studio.studio import Studio
from hitab_studio.swarm_finder import Target
from hitab_studio.views import render

ONE, TWO = "keeper_1", "keeper_2"
UP = Target(0, "keepaway", (ONE, TWO), 1, folder="/keepaway", world=True)
SUSPENDED = Silence(
    TWO, "is suspended (process 7); `kill -CONT 7` lets it continue", True, "suspended"
)
ENDED = Silence(TWO, f"has ended (killed); see `hitab logs {TWO}`", True, "ended")
HOST_ENDED = Silence("host_1", "has ended (killed); see `hitab logs host_1`", True, "ended")


def known(*heard: str, **more: Any) -> Known:
    statuses = {name: AgentStatus(agent=name, mode="performing") for name in heard}
    return Known(UP, statuses=statuses, world=WorldStatus(missing=[TWO]), **more)


def panels(of: Known, agent: str = TWO, tab: str = "teach") -> dict[str, str]:
    async def made() -> dict[str, str]:
        session = Studio(lambda: Target(0)).open()
        session.shared.store.known = of
        session.agent, session.tab = agent, tab
        return {panel: render(panel, session) for panel in ("top", "agents", "overlay", "side")}

    return asyncio.run(made())


@pytest.mark.parametrize(
    ("why", "word", "sentence"),
    [
        (SUSPENDED, "suspended", "is suspended (process 7); `kill -CONT 7` lets it continue"),
        (ENDED, "ended", "has ended (killed); see `hitab logs keeper_2`"),
        (
            HOST_ENDED,
            "ended",
            "does not answer: host_1, which runs it, has ended (killed); see `hitab logs host_1`",
        ),
        (None, "silent", "has been silent for 40 s"),
    ],
)
@pytest.mark.parametrize("is_gone", [False, True])
def test_one_word_stands_wherever_an_agent_is_said_to_be_absent(why, word, sentence, is_gone):
    """A suspended one was silent, missing, not responding and ended at the same moment."""
    since = MappingProxyType({TWO: time.monotonic() - 40.0})
    of = known(
        ONE, TWO, silent=since, gone=since if is_gone else {}, why={TWO: why} if why else {}
    )
    said = panels(of)
    assert "1 of 2 agents" in said["top"]
    assert f'data-test="absent-{word}">1 {word}</b>' in said["top"]
    assert f'<span class="mode m-performing">{word}</span>' in said["agents"]
    assert f'data-test="mode">{word.capitalize()}</span>' in said["overlay"]
    assert (
        f'data-test="absent" title="{TWO} {sentence}">{sentence}; before that' in said["overlay"]
    )
    assert f"{TWO}: {word}</h2><p>{TWO} {sentence}." in said["side"]
    assert f"{word.capitalize()}: {TWO}</div>" in panels(of, tab="swarm")["side"]
    others = {"silent", "missing", "not responding", "suspended", "has ended"} - {word}
    if word == "ended":
        others.remove("has ended")
    for text in said.values():
        assert not [other for other in others if other in text.replace(sentence, "")]


def test_one_that_never_answered_is_said_so_and_how_its_process_ended():
    late = time.monotonic() - JOINING_SECONDS - 1
    said = panels(known(ONE, joined=late))
    assert f"{TWO}</b>" in said["overlay"]
    assert ">No answer</span>" in said["overlay"]
    assert "1 no answer" in said["top"]
    waiting = known(ONE, joined=time.monotonic(), why={TWO: ENDED})
    assert "1 ended" in panels(waiting)["top"], "it need not be waited for"


def test_an_agent_that_only_the_world_does_not_hear_is_said_so():
    said = panels(known(ONE, TWO))["top"]
    assert "2 agents, 1 not heard by the world" in said
    assert "missing" not in said


def test_why_a_process_does_not_answer_is_found_out_without_waiting(monkeypatch):
    child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
    record = SimpleNamespace(processes={}, world=False, swarm="s", socket="")

    def slow(*_: Any) -> list[dict[str, Any]]:
        time.sleep(0.3)
        return [{"name": TWO, "statename": "RUNNING", "pid": child.pid, "exitstatus": 0}]

    monkeypatch.setattr(processes, "RunFolder", lambda path: SimpleNamespace(read=lambda: record))
    monkeypatch.setattr("hitab_client.run_processes.process_states", slow)
    try:
        os.kill(child.pid, signal.SIGSTOP)
        asks = Processes("/keepaway")
        began = time.monotonic()
        assert asks.why([TWO]) == {}
        assert time.monotonic() - began < 0.2
        while not (found := asks.why([TWO])):
            assert time.monotonic() < began + 20.0, "it is found out"
            time.sleep(0.01)
        assert found[TWO].what.startswith(f"is suspended (process {child.pid})")
        assert asks.why([]) == {}
        assert Processes("").why([TWO]) == {}, "nothing is known of nodes started by hand"
    finally:
        child.kill()
        child.wait()


def test_a_refusal_never_looks_like_a_success():
    async def made() -> str:
        session = Studio(lambda: Target(0)).open()
        session.shared.store.known = known(ONE, TWO)
        await perform(session, {"do": "why", "reason": f"{TWO} is suspended."})
        return render("messages", session)

    assert '<div class="message k-note"' in asyncio.run(made())
