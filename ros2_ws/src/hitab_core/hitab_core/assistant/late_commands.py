"""An assistant that estimates when late commands were due, again with each new one.

Commands that a person has retimed keep their times. A correction also records which decision it
corrects.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from hitab_core.assistant.lateness import LateCommand, Lateness, settled
from hitab_core.codec import to_dict
from hitab_core.texts.errors import HitabError
from hitab_core.training.events import CommandGiven, Proposal
from hitab_core.training.percept_history import KEPT_SECONDS
from hitab_core.training.percepts import PerceptRecord
from hitab_core.training.retiming import moved
from hitab_core.training.trainer import Trainer

BLAMED_SECONDS = 1.0
"""Longest time from a change of state until its correction was due, s."""

Window = tuple[float, Sequence[PerceptRecord]]
"""The time of a command, s, and the moments around it."""


class LateCommands:
    """Estimates the delay of commands whose reaction time is unknown.

    Args:
        trainer: the trainer.
        people: see below.

    Attributes:
        people: delay of the commands of each demonstrator; kept up to date.
    """

    def __init__(self, trainer: Trainer, people: dict[str, Lateness]) -> None:
        self.people = people
        self._trainer = trainer
        self._before = dict(people)
        self._who: dict[int, str] = {}
        self._paces: dict[int, float] = {}
        self._corrects = set[int]()
        self._estimated: dict[int, set[float]] = {}

    def subscribe(self) -> None:
        """Propose moments for commands from now on."""
        self._trainer.events.commanded.subscribe(self._propose)
        self._trainer.events.changed.subscribe(self._keep)

    def _keep(self, record: Mapping[str, Any]) -> None:
        """Keep the data of a command, and of earlier ones, from its record in the journal."""
        if record["do"] != "command":
            return
        first = record["examples"][0]
        command = int(first["command"])
        if "pace" in record:
            self._paces[command] = float(record["pace"])
        if "corrects" in record:
            self._corrects.add(command)
        if "who" in record:
            self._who[command] = record["who"]
            for example in (first, *record["settled"]):
                self._estimated.setdefault(example["command"], set()).add(example["ago"])

    def _propose(self, command: CommandGiven) -> Proposal | None:
        """Return when a command was due; None if the trainer has to refuse it."""
        with suppress(HitabError):
            given = command.given
            if given.pace and not given.exact and self._trainer.history.is_past:
                return self._estimate(command)
            due = command.stated()  # the delay of the command is known
            return Proposal(due, (), self._correction(command, due))
        return None

    def _estimate(self, command: CommandGiven) -> Proposal:
        """Estimate when a late command was due, from all late ones of the person together."""
        history, log, who = self._trainer.history, self._trainer.log, command.given.who
        features, pace = self._trainer.curriculum.features, command.given.pace
        known = self.people.get(who, Lateness())
        usual = min(known.median * pace, KEPT_SECONDS)
        due = history.at(usual, command.given.seen)
        window: Window = history.time, history.window(due)
        correction = self._correction(command, due)
        newest = log.next_command
        self._paces[newest] = pace
        (self._corrects.add if correction else self._corrects.discard)(newest)
        found = {newest: self._late(newest, window, command.label, known)}
        for e in log.examples:
            mine = self._who.get(e.command) == who and e.ago in self._estimated[e.command]
            around = history.kept_around(e.command)
            if mine and not e.is_default and around is not None:
                at = (e.state, e.cycle)
                found[e.command] = self._late(e.command, around, e.next_state, known, at)
        late = {number: one for number, one in found.items() if one is not None}
        before = self._before.get(who, Lateness())
        scales = list(map(self._trainer.context.repertoire.domain.scale_of, features))
        places, self.people[who] = settled([one for one, _ in late.values()], scales, before)
        meant = {n: among[i] for (n, (_, among)), i in zip(late.items(), places, strict=True)}
        dues = {n: moment for n, moment in meant.items() if history.shows(moment, features)}
        due = dues.pop(newest, due)
        earlier = moved(self._trainer, dues)
        record = {"moments": list(map(to_dict, window[1])), "pace": pace, **correction}
        record |= {"settled": list(map(to_dict, earlier)), "who": who}
        return Proposal(due, earlier, record)

    def _correction(self, command: CommandGiven, due: PerceptRecord) -> dict[str, Any]:
        """Return for the journal whether a command may correct the decision before it.

        The wrong decision is the first change of state after the command was due, whatever
        followed before the person took over; else the last one before, if that was not long
        before; else the automaton's staying in the state that was active then.
        """
        if not command.taken_over_in:
            return {}
        kept = self._trainer.history.since(due.time - BLAMED_SECONDS)
        states = [*(moment.state for moment in kept), command.taken_over_in]
        changes = [
            (moment, after)
            for moment, after in zip(kept, states[1:], strict=True)
            if moment.state != after
        ]
        wrong = changes[-1][1] if changes else due.state
        wrong = next((after for moment, after in changes if moment.time >= due.time), wrong)
        return {"corrects": True} if wrong != command.label else {}

    def _late(
        self,
        command: int,
        window: Window,
        label: str,
        lateness: Lateness,
        recorded: tuple[str, int] | None = None,
    ) -> tuple[LateCommand, Sequence[PerceptRecord]] | None:
        """Return a command that came late, and the moments for which it may have been meant.

        Args:
            command: number of the command.
            window: see `Window`.
            label: label of the next state.
            lateness: lateness of the person's commands.
            recorded: the state and the cycle for which it was recorded; None before that.

        Returns:
            The command; and the moments in one state, with one in which the automaton changed its
            state last, if it may correct that. None if it is known when the command was due.
        """
        pace = self._paces.get(command)
        given, moments = window
        if pace is None or not moments:
            return None
        delays = (given - np.array([moment.time for moment in moments])) / pace
        odds = lateness.density(delays)
        states = [moment.state for moment in moments]
        ends = [i for i in range(len(states) - 1) if states[i] != states[i + 1]]
        stretches = list(pairwise([0, *(end + 1 for end in ends), len(states)]))
        changed: int | None = None
        if command in self._corrects:
            wrong = [end for end in ends if states[end + 1] != label]
            changed = max(wrong, key=lambda end: odds[end], default=None)
        else:
            stretches = stretches[-1:]
        corrects = None
        begin, end = max(stretches, key=lambda one: odds[one[0] : one[1]].sum())
        if recorded is not None:
            there = [i for i, m in enumerate(moments) if (m.state, m.cycle) == recorded]
            corrects = None if changed is None else there == [changed]
            if there and not corrects:
                begin, end = next(one for one in stretches if one[1] > there[0])
        if states[begin] == label and changed is None:
            return None
        among, features = moments[begin:end], self._trainer.curriculum.features
        values = np.array([self._trainer.history.in_moment(one, features) for one in among])
        values = values.reshape(len(among), len(features))
        late = LateCommand(states[begin], label, delays[begin:end], values)
        if changed is None:
            return late, among
        late = replace(late, changed=float(delays[changed]), corrects=corrects)
        return late, (*among, moments[changed])
