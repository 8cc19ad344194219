"""The parts of the studio, without a browser and without a swarm."""

import asyncio
import struct
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hitab_msgs.msg import AgentStatus, Entity, Look, WorldState

from hitab_client import Learned
from hitab_client.errors import SwarmError
from hitab_core.domain import Scale
from hitab_core.example import Example, ExampleKind
from hitab_core.learning import learn_transitions
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.term import Term
from hitab_studio.access import AccessControl, is_loopback, new_token
from hitab_studio.field.remembered_scenes import RECENT, THINGS_MAX, RememberedScenes
from hitab_studio.field.scene import NO_COLOR, Palette, frame, scene_of, state_shown
from hitab_studio.pages.example_effects import effect, is_contradicted
from hitab_studio.pages.page_view import perform
from hitab_studio.pages.tree_rows import tree_rows
from hitab_studio.studio import Studio
from hitab_studio.swarm.agent_watch import AgentState
from hitab_studio.swarm.received_vocabulary import Vocabulary
from hitab_studio.swarm.swarm_finder import SwarmTarget
from hitab_studio.swarm.swarm_state import SwarmState
from hitab_studio.views import render

DISTANCE = "DistanceTo(ball)"


def scene(cycle: int = 0, x: float = 0.0) -> Any:
    things = [Entity(name="keeper_1", kind="keeper", x=x, y=2.0, heading=0.5, say="hey")]
    things.append(Entity(name="ball", kind="ball", x=-1.0))
    looks = [Look(kind="ball", color="#123456", shape="ball", opacity=0.5, layer=1)]
    return scene_of(WorldState(cycle=cycle, width=20.0, height=10.0, entities=things, looks=looks))


def test_placements_cannot_be_undone_in_another_episode():
    studio = Studio(lambda: SwarmTarget(0))
    studio.take(SwarmState(scene=replace(scene(), episode=1)))
    studio.placements.append({"ball": {"x": 0.0}})
    studio.take(SwarmState(scene=replace(scene(5), episode=1)))
    assert studio.placements
    studio.take(SwarmState(scene=replace(scene(9), episode=2)))
    assert not studio.placements


def test_where_nothing_has_a_place_what_an_agent_perceives_is_plotted_instead():
    async def term() -> None:
        studio = Studio(lambda: SwarmTarget(0))
        page = studio.open()
        page.agent = "pump"
        readings = {("", "Heat"): (20.0, 21.5), ("", "Gap(a,a)"): (0.0,), ("", DISTANCE): (3.0,)}
        known = SwarmState(
            statuses={"pump": AgentStatus(mode="idle")},
            watched={"pump": AgentState(Vocabulary("plant"), readings=readings)},
            scene=scene_of(WorldState(width=20.0, height=10.0)),
        )
        studio.take(known)
        shown = render("overlay", page)
        assert "21.50" in shown
        assert DISTANCE in shown
        assert "Gap(a,a)" not in shown
        studio.take(replace(known, scene=scene()))
        assert "21.50" not in render("overlay", page)
        assert "21.50" in render("side", page), "an idle agent perceives all the same"

    asyncio.run(term())


def example(number: int, state: str, value: float, to: str, kind: str = "demonstrated") -> Example:
    return Example(state, (value,), to, ExampleKind(kind), number, number)


def learned(*examples: Example) -> Learned:
    return Learned(
        "Near",
        tuple(dict.fromkeys(Term(example.next_state) for example in examples)),
        (Term.parse(DISTANCE),),
        learn_transitions(examples, (Scale(),)),  # type: ignore[arg-type]
        examples=examples,
        units=("m",),
        scales=(Scale(),),
    )


# -- who may talk to the page ---------------------------------------------------------------


