"""An assistant that tells what an agent would do next by what it has learned so far.

It learns when somebody looks and the examples have changed, never in a tick.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass

from hitab_core.advice.confidence import FAR, RatedFunctions
from hitab_core.automaton import Automaton
from hitab_core.example import Example
from hitab_core.texts.errors import HitabError
from hitab_core.training.percepts import PerceptRecord, state_of
from hitab_core.training.trainer import Trainer


@dataclass(frozen=True)
class Preview:
    """What an agent would do in a situation.

    Attributes:
        state: label of the next state that it would choose; empty if it has learned nothing.
        probability: probability with which it would choose it.
        unsure: why it is not sure of it; empty if it is sure.
    """

    state: str = ""
    probability: float = 0.0
    unsure: str = ""


NOTHING = Preview()
"""The preview of an agent that has learned nothing for its state."""


class Previews:
    """Tells what the automaton that is being learned would do.

    Args:
        trainer: the trainer.
    """

    def __init__(self, trainer: Trainer) -> None:
        self._trainer = trainer
        self._looks = False
        self._about: tuple[Sequence[Example], Sequence[object]] = (), ()
        self._learned: Automaton | None = None
        self._rated = RatedFunctions()

    def subscribe(self) -> None:
        """Enable previews."""
        self._looks = True

    def learn(self) -> None:
        """Learn from the present examples, unless that was done; nothing if it is impossible."""
        trainer = self._trainer
        about = trainer.examples, trainer.curriculum.features
        if not self._looks or all(a is b for a, b in zip(about, self._about, strict=True)):
            return
        self._about, self._learned = about, None
        with suppress(HitabError):  # testing reports why nothing can be learned
            self._learned = trainer.automaton()

    def now(self) -> Preview:
        """Return what it would do now by what was learned last; read, and change, nothing."""
        running = self._trainer.running
        features = self._trainer.curriculum.features
        return self._of(state_of(running.active), lambda: list(map(running.look, features)))

    def at(self, percept: PerceptRecord) -> Preview:
        """Return what it would do in a percept, in the state that was active then."""
        trainer = self._trainer
        self.learn()
        return self._of(
            percept.state,
            lambda: list(trainer.history.in_moment(percept, trainer.curriculum.features)),
        )

    def _of(self, state: str, read: Callable[[], list[float]]) -> Preview:
        learned, trainer = self._learned, self._trainer
        function = None if learned is None else learned.transitions.get(state)
        if learned is None or function is None:
            return NOTHING
        values = read()
        odds = function.explain(values, learned.feature_labels).distribution
        if not odds:
            return NOTHING
        chosen = max(odds, key=odds.__getitem__)
        domain = trainer.context.repertoire.domain
        rated = self._rated.of(function, state, learned.features, learned.examples, domain)
        return Preview(chosen, odds[chosen], rated.doubts(list(values), FAR))
