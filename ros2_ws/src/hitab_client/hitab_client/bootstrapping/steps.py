"""Behavior bootstrapping, a generation at a time.

If the right behavior depends on the teammates, these have to act while one is trained. So what is
being trained is saved and given to the team, which performs it, and the training goes on among
them. Each such stage is a generation: it is kept with its score, and one can go back to it.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from hitab_msgs.msg import WorldStatus

from hitab_client.acknowledgements import QUIET_SECONDS, DistributionReport
from hitab_client.bootstrapping.configuration import Configuration
from hitab_client.bootstrapping.evaluating import LENGTH, SHORT, Evaluation, evaluated
from hitab_client.bootstrapping.generations import (
    Generation,
    Generations,
    folder_of,
    held,
    read_generations,
)
from hitab_client.bootstrapping.kept_copies import KeptCopies
from hitab_client.bootstrapping.trainees import mates_of, refuse_unsaved, training_of
from hitab_client.errors import SwarmError
from hitab_client.interruptions import not_interrupted
from hitab_client.learned import Learned
from hitab_client.swarm_client import SwarmClient
from hitab_client.world_as_it_was import standing_still
from hitab_client.world_client import WorldClient
from hitab_core import Fix, quantity, some
from hitab_core.library import content_of, reissued, time_now

Progress = Callable[[int, int, str], None]
"""Called with the amount done, the total (0: unknown) and the current activity."""


class Bootstrapping:
    """Makes generations with a swarm, and goes back to them.

    Args:
        swarm: the agents.
        world: theirs; None: they have none.
        run_folder: that keeps the generations.
        who: demonstrates; empty: whoever the client says.
        patience: how long to wait for the next answer of a teammate, s.
        say: called with each thing that is done.
        progress: called while it goes on.

    Attributes:
        left: what remains to be done if it is interrupted now; empty: nothing has changed.
    """

    def __init__(
        self,
        swarm: SwarmClient,
        world: WorldClient | None,
        run_folder: Path,
        *,
        who: str = "",
        patience: float = QUIET_SECONDS,
        say: Callable[[str], None] = lambda text: None,
        progress: Progress = lambda done, total, doing: None,
    ) -> None:
        self._swarm = swarm
        self._world = world
        self._run_folder = run_folder
        self._who = who or swarm.demonstrator
        self._patience = patience
        self._say = say
        self._progress = progress
        self._copies = KeptCopies(swarm)
        self.left = ""

    # -- the steps --------------------------------------------------------------------------

    def next(
        self,
        agent: str,
        *,
        to: Sequence[str] = (),
        note: str = "",
        evaluation: Evaluation = SHORT,
        configuration: Configuration | None = None,
    ) -> Generation:
        """Make the next generation of what an agent is being trained, and train on.

        It is saved and kept, given to the teammates, who perform it, and evaluated. Then the
        training goes on with the same examples, in the configuration that is named.

        Args:
            agent: that is trained.
            to: its teammates; by default all others of its domain.
            note: to keep.
            evaluation: how to evaluate it.
            configuration: in which the training goes on; None: that of the last generation.

        Raises:
            SwarmError: naming what is wrong. Unless it says otherwise nothing has changed.
        """
        with held(self._run_folder):
            training = training_of(self._swarm, agent)
            known = self._known(agent, training.name)
            last = known.get(known.current).restart if known.current else Configuration()
            chosen = last if configuration is None else configuration
            chosen.check(self._world)
            mates = mates_of(self._swarm, agent, to)
            with standing_still(self._world) as before:
                with contextlib.ExitStack() as stack:
                    with not_interrupted():
                        saved = self._swarm.save(agent, keep_unused=True)
                        stack.enter_context(self._training_goes_on(agent, training))
                        made = Generation(
                            number=max((g.number for g in known.all), default=0) + 1,
                            parent=known.current,
                            version=self._swarm.behavior(agent, training.name).version,
                            digest=saved.digest,
                            at=time_now(),
                            by=self._who,
                            examples=len(training.examples),
                            arguments=training.arguments,
                            note=note,
                            unscored="it was interrupted",
                            restart=chosen,
                        )
                        known = known.with_(made, current=made.number)
                        known.keep_texts(made.number, self._copies.present(agent, training.name))
                        known.keep()
                        self._say(
                            f"generation {made.number} of {training.name}: saved as version "
                            f"{made.version} with {quantity(made.examples, 'example')}"
                        )
                    known = self._give(known, made.number, mates, evaluation)
                self._restart(known, chosen, before)
            return known.get(made.number)

    def back(
        self,
        agent: str,
        behavior: str,
        number: int,
        *,
        to: Sequence[str] = (),
        discard: bool = False,
        evaluation: Evaluation = SHORT,
        configuration: Configuration | None = None,
    ) -> Generation:
        """Go back to a generation: agent and team have it, and the training goes on from it.

        It becomes the next version in the libraries. A generation without a score is evaluated.

        Args:
            agent: that is trained.
            behavior: that is trained.
            number: of the generation.
            to: the teammates; by default all others of the agent's domain.
            discard: give up examples that are in no generation.
            evaluation: how to evaluate it, if it has no score yet.
            configuration: in which the training goes on; None: that of the generation.

        Raises:
            SwarmError: naming what is wrong. Unless it says otherwise nothing has changed.
        """
        with held(self._run_folder):
            self._swarm.await_agent(agent)
            known = self._known(agent, behavior)
            meant = known.get(number)
            known.texts(number)  # which may be damaged
            chosen = configuration if configuration is not None else meant.restart
            chosen.check(self._world)
            mates = mates_of(self._swarm, agent, to)
            if not discard:
                refuse_unsaved(self._swarm, agent)
            with standing_still(self._world) as before:
                with not_interrupted():
                    versions = (*meant.restored, self._bring_back(known, number))
                    known = known.with_(meant.but(restored=versions), current=number).keep()
                saved = replace(self._swarm.behavior(agent, behavior), arguments=meant.arguments)
                with self._training_goes_on(agent, saved, replaces=True):
                    known = self._give(known, number, mates, evaluation)
                self._restart(known, chosen, before)
            return known.get(number)

    # -- what is there ----------------------------------------------------------------------

    def _known(self, agent: str, behavior: str) -> Generations:
        return read_generations(folder_of(self._run_folder, agent), agent, behavior)

    # -- doing it ---------------------------------------------------------------------------

    @contextlib.contextmanager
    def _training_goes_on(
        self, agent: str, training: Learned, *, replaces: bool = False
    ) -> Iterator[None]:
        """Resume a training that was saved, whatever happens meanwhile.

        Args:
            agent: that is trained.
            training: what to resume.
            replaces: whether it takes the place of one that is under way.
        """
        try:
            yield
        except BaseException:
            with not_interrupted():
                try:
                    self._resume(agent, training, replaces)
                except SwarmError as another:
                    self._say(str(another))
                    self.left += f"; {another}"
            raise
        with not_interrupted():
            self._resume(agent, training, replaces)

    def _resume(self, agent: str, training: Learned, replaces: bool) -> None:
        try:
            answer = self._swarm.begin(
                agent,
                training.name,
                features=list(training.features),
                states=list(training.chosen),
                parameters=list(training.parameters) if training.arguments else [],
                arguments=list(training.arguments),
                resume=training.name,
                classifier=training.classifier,
                discard=replaces,
            )
        except SwarmError as error:
            raise SwarmError(
                f"the training could not go on by itself: {error.problem}",
                Fix.TRAIN_FURTHER(agent=agent, behavior=training.name),
                *error.remedies,
            ) from None
        self._say(f"{agent}: {answer.message}")

    def _give(
        self, known: Generations, number: int, mates: Sequence[str], evaluation: Evaluation
    ) -> Generations:
        """Give a generation to the teammates, have all perform it, and evaluate it."""
        made = known.get(number)
        agent, behavior = known.agent, known.behavior
        rest = Fix.GO_BACK(agent=agent, behavior=behavior, generation=number)
        self.left = f"generation {number} is kept, but not given to all of the team; {rest}"
        report = DistributionReport()
        if mates:
            report = self._swarm.distribute(
                agent,
                behavior,
                arguments=made.arguments,
                receivers=mates,
                start=True,
                seconds=self._patience,
                progress=lambda done, total: self._progress(done, total, "distributing"),
            )
        missing = report.missing
        made = made.but(team=tuple(report.accepted), missing=missing)
        if missing:
            made = made.but(unscored="it is not performed by all of the team")
            known.with_(made).keep()
            raise SwarmError(
                "\n".join(f"{name} {why}" for name, why in missing.items())
                + f"\ngeneration {number} of {behavior} is kept, but without a score, since "
                f"{some(sorted(missing))} of the team lack it; mend that first",
                rest,
            )
        known = known.with_(made).keep()
        self.left = f"generation {number} is kept and the team has it, but it has no score; {rest}"
        self._swarm.perform(agent, behavior, made.arguments)
        if mates:
            self._say(f"{some(mates, most=3)} perform{'s' * (len(mates) == 1)} it")
        return self._scored(known, made, evaluation)

    def _scored(self, known: Generations, made: Generation, evaluation: Evaluation) -> Generations:
        if made.score is not None:
            return known
        score, why = None, ""
        if self._world is None:
            why = "there is no world to play in"
        elif not evaluation.episodes:
            why = "no episodes were asked for"
        else:

            def progress(done: int) -> None:
                self._progress(done, evaluation.episodes, "evaluating")

            score = evaluated(self._world, evaluation, self._say, progress)
        told = f"generation {made.number} has no score: {why}"
        if score is not None:
            played = f"{quantity(score.episodes, 'episode')}, seed {score.seed}"
            told = f"generation {made.number}: {score.figures[LENGTH]} s an episode ({played})"
        self._say(told)
        return known.with_(made.but(score=score, unscored=why)).keep()

    def _bring_back(self, known: Generations, number: int) -> int:
        """Give a generation back to the trained agent, as a new version; return its number."""
        agent, behavior, texts = known.agent, known.behavior, dict(known.texts(number))
        versions = [version for g in known.all for version in (g.version, *g.restored)]
        with contextlib.suppress(SwarmError):  # it was deleted, or is damaged
            versions += self._swarm.behavior(agent, behavior).versions
        texts[behavior] = reissued(
            texts[behavior],
            behavior,
            version=max(versions) + 1,
            created=time_now(),
            author=self._who,
            earlier=content_of(texts[behavior], behavior)["checksum"],
            note=f"generation {number} restored",
        )
        self._copies.send(agent, behavior, texts)
        self._say(
            f"{agent} has generation {number} of {behavior} again, as version {max(versions) + 1}"
        )
        return max(versions) + 1

    def _restart(
        self, known: Generations, chosen: Configuration, before: WorldStatus | None
    ) -> None:
        """Put the world into the configuration, or wait for it; then the demonstrator decides."""
        agent = known.agent
        self.left = (
            f"generation {known.current} is complete and {agent} is in training mode; only the "
            "situation in which the training was to go on has not come about"
        )
        if self._world is not None and chosen.places:
            chosen.put(self._world)
            self._say(f"the training goes on from: {chosen.but(wait=None)}")
        if chosen.wait is not None:
            self._say(f"waiting until {chosen.wait.describe()} ...")
            in_real_time = before is not None and before.pace == WorldStatus.REALTIME
            factor = before.factor if before is not None and in_real_time else 0.0
            chosen.await_(
                self._swarm,
                self._world,
                agent,
                factor,
                lambda seen: self._progress(0, 0, f"waiting: {seen}"),
            )