def answer_of(access: AccessControl, kind: str = "http", query: str = "", **headers: str) -> int:
    """Return the status of a request's answer, or the closing code of a refused web socket."""
    sent: list[dict[str, Any]] = []

    async def receive() -> dict[str, Any]:
        return {}

    async def send(message: dict[str, Any]) -> None:
        sent.append(message)

    raw = [(k.encode(), v.encode()) for k, v in ({"host": "127.0.0.1:80"} | headers).items()]
    scope = {"type": kind, "path": "/", "headers": raw, "query_string": query.encode()}
    asyncio.run(access(scope, receive, send))
    return int(sent[0].get("status") or sent[0]["code"])


async def page(scope: Any, receive: Any, send: Any) -> None:
    await send({"type": "http.response.start", "status": 200, "headers": []})


def test_only_this_page_talks_to_the_server():
    for kind, refused in (("http", 403), ("websocket", 1008)):
        access = AccessControl(page)
        assert answer_of(access, kind) == 200
        assert answer_of(access, kind, origin="http://127.0.0.1:80") == 200
        assert answer_of(access, kind, origin="http://127.0.0.1:81") == refused
        assert answer_of(access, kind, origin="null") == refused
        assert answer_of(access, kind, host="evil.example") == refused


def test_behind_a_proxy_it_has_the_names_that_are_allowed():
    origin = "https://lab.example.org"
    for kind, refused in (("http", 403), ("websocket", 1008)):
        access = AccessControl(page, allowed=["Lab.Example.org"])
        for host in ("127.0.0.1:8080", "lab.example.org"):  # as nginx sends it, or handed on
            assert answer_of(AccessControl(page), kind, host=host, origin=origin) == refused
            assert answer_of(access, kind, host=host, origin=origin) == 200
        assert answer_of(access, kind, origin="https://evil.example") == refused
        assert answer_of(access, kind, origin="null") == refused
        assert answer_of(access, kind, host="evil.example") == refused


@pytest.mark.parametrize("path", ["/recordings/a", "/hitab/recordings/a"])
def test_below_another_path_it_is_found_whether_the_proxy_cuts_that_off_or_not(path):
    asked: list[tuple[str, str]] = []

    async def note(scope: Any, receive: Any, send: Any) -> None:
        asked.append((scope["root_path"], scope["path"]))

    scope = {"type": "http", "path": path, "headers": [(b"host", b"localhost")]}
    access = AccessControl(note, root_path="/hitab")
    asyncio.run(access(scope | {"query_string": b""}, None, None))  # type: ignore[arg-type]
    assert asked == [("/hitab", "/hitab/recordings/a")]


def test_with_a_token_only_who_shows_it_is_let_in():
    access = AccessControl(page, "0.0.0.0", "right-token")
    there = {"host": "robot.lan:8080"}
    assert answer_of(access, **there) == 401
    assert answer_of(access, "websocket", "token=right-token", **there) == 1008
    assert answer_of(access, query="token=right-token", **there) == 303
    assert answer_of(access, cookie="hitab_studio_token=right-token", **there) == 200
    assert answer_of(access, cookie="hitab_studio_token=wrong-token", **there) == 401
    assert answer_of(access, cookie="=;=;", **there) == 401


def test_a_token_is_made_where_other_machines_reach_the_page():
    assert is_loopback("127.0.0.1")
    assert is_loopback("localhost")
    assert not is_loopback("0.0.0.0")
    assert new_token("127.0.0.1") == ""
    assert len(new_token("0.0.0.0")) > 16
    with pytest.raises(SwarmError, match="at least 8"):
        new_token("0.0.0.0", "a b")


# -- who holds an agent ---------------------------------------------------------------------


def test_an_agent_is_commanded_by_one_demonstrator_until_another_takes_it():
    async def term() -> None:
        studio = Studio(lambda: SwarmTarget(0))
        anna, ben = studio.open("Anna"), studio.open("Ben")
        anna.agent = ben.agent = "keeper_1"
        anna.hold("keeper_1")
        anna.hold("keeper_1")
        with pytest.raises(SwarmError, match="trained by Anna; press Take over"):
            ben.hold("keeper_1")
        await perform(ben, {"do": "take"})
        assert anna.messages.shown[0].text == "Ben has taken keeper_1"
        studio.close(anna)
        assert studio.held == {"keeper_1": ben}
        studio.close(ben)
        assert not studio.held

    asyncio.run(term())


