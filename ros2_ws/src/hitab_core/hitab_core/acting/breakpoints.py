"""Breakpoints: states, changes of state and doubts at which an agent holds its world."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from hitab_core.acting.draws import Draws
from hitab_core.automaton import FLAGS, START
from hitab_core.repertoire import Repertoire
from hitab_core.running.run_context import Running
from hitab_core.running.running_automaton import RunningAutomaton
from hitab_core.texts.errors import VocabularyError
from hitab_core.texts.vocabulary import unknown

UNSURE = "unsure"
"""The breakpoint at a decision that is far from all examples."""

ARROW = " -> "


@dataclass(frozen=True)
class Breakpoint:
    """One breakpoint; a state without targets stands for it with any.

    Attributes:
        destination: label of the state that is entered; or ``unsure``.
        source: label of the state that is left; empty for any.
    """

    destination: str
    source: str = ""

    @classmethod
    def parse(cls, text: str, repertoire: Repertoire) -> Breakpoint:
        """Return the breakpoint that a text means, such as ``ControlBall -> Pass``.

        Raises:
            VocabularyError: if it names no behavior, naming those there.
        """
        source, arrow, to = (part.strip() for part in text.replace("→", "->").partition("->"))
        if not arrow:
            source, to = "", source
        known = [*repertoire.names(), START, *FLAGS]
        for label in () if to == UNSURE and not source else (to, source or to):
            if label.partition("(")[0] not in known:
                raise VocabularyError(unknown("state", label, [*known, UNSURE]))
        return cls(to, source)

    def __str__(self) -> str:
        """Return the text that it was made from."""
        return f"{self.source}{ARROW}{self.destination}" if self.source else self.destination

    def is_met(self, source: str, destination: str) -> bool:
        """Whether a change of state meets it."""
        return _means(self.destination, destination) and (
            not self.source or _means(self.source, source)
        )


def _means(text: str, label: str) -> bool:
    return text == label or text == label.partition("(")[0]


class Breakpoints:
    """The breakpoints of an agent, each met once until the situation has passed.

    Attributes:
        set: the breakpoints.
        held: what was met last, as in ``ControlBall -> Pass``; empty if the agent has gone on.
    """

    def __init__(self, *, keeps: bool) -> None:
        """Set none.

        Args:
            keeps: whether what was met stays in `held`: no world waits for this agent.
        """
        self.set: tuple[Breakpoint, ...] = ()
        self.held = ""
        self._met = ""
        self._keeps = keeps

    def forget(self) -> None:
        """Meet everything anew, as after going back."""
        self.held = self._met = ""

    def look(
        self, running: Running | None, draws: Draws, doubt: Callable[[], str], *, decides: bool
    ) -> bool:
        """Return whether the next tick would meet a breakpoint that has not just been met.

        It changes nothing: the tick draws the same numbers and decides the same.

        Args:
            running: the performed behavior.
            draws: the agent's random numbers.
            doubt: function that tells why the next decision is unsure; empty if it is sure.
            decides: whether the agent decides, not a demonstrator.
        """
        met = ""
        if not self._keeps:
            self.held = ""  # also if the next decision fails
        if decides:
            changes = upcoming(running, draws.ahead())
            for source, to in changes:
                if any(one.is_met(source, to) for one in self.set):
                    met = f"{source}{ARROW}{to}"
                    break
        if not met and any(str(one) == UNSURE for one in self.set):
            met = f"{UNSURE}: {why}" if (why := doubt()) else ""
        # The number in a doubt changes from cycle to cycle.
        kind = UNSURE if met.startswith(UNSURE) else met
        is_new, self._met = bool(kind) and kind != self._met, kind
        if is_new:
            self.held = met
        return is_new


def upcoming(running: Running | None, draw: Callable[[], float]) -> Iterator[Sequence[str]]:
    """Yield each change of state of the next tick, outermost first; change nothing.

    Args:
        running: the performed behavior.
        draw: function that gives the random numbers, without drawing them.
    """
    entered = False
    while isinstance(running, RunningAutomaton):
        source, to, child = running.upcoming(draw, entered=entered)
        if source != to:
            yield source, to
        entered, running = entered or source != to, child
