"""An exported behavior decides as the engine does, percept by percept."""

from __future__ import annotations

import ast
import re
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from functools import cache
from itertools import islice
from pathlib import Path
from types import ModuleType
from typing import Any
from xml.etree import ElementTree

import pytest
from odd_library import odd_library
from replays import (
    Replayed,
    Step,
    all_transitions,
    draws,
    recorded_steps,
    replayed,
    steered_steps,
)

from foraging_world.world import ForagingWorld
from hitab_bringup import open_library
from hitab_client.runs.shipped import shipped
from hitab_core import BehaviorLibrary, Repertoire, Term
from hitab_export import exported
from hitab_export.behavior_tree import BUILT_IN
from hitab_export.hierarchy_form import Hierarchy, hierarchy_of
from hitab_export.names import identifiers
from hitab_world.inprocess import perform, play
from keepaway_world.world import KeepawayWorld

SHIPPED = {
    "keepaway": ("Keepaway",),
    "keepaway_captained": ("Keepaway", "Freeze", "Regroup"),
    "keepaway_handcoded": ("GotoBall",),
    "captain": ("Captain",),
    "foraging": ("Forage", "Help", "Approach(scout)"),
    "foraging_squad": ("SquadForage", "HaulNext"),
    "foraging_company": ("CompanyForage",),
    "foraging_roles": ("Collect",),
}
"""Behaviors that the automata of each library are part of."""

BEHAVIORS = [*((name, each) for name in SHIPPED for each in SHIPPED[name]), ("odd", "Behavior")]
WORLDS = {"keepaway": KeepawayWorld, "foraging": ForagingWorld}
COUNT = 10_000
TEXT: Any = {"text": True, "capture_output": True, "check": True}


@cache
def library(name: str) -> BehaviorLibrary:
    if name == "odd":
        return odd_library(Path(tempfile.mkdtemp()))
    return open_library(shipped("libraries", name))


@cache
def hierarchy(name: str, behavior: str) -> Hierarchy:
    return hierarchy_of(library(name).loaded().repertoire, Term.parse(behavior))


@cache
def steps_of(name: str, behavior: str) -> tuple[Step, ...]:
    """Return percepts of episodes, if the robots of a world perform it, then steered ones."""
    form, there = hierarchy(name, behavior), library(name)
    recorded: list[Step] = []
    if there.domain.name in WORLDS:
        world = WORLDS[there.domain.name](seed=1)
        players = perform(world, Repertoire(there.domain, there.load()), behavior)
        recorded = recorded_steps(form, there.domain, world, players)
        play(world, players, 3, cycles_max=150)
        assert len(recorded) > 100
    steered = steered_steps(form, COUNT - len(recorded), f"{name} {behavior}")
    return (*recorded, *((percept, now + len(recorded), new) for percept, now, new in steered))


@cache
def engine_of(name: str, behavior: str) -> tuple[Replayed, float]:
    """Return what the engine makes of the percepts, and the first draw that it left."""
    draw, there = draws(behavior), library(name)
    term = Term.parse(behavior)
    found = replayed(there.domain, there.load(), term, steps_of(name, behavior), draw.__next__)
    return found, next(draw)


@pytest.mark.parametrize("name", SHIPPED)
def test_the_percepts_lead_through_every_transition_of_a_library(name):
    taken, there = set(), set()
    for behavior in SHIPPED[name]:
        taken |= engine_of(name, behavior)[0].taken
        there |= all_transitions(hierarchy(name, behavior))
    assert taken == there
    assert {term.partition("(")[0] for term, _, _ in taken} == set(library(name).files)


@pytest.mark.parametrize(("name", "behavior"), BEHAVIORS)
def test_python_decides_as_the_engine_does(name, behavior):
    engine, left = engine_of(name, behavior)
    draw = draws(behavior)
    robot = python_robot(exported(library(name), behavior, "python"))
    before = ""
    for number, (step, expected) in enumerate(
        zip(steps_of(name, behavior), engine.seen, strict=True)
    ):
        percept, now, begins = step
        acts = []
        if begins:
            robot.start(now)
            acts += [f"stop {before}"] * bool(before)
            before = ""
        action = robot.tick(percept, now, draw.__next__)
        if action is None or action.started:
            acts += [f"stop {before}"] * bool(before)
            before = ""
        if action is not None:
            before = str(Term(action.name, action.arguments))
            acts += [f"start {before}"] * action.started
            acts += [f"pulse {before}"] * (action.started or not action.one_shot)
        assert (robot.path, acts) == expected, f"tick {number}: {percept}"
    assert next(draw) == left, "it drew as often"


