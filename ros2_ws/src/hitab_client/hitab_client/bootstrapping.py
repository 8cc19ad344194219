"""Behavior bootstrapping: a team learns one generation of a behavior after the other.

If the right behavior depends on the teammates, they have to act while one agent is trained. The
behavior in training is therefore saved and distributed to the team, which performs it while the
training continues. A generation is a version of the behavior in the library of the trained agent,
with a note and a score in the run folder, as in ``generations/keeper_1/Keepaway.yaml``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import yaml
from hitab_msgs.msg import WorldStatus
from pydantic import ConfigDict, Field

from hitab_client.errors import LessonError, SwarmError
from hitab_client.learned import Learned
from hitab_client.lessons.lesson import Lesson, parse_lesson
from hitab_client.lessons.lesson_player import LessonPlayer
from hitab_client.runs.run_folder import state_home
from hitab_client.scores import Score, score_of
from hitab_client.showing.world_as_it_was import arranged_as_it_was, standing_still
from hitab_client.swarm_client import SwarmClient
from hitab_client.terminal.interruptions import not_interrupted
from hitab_client.world_client import WorldClient
from hitab_core import Fix, quantity, some
from hitab_core.library import time_now
from hitab_core.library.durable_files import file_errors, write_durably
from hitab_core.library.yaml_models import Format, Record, Texts, open_record
from hitab_core.library.yaml_places import open_yaml
from hitab_core.operations import BeginTraining, Distribute, Perform, SaveBehavior, TakeOver

FORMAT = 2
"""Format version that is written, and newest that is read; additional fields of 1 are ignored."""


class Generation(Record):
    """One version of a behavior that was given to the team and evaluated.

    Attributes:
        version: the behavior's version in the library of the trained agent.
        at: creation time, ISO 8601.
        by: the demonstrator's name.
        examples: number of examples, default ones included.
        arguments: targets of the behavior's parameters.
        note: free text.
        score: the evaluation's score; has no episodes if the evaluation was not completed.
    """

    model_config = ConfigDict(extra="ignore")  # earlier formats have more fields
    version: int = Field(ge=1)
    at: str
    by: str
    examples: int
    arguments: Texts = ()
    note: str = ""
    score: Score = Score()


class _File(Record):
    model_config = ConfigDict(extra="ignore")
    format: Format = FORMAT
    generations: tuple[Generation, ...] = Field(strict=False)


def generations_folder(run_folder: Path | str | None, agent: str) -> Path:
    """Return the folder with a file for each behavior of an agent that has generations.

    Args:
        run_folder: the swarm's run folder; None for robots that were started by hand, which
            share a folder.
        agent: name of the trained agent.
    """
    return Path(run_folder or state_home()) / "generations" / agent


def read_generations(folder: Path, behavior: str) -> tuple[Generation, ...]:
    """Return the generations of a behavior, by ascending version; none if there is no file.

    Raises:
        SwarmError: if the file is invalid; names each fault with its line.
    """
    path = folder / f"{behavior}.yaml"
    if not path.exists():
        return ()
    return open_record(_File, open_yaml(path, error=SwarmError), FORMAT).generations


def _keep(folder: Path, behavior: str, made: Generation) -> None:
    content = _File(generations=(*read_generations(folder, behavior), made))
    text = yaml.safe_dump(content.model_dump(mode="json"), sort_keys=False, allow_unicode=True)
    with file_errors(path := folder / f"{behavior}.yaml", "write"):
        write_durably(path, text.encode())


@dataclass(frozen=True)
class Bootstrapping:
    """Steps of behavior bootstrapping with a swarm.

    Attributes:
        swarm: client of the agents.
        world: client of the agents' world; None without a world.
        run_folder: folder for notes and scores; None as in `generations_folder`.
        to: names of the teammates; empty for all other agents of the trained agent's domain.
        episodes: number of episodes to play for the score; 0 for no score.
        seed: random seed of these episodes.
        wait: condition, as in lessons, until which the agent then acts by itself, such as
            ``{said: keeper_2}``; empty to continue at once.
        within: timeout for that condition, s.
        who: name of the demonstrator; empty for the client's own.
        say: called with a message after each step.
        progress: called with the amount done, the total and the current activity.
    """

    swarm: SwarmClient
    world: WorldClient | None
    run_folder: Path | str | None
    to: Sequence[str] = ()
    episodes: int = 20
    seed: int = 1
    wait: str = ""
    within: float = 1e9
    who: str = ""
    say: Callable[[str], None] = lambda text: None
    progress: Callable[[int, int, str], None] = lambda done, total, doing: None

    def next(self, agent: str, note: str = "") -> Generation:
        """Make the next generation of the behavior in training, and continue the training.

        The behavior is saved, distributed to the teammates, who perform it, and evaluated, while
        the training waits. The training then continues with the same examples in the same world.

        Raises:
            HitabError: if a step fails. If the behavior was not saved, nothing has changed.
        """
        training = self.swarm.training(agent)
        name, bound = training.name, training.arguments
        waiting = self._waiting(agent)
        self.swarm.await_agents()
        for mate in self.to or self.swarm.expected:
            self.swarm.await_agent(mate)
        mates = [mate for mate in self.to or self.swarm.mates_of(agent) if mate != agent]
        folder = generations_folder(self.run_folder, agent)
        read_generations(folder, name)  # refuses a damaged file before anything is changed
        with standing_still(self.world) as before:
            with not_interrupted():
                self.swarm.do(agent, SaveBehavior(keep_unused=True))
                version = self.swarm.behavior(agent, name).version
                self._train(agent, training, bound, version)
            made = Generation(
                version=version,
                at=time_now(),
                by=self.who or self.swarm.demonstrator,
                examples=len(training.examples),
                arguments=bound,
                note=note,
            )
            many = quantity(made.examples, "example")
            self.say(f"generation {version} of {name}: saved with {many}")
            try:
                self._give(agent, name, bound, mates)
                made = made.but(score=self._score())
            finally:
                with not_interrupted():
                    _keep(folder, name, made)
                    self.say(f"generation {version}: {made.score}")
                    self.swarm.do(agent, TakeOver())
            if waiting is not None:
                self._await(waiting, before)
        return made

    def back(self, agent: str, behavior: str, version: int, discard: bool = False) -> Generation:
        """Return to a version of a behavior, which becomes the next generation.

        Behaviors that the version uses stay as they are now.

        Args:
            agent: name of the trained agent.
            behavior: name of the behavior.
            version: number of the version.
            discard: whether to discard examples that no version contains.

        Raises:
            HitabError: if a step fails. If the behavior was not saved, nothing has changed.
        """
        earlier = self.swarm.behavior(agent, behavior, version=version)
        self._waiting(agent)
        if not discard and self.swarm.statuses[agent].training.automaton:
            training = self.swarm.training(agent)
            if training.done:
                raise SwarmError(
                    f"{agent} has {quantity(len(training.done), 'change')} to its training of "
                    f"{training.name} that no generation has; give it up with --discard",
                    Fix.NEXT_GENERATION(agent=agent),
                )
        known = read_generations(generations_folder(self.run_folder, agent), behavior)
        bound = next((g.arguments for g in known if g.version == version), ())
        self._train(agent, earlier, bound, version)
        return self.next(agent, f"version {version} again")

    # -- steps ------------------------------------------------------------------------------

    def _train(self, agent: str, what: Learned, bound: Sequence[str], version: int) -> None:
        """Begin a training from a version of a behavior."""
        begin = BeginTraining(
            what.name,
            states=what.chosen_states,
            parameters=dict(zip(what.parameters, bound, strict=True)) if bound else {},
            resume=f"{what.name}@{version}",
            classifier=what.classifier,
            discard=True,
        )
        self.swarm.do(agent, begin)

    def _give(self, agent: str, name: str, bound: Sequence[str], mates: Sequence[str]) -> None:
        """Distribute a saved behavior to the team, which performs it.

        Raises:
            SwarmError: if a teammate does not have it; names each with the reason.
        """
        if mates:
            report = self.swarm.distribute(
                agent,
                Distribute(name, bound, mates, start=True),
                progress=lambda done, total: self.progress(done, total, "distributing"),
            )
            if lacking := [f"{mate} {why}" for mate, why in report.missing.items()]:
                raise SwarmError("\n".join(lacking), Fix.NEXT_GENERATION(agent=agent))
            self.say(f"{some(mates, most=3)} perform{'s' * (len(mates) == 1)} it")
        self.swarm.do(agent, Perform(name, bound))

    def _score(self) -> Score:
        """Return the score of the team's behavior; an empty score without a world or episodes."""
        world = self.world
        if world is None or not self.episodes:
            return Score()
        with arranged_as_it_was(world):
            played = world.play(
                self.episodes,
                self.seed,
                progress=lambda done: self.progress(done, self.episodes, "evaluating"),
            )
        return score_of(played, self.seed)

    def _waiting(self, agent: str) -> Lesson | None:
        """Return the lesson that runs an agent until the `wait` condition; None without one."""
        if not self.wait:
            return None
        until = self.wait if self.wait.lstrip().startswith("{") else f"{{{self.wait}}}"
        steps = f"{{test: a, restart: true}}, {{until: {until}, within: {self.within}}}"
        text = f"{{lesson: wait, agent: {agent}, steps: [{steps}]}}"
        return parse_lesson(text, Path("--wait"))

    def _await(self, lesson: Lesson, before: WorldStatus | None) -> None:
        """Test an agent's behavior until the lesson's condition holds, then take control back."""
        self.say(f"waiting until {self.wait} ...")
        factor = before.factor if before and before.pace == WorldStatus.REALTIME else 0.0
        try:
            LessonPlayer(lesson, self.swarm, self.world, factor=factor).play(self.progress)
        except LessonError as error:
            raise LessonError(error.what, Fix.TEST(agent=lesson.agent)) from None
        finally:
            with not_interrupted():
                self.swarm.do(lesson.agent, TakeOver())
