"""Remarks: signs that the learned automaton does not work, each with a remedy.

Two commands that lead back to each other in one situation contradict each other in no state, so no
question is about them; yet the automaton goes round forever there. A *loop* is found in each
situation of an example, with the features held constant, if from the state of that time the
automaton can only change: no reachable state stays, ends in a flag or is executed only
once per entry. States are seen as they are entered, so a flag or a timer that is waited for makes
no loop. Situations that were merely perceived are left out: where two boundaries overlap, changing
to and fro may well be how the robot advances.

Remarks on tests are in `hitab_core.assistant.trial_statistics`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum, unique

from hitab_core.advice.evidence import Evidence
from hitab_core.advice.situation_text import situation_in_words
from hitab_core.automaton import Automaton, as_entered
from hitab_core.default_example import superseding
from hitab_core.example import Example
from hitab_core.learning.transition_learning import relearned
from hitab_core.repertoire import Repertoire
from hitab_core.texts.remedies import Fix, Remedy


@unique
class RemarkKind(Enum):
    """Kinds of remarks, in plain words; arguments are the names in braces."""

    LOOP = "with {situation}, it changes between {states} forever"
    NOT_ENTERED = "{state} was commanded, but was not entered in {episodes} episodes of the test"
    NOT_LEFT = (
        "commands leave {state}, but it was not left in any of the {episodes} episodes of the "
        "test that entered it"
    )
    NOT_RAISED = (
        "the flag {state} was commanded, but was not raised in {episodes} episodes of the test"
    )


@dataclass(frozen=True)
class Remark:
    """One sign, with arguments by name, and a remedy."""

    code: RemarkKind
    arguments: tuple[tuple[str, str], ...]
    remedy: Remedy

    def of(self, agent: str) -> Remark:
        """Return the remark with an agent's name in its remedy."""
        return replace(self, remedy=self.remedy.of(agent))

    def __str__(self) -> str:
        """Return the remark in plain words, without the remedy."""
        return self.code.value.format_map(dict(self.arguments))


def loops(automaton: Automaton, repertoire: Repertoire, classifier: str) -> list[Remark]:
    """Return a remark on each loop of the learned automaton.

    Args:
        automaton: the automaton with its examples and transition functions.
        repertoire: used in learning.
        classifier: classifier that learned it.

    Raises:
        TrainingError: see `relearned`.
    """
    looping = _Looping(automaton, repertoire, classifier)
    found: dict[tuple[str, ...], Remark] = {}
    for state, values in dict.fromkeys(map(looping.place, automaton.examples)):
        states = looping.trap(automaton, state, values)
        if states and states not in found:
            arguments = (("situation", looping.words(values)), ("states", _listed(states)))
            found[states] = Remark(
                RemarkKind.LOOP, arguments, looping.remedy(state, values, states)
            )
    return list(found.values())


def _listed(states: Sequence[str]) -> str:
    """Return ``A, B and C``."""
    return f"{', '.join(states[:-1])} and {states[-1]}"


@dataclass(frozen=True)
class _Looping:
    automaton: Automaton
    repertoire: Repertoire
    classifier: str

    def place(self, example: Example) -> tuple[str, tuple[float, ...]]:
        """Return the state of an example, and its values as entered states see them."""
        return example.state, as_entered(self.automaton.features, example.features)

    def trap(self, automaton: Automaton, state: str, values: tuple[float, ...]) -> tuple[str, ...]:
        """Return the states between which it changes forever; none if it need not."""
        if any(map(math.isnan, values)):
            return ()
        ends = {str(term) for term in automaton.states if self.repertoire.is_one_shot(term)}
        names = automaton.feature_labels
        follow: dict[str, Mapping[str, float]] = {}
        waiting = [state]
        while waiting:
            label = waiting.pop()
            function = automaton.transitions.get(label)
            if label in ends or function is None:
                return ()
            follow[label] = function.explain(values, names).distribution
            if label in follow[label]:
                return ()
            waiting += [after for after in follow[label] if after not in follow]
        states = set(follow)
        while (after := {label for one in states for label in follow[one]}) != states:
            states = after  # without states that only lead into the loop
        return tuple(label for label in automaton.labels if label in states)

    def words(self, values: Sequence[float]) -> str:
        """Return a situation in words."""
        terms, domain = self.automaton.features, self.repertoire.domain
        scales, units = map(domain.scale_of, terms), [domain.feature(u.name).unit for u in terms]
        evidence = Evidence.of("", (), tuple(scales), list(map(str, terms)), units)
        return situation_in_words(evidence, values, range(len(values))) or "no feature chosen"

    def remedy(self, state: str, values: tuple[float, ...], states: Sequence[str]) -> Remedy:
        """Return the remedy: the state commanded last stays, if one example leaves it there."""
        there = [
            e for e in self.automaton.examples if self.place(e) in {(s, values) for s in states}
        ]
        commands = [e for e in there if e.leaves]
        came = {e.next_state: e.number for e in commands}
        for label in sorted(came, key=lambda one: -came[one]):
            leaving = [e for e in commands if e.state == label]
            if len(leaving) == 1:
                stays = replace(leaving[0], next_state=label)
                examples = [stays if e is leaving[0] else e for e in self.automaton.examples]
                changed = replace(self.automaton, examples=tuple(superseding(examples)))
                changed = relearned(changed, self.repertoire.domain, self.classifier)
                if not self.trap(changed, state, values):
                    before = leaving[0].next_state
                    return Fix.RELABEL(number=stays.number, behavior=label, before=before)
        return Fix.CHOOSE_FEATURES()
