"""Measures what each number of the engine is worth: what changes if it is half, and double.

A number of the learner is tried on the shipped examples: how many of their trees change. One of
what is asked is tried on them, too: how many questions change. It and one of when late commands
were due are tried on simulated people (`teachers.py`), who
train their teams again: how many of their trees change, and how much of what they decide is then
otherwise than intended. The people's habits stay what they are.

    scripts/python research/constants.py --people 3 --resume constants.jsonl
    scripts/python research/constants.py --only FAR --people 20

A share above one half is moved towards 1 and away from it: what is left to 1 is halved and
doubled. Of several numbers the logarithms are.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from math import log, sqrt
from pathlib import Path
from statistics import fmean, stdev
from typing import Annotated, Any

import numpy as np
import typer
import yaml
from agreement import decisions, objections
from finished_runs import FinishedRuns, Resume
from habits import Habits
from novices import NOVICE
from pupils import InProcessPupil
from teachers import Setting, intention_of, person_of, pupil_of

import foraging_world
import keepaway_world
from hitab_core.advice.evidence import Evidence
from hitab_core.advice.unshown import unshown
from hitab_core.domain import load_domain
from hitab_core.example import Example
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.library.behavior_reader import read_behavior

NOVICES = Setting(NOVICE, novices=True)
ENGINEERS = Setting(Habits(wrong=0.1))
DELAY = 0.6
"""Median delay of a novice, s."""


@dataclass(frozen=True)
class Constant:
    """A number of the engine.

    Attributes:
        place: module and name.
        people: who shows what it does; None: the shipped examples.
    """

    place: str
    people: Setting | None = None

    @property
    def name(self) -> str:
        """Its name."""
        return self.place.rpartition(".")[2]

    @property
    def value(self) -> Any:
        """What it is."""
        module, _, name = self.place.rpartition(".")
        return getattr(import_module(f"hitab_core.{module}"), name)


def _of(people: Setting | None, module: str, names: str) -> list[Constant]:
    return [Constant(f"{module}.{name}", people) for name in names.split()]


HISTORY = "KEPT_SECONDS WINDOW_SECONDS WINDOW_MAX STEP_SECONDS"
CONSTANTS = [
    *_of(None, "learning.gain_ratio", "TIE"),
    *_of(None, "learning.tree_growth", "LEAST_FRACTION AHEAD_MAX"),
    *_of(NOVICES, "assistant.lateness", "SOONEST LATEST SPREADS STAYING OTHERWISE"),
    *_of(NOVICES, "assistant.causes", "P_IMMEDIATE EVENTS NEAR THRESHOLDS_MAX"),
    *_of(NOVICES, "assistant.situation_sample", "SITUATIONS_MAX"),
    *_of(NOVICES, "advice.unshown", "ASSUMED TOUCHING NO_EXAMPLE_DISTANCE GAIN_MIN"),
    *_of(ENGINEERS, "assistant.questions", "CORRECTED"),
    *_of(NOVICES, "training.percept_history", HISTORY),
]


def varied(value: Any, factor: float) -> Any:
    """Return a constant, times a factor; see above."""
    if isinstance(value, tuple):
        return tuple(one**factor for one in value)
    if isinstance(value, int):
        return max(1, round(value * factor))
    if isinstance(value, float) and 0.5 < value < 1.0:
        return 1.0 - (1.0 - value) * factor
    return value * factor


@contextmanager
def patched(constant: Constant, value: Any) -> Iterator[None]:
    """Give a constant another value wherever it was imported."""
    usual = constant.value
    places = [
        module
        for name, module in sys.modules.items()
        if name.startswith("hitab_core.") and vars(module).get(constant.name) is usual
    ]
    for module in places:
        setattr(module, constant.name, value)
    try:
        yield
    finally:
        for module in places:
            setattr(module, constant.name, usual)


def shipped() -> dict[str, str]:
    """Return what shipped examples teach, by file and state: the digests of trees."""
    found = {}
    for name, evidences, _ in _shipped():
        for evidence in evidences:
            tree = evidence.learn()
            if tree is not None:
                found[f"{name} {evidence.state}"] = tree.digest()
    return found


def questions() -> dict[str, str]:
    """Return what is asked about shipped examples, of keepers and foragers.

    What was met is what the examples saw in any state.
    """
    found = {}
    for name, evidences, examples in _shipped():
        if name.partition("/")[0] not in ("keepaway", "foraging"):
            continue
        met = [(e.state, e.features) for e in examples]
        for evidence in evidences:
            own = [e for e in examples if e.state == evidence.state and e.is_learned]
            assumed = np.array([e.is_default for e in own])
            asked = unshown(evidence, [values for _, values in met], [], assumed)
            if asked is not None:
                found[f"{name} {asked.state} is unshown"] = str(asked.situation)
    return found


def _shipped() -> Iterator[tuple[str, list[Evidence], tuple[Example, ...]]]:
    """Yield the shipped automata: a name, the evidence for each state, and all examples."""
    for world in (keepaway_world, foraging_world):
        assert world.__file__ is not None
        for path in sorted(Path(world.__file__).parents[1].glob("libraries/*/*.hfa.yaml")):
            text = path.read_text(encoding="utf-8")
            if (path.parent / "commander.yaml").exists():
                continue  # its domain is made from its description
            domain = load_domain(yaml.safe_load(text)["domain"]["name"])
            automaton = read_behavior(text, path.name, domain).automaton
            scales = [domain.scale_of(term) for term in automaton.features]
            names = [str(term) for term in automaton.features]
            yield (
                f"{path.parent.name}/{path.name}",
                [
                    Evidence.of(state, automaton.examples, scales, names)
                    for state in automaton.transitions
                ],
                automaton.examples,
            )


def trained(number: int, setting: Setting) -> dict[str, Any]:
    """Have a person train a team; return what was learned and how much of it is otherwise."""
    intention = intention_of(number)
    person, pupil = person_of(number, setting), pupil_of(number, setting)
    assert isinstance(pupil, InProcessPupil)
    try:
        diary = person.train(pupil)
        automata = pupil.repertoire.automata
    finally:
        pupil.close()
    records = decisions(intention.name, setting.seed)
    trees, otherwise = {}, []
    for plan in intention.plans:
        automaton = automata.get(plan.name)
        if automaton is None:
            otherwise.append(1.0)
            continue
        otherwise += objections(plan, automaton, records[plan.name]).values()
        for state, function in automaton.transitions.items():
            if isinstance(function, TransitionTree):
                trees[f"{plan.name} {state}"] = function.digest()
    return {
        "trees": trees,
        "otherwise": fmean(otherwise),
        "answers": diary.counts["answers"],
        "delay": pupil.lateness if setting.novices else DELAY,
    }


def changed(before: Mapping[str, str], after: Mapping[str, str]) -> int:
    """Return how many trees are not what they were."""
    return sum(before.get(name) != after.get(name) for name in {*before, *after})


def row(usual: list[dict[str, Any]], found: list[dict[str, Any]]) -> list[str]:
    """Return what changes for some people."""
    pairs = list(zip(usual, found, strict=True))
    trees = sum(changed(a["trees"], b["trees"]) for a, b in pairs)
    more = [b["otherwise"] - a["otherwise"] for a, b in pairs]
    spread = stdev(more) / sqrt(len(more)) if len(more) > 1 else 0.0
    answers = sum(b["answers"] - a["answers"] for a, b in pairs)
    off = [fmean(abs(log(one["delay"] / DELAY)) for one in people) for people in (usual, found)]
    of = sum(len(a["trees"]) for a, _ in pairs)
    return [
        f"{trees} of {of}",
        f"{fmean(more):+.3f} ± {spread:.3f}" if trees else "0",
        f"{answers:+d}",
        f"{off[1] - off[0]:+.2f}",
    ]


def main(
    people: Annotated[int, typer.Option(help="How many of each kind.", min=1)] = 3,
    only: Annotated[list[str] | None, typer.Option(help="Constant; repeat for several.")] = None,
    seed: Annotated[int, typer.Option(help="Of the people.")] = 6161,
    resume: Resume = "",
) -> None:
    """Halve and double the engine's numbers."""
    runs = FinishedRuns(resume, {"seed": seed})

    def of(number: int, people: Setting, title: str) -> dict[str, Any]:
        kind = "novice" if people.novices else "engineer"
        name = f"{title}, {kind} {number}"
        if name not in runs.figures:
            print(name, file=sys.stderr, flush=True)
            setting = Setting(people.habits, seed=seed, novices=people.novices)
            runs.add(name, trained(number, setting))
        found: dict[str, Any] = runs.figures[name]
        return found

    print("| number | value | tried | questions | trees | otherwise | answers | delay |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
    learned, asked = shipped(), questions()
    for constant in CONSTANTS:
        if only and constant.name not in only:
            continue
        for factor in (0.5, 2.0):
            value = varied(constant.value, factor)
            title = f"{constant.place} x {factor:g}"
            others = ""
            if constant.place.startswith("advice."):
                with patched(constant, value):
                    others = f"{changed(asked, questions())} of {len(asked)}"
            if constant.people is None:
                with patched(constant, value):
                    cells = [f"{changed(learned, shipped())} of {len(learned)}", "", "", ""]
            else:
                usual = [of(n, constant.people, "as it is") for n in range(people)]
                with patched(constant, value):
                    cells = row(usual, [of(n, constant.people, title) for n in range(people)])
            texts = [f"`{constant.place}`", _shown(constant.value), _shown(value), others, *cells]
            print("| " + " | ".join(texts) + " |", flush=True)


def _shown(value: Any) -> str:
    if isinstance(value, tuple | np.ndarray):
        return ", ".join(f"{one:.3g}" for one in value)
    return f"{value:.3g}"


if __name__ == "__main__":
    typer.run(main)