def python_robot(text: str) -> Any:
    module = ModuleType("exported")
    ast.parse(text, feature_version=(3, 8))
    exec(compile(text, "exported.py", "exec"), module.__dict__)
    (made,) = module.__dict__["Behavior"].__subclasses__()
    return made()


CPP_RUN = """
template <class Behavior, class Features, class Table>
void run(const Table& table, int count) {
  Behavior robot;
  std::string before;
  for (int i = 0; i < count; ++i) {
    Features features;
    double now, begins;
    std::scanf("%lf %lf", &begins, &now);
    for (const auto& feature : table) std::scanf("%lf", &(features.*feature.value));
    std::string acts;
    if (begins) {
      robot.start(now);
      if (!before.empty()) acts += " stop " + before + ";";
      before.clear();
    }
    auto action = robot.tick(features, now, [] { return random_numbers[drawn++]; });
    if ((!action || action->started) && !before.empty()) acts += " stop " + before + ";";
    before.clear();
    if (action) {
      before = action->name;
      for (std::size_t a = 0; a < action->arguments.size(); ++a)
        before += (a ? ", " : "(") + action->arguments[a];
      if (!action->arguments.empty()) before += ")";
      if (action->started) acts += " start " + before + ";";
      if (action->started || !action->one_shot) acts += " pulse " + before + ";";
    }
    for (const auto& label : robot.path()) std::printf("%s/", label.c_str());
    std::printf("%s\\n", acts.c_str());
  }
  std::printf("%zu\\n", drawn);
}
"""


@pytest.mark.skipif(shutil.which("g++") is None, reason="there is no g++")
def test_cpp_decides_as_the_engine_does(tmp_path):
    headers = "algorithm cmath cstdio functional optional stdexcept string utility vector"
    lines = [f"#include <{header}>" for header in headers.split()]
    lines += ["std::size_t drawn;", "std::vector<double> random_numbers;", CPP_RUN]
    main: list[str] = []
    given: list[str] = []
    expected: list[str] = []
    for number, (name, behavior) in enumerate(BEHAVIORS):
        text = exported(library(name), behavior, "cpp")
        (tmp_path / f"{number}.hpp").write_text(text)
        space = f"n{number}::{re.search('namespace (hitab_[A-Za-z0-9_]+)', text)[1]}"
        # Two libraries have a behavior of the same name.
        lines += [f"namespace n{number} {{", f'#include "{number}.hpp"', "}"]
        engine, left = engine_of(name, behavior)
        steps = steps_of(name, behavior)
        numbers = list(islice(draws(behavior), 2 * COUNT))
        used = numbers.index(left)
        main += [f"drawn = 0; random_numbers.resize({used});"]
        main += ['for (double& number : random_numbers) std::scanf("%lf", &number);']
        main += [f"run<{space}::Behavior, {space}::Features>({space}::FEATURES, {len(steps)});"]
        given += [drawn.hex() for drawn in numbers[:used]]
        for percept, now, begins in steps:
            values = [percept[f.label] for f in hierarchy(name, behavior).features]
            given += [float(value).hex() for value in (begins, now, *values)]
        expected += [
            "/".join(path) + "/" + "".join(f" {act};" for act in acts)
            for path, acts in engine.seen
        ]
        expected.append(str(used))
    (tmp_path / "main.cpp").write_text("\n".join([*lines, "int main() {", *main, "}"]))
    flags = ["-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O0"]
    subprocess.run(["g++", *flags, "main.cpp", "-o", "main"], cwd=tmp_path, check=True)
    said = subprocess.run([tmp_path / "main"], input=" ".join(given), **TEXT).stdout.splitlines()
    assert said == expected


@pytest.mark.parametrize(("name", "behavior"), BEHAVIORS)
def test_a_tree_consists_of_its_subtrees_what_its_head_lists_and_what_is_built_in(name, behavior):
    text = exported(library(name), behavior, "bt.xml")
    root = ElementTree.fromstring(text)
    there = {tree.get("ID") for tree in root}
    assert root.get("main_tree_to_execute") in there
    assert {tree.get("ID") for tree in root.iter("SubTree")} <= there
    listed = set(re.findall(r"^  (\w+) = ", text.partition("-->")[0], re.M))
    used = {node.tag for node in root.iter()} - {"Draw"}
    assert used - listed <= set(BUILT_IN.split())
    assert not there & set(BUILT_IN.split())


