"""Behavior bootstrapping, a generation at a time.

If the right behavior depends on the teammates, these have to act while one is trained. So what is
being trained is saved and given to the team, which performs it, and the training goes on among
them. Each such stage is a generation: a version of the behavior in the library, with a score.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from hitab_msgs.msg import AgentStatus, WorldStatus
from hitab_msgs.srv import Control, Snapshot

from hitab_client.acknowledgements import QUIET_SECONDS
from hitab_client.bootstrapping.generations import (
    LENGTH,
    Generation,
    folder_of,
    read_generations,
    score_of,
)
from hitab_client.errors import LessonError, SwarmError
from hitab_client.interruptions import not_interrupted
from hitab_client.learned import Learned
from hitab_client.lessons.condition_watch import ConditionWatch
from hitab_client.lessons.conditions import Condition
from hitab_client.swarm_client import SwarmClient
from hitab_client.world_as_it_was import standing_still
from hitab_client.world_client import WorldClient
from hitab_core import Fix, quantity, some
from hitab_core.library import time_now
from hitab_core.library.yaml_models import Record, open_record
from hitab_core.library.yaml_places import read_yaml

BEFORE = "before_bootstrap"
"""The snapshot of the world as it was, while a generation is evaluated."""


@dataclass
class Bootstrapping:
    """Makes generations with a swarm, and goes back to them.

    Attributes:
        swarm: the agents.
        world: theirs; None: they have none.
        run_folder: keeps the notes and scores.
        to: the teammates; none: all others of the domain of whoever is trained.
        episodes: to play for the score; 0: no score.
        seed: of these episodes.
        wait: condition until which the agent then acts by itself, as in lessons, such as
            ``{said: keeper_2}``; empty: none.
        within: how long that may take, s.
        who: demonstrates; empty: whoever the client says.
        patience: how long to wait for the next answer of a teammate, s.
        say: called with each thing that is done.
        progress: called with the amount done, the total (0: unknown) and the current activity.
        left: what remains to be done if it is interrupted now; empty: nothing has changed.
    """

    swarm: SwarmClient
    world: WorldClient | None
    run_folder: Path
    to: Sequence[str] = ()
    episodes: int = 20
    seed: int = 1
    wait: str = ""
    within: float = math.inf
    who: str = ""
    patience: float = QUIET_SECONDS
    say: Callable[[str], None] = lambda text: None
    progress: Callable[[int, int, str], None] = lambda done, total, doing: None
    left: str = ""

    def next(self, agent: str, note: str = "") -> Generation:
        """Make the next generation of what an agent is being trained, and train on.

        It is saved, given to the teammates, who perform it, and evaluated. Then the training goes
        on with the same examples, in the world as it was.

        Raises:
            SwarmError: naming what is wrong. Unless it says otherwise nothing has changed.
        """
        training = self.swarm.training(agent)
        name, arguments = training.name, training.arguments
        condition, mates = self._checked(agent)
        known = read_generations(folder_of(self.run_folder, agent), name)
        with standing_still(self.world) as before:
            with contextlib.ExitStack() as at_the_end:
                with not_interrupted():
                    self.swarm.save(agent, keep_unused=True)
                    at_the_end.callback(self._resume, agent, training)
                    made = Generation(
                        version=self.swarm.behavior(agent, name).version,
                        at=time_now(),
                        by=self.who or self.swarm.demonstrator,
                        examples=len(training.examples),
                        arguments=arguments,
                        note=note,
                        unscored="it was interrupted",
                    )
                    known.keep(made)
                    number, many = made.version, quantity(made.examples, "example")
                    self.say(f"generation {number} of {name}: saved with {many}")
                    again = Fix.NEXT_GENERATION(agent=agent)
                    kept = f"generation {number} of {name} is kept without a score"
                    self.left = f"{kept}, and perhaps not all of the team have it; {again}"
                if lacking := self._given(agent, training, mates):
                    known.keep(made.but(unscored="; ".join(lacking)))
                    told = f"{kept}, since not all of the team have it; mend that first"
                    raise SwarmError("\n".join([*lacking, told]), again)
                self.swarm.perform(agent, name, arguments)
                made = self._evaluated(made)
                known.keep(made)
            self.left = f"generation {number} is complete and {agent} is in training mode"
            if condition is not None:
                self._await(agent, condition, before)
        return made

    def back(self, agent: str, behavior: str, version: int, discard: bool = False) -> Generation:
        """Go back to a version of a behavior: it becomes the next generation.

        What it uses stays as it is now.

        Args:
            agent: that is trained.
            behavior: that is trained.
            version: of the behavior.
            discard: give up examples that are in no version.

        Raises:
            SwarmError: naming what is wrong. Unless it says otherwise nothing has changed.
        """
        self.swarm.await_agent(agent)
        earlier = self.swarm.behavior(agent, behavior, version=version)
        known = read_generations(folder_of(self.run_folder, agent), behavior)
        self._checked(agent)
        under_way = self.swarm.statuses[agent].training and self.swarm.training(agent)
        if under_way and under_way.done and not discard:
            raise SwarmError(
                f"{agent} has {quantity(len(under_way.done), 'change')} to its training of "
                f"{under_way.name} that no generation has; give it up with --discard",
                Fix.NEXT_GENERATION(agent=agent),
            )
        bound = next((g.arguments for g in known.all if g.version == version), ())
        with not_interrupted():
            self._begin(agent, earlier, bound, f"{behavior}@{version}", discard=True)
            self.left = f"{agent} is trained from version {version}, which the team does not have"
        return self.next(agent, f"version {version} again")

    # -- doing it ---------------------------------------------------------------------------

    def _checked(self, agent: str) -> tuple[Condition | None, list[str]]:
        """Return what is awaited, and the teammates, once all are there and free."""
        condition = _awaited(self.wait, agent) if self.wait else None
        self.swarm.await_agents()
        for mate in self.to or self.swarm.expected:
            self.swarm.await_agent(mate)
        mates = [mate for mate in self.to or self.swarm.mates_of(agent) if mate != agent]
        for mate in mates:
            if self.swarm.statuses[mate].mode in (AgentStatus.TRAINING, AgentStatus.TESTING):
                raise SwarmError(
                    f"{mate} is in training itself; name the others with --to",
                    Fix.SAVE(agent=mate),
                    Fix.DISCARD(agent=mate),
                )
        return condition, list(dict.fromkeys(mates))

    def _begin(
        self, agent: str, what: Learned, bound: Sequence[str], resume: str, discard: bool = False
    ) -> str:
        answer = self.swarm.begin(
            agent,
            what.name,
            features=list(what.features),
            states=list(what.chosen),
            parameters=list(what.parameters) if bound else [],
            arguments=list(bound),
            resume=resume,
            classifier=what.classifier,
            discard=discard,
        )
        return str(answer.message)

    def _resume(self, agent: str, training: Learned) -> None:
        try:
            with not_interrupted():
                told = self._begin(agent, training, training.arguments, training.name)
                self.say(f"{agent}: {told}")
        except SwarmError as error:
            raise SwarmError(
                f"the training could not go on by itself: {error.problem}",
                Fix.TRAIN_FURTHER(agent=agent, behavior=training.name),
                *error.remedies,
            ) from None

    def _given(self, agent: str, training: Learned, mates: Sequence[str]) -> list[str]:
        """Have teammates perform what was saved; return who does not have it, and why."""
        if not mates:
            return []
        report = self.swarm.distribute(
            agent,
            training.name,
            arguments=training.arguments,
            receivers=mates,
            start=True,
            seconds=self.patience,
            progress=lambda done, total: self.progress(done, total, "distributing"),
        )
        if not report.missing:
            self.say(f"{some(mates, most=3)} perform{'s' * (len(mates) == 1)} it")
        return [f"{name} {why}" for name, why in report.missing.items()]

    def _evaluated(self, made: Generation) -> Generation:
        """Return a generation with the score of what the team performs.

        The situation that the demonstrator had arranged comes back, if the world can do that.
        """
        world = self.world
        if world is None or not self.episodes:
            why = "no episodes were asked for" if world else "there is no world to play in"
            self.say(f"generation {made.version} has no score: {why}")
            return made.but(unscored=why)
        try:
            world.snapshot(Snapshot.Request.SAVE, BEFORE)
        except SwarmError as error:
            self.say(f"a new episode follows the evaluation, since {error}")
        try:
            played = world.play(
                self.episodes,
                self.seed,
                progress=lambda done: self.progress(done, self.episodes, "evaluating"),
            )
        except BaseException:
            with not_interrupted(), contextlib.suppress(SwarmError):  # the first is reported
                world.play(0, world.wait().seed)  # without a limit, or the rest would be played
            raise
        finally:
            with not_interrupted(), contextlib.suppress(SwarmError):  # it has no such snapshot
                world.shown(world.control(Control.Request.PAUSE))
                world.shown(world.snapshot(Snapshot.Request.RESTORE, BEFORE))
                world.snapshot(Snapshot.Request.DELETE, BEFORE)
        score = score_of(played, self.seed)
        many = f"{quantity(score.episodes, 'episode')}, seed {score.seed}"
        self.say(f"generation {made.version}: {score.figures[LENGTH]} s an episode ({many})")
        return made.but(score=score, unscored="")

    def _await(self, agent: str, condition: Condition, before: WorldStatus | None) -> None:
        """Have an agent act as it has learned until a condition holds; then take over."""
        self.say(f"waiting until {condition.describe()} ...")
        in_real_time = before is not None and before.pace == WorldStatus.REALTIME
        factor = before.factor if before is not None and in_real_time else 0.0
        try:
            self.swarm.set_mode(agent, AgentStatus.TESTING, restart=True)
            with ConditionWatch(self.swarm, self.world, factor=factor) as watch:
                came = watch.until(
                    condition,
                    self.within,
                    lambda view: self.progress(0, 0, f"waiting: {condition.describe(view)}"),
                )
                last = condition.describe(watch.view())
        except LessonError as error:
            raise SwarmError(f"what is awaited cannot come about: {error}") from None
        finally:
            with not_interrupted():
                self.swarm.set_mode(agent, AgentStatus.TRAINING)
        if not came:
            raise SwarmError(
                f"waited {self.within:g} s in vain until {last}; {agent} is in training mode, "
                "where it is now; bring the situation about by hand",
                Fix.TEST(agent=agent),
            )


class _Awaited(Record):
    """A condition by itself."""

    wait: Condition


def _awaited(text: str, agent: str) -> Condition:
    """Read a condition, which is about this agent where it names none.

    Raises:
        SwarmError: naming what is wrong with it.
    """
    flow = text if text.lstrip().startswith("{") else f"{{{text}}}"
    document = read_yaml(f"wait: {flow}", "--wait", error=SwarmError)
    return open_record(_Awaited, document, 1).wait.about(agent)
