"""An assistant that counts the decisions of a tested automaton by episodes, and remarks on them.

Episodes begin where the world says so; robots outside of a world have no episodes, and get none
of these remarks. Only whole episodes without a takeover count, of a test of the same
examples.
"""

from __future__ import annotations

from collections import Counter

from hitab_core.advice.remarks import Remark, RemarkKind
from hitab_core.automaton import FLAGS, START
from hitab_core.example import Example
from hitab_core.texts.remedies import Fix
from hitab_core.training.trainer import Trainer

EPISODES_MIN = 50
"""Minimum number of episodes before a missing event is remarked on.

The rarest states of the shipped lessons are entered in one episode of ten to fifteen; an event
of one in fifteen is missing in all of fifty with a probability of 0.03.
"""


class TrialStatistics:
    """Statistics of the tested automaton, by episodes.

    Args:
        trainer: the trainer.
    """

    def __init__(self, trainer: Trainer) -> None:
        self._trainer = trainer
        self._forget(())

    def subscribe(self) -> None:
        """Start to count decisions."""
        events = self._trainer.events
        events.episode.subscribe(self._begin)
        events.interrupted.subscribe(self._interrupt)
        events.decided.subscribe(self._see)

    def _forget(self, examples: tuple[Example, ...]) -> None:
        self._about = examples
        self._episodes = 0
        self._entered: Counter[str] = Counter()
        self._ever: set[str] = set()
        self._left: set[str] = set()
        self._found: list[Remark] = []
        self._whole = False
        self._seen: set[str] = set()
        self._active = START

    def _begin(self) -> None:
        """Begin an episode, after the last one; if in a test, the automaton decides all of it."""
        if self._whole and self._seen:
            self._episodes += 1
            self._entered.update(self._seen)
            self._found = self._remarks()
        self._whole, self._seen, self._active = self._trainer.testing, set(), START

    def _interrupt(self, active: str) -> None:
        """Do not count this episode: a demonstrator intervened while a state was active."""
        self._whole, self._active = False, active

    def _see(self, active: str) -> None:
        """Count the state that is active after a tick of the tested automaton."""
        examples = self._trainer.examples
        if examples is not self._about:
            whole = self._whole and not self._seen
            self._forget(examples)
            self._whole = whole
        if active != self._active:
            self._left.add(self._active)
            self._active = active
        self._seen.add(active)
        self._ever.add(active)

    def remarks(self) -> list[Remark]:
        """Return the remarks on the automaton learned from the present examples."""
        return self._found if self._trainer.examples is self._about else []

    def _remarks(self) -> list[Remark]:
        if self._episodes < EPISODES_MIN:
            return []
        found = []
        commands = [e for e in self._about if not e.is_default]
        # A path to states that were never entered is reported with these states.
        follows = {
            e.state: e.next_state for e in commands if e.leaves and e.next_state in self._ever
        }
        for state in dict.fromkeys(e.next_state for e in commands):
            if state not in self._ever:
                sign = RemarkKind.NOT_RAISED if state in FLAGS else RemarkKind.NOT_ENTERED
                found.append(_remark(sign, state, self._episodes, state))
            elif (
                state in follows
                and state not in self._left
                and self._entered[state] >= EPISODES_MIN
            ):
                sign, episodes = RemarkKind.NOT_LEFT, self._entered[state]
                found.append(_remark(sign, state, episodes, follows[state]))
        return found


def _remark(sign: RemarkKind, state: str, episodes: int, behavior: str) -> Remark:
    arguments = (("state", state), ("episodes", str(episodes)))
    return Remark(sign, arguments, Fix.CORRECT(behavior=behavior))