# -- moments --------------------------------------------------------------------------------


def test_a_frame_holds_places_states_and_modes_as_the_page_reads_them():
    palette = Palette()
    data = frame(scene(7, 3.0), {"keeper_1": ("training", "GoFast")}, palette)
    assert struct.unpack_from("<IId", data) == (1, 2, 7.0)
    places = np.frombuffer(data, "<f4", 6, 16)
    assert places.tolist() == [3.0, 2.0, 0.5, -1.0, 0.0, 0.0]
    assert list(data[40:42]) == [palette.index("GoFast"), NO_COLOR]
    assert list(data[42:44]) == [3, 0]
    assert len(data) == 16 + 14 * 2


def test_an_agent_is_colored_by_the_role_that_its_commander_gives_it():
    status = AgentStatus(mode="performing", behavior="Winger", active_path=["RunTo(spot)"])
    assert state_shown(status) == "RunTo"
    status.order.commander = "captain"
    assert state_shown(status) == "Winger"
    status.mode = "training"
    assert state_shown(status) == "RunTo"


def test_the_moment_of_an_example_is_kept_when_recent_moments_are_forgotten():
    scenes = RememberedScenes()
    scenes.see(scene(1, 3.0))
    scenes.keep("keeper_1", "Near", [(1, 1), (2, 400)])
    for cycle in range(2, RECENT + 10):
        scenes.see(scene(cycle, 9.0))
    assert [*scenes.kept] == [("keeper_1", "Near", 1, 1)]
    (kept,) = scenes.kept.values()
    assert kept.everything()["keeper_1"]["x"] == 3.0


@pytest.mark.parametrize("count", [1, 10_000])
def test_scenes_of_many_things_are_remembered_for_a_shorter_time(count: int):
    scenes = RememberedScenes()
    many = replace(scene(), names=("ant",) * count)
    for cycle in range(RECENT + 10):
        scenes.see(replace(many, cycle=cycle))
    scenes.keep("ant", "Near", enumerate(range(RECENT + 10)))
    back = 3  # an example without a scene of its cycle has that of one shortly before
    assert len(scenes.kept) in range(30, min(RECENT, THINGS_MAX // count) + back)


# -- learned behaviors ----------------------------------------------------------------------


def test_examples_that_go_to_different_states_from_the_same_disagree():
    examples = [
        example(1, "GoFast", 2.0, "Stop"),
        example(2, "GoFast", 2.0, "GoSlow"),
        example(3, "GoFast", 2.5, "GoSlow"),
        example(4, "GoSlow", 2.0, "Stop"),
    ]
    assert is_contradicted(examples) == {1: [2], 2: [1]}


def test_the_effect_of_a_correction_is_told_in_rules_and_in_decisions():
    kept = [example(1, "Start", 8.0, "GoFast"), example(2, "Start", 2.0, "GoSlow")]
    before = learned(*kept, example(3, "Start", 4.0, "GoSlow"))
    after = learned(*kept, example(3, "Start", 4.0, "GoFast"))
    change = effect(before, after)
    assert any("<= 6" in rule for rule in change.rules_gone)
    assert any("<= 3" in rule for rule in change.rules_new)
    assert [(e.number, was, now) for e, was, now in change.decisions] == [(3, "GoSlow", "GoFast")]


def test_the_path_of_a_decision_is_lit_in_the_tree():
    X, y = [[1.0], [2.0], [8.0]], ["Stop", "GoSlow", "GoFast"]
    tree = TransitionTree([Scale()]).fit(X, y)
    rows = tree_rows(tree, [DISTANCE], {DISTANCE: 1.9})
    leaves = [row for row in rows if row.chances]
    assert [row.chances[0][1] for row in leaves if row.taken] == ["GoSlow"]
    assert len(leaves) == 3
    assert not any(row.taken for row in tree_rows(tree, [DISTANCE], {}))
