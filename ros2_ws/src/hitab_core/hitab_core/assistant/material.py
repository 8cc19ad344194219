"""Material: the examples of a training and the situations met, from which questions are found."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from hitab_core.advice.changed import decided
from hitab_core.advice.evidence import Evidence
from hitab_core.automaton import FLAGS
from hitab_core.domain import Domain, FeatureKind
from hitab_core.example import Example
from hitab_core.training.percepts import PerceptRecord
from hitab_core.training.trainer import Trainer


class Material:
    """Data from which questions are found.

    Args:
        trainer: the trainer.
        situations: a sample of the situations met.

    Attributes:
        examples: examples of the training.
        classifier: classifier that learns from them.
        labels: labels of the states, without Start.
        goals: labels of possible answers: the chosen states, or else those in the examples.
        met: the situations: each with the state of that time, the feature values and the cycle;
            and imagined ones, of cycle 0, in which a state that nothing leaves may have to end.
    """

    def __init__(self, trainer: Trainer, situations: Iterable[PerceptRecord]) -> None:
        chosen, domain = trainer.curriculum, trainer.context.repertoire.domain
        self._features, self._history = chosen.features, trainer.history
        self.examples = trainer.examples
        self.classifier = chosen.classifier
        self.labels = tuple(trainer.states)
        self.goals = tuple(map(str, chosen.states)) or self.labels
        self.met = [(m.state, self.in_moment(m), m.cycle) for m in situations]
        # A commanded state met the situation of its command, too.
        entered = [e for e in self.examples if e.state != e.next_state]
        self.met += [(e.next_state, e.features, e.cycle) for e in entered]
        self.met += self._imagined(domain)
        units = tuple(domain.feature(term.name).unit for term in chosen.features)
        scales, names = (
            tuple(map(domain.scale_of, chosen.features)),
            tuple(map(str, chosen.features)),
        )
        self._about = scales, names, units, chosen.classifier
        self._evidence: dict[str, Evidence] = {}
        self._decisions: dict[str, list[str]] = {}

    def in_moment(self, moment: PerceptRecord) -> tuple[float, ...]:
        """Return the values of the automaton's features in a moment."""
        return self._history.in_moment(moment, self._features)

    def evidence(self, state: str) -> Evidence:
        """Return the evidence from which the transition function of a state is learned."""
        if state not in self._evidence:
            self._evidence[state] = self.learnable(state, self.examples)
        return self._evidence[state]

    def _imagined(self, domain: Domain) -> list[tuple[str, tuple[float, ...], int]]:
        """Return situations that were not met, in which a state that nothing leaves may end.

        In each, a boolean that was the same in all that was met is otherwise. Flags are left out:
        most behaviors never raise them.
        """
        ends = {e.state for e in self.examples if e.next_state != e.state}
        found = []
        for state in (label for label in self.labels if label not in {*ends, *FLAGS}):
            met = self.met_in(state)
            for f, term in enumerate(self._features):
                is_boolean = domain.scale_of(term).kind is FeatureKind.BOOLEAN
                if is_boolean and term.name not in FLAGS and len({v[f] for v in met}) == 1:
                    values = list(met[-1])
                    values[f] = 1.0 - values[f]
                    found.append((state, tuple(values), 0))
        return found

    def learnable(self, state: str, examples: Sequence[Example]) -> Evidence:
        """Return the evidence for a state that some examples give."""
        return Evidence.of(state, examples, *self._about)

    def met_in(self, state: str) -> list[tuple[float, ...]]:
        """Return the feature values of the situations met in a state."""
        return [values for there, values, _ in self.met if there == state]

    def decisions(self, state: str) -> list[str]:
        """Return the present decisions in the situations met in a state."""
        if state not in self._decisions:
            self._decisions[state] = decided(self.evidence(state), self.met_in(state))
        return self._decisions[state]

    def cycle_of(self, state: str, situation: Sequence[float]) -> int:
        """Return the world's cycle at which a situation was met last; 0 if unknown."""
        wanted = state, str(tuple(situation))  # missing values are NaN
        there = [c for s, values, c in self.met if (s, str(tuple(values))) == wanted]
        return there[-1] if there else 0
