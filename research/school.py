"""Plays lessons in one process and writes down what was commanded, and in which situation.

The lessons are the files that `hitab lesson run` plays over topics, and give the same examples
here. A peer (`peers`) learns from the commands as they were given: what the robot could read, the
basic behavior that it performed, and the basic behavior that it performs on the command.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from peers import Command as Shown

from hitab_client.errors import LessonError
from hitab_client.lessons import read_lesson
from hitab_client.lessons.conditions import Condition
from hitab_client.lessons.lesson import (
    Check,
    Lesson,
    Never,
    NewEpisode,
    Operate,
    Place,
    Say,
    Step,
    Until,
)
from hitab_client.showing.world_view import WorldView, speakers
from hitab_commander.inprocess import HierarchyPlayers
from hitab_core import START, Agent, Automaton, HitabError, Term
from hitab_core.operations import BeginTraining, Command, Distribute
from hitab_core.running import RunningAutomaton
from hitab_core.running.feature_cache import value_or_nan
from hitab_world import Placement, World
from hitab_world.inprocess import AutomatonPlayer, cycle


def basic_behavior(running: object) -> str:
    """Return the basic behavior at the bottom of a performance, bound to targets, or Start."""
    while isinstance(running, RunningAutomaton):
        child = running.child
        if child is None:
            return START
        if not isinstance(child, RunningAutomaton):
            return str(Term.parse(running.active).bound(running.bindings))
        running = child
    return START


@dataclass
class School:
    """A world and agents, in which lessons are played one after the other.

    Agents of the same kind share a library, so that what one saves is there for all.

    Attributes:
        world: is placed and stepped by the lessons.
        hierarchy: of the agents.
        words: the features that are written down with each command.
        bindings: what parameters in them stand for where a lesson does not say so.
        commands: what was commanded, by lesson.
        costs: the number of commands and of examples, by lesson.
    """

    world: World
    hierarchy: HierarchyPlayers
    words: Sequence[Term]
    bindings: Mapping[str, str] = field(default_factory=dict)
    commands: dict[str, list[Shown]] = field(default_factory=dict)
    costs: dict[str, tuple[int, int]] = field(default_factory=dict)
    _said: frozenset[str] = frozenset()
    _ended: tuple[str, ...] = ()
    _begun_at: int = 0
    _doing: str = START
    _episode: tuple[int, int] = (-1, -1)

    def play(self, path: Path) -> None:
        """Play a lesson.

        Raises:
            LessonError: naming the file and line of a step that is refused or fails.
        """
        lesson = read_lesson(path)
        self.commands[lesson.name] = []
        given = 0
        self._look()
        for step in lesson.steps:
            self._said, self._ended, self._begun_at = frozenset(), (), self.world.cycle
            try:
                if isinstance(step, Operate):
                    given += self._operate(step, lesson)
                else:
                    _STEPS[type(step)](self, step)
            except HitabError as error:
                place = f"{lesson.file}:{step.line}: step `{step.kind}`: "
                raise LessonError(f"{place}{error}") from None
        learned = self.learned(lesson.agent)[lesson.name]
        self.costs[lesson.name] = (given, len(learned.examples))

    def learned(self, agent: str) -> Mapping[str, Automaton]:
        """Return what is in an agent's library, by name."""
        return self.hierarchy.agents[agent].library.load()

    def _agent(self, step: Step) -> Agent:
        return self.hierarchy.agents[step.agent]

    # -- the world --------------------------------------------------------------------------

    def _look(self) -> None:
        """Let all perceive the present situation; a new episode begins at Start."""
        players, world = self.hierarchy.players, self.world
        if self._episode != (world.seed, world.episode):
            self._episode = (world.seed, world.episode)
            self._doing = START
            for player in players.values():
                player.begin(world.seed, world.episode)
        for name, player in players.items():
            player.body.sense(*world.percept(name))
        self.hierarchy.confer()

    def _run(self, agent: Agent) -> None:
        world = self.world
        ended = cycle(world, self.hierarchy.players, self.hierarchy.confer)
        now = basic_behavior(agent.session.running if agent.session is not None else None)
        self._doing = now if now != START else self._doing
        self._said |= speakers(self._things())
        if ended:
            self._ended += (ended,)
            world.reset()
        self._look()

    def _things(self) -> list[Any]:
        return list(self.world.entities())

    def _view(self) -> WorldView:
        world = self.world
        return WorldView(
            self._things(),
            (world.cycle - self._begun_at) * world.cycle_seconds,
            {name: agent.active_path for name, agent in self.hierarchy.agents.items()},
            self._said,
            self._ended,
        )

    def _await(self, condition: Condition, within: float, agent: Agent) -> bool:
        while not condition.holds(view := self._view()):
            if view.seconds >= within - 1e-6:
                return False
            self._run(agent)
        return True

    # -- the steps --------------------------------------------------------------------------

    def _place(self, step: Place) -> None:
        placements = [Placement(name, **where) for name, where in step.things.items()]
        self.world.place(placements, new_episode=step.new_episode)
        self._look()

    def _new_episode(self, step: NewEpisode) -> None:
        self.world.reset()
        self._look()

    def _operate(self, step: Operate, lesson: Lesson) -> int:
        """Have the step's agents carry it out; return how many were commanded."""
        operation = step.operation
        # A lesson may tell a captain to perform whom this swarm does not have.
        for agent in map(self.hierarchy.agents.get, step.agents):
            if agent is None:
                continue
            if isinstance(operation, Distribute):
                self._distribute(agent, operation)
            elif isinstance(operation, Command):
                self._command(agent, operation, lesson)
            else:
                agent.do(operation)
            if isinstance(operation, BeginTraining):
                self._doing = START
        return isinstance(operation, Command) * len(step.agents)

    def _command(self, agent: Agent, command: Command, lesson: Lesson) -> None:
        session = agent.session
        assert session is not None
        bindings = {**self.bindings, **session.running.bindings}
        terms = [term.bound(bindings) for term in self.words]
        readings = tuple(value_or_nan(agent.context.feature_cache.look, term) for term in terms)
        performed = self._performed(agent, Term.parse(command.behavior).bound(bindings))
        if performed != START:
            names = {bindings[name]: name for name in self.bindings}
            shown = Shown(readings, _renamed(self._doing, names), _renamed(performed, names))
            self.commands[lesson.name].append(shown)
        agent.do(command)
        self._doing = performed if performed != START else self._doing

    def _performed(self, agent: Agent, term: Term) -> str:
        """Return the basic behavior that an agent begins with when it is commanded ``use``."""
        if term.name in agent.domain.behaviors:
            return str(term)
        if term.name not in agent.repertoire:
            return START  # a flag
        probe = AutomatonPlayer(agent.repertoire, term, agent.name)
        probe.begin(0, 0)
        probe.body.sense(*self.world.percept(agent.name))
        probe.tick()
        return basic_behavior(probe.running)

    def _until(self, step: Until) -> None:
        if not self._await(step.condition, step.within, self._agent(step)):
            told = step.condition.describe(self._view())
            raise LessonError(f"waited {step.within:g} s in vain until {told}")

    def _never(self, step: Never) -> None:
        if self._await(step.condition, step.within, self._agent(step)):
            raise LessonError(f"{step.condition.describe(self._view())} came but should not")

    def _distribute(self, source: Agent, sent: Distribute) -> None:
        for agent in self.hierarchy.agents.values():
            receives = agent.name in (sent.receivers or self.world.agents)
            if agent.library is source.library and receives:
                agent.reload()
                if sent.start:
                    agent.perform(Term.parse(sent.behavior))

    def _say(self, step: Say) -> None:
        """Do nothing: there is nobody to read it."""


def _renamed(behavior: str, names: Mapping[str, str]) -> str:
    """Return a bound behavior in terms of the parameter that its target stands for."""
    return str(Term.parse(behavior).bound(names))


_STEPS: dict[type[Step], Callable[[School, Any], None]] = {
    Say: School._say,
    Place: School._place,
    Until: School._until,
    Check: School._until,
    Never: School._never,
    NewEpisode: School._new_episode,
}
