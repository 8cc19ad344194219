"""Caution: an agent that is unsure continues, halts, or hands back to the person.

A decision is unsure if the situation is far from all examples of the state
(`hitab_core.advice.confidence`). Each level of the performed behavior is judged before the agent
decides, so that no action has to be taken back. Numbers are judged after the decision, since the
state is known only then: far from the moments shown, it does nothing (`NumberRange`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum

from hitab_core.advice.confidence import RatedFunctions
from hitab_core.example import Example
from hitab_core.running.given_numbers import NumberRange
from hitab_core.running.run_context import RunContext, Running
from hitab_core.running.running_automaton import RunningAutomaton
from hitab_core.texts.errors import TrainingError
from hitab_core.texts.remedies import Fix
from hitab_core.texts.vocabulary import unknown


class WhenUnsure(StrEnum):
    """Responses of an unsure agent."""

    GO_ON = "go_on"  # it decides as if it were sure
    HALT = "halt"  # it does nothing until it is sure
    HAND_BACK = "hand_back"  # the demonstrator is in control


@dataclass(frozen=True)
class Caution:
    """Caution of an agent: when it is unsure, and its response.

    Attributes:
        when_unsure: the response.
        distance: distance from the nearest example above which it is unsure, in spreads of the
            state's examples; 0 for no limit.
    """

    when_unsure: WhenUnsure = WhenUnsure.GO_ON
    distance: float = 0.0

    @classmethod
    def parse(cls, when_unsure: str, distance: float) -> Caution:
        """Return the caution with these values.

        Raises:
            TrainingError: if a value is invalid, naming the valid ones.
        """
        if when_unsure not in list(WhenUnsure):
            raise TrainingError(unknown("caution", when_unsure, list(WhenUnsure)))
        if not 0 <= distance < math.inf:
            raise TrainingError(f"distance must be a number of at least 0, not {distance:g}")
        if when_unsure != WhenUnsure.GO_ON and not distance:
            raise TrainingError(
                f'"{when_unsure}" needs to know when an agent is unsure: how far from any example '
                "(distance)",
                Fix.CAUTION(when_unsure=when_unsure),
            )
        return cls(WhenUnsure(when_unsure), distance)

    def __str__(self) -> str:
        """Return the caution in words.

        Examples:
            >>> str(Caution(WhenUnsure.HALT, 3))
            'when it is farther than 3 from any example: halt'
        """
        if self.when_unsure is WhenUnsure.GO_ON:
            return "when it is unsure: go_on"
        return f"when it is farther than {self.distance:g} from any example: {self.when_unsure}"


class CautionMonitor:
    """Judges whether an agent's next decision is sure, and halts its behavior meanwhile.

    Attributes:
        caution: limit of a sure decision, and the response.
        judges: whether decisions have to be judged before they are made.
        unsure: why the next decision is unsure, for people; empty if it is sure, or if the agent
            goes on regardless.
        number_range: range shared with the agent's context.
    """

    def __init__(self) -> None:
        self.caution = Caution()
        self.judges = False
        self.number_range = NumberRange()
        self.unsure = ""
        self._halted: Running | None = None
        self._rated = RatedFunctions()

    def set(self, caution: Caution) -> None:
        """Replace the caution."""
        if caution.when_unsure is not WhenUnsure.HALT:
            self._release()
        self.caution, self.unsure = caution, ""
        self.judges = caution.when_unsure is not WhenUnsure.GO_ON

    def watch(
        self,
        tick: Callable[[], None],
        running: Running | None,
        context: RunContext,
        trained: Sequence[Example] = (),
    ) -> bool:
        """Tick if the next decisions are sure on all levels.

        Args:
            tick: makes the decisions.
            running: the performed behavior.
            context: context of the agent.
            trained: examples of the outermost automaton, if that is in training.

        Returns:
            Whether the agent was sure; otherwise `unsure` is the reason.
        """
        self.unsure = self.doubts(running, context, trained, self.caution.distance)
        if not self.unsure:
            self._release()
            self.number_range.max_distance = self.caution.distance or math.inf
            self.number_range.reason = ""
            try:
                tick()
            finally:
                self.number_range.max_distance = math.inf
            self.unsure = self.number_range.reason
        elif self.caution.when_unsure is WhenUnsure.HALT:
            self._halt(running)
        return not self.unsure

    def doubts(
        self,
        running: Running | None,
        context: RunContext,
        examples: Sequence[Example],
        distance: float,
    ) -> str:
        """Return why a decision is unsure; empty if all are sure.

        Args:
            running, context: see `watch`.
            examples: those of the outermost automaton, if that is in training.
            distance: largest distance from the nearest example of a sure decision.
        """
        while isinstance(running, RunningAutomaton):
            own = examples or running.automaton.examples
            if own and (doubt := self._doubt(running, own, context, distance)):
                return f"{running.label} in {running.active}: {doubt}"
            running, examples = running.child, ()
        return ""

    def _doubt(
        self,
        running: RunningAutomaton,
        examples: Sequence[Example],
        context: RunContext,
        distance: float,
    ) -> str:
        function = running.function
        if function is None:
            return ""
        features = running.automaton.features
        domain = context.repertoire.domain
        rated = self._rated.of(function, running.active, features, examples, domain)
        return rated.doubts(list(map(running.look, features)), distance)

    def _halt(self, running: Running | None) -> None:
        """Stop the basic behavior that is performed, until it is released."""
        if self._halted is None:
            while isinstance(running, RunningAutomaton):
                running = running.child
            if running is not None:
                running.stop()
                self._halted = running

    def _release(self) -> None:
        """Restart the halted behavior."""
        halted, self._halted = self._halted, None
        if halted is not None:
            halted.start()

    def forget(self) -> None:
        """Forget the halted behavior, since another one is performed."""
        self._halted = None
