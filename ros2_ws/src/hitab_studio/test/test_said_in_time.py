"""The page says what a person should know before they press, and where they look."""

import asyncio
import math
import re
from dataclasses import replace
from types import MappingProxyType, SimpleNamespace
from typing import Any

import pytest
from hitab_msgs.msg import AgentStatus

from hitab_client import Learned, SwarmError
from hitab_client.called_as import CALLED_AS
from hitab_core import Example
from hitab_core.example import ExampleKind
from hitab_studio.actions import perform
from hitab_studio.agent_watch import Watched
from hitab_studio.known import Known
from hitab_studio.launching import Launch, Startable, unknown
from hitab_studio.learned import Vocabulary
from hitab_studio.remembered_scenes import RememberedScenes
from hitab_studio.session import Session
from hitab_studio.studio import Studio
from hitab_studio.swarm_finder import Choice, Target
from hitab_studio.views import render

ONE = "keeper_1"
UP = Target(0, "keepaway", (ONE,), 1, folder="/keepaway", world=True)
SAVED = Learned(
    "FetchBall", "trained", "", "tree", (), (), ("Stop",), (), (), (),
    tuple(Example("Start", (), "Stop", ExampleKind.DEMONSTRATED, i, i) for i in (1, 2, 3)),
)  # fmt: skip
WORDS = Vocabulary(
    domain="soccer",
    trained=frozenset({"FetchBall"}),
    features=("DirectionTo(X)",),
    kinds={"DirectionTo": "toroidal"},
    units={"DirectionTo": "rad"},
    targets=("ball",),
)


def page(known: Known, use: Any) -> Any:
    async def made() -> Any:
        session = Studio(lambda: Target(0)).open()
        session.shared.store.known = known
        session.agent = ONE
        return await use(session)

    return asyncio.run(made())


def keeper(status: AgentStatus | None = None, **watched: Any) -> Known:
    known = Watched(vocabulary=WORDS, behaviors={"FetchBall": SAVED}, **watched)
    idle = AgentStatus(agent=ONE, mode="idle", domain="soccer")
    return Known(UP, statuses={ONE: status or idle}, watched=MappingProxyType({ONE: known}))


# -- commands while the world stands still ----------------------------------------------------


def scene(cycle: int, mode: str) -> Any:
    return SimpleNamespace(cycle=cycle, mode=mode, names=())


def test_a_command_that_was_given_while_the_world_stood_still_was_never_late():
    """The button was gray then, but not once the world ran; it failed with "from 0 to 0"."""
    scenes = RememberedScenes()
    scenes.see(scene(5, "running"))
    scenes.keep(ONE, "Chase", [(1, 5)])
    scenes.see(scene(9, "paused"))
    scenes.keep(ONE, "Chase", [(1, 5), (2, 9)])
    scenes.see(scene(30, "running"))
    scenes.keep(ONE, "Chase", [(1, 5), (2, 9)])

    given = tuple(
        Example("Start", (), "Stop", ExampleKind.DEMONSTRATED, n, n, cycle)
        for n, cycle in ((1, 5), (2, 9))
    )
    training = replace(SAVED, name="Chase", examples=given)
    status = AgentStatus(agent=ONE, mode="testing", behavior="Chase", examples=2)
    known = replace(keeper(status, training=training), moments=scenes.kept)

    async def use(session: Session) -> None:
        teach = render("side", session).partition('data-test="earlier"')[2]
        assert teach.startswith(' aria-disabled="true" title="The command was given while the')
        session.tab = "examples"
        table = render("side", session)
        assert "readonly" in table.partition('data-test="ago-2"')[2].partition("</td>")[0]
        assert "readonly" not in table.partition('data-test="ago-1"')[2].partition("</td>")[0]
        await perform(session, {"do": "earlier"})
        await perform(session, {"do": "retime", "number": 2, "value": "0.2"})
        (said,) = session.messages.shown
        assert said.times == 2
        assert "while the world stood still" in said.text

    page(known, use)


