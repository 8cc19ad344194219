"""What an agent does when it is unsure: goes on, halts, or hands back to the person.

A decision is unsure if it rests on few examples, or if the situation is far from all examples of
the state (`hitab_core.advice.confidence`). That is judged before the agent decides, for each level
of what it performs, so that nothing is done that has to be taken back.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum

from hitab_core.advice.confidence import Confidences
from hitab_core.advice.evidence import Evidence
from hitab_core.automaton import OWN_FEATURES
from hitab_core.errors import TrainingError
from hitab_core.example import Example
from hitab_core.repertoire import Repertoire
from hitab_core.running.running_automaton import Running, RunningAutomaton
from hitab_core.running.senses import value_or_nan
from hitab_core.transition_function import TransitionFunction
from hitab_core.use import Use
from hitab_core.vocabulary import unknown


class WhenUnsure(StrEnum):
    """What an unsure agent does."""

    GO_ON = "go_on"  # it decides all the same
    HALT = "halt"  # it does nothing until it is sure
    HAND_BACK = "hand_back"  # the demonstrator is in control


@dataclass(frozen=True)
class Caution:
    """When an agent is unsure, and what it does then.

    Attributes:
        when_unsure: what it does.
        support: it is unsure with fewer examples in the leaf that decides.
        distance: it is unsure farther than this from any example, in spreads of the state's
            examples; 0: any distance will do.
    """

    when_unsure: WhenUnsure = WhenUnsure.GO_ON
    support: float = 0.0
    distance: float = 0.0

    @classmethod
    def parse(cls, when_unsure: str, support: float, distance: float) -> Caution:
        """Return what was asked for.

        Raises:
            TrainingError: if that is no caution, saying what is.
        """
        if when_unsure not in list(WhenUnsure):
            raise TrainingError(unknown("caution", when_unsure, list(WhenUnsure)))
        if not (0 <= support < float("inf") and 0 <= distance < float("inf")):
            raise TrainingError(
                f"an agent cannot be unsure below {support:g} examples or beyond a distance of "
                f"{distance:g}; give numbers of at least 0"
            )
        asks = when_unsure != WhenUnsure.GO_ON
        if asks and not (support or distance):
            raise TrainingError(
                f'"{when_unsure}" needs a number of examples or a distance below or beyond which '
                "the agent is unsure"
            )
        return cls(WhenUnsure(when_unsure), support, distance)


class Doubts:
    """Judges how sure an agent's next decisions are."""

    def __init__(self) -> None:
        self._rated: dict[tuple[int, str], tuple[TransitionFunction, Confidences]] = {}

    def of(
        self,
        running: Running | None,
        caution: Caution,
        repertoire: Repertoire,
        look: Callable[[Use], float],
        trained: Sequence[Example] = (),
    ) -> str:
        """Return why the next decision is unsure, for people; empty if all levels are sure.

        Args:
            running: what is performed.
            caution: when a decision is unsure.
            repertoire: of the agent.
            look: returns the value of a feature that is bound to targets.
            trained: examples of the outermost automaton, if that is in training.
        """
        examples = trained
        while isinstance(running, RunningAutomaton):
            function = running.function
            own = examples or running.automaton.examples
            if function is not None and own:
                doubt = self._doubt(running, function, own, caution, repertoire, look)
                if doubt:
                    return f"{running.label} in {running.active}: {doubt}"
            running, examples = running.child, ()
        return ""

    def _doubt(
        self,
        running: RunningAutomaton,
        function: TransitionFunction,
        examples: Sequence[Example],
        caution: Caution,
        repertoire: Repertoire,
        look: Callable[[Use], float],
    ) -> str:
        features, state = running.automaton.features, running.active
        key = (id(function), state)
        rated = self._rated.get(key)
        if rated is None or rated[0] is not function:
            evidence = Evidence.of(
                state,
                examples,
                [repertoire.scale_of(use) for use in features],
                [str(use) for use in features],
            )
            rated = self._rated[key] = (function, Confidences(function, evidence))
        values = [
            running.own_feature(use)
            if use in OWN_FEATURES
            else value_or_nan(look, use.bound(running.bindings))
            for use in features
        ]
        return rated[1](values).doubts(caution.support, caution.distance)

    def forget(self) -> None:
        """Forget what was rated, since behaviors have changed."""
        self._rated.clear()
