"""What checking and saving cost, counted: none of it grows faster than what is checked."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from bodies import Body
from hypothesis import given
from hypothesis import strategies as st

from hitab_core.agent import Agent
from hitab_core.automaton import Automaton
from hitab_core.domain import BasicBehavior, Domain, Feature
from hitab_core.example import Example
from hitab_core.hierarchy import circle_among, in_order
from hitab_core.learning.transition_learning import learn_transitions
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.library.check import misfits
from hitab_core.term import Term
from hitab_core.training import Curriculum

DOMAIN = Domain.of(
    "line",
    "1",
    Body,
    behaviors=[BasicBehavior(name) for name in ("Left", "Right", "Stay")],
    features=[Feature("x", lambda body: body.x), Feature("y", lambda body: body.values[1])],
)


def lattice(levels: int) -> dict[str, Automaton]:
    """Return two automata a level, both of which use both of the level below."""
    made = {}
    for level in range(levels):
        below = (Term("Left"), Term("Right"))
        if level:
            below = (Term(f"A{level - 1}"), Term(f"B{level - 1}"))
        for letter in "AB":
            made[f"{letter}{level}"] = Automaton(f"{letter}{level}", below, (), {})
    return made


@pytest.fixture
def looks(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """Count how often it is asked what an automaton uses."""
    counted: Counter[str] = Counter()
    computed = Automaton.behaviors_used.fget  # type: ignore[attr-defined]

    def used(automaton: Automaton) -> frozenset[str]:
        counted[automaton.name] += 1
        assert counted[automaton.name] < 1000, f"{automaton.name} is looked at far too often"
        return computed(automaton)

    monkeypatch.setattr(Automaton, "behaviors_used", property(used))
    return counted


LEVELS = 40  # by every way through it, a trillion looks


def test_whether_files_fit_is_found_by_a_few_looks_at_each(
    looks: Counter[str], tmp_path: Path
) -> None:
    library = BehaviorLibrary(tmp_path, DOMAIN)
    library.save(learned("Base"), agent="", classifier="tree")
    one = library.file("Base")
    files = {
        name: replace(one, automaton=automaton, state_lines=(1, 2))
        for name, automaton in lattice(LEVELS).items()
    }
    looks.clear()
    assert misfits(files, DOMAIN) == ({}, {})
    assert max(looks.values()) <= 4
    looks.clear()
    del files["A0"]
    found, lost = misfits(files, DOMAIN, ["A0"])
    assert (len(found), len(lost)) == (2 * LEVELS - 2, 2 * LEVELS - 1)
    assert max(looks.values()) <= 4


def learned(name: str) -> Automaton:
    examples = (Example("Start", (0.0,), "Left", number=1, command=1),)
    scales = [DOMAIN.features["x"].scale]
    return Automaton(
        name, (Term("Left"),), (Term("x"),), learn_transitions(examples, scales), (), examples
    )


# The same as before -----------------------------------------------------------------------------

graphs = st.dictionaries(
    st.sampled_from("ABCDEF"), st.frozensets(st.sampled_from("ABCDEFG"), max_size=3), max_size=6
)


def reachable(graph: dict[str, frozenset[str]], name: str) -> set[str]:
    found: set[str] = set()
    while more := {u for n in (found or {name}) for u in graph.get(n, ())} - found:
        found |= more
    return found | set(graph.get(name, ()))


@given(graphs)
def test_circles_groups_and_orders_are_those_of_the_definition(
    graph: dict[str, frozenset[str]],
) -> None:
    def terms(name: str) -> frozenset[str]:
        return graph.get(name, frozenset())

    below = {name: reachable(graph, name) for name in graph}
    recursive = {name for name in graph if name in below[name]}
    circle = circle_among(sorted(graph), terms)
    assert bool(circle) == bool(recursive)
    assert not circle or circle[0] == circle[-1]
    assert all(b in terms(a) for a, b in pairwise(circle))
    if not circle:
        order = in_order(sorted(graph), terms)
        assert sorted(order) == sorted(set(graph) | {u for n in graph for u in graph[n]})
        for place, name in enumerate(order):
            assert terms(name) <= set(order[:place])


# Learning ---------------------------------------------------------------------------------------


@pytest.fixture
def fits(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Write down from what trees are grown."""
    done: list[Any] = []
    fit = TransitionTree.fit

    def counts(self: TransitionTree, X: Any, y: Any, default: Any = None) -> Any:
        done.append(([list(row) for row in X], list(y)))
        return fit(self, X, y, default)

    monkeypatch.setattr(TransitionTree, "fit", counts)
    return done


def taught(agent: Agent, tag: float) -> None:
    """Teach two states with a feature that is not needed."""
    agent.begin(Curriculum("Home", (Term("x"), Term("y"))))
    for x, y, label in ((5.0 + tag, 1.0, "Left"), (0.0, 1.0, "Stay"), (9.0, 1.0, "Left")):
        agent.sense((x, y), ())
        agent.command(Term(label))


def test_one_save_learns_from_the_same_examples_once(tmp_path: Path, fits: list[Any]) -> None:
    """Preview, trimming, reading the file back and performing it would each learn again."""
    library = BehaviorLibrary(tmp_path / "library", DOMAIN)
    agent = Agent("ann", DOMAIN, library, tmp_path)
    taught(agent, 0.125)
    agent.test()
    agent.session.trimmed(keep_unused=False)
    agent.save()
    agent.reload()
    assert fits
    distinct = {repr(learned_from) for learned_from in fits}
    assert len(fits) == len(distinct)
    states, ways = 3, 2  # with all features, and with those that are needed
    assert len(fits) <= states * ways


def test_what_is_learned_again_from_the_same_tells_the_names_that_were_asked_for() -> None:
    first, again = learned("One").transitions["Start"], learned("Two").transitions["Start"]
    assert first.digest() == again.digest()  # type: ignore[attr-defined]
    scales = [DOMAIN.features["x"].scale]
    examples = learned("One").examples
    (named,) = learn_transitions(examples, scales, names=["Speed"]).values()
    (other,) = learn_transitions(examples, scales, names=["Distance"]).values()
    assert isinstance(named, TransitionTree)
    assert isinstance(other, TransitionTree)
    assert (named.feature_names, other.feature_names) == (("Speed",), ("Distance",))
    assert named.digest() == other.digest()
