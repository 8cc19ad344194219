"""Remedies for errors, as data: each user interface words them in its own way."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum, unique


@unique
class Fix(Enum):
    """Fixes for errors, in plain words; arguments are the names in braces.

    A user interface with a command, button or call for a fix has a table of its own words.
    ``Fix.SAVE(agent="keeper_1")`` is a remedy. An argument that is not given is named in capitals.
    """

    # trainings
    TRAIN = 'train {agent} to perform "{behavior}"'
    TRAIN_FURTHER = 'train "{behavior}" of {agent} further, from its examples'
    RESUME = "go on with the training of {agent}"
    DEMONSTRATE = "command {agent} a behavior"
    CORRECT = "take over from {agent}, and command {behavior} where it is right"
    CHOOSE_FEATURES = "choose features for {agent} by its decisions"
    VOCABULARY = "list what {agent} can do and perceive"
    QUESTIONS = "see what {agent} asks"
    EXAMPLES = "list the examples of {agent}"
    RELABEL = (
        "have example {number} of {agent} go to {behavior} instead of {before}, if that is wrong"
    )
    EXAMPLES_OF = "list the examples of a trained behavior of {agent}"
    TEST = "test what {agent} has learned"
    CAUTION = "say when {agent} is unsure"
    SAVE = "save the training of {agent}"
    DISCARD = "discard the training of {agent}"
    PERFORM = "have {agent} perform a behavior"
    IDLE = "make {agent} idle"
    # libraries
    CHECK_LIBRARY = "check the library"
    RESTORE = 'bring version {version} of "{behavior}" back in {folder}'
    DELETE = 'give "{behavior}" up in {folder}'
    MOVE_AWAY = "move {file} away"
    PUT_INTACT = "put an intact file in the place of {file}"
    SEND = 'have an agent that has "{behavior}" send it'
    GIVE = 'have {agent} give "{behavior}" to {receiver}'
    RELOAD = "have the agents of {swarm} read their libraries again"
    # generations
    NEXT_GENERATION = "make a generation of what {agent} trains"
    # worlds and robots
    GO = "release the emergency stop"
    ARM = "let {robot} act again"
    PACE = "have the world wait for real time"
    RESUME_WORLD = "let the world go on"
    SAVE_SNAPSHOT = "save the snapshot {snapshot}"
    DELETE_SNAPSHOT = "delete a snapshot"
    # swarms
    UP = "start {swarm}"
    DOWN = "stop {swarm}, or end what is left of it"
    DOWN_FOLDER = "stop the swarm in {folder}, or end what is left of it"
    STATUS = "see who is there"
    TREE = "see who performs the orders of {commander}"
    LOGS = "look into the log of {node}"
    DOCTOR = "look for the cause"
    RECORD = "record it"
    # demonstrators

    def __call__(self, **arguments: object) -> Remedy:
        """Return the remedy with these arguments."""
        return Remedy(self, tuple((name, str(value)) for name, value in arguments.items()))


@dataclass(frozen=True)
class Remedy:
    """Something to do, with its arguments by name."""

    code: Fix
    arguments: tuple[tuple[str, str], ...] = ()

    def of(self, agent: str) -> Remedy:
        """Return the remedy with an agent's name, if it is for an agent and names none."""
        if "{agent}" not in self.code.value or "agent" in dict(self.arguments):
            return self
        return Remedy(self.code, (("agent", agent), *self.arguments))

    def __str__(self) -> str:
        """Return the remedy in plain words.

        Examples:
            >>> str(Fix.SAVE(agent="keeper_1")), str(Fix.SAVE())
            ('save the training of keeper_1', 'save the training of AGENT')
        """
        return self.worded({})

    def worded(self, words: Mapping[Fix, str]) -> str:
        """Return the remedy in the words of a table; in plain words if the table has none."""
        return words.get(self.code, self.code.value).format_map(_Given(self.arguments))


class _Given(dict[str, str]):
    def __missing__(self, name: str) -> str:
        return name.upper()
