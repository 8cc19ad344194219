"""An assistant that estimates when late commands were due, again with each new one.

Commands that a person has retimed keep their times, and tell how late the person is. A command for
a percept that is stated, or that the world still shows, is exact, and tells nothing of delays.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from hitab_core.assistant.causes import settled
from hitab_core.assistant.doubts import Doubt, doubtful
from hitab_core.assistant.lateness import LateCommand, Lateness
from hitab_core.codec import to_dict
from hitab_core.texts.errors import HitabError
from hitab_core.training.events import CommandGiven, Proposal
from hitab_core.training.percept_history import KEPT_SECONDS
from hitab_core.training.percepts import PerceptRecord
from hitab_core.training.retiming import moved
from hitab_core.training.trainer import Trainer

AT_ONCE = 0.3
"""Who takes over so long before commanding, s, has begun to guide, and waits for nothing."""


class Press(NamedTuple):
    """What a person had before their eyes who gave a command.

    Attributes:
        pace: simulated seconds in a second of the person.
        time: of the percept seen, s.
        took: time at which the person took over to give the command, s; None if the automaton had
            not decided.
    """

    pace: float
    time: float
    took: float | None


class LateCommands:
    """Estimates the delay of commands whose reaction time is unknown.

    Args:
        trainer: the trainer.
        people: see below.

    Attributes:
        people: delay of the commands of each demonstrator; kept up to date.
        doubts: by command, those that may be meant for another moment.
    """

    def __init__(self, trainer: Trainer, people: dict[str, Lateness]) -> None:
        self.people = people
        self._trainer = trainer
        self._before = dict(people)
        self._who: dict[int, str] = {}
        self._shown: dict[int, Press] = {}
        self._estimated: dict[int, set[float]] = {}
        self._interrupted = 0.0
        self.doubts: dict[int, Doubt] = {}

    def subscribe(self) -> None:
        """Propose moments for commands from now on."""
        self._trainer.events.commanded.subscribe(self._propose)
        self._trainer.events.changed.subscribe(self._keep)
        self._trainer.events.interrupted.subscribe(self._note)

    def _note(self, state: str) -> None:
        """Note when somebody intervened."""
        self._interrupted = self._trainer.history.time

    def _keep(self, record: Mapping[str, Any]) -> None:
        """Keep the data of a command, and of earlier ones, from its record in the journal."""
        if record["do"] == "retime_examples":  # the person has said when these were due
            for command in self._trainer.log.commands_of(record["numbers"]):
                self._estimated[command] = set()
                self.doubts.pop(command, None)
        if record["do"] != "command" or "who" not in record:
            return
        first = record["examples"][0]
        command = int(first["command"])
        pace, time = float(record["pace"]), float(record.get("shown", record["time"]))
        self._shown[command] = Press(pace, time, record.get("took"))
        self._who[command] = record["who"]
        for example in (first, *record["settled"]):
            self._estimated.setdefault(example["command"], set()).add(example["ago"])

    def _propose(self, command: CommandGiven) -> Proposal | None:
        """Return when a command was due; None if that is known, or the trainer must refuse."""
        with suppress(HitabError):
            given = command.given
            if given.pace and not given.exact and self._trainer.history.is_past(given.seen):
                return self._estimate(command)
        return None

    def _estimate(self, command: CommandGiven) -> Proposal:
        """Estimate when a late command was due, from all late ones of the person together."""
        history, log, given = self._trainer.history, self._trainer.log, command.given
        who, features = given.who, self._trainer.curriculum.features
        known = self.people.get(who, Lateness())
        due = history.at(min(known.median * given.pace, KEPT_SECONDS), given.seen)
        moments, newest = history.window(due), log.next_command
        took = self._interrupted if command.taken_over_in else None
        seen = Press(given.pace, history.at(0.0, given.seen).time, took)
        found = {newest: self._late(seen, moments, command.label, known)}
        told = []
        for e in log.examples:
            around, shown = history.kept_around(e.command), self._shown.get(e.command)
            if e.is_default or around is None or shown is None or self._who[e.command] != who:
                continue
            if e.ago in self._estimated[e.command]:
                found[e.command] = self._late(shown, around[1], e.next_state, known)
            else:
                delay = (shown.time - around[0] + e.ago) / shown.pace
                told.append(max(0.0, delay))
        late = {number: one for number, one in found.items() if one is not None}
        before = self._before.get(who, Lateness())
        scales = list(map(self._trainer.context.repertoire.domain.scale_of, features))
        commands = [one for one, _ in late.values()]
        places, weights, self.people[who] = settled(commands, scales, before, told)
        meant = {n: among[i] for (n, (_, among)), i in zip(late.items(), places, strict=True)}
        dues = {n: moment for n, moment in meant.items() if history.shows(moment, features)}
        self.doubts = {}
        for (n, (one, among)), weight, place in zip(late.items(), weights, places, strict=True):
            other = doubtful(one, weight, place)
            if other is not None and n in dues and history.shows(among[other], features):
                kept = None if n == newest else history.kept_around(n)
                self.doubts[n] = Doubt(kept[0] if kept else history.time, dues[n], among[other])
        due = dues.pop(newest, due)
        earlier = moved(self._trainer, dues)
        record = {"moments": list(map(to_dict, moments)), "who": who, "pace": seen.pace}
        record |= {"settled": list(map(to_dict, earlier))}
        return Proposal(due, earlier, record | {"shown": seen.time, "took": seen.took})

    def _late(
        self, shown: Press, moments: Sequence[PerceptRecord], label: str, lateness: Lateness
    ) -> tuple[LateCommand, Sequence[PerceptRecord]] | None:
        """Return a command that came late, and the moments for which it may have been meant.

        Args:
            shown: what the person had before their eyes.
            moments: around the command, as far as kept.
            label: label of the next state.
            lateness: lateness of the person's commands.

        Returns:
            The command; and the moments in one state, with those in which the automaton changed
            to a wrong state, if the person took over. None if there is no such moment.
        """
        moments = [moment for moment in moments if moment.time <= shown.time]
        if not moments:
            return None
        delays = (shown.time - np.array([moment.time for moment in moments])) / shown.pace
        states = [moment.state for moment in moments]
        ends = [i for i in range(len(states) - 1) if states[i] != states[i + 1]]
        stretches = list(pairwise([0, *(end + 1 for end in ends), len(states)]))
        changed = []
        if shown.took is None:
            stretches = stretches[-1:]
        else:
            changed = [end for end in ends if states[end + 1] != label]
        watched = shown.took is not None and shown.time - shown.took < AT_ONCE * shown.pace
        odds = lateness.density(delays, waits=watched)
        begin, end = max(stretches, key=lambda one: odds[one[0] : one[1]].sum())
        if states[begin] == label and not changed:
            return None
        among, features = moments[begin:end], self._trainer.curriculum.features
        values = np.array([self._trainer.history.in_moment(one, features) for one in among])
        values = values.reshape(len(among), len(features))
        times = tuple(delays[changed].tolist())
        late = LateCommand(states[begin], label, delays[begin:end], values, watched, times)
        return late, (*among, *(moments[i] for i in changed))
