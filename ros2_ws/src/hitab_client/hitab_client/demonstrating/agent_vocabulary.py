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
from hitab_ros.conversions import numbers_of_behaviors


@dataclass(frozen=True)
class AgentVocabulary:
    """Vocabulary for commands to an agent.

    Attributes:
        domain: of the agent.
        behaviors: with parameters, in the order of their keys; in training the flags come last.
        keys: of the behaviors that have one.
        targets: of parameters; in training its own parameters are among them.
        training: name of the training that is under way, or kept with its examples; "": none.
        numbers: of the behaviors that take some, by name.
    """

    domain: str = ""
    behaviors: tuple[str, ...] = ()
    keys: tuple[tuple[str, str], ...] = ()
    targets: tuple[str, ...] = ()
    training: str = ""
    numbers: Mapping[str, tuple[BoundedNumber, ...]] = field(default_factory=dict)

    def open_numbers(self, term: Term) -> list[BoundedNumber]:
        """Return the numbers that a behavior takes and is not given."""
        given = {argument.partition("=")[0] for argument in term.arguments if "=" in argument}
        return [n for n in self.numbers.get(term.name, ()) if n.name not in given]

    def open_parameter(self, term: Term) -> int | None:
        """Return the place of a parameter that is bound to no target; None if there is none."""
        term = without_numbers(term)
        for declared in map(Term.parse, self.behaviors):
            if declared.name == term.name and len(declared.arguments) == len(term.arguments):
                pairs = enumerate(zip(term.arguments, declared.arguments, strict=True))
                return next(
                    (i for i, (a, own) in pairs if a == own and a not in self.targets), None
                )
        return None

    def open_part(self, pressed: Pressed) -> Prompt | None:
        """Return what a person can be asked for, of a behavior that needs a target or a number."""
        term = Term.parse(pressed.behavior)
        place, numbers = self.open_parameter(term), self.open_numbers(term)
        if place is not None:
            return Prompt(term, pressed, place, self.targets) if self.targets else None
        return Prompt(term, pressed, number=numbers[0]) if numbers else None

    def check_bound(self, term: Term, agent: str) -> None:
        """Check that a behavior of an agent has all its targets.

        Raises:
            SwarmError: naming the targets that there are.
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
        """Return the behavior on a key; "" if there is none."""
        return dict(self.keys).get(key, "")

    def number(self, number: int) -> str:
        """Return a behavior by its place in the order, from 1; "" if there are fewer."""
        names = [name for name in self.behaviors if name not in FLAGS]
        return names[number - 1] if 1 <= number <= len(names) else ""


class WordsOfAgents:
    """Asks agents for their words, again when these may have changed."""

    def __init__(self, agents: SwarmClient, keys: Keys) -> None:
        self._agents = agents
        self._keys = keys
        self._known: dict[str, tuple[tuple[str, ...], AgentVocabulary]] = {}

    def known(self, agent: str) -> AgentVocabulary:
        """Return what is known of an agent's words, without waiting."""
        return self._known.get(agent, ((), AgentVocabulary()))[1]

    def is_old(self, agent: str) -> bool:
        """Whether an agent's words may have changed since it was asked."""
        status = self._agents.statuses.get(agent)
        return status is not None and self._known.get(agent, ((),))[0] != _state(status)

    def ask(self, agent: str) -> AgentVocabulary:
        """Return an agent's words; it is asked if they may have changed.

        Raises:
            SwarmError: if it does not answer.
        """
        status = self._agents.await_agent(agent)
        state = _state(status)
        if self._known.get(agent, ((),))[0] != state:
            self._known[agent] = state, self._asked(agent, status)
        return self._known[agent][1]

    def _asked(self, agent: str, status: AgentStatus) -> AgentVocabulary:
        told = self._agents.vocabulary(agent)
        targets = list(told.targets)
        training = self._agents.training(agent) if _is_trained(status) else None
        if training is not None:
            targets += [p for p in training.parameters if p not in targets]
        behaviors = [b.name for b in told.behaviors]
        trained = {Term.parse(b.name).name for b in told.behaviors if b.trained}
        there = self._keys.commandable(told.domain, behaviors, trained, training)
        keys = ((self._keys.of(told.domain, name), name) for name in there)
        return AgentVocabulary(
            told.domain,
            tuple(there),
            tuple(k for k in keys if k[0]),
            tuple(targets),
            status.training,
            numbers_of_behaviors(told.behaviors),
        )


def _is_trained(status: AgentStatus) -> bool:
    return status.mode in (AgentStatus.TRAINING, AgentStatus.TESTING)


def _state(status: AgentStatus) -> tuple[str, ...]:
    """Return what an agent's words depend on."""
    return status.domain, status.library_digest, str(_is_trained(status)), status.training
