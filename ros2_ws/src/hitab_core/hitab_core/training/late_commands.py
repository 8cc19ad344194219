"""The late commands of a training: when they were due is estimated again with each new one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from hitab_core.domain import Scale
from hitab_core.example import Example
from hitab_core.training.example_log import ExampleLog
from hitab_core.training.lateness import Lateness, settled
from hitab_core.training.percept_history import PerceptHistory
from hitab_core.training.recent_percepts import KEPT_SECONDS, PerceptRecord
from hitab_core.training.retiming import moved
from hitab_core.use import Use


class LateCommands:
    """Estimates the delay of commands whose reaction time is unknown.

    What a person has retimed stays as it is.

    Attributes:
        people: how late the commands of each demonstrator come.
    """

    def __init__(self, people: dict[str, Lateness]) -> None:
        """Begin a training; ``people`` is kept up to date."""
        self.people = people
        self._before = dict(people)
        self._who: dict[int, str] = {}
        self._estimated: dict[int, set[float]] = {}

    def usual(self, who: str, pace: float) -> float:
        """Return how late a person's commands usually are, s of simulated time.

        Args:
            who: the person.
            pace: simulated seconds in a second of the person.
        """
        return min(self.people.get(who, Lateness()).median * pace, KEPT_SECONDS)

    def keep(self, record: Mapping[str, Any]) -> None:
        """Keep what the journal's record of a command says about it, and about earlier ones."""
        if "who" in record:
            self._who[int(record["examples"][0]["command"])] = record["who"]
            for example in (record["examples"][0], *record["settled"]):
                self._estimated.setdefault(example["command"], set()).add(example["ago"])

    def settle(
        self,
        kept: PerceptHistory,
        log: ExampleLog,
        features: Sequence[Use],
        scales: Sequence[Scale],
        *,
        label: str,
        around: Mapping[str, Any],
        who: str,
        due: PerceptRecord,
    ) -> tuple[PerceptRecord, list[Example]]:
        """Estimate when late commands of a person were due, from all of them together.

        Args:
            kept: what was perceived around each command.
            log: of the examples.
            features: of the automaton in training.
            scales: of the features.
            label: of the state that the newest command goes to.
            around: what is kept of it.
            who: commands.
            due: the moment for which it is taken so far.

        Returns:
            The moment for which the newest was meant, and the earlier examples as they are now.
        """
        lateness, newest = self.people.get(who, Lateness()), log.next_command
        kept.keep_around(newest, around)
        found = {newest: kept.late(newest, label, features, lateness)}
        for e in log.examples:
            mine = self._who.get(e.command) == who and e.ago in self._estimated[e.command]
            if mine and not e.is_default:
                at = (e.state, e.cycle)
                found[e.command] = kept.late(e.command, e.next_state, features, lateness, at)
        late = {command: one for command, one in found.items() if one is not None}
        before = self._before.get(who, Lateness())
        places, self.people[who] = settled([one for one, _ in late.values()], scales, before)
        dues: dict[int, tuple[float, PerceptRecord]] = {}
        for (command, (_, among)), place in zip(late.items(), places, strict=True):
            window = kept.window(command)
            if window is not None and kept.shows(among[place], features):
                dues[command] = (window[0], among[place])
        if newest in dues:
            _, due = dues.pop(newest)
        return due, moved(log, kept, dues, features)