# -- a training that began a moment ago -------------------------------------------------------


@pytest.mark.parametrize("mode", ["training", "testing"])
def test_who_trains_is_not_said_to_train_nothing_until_it_is_known_what(mode):
    """The status arrives before the training, and the page said "begin a training" meanwhile."""

    async def use(session: Session) -> None:
        undo = render("overlay", session).partition('data-test="undo"')[2].partition(">")[0]
        assert "nothing to undo: no command" in undo
        await perform(session, {"do": "save-dialog"})
        (said,) = session.messages.shown
        assert said.text == "What keeper_1 trains is not known yet: try again in a moment."

    page(keeper(AgentStatus(agent=ONE, mode=mode, behavior="Chase")), use)


# -- a name that is taken ---------------------------------------------------------------------


def test_the_dialog_says_that_a_name_is_saved_already_and_what_to_do_instead():
    async def use(session: Session) -> None:
        await perform(session, {"do": "new"})
        assert "is saved already" not in render("dialog", session)
        await perform(session, {"do": "new-name", "value": "FetchBall"})
        said = render("dialog", session)
        assert "<b>FetchBall</b> is saved already, with 3 examples" in said
        assert 'data-do="new" data-resume="FetchBall"' in said
        assert "hitab" not in said, "the page has buttons for it"
        await perform(session, {"do": "new", "resume": "FetchBall"})
        assert "is saved already" not in render("dialog", session)

    page(keeper(), use)


def test_who_begins_before_that_was_said_is_told_and_may_begin_then(monkeypatch):
    async def use(session: Session) -> None:
        begun = []

        async def ask_agent(job: Any) -> None:
            begun.append(job)

        monkeypatch.setattr(session, "ask_agent", ask_agent)
        begin = {"do": "begin", "values": {"name": "FetchBall", "features": ["Done"]}}
        await perform(session, {"do": "new"})
        await perform(session, begin)
        said = render("dialog", session)
        assert not begun
        assert 'data-test="saved-already"' in said
        assert "Begin replaces it" in said
        await perform(session, begin)
        assert len(begun) == 1
        assert session.messages.shown[-1].text == "keeper_1 is being trained: FetchBall"

    page(keeper(), use)


def test_what_was_typed_last_opens_no_dialog_that_is_closed():
    """An empty dialog took the Esc that was meant for the training."""

    async def use(session: Session) -> None:
        for late in ("new-name", "new-parameter", "reaction-who"):
            await perform(session, {"do": late, "value": "A"})
            assert session.dialog == {}

    page(keeper(), use)


def test_features_are_offered_with_the_unit_in_which_their_values_are_shown():
    watched = replace(keeper().watched[ONE], probed={"DirectionTo(ball)": math.pi / 2})
    known = replace(keeper(), watched={ONE: watched})

    async def use(session: Session) -> None:
        await perform(session, {"do": "new"})
        said = render("dialog", session)
        assert "toroidal, deg" in said
        assert "90.0 deg" in said
        assert "toroidal, rad" not in said

    page(known, use)


# -- what is no fault -------------------------------------------------------------------------


def test_a_training_that_was_resumed_is_a_note_and_no_alarm():
    text = 'resumed the interrupted training of "Chase" with 2 examples'
    status = AgentStatus(agent=ONE, mode="training", behavior="Chase", examples=2)
    status.note = text

    async def use(session: Session) -> None:
        assert f"fault-{ONE}" not in render("agents", session)
        assert "resumed the interrupted training" in render("overlay", session)
        session.tab = "swarm"
        assert "resumed" not in render("side", session)
        status.faults = ["the disk is full"]
        assert 'title="the disk is full"' in render("agents", session)

    page(keeper(status), use)


# -- swarms -----------------------------------------------------------------------------------