def test_a_tree_names_each_state_test_and_transition_for_groot():
    root = ElementTree.fromstring(exported(library("keepaway"), "Keepaway", "bt.xml"))
    (tree,) = (tree for tree in root if tree.get("ID") == "ApproachBall")
    states = {each.get("name"): each for each in tree.iter("Sequence")}
    assert {"in Start", "in GoFast", "in Stop"} <= set(states)
    shown = [each.get("name", "") for each in states["in GoFast"].iter("Script")]
    assert "GoFast stays" in shown
    assert "GoFast -> GoMedium" in shown
    assert any("DistanceTo(ball) <=" in name for name in shown)
    assert all(shown)


@pytest.mark.parametrize(("name", "behavior"), BEHAVIORS)
def test_behavior_tree_cpp_decides_as_the_engine_does(name, behavior):
    library_of_trees = pytest.importorskip(
        "behaviortreepy", reason="BehaviorTree.CPP is missing: pip install behaviortreepy"
    )
    form, (engine, left) = hierarchy(name, behavior), engine_of(name, behavior)
    text = exported(library(name), behavior, "bt.xml")
    factory, board = library_of_trees.BehaviorTreeFactory(), library_of_trees.Blackboard.create()
    status, draw = library_of_trees.NodeStatus, draws(behavior)
    acts: list[str] = []

    def noting(*texts: str) -> Callable[[Any], Any]:
        def note(node: Any) -> Any:
            acts.extend(texts)
            return status.RUNNING

        return note

    # A person reads in the file's head what to register.
    head = text.partition("-->")[0]
    told = {term: node for node, term in re.findall(r"^  (\w+) = (\w+(?:\([^)]*\))?)", head, re.M)}
    for term, one_shot in form.basics.items():
        goes_on = noting(*[f"pulse {term}"] * (not one_shot))
        starts, stops = noting(f"start {term}", f"pulse {term}"), noting(f"stop {term}")
        factory.register_simple_stateful_action(told[str(term)], starts, goes_on, stops)

    def draws_one(node: Any) -> Any:
        board.set_double("drawn", next(draw))
        return status.SUCCESS

    factory.register_simple_action("Draw", draws_one)
    entries = {feature.label: told[feature.label] for feature in form.features}
    for entry in (*entries.values(), "now", "drawn"):
        board.set_double(entry, 0.0)
    tree = factory.create_tree_from_text(text, board)
    steps = steps_of(name, behavior)
    for number, (step, (path, expected)) in enumerate(zip(steps, engine.seen, strict=True)):
        percept, now, begins = step
        acts.clear()
        if begins:
            tree.halt_tree()
            board.set_double("hitab_begin", 1.0)
        board.set_double("now", now)
        for label, entry in entries.items():
            board.set_double(entry, percept[label])
        tree.tick_exactly_once()
        assert (states_of(form, board, len(path)), acts) == (path, expected), (
            f"{number}: {percept}"
        )
    assert next(draw) == left, "it drew as often"


def states_of(form: Hierarchy, board: Any, count: int) -> list[str]:
    """Return the active states by the blackboard, the outermost first."""
    automaton, found = form.top, []
    while len(found) < count:
        (name,) = identifiers([str(automaton.term)]).values()
        found.append(board.get_string(f"hitab_{name}_state"))
        active = next(state for state in automaton.states if state.label == found[-1])
        if not active.is_automaton:
            break
        automaton = next(inner for inner in form.automata if inner.term == active.performs)
    return found


@pytest.mark.parametrize("language", ["python", "cpp", "bt.xml"])
def test_a_file_names_the_unit_of_each_feature(language):
    text = exported(library("keepaway"), "Keepaway", language)
    line = next(line for line in text.splitlines() if "DirectionTo(ball)" in line)
    assert re.search(r"\brad\b", line)


def test_the_page_shows_what_its_code_prints(tmp_path, monkeypatch, capsys):
    page = (Path(__file__).parents[1] / "docs" / "export.md").read_text()
    (tmp_path / "Keepaway.py").write_text(exported(library("keepaway"), "Keepaway", "python"))
    monkeypatch.syspath_prepend(tmp_path)
    code, shown = re.findall(r"```(?:python)?\n(.*?)```", page, re.DOTALL)
    exec(compile(code, "export.md", "exec"), {})
    assert capsys.readouterr().out == shown
