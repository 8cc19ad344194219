"""Swarms with commanders in one process do as they do over topics."""

import math
from dataclasses import replace

from bodies import Body

from hitab_commander.commander_domain import commander_domain
from hitab_commander.inprocess import Commander, HierarchyPlayers, Member
from hitab_commander.kinds.kind_reader import described_kind
from hitab_core.automaton import START, Automaton
from hitab_core.domain import BasicBehavior, Domain, Feature
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.repertoire import Repertoire
from hitab_core.term import Term
from hitab_core.transition_function import HandWritten

_TURNS = HandWritten(lambda x: "Wait" if x % 2.0 else "Search", (0,))
ANT = Domain.of(
    "ant",
    "1",
    Body,
    behaviors=[BasicBehavior("Search"), BasicBehavior("Wait")],
    features=[Feature("X", lambda body: body.x)],
    automata=[
        Automaton(
            "Turns",
            (Term("Search"), Term("Wait")),
            (Term("X"),),
            dict.fromkeys((START, "Search", "Wait"), _TURNS),
        )
    ],
)


def hierarchy(folder, features, behavior="Turns"):
    """Return ants a, which performs a behavior, and b, which always waits, and their chief."""
    described = {"orders": {"Rest": "nothing"}, "features": features}
    kind = described_kind("Chief", described)
    library = BehaviorLibrary(folder / "ants", ANT)
    chiefs = BehaviorLibrary(folder / "chief", commander_domain(kind))
    return HierarchyPlayers(
        [Member("a", library, behavior), Member("b", library, "Wait")],
        [Commander("chief", kind, chiefs, "", ("a", "b"))],
    )


def play(made, values):
    for value in values:
        for player in made.players.values():
            player.sense((value,), ())
        made.confer()
        for player in made.players.values():
            player.tick()
            player.act()


def test_who_has_no_news_is_not_taken_for_silent(tmp_path):
    made = hierarchy(tmp_path, {"Waiting": {"count": {"active": "Wait"}}})
    play(made, range(100))  # 10 s
    body = made.agents["chief"].body
    assert [name for name, _ in body.present()] == ["a", "b"]
    assert body.fraction_silent == 0.0


def test_a_commander_whose_feature_has_no_value_does_nothing_until_it_has_one(tmp_path):
    made = hierarchy(tmp_path, {"MeanX": {"mean": "X"}}, "Wait")
    chief = made.agents["chief"]
    rests = HandWritten(lambda x: "Rest", (0,))
    plan = Automaton("Plan", (Term("Rest"),), (Term("MeanX"),), {START: rests})
    chief.context = replace(chief.context, repertoire=Repertoire(chief.domain, {"Plan": plan}))
    chief.perform(Term("Plan"))
    play(made, [math.nan] * 10)
    assert chief.active_path == ["Start"]
    play(made, [1.0] * 10)
    assert chief.active_path == ["Rest"]