def test_a_swarm_that_starts_is_said_to_and_not_that_none_is_up():
    async def use(session: Session) -> None:
        assert "No swarm is up" in render("overlay", session)
        session.shared.launcher.launch = Launch("up", "keepaway", 0.0)
        said = render("overlay", session)
        assert "<h2>Starting keepaway …</h2>" in said
        assert "No swarm is up" not in said
        assert "Start one" not in said

    page(Known(Target(0)), use)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("keepaway", ""),
        ("keepawy", 'No swarm "keepawy" is shipped. Did you mean "keepaway"? Start one of your'),
        ("nosuch", 'No swarm "nosuch" is shipped. Start one of your own with `hitab up`'),
    ],
)
def test_a_swarm_that_is_not_shipped_is_not_proposed_to_be_started(name, said):
    assert unknown(name).startswith(said)
    assert bool(unknown(name)) == bool(said)

    async def use(session: Session) -> None:
        shown = render("overlay", session).replace("&#34;", '"')
        assert said in shown
        assert (f"<code>hitab up {name}</code>" in shown) == (not said)

    page(Known(Target(0, name, problem=f'Swarm "{name}" is not up.')), use)


def test_the_page_says_what_it_is_not_connected_to_and_what_to_do():
    choices = (Choice("red", "/red", 0, 3),)

    async def shown(session: Session) -> list[str]:
        found = []
        for target in (
            None,
            Target(0, problem="Which?", choices=choices),
            Target(0, "red", ("a",), 1, folder="/red"),
        ):
            session.shared.store.known = Known(target)
            found += re.findall(r"not connected[^<]*", render("top", session))
        return found

    assert page(Known(), shown) == [
        "not connected to a swarm: start one in a terminal",
        "not connected to a swarm: choose one below",
        "not connected to red yet: it does not answer",
    ]


def test_commands_are_named_as_the_command_was_called(monkeypatch):
    """The page said `hitab up`, and what it had run said `scripts/hitab up`."""
    monkeypatch.setenv(CALLED_AS, "scripts/hitab")

    async def shown(session: Session) -> str:
        session.tell("It has ended; see `hitab logs keeper_1`")
        return render("overlay", session) + render("messages", session)

    said = page(Known(Target(0)), shown)
    assert "<code>scripts/hitab up keepaway</code>" in said
    assert "see `scripts/hitab logs keeper_1`" in said


def test_the_swarm_that_is_chosen_to_be_started_is_described_in_full():
    swarms = tuple(Startable(name, f"What {name} is. " * 9) for name in ("keepaway", "thousand"))

    async def shown(session: Session) -> list[str]:
        session.shared.launcher.startable = swarms
        found = [render("overlay", session)]
        await perform(session, {"do": "swarm-about", "value": "thousand"})
        return [*found, render("overlay", session)]

    for swarm, said in zip(swarms, page(Known(Target(0)), shown), strict=True):
        assert f'data-test="swarm-about">{swarm.about}</p>' in said
        assert f'<option value="{swarm.name}" selected>' in said
        assert f"<code>hitab up {swarm.name}</code>" in said


# -- the library ------------------------------------------------------------------------------


def test_long_rules_are_broken_below_where_they_begin():
    async def use(session: Session) -> None:
        session.tab, session.behavior = "library", "FetchBall"
        said = render("side", session)
        assert "3 examples" in said
        assert '<div class="rule-line" style="--indent: 2">features: one' in said

    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr(
            "hitab_studio.views.library.automaton_as_text", lambda *_, **__: "F\n  features: one"
        )
        monkeypatch.setattr(Learned, "automaton", object())
        page(keeper(), use)


def test_a_refused_request_of_an_absent_agent_is_in_the_same_words():
    async def use(session: Session) -> None:
        with pytest.raises(SwarmError, match="keeper_1 does not answer"):
            await session.ask_agent(lambda swarm, agent: None)

    page(Known(UP), use)
