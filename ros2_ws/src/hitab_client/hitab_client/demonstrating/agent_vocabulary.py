"""Vocabulary for commands to an agent, with the keys of its behaviors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from hitab_msgs.msg import AgentStatus

from hitab_client.demonstrating.behavior_keys import Keys
from hitab_client.demonstrating.pressed import Pressed, Prompt
from hitab_client.errors import SwarmError
from hitab_client.swarm_client import SwarmClient
from hitab_core import FLAGS, BoundedNumber, Term, some, without_numbers
from hitab_ros.messages.conversions import numbers_of_behaviors


@dataclass(frozen=True)
class AgentVocabulary:
    """Vocabulary for commands to an agent.

    Attributes:
        domain: name of the agent's domain.
        behaviors: behaviors with parameters, in the order of their keys; in training, flags
            come last.
        keys: keys of the behaviors, by behavior.
        targets: targets for parameters; in training, also the automaton's own parameters.
        training: name of the automaton in training, or of a suspended training; empty if none.
        numbers: numbers of the behaviors that take numbers, by name.
    """

    domain: str = ""
    behaviors: tuple[str, ...] = ()
    keys: tuple[tuple[str, str], ...] = ()
    targets: tuple[str, ...] = ()
    training: str = ""
    numbers: Mapping[str, tuple[BoundedNumber, ...]] = field(default_factory=dict)

    def open_numbers(self, term: Term) -> list[BoundedNumber]:
        """Return the numbers that a behavior takes and the term does not give."""
        given = {argument.partition("=")[0] for argument in term.arguments if "=" in argument}
        return [n for n in self.numbers.get(term.name, ()) if n.name not in given]

    def open_parameter(self, term: Term) -> int | None:
        """Return the position of the first unbound parameter; None if all are bound."""
        term = without_numbers(term)
        for declared in map(Term.parse, self.behaviors):
            if declared.name == term.name and len(declared.arguments) == len(term.arguments):
                pairs = enumerate(zip(term.arguments, declared.arguments, strict=True))
                return next(
                    (i for i, (a, own) in pairs if a == own and a not in self.targets), None
                )
        return None

    def open_part(self, pressed: Pressed) -> Prompt | None:
        """Return a prompt for a behavior's missing target or number; None if it needs none."""
        term = Term.parse(pressed.behavior)
        place, numbers = self.open_parameter(term), self.open_numbers(term)
        if place is not None:
            return Prompt(term, pressed, place, self.targets) if self.targets else None
        return Prompt(term, pressed, number=numbers[0]) if numbers else None

    def check_bound(self, term: Term, agent: str) -> None:
        """Check that a behavior of an agent has all its targets.

        Raises:
            SwarmError: if it lacks one; names the existing targets.
        """
        if (place := self.open_parameter(term)) is None:
            return
        needs = f"{term} needs a target for {term.arguments[place]}"
        if not self.targets:
            raise SwarmError(f"{needs}, and {agent} has none")
        raise SwarmError(
            f"{needs}: name the behavior with one, such as {term.name}({self.targets[0]}); the "
            f"targets are {some(self.targets)}"
        )

    def on_key(self, key: str) -> str:
        """Return the behavior on a key; empty if there is none."""
        return dict(self.keys).get(key, "")

    def number(self, number: int) -> str:
        """Return the behavior at a position, from 1; empty if there are fewer."""
        names = [name for name in self.behaviors if name not in FLAGS]
        return names[number - 1] if 1 <= number <= len(names) else ""


class WordsOfAgents:
    """Vocabularies of agents, requested again when they may have changed."""

    def __init__(self, agents: SwarmClient, keys: Keys) -> None:
        self._agents = agents
        self._keys = keys
        self._known: dict[str, tuple[tuple[str, ...], AgentVocabulary]] = {}

    def known(self, agent: str) -> AgentVocabulary:
        """Return an agent's last known vocabulary, without waiting."""
        return self._known.get(agent, ((), AgentVocabulary()))[1]

    def is_old(self, agent: str) -> bool:
        """Whether an agent's vocabulary may have changed since the last request."""
        status = self._agents.statuses.get(agent)
        return status is not None and self._known.get(agent, ((),))[0] != _state(status)

    def ask(self, agent: str) -> AgentVocabulary:
        """Return an agent's vocabulary, requested if it may have changed.

        Raises:
            SwarmError: if the agent does not answer.
        """
        status = self._agents.await_agent(agent)
        state = _state(status)
        if self._known.get(agent, ((),))[0] != state:
            self._known[agent] = state, self._asked(agent, status)
        return self._known[agent][1]

    def _asked(self, agent: str, status: AgentStatus) -> AgentVocabulary:
        answer = self._agents.vocabulary(agent)
        targets = list(answer.targets)
        training = self._agents.training(agent) if _is_trained(status) else None
        if training is not None:
            targets += [p for p in training.parameters if p not in targets]
        behaviors = [b.name for b in answer.behaviors]
        trained = {Term.parse(b.name).name for b in answer.behaviors if b.trained}
        commandable = self._keys.commandable(answer.domain, behaviors, trained, training)
        keys = ((self._keys.of(answer.domain, name), name) for name in commandable)
        return AgentVocabulary(
            answer.domain,
            tuple(commandable),
            tuple(k for k in keys if k[0]),
            tuple(targets),
            status.training.automaton,
            numbers_of_behaviors(answer.behaviors),
        )


def _is_trained(status: AgentStatus) -> bool:
    return status.mode in (AgentStatus.TRAINING, AgentStatus.TESTING)


def _state(status: AgentStatus) -> tuple[str, ...]:
    """Return the parts of a status that an agent's vocabulary depends on."""
    return (
        status.domain,
        status.library_digest,
        str(_is_trained(status)),
        status.training.automaton,
    )
