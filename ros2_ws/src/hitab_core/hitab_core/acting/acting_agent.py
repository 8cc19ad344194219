"""An agent as it perceives and acts: percepts, ticks, breakpoints, and the way back in time."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path

from hitab_core.acting.breakpoints import Breakpoint, Breakpoints
from hitab_core.acting.course import Course
from hitab_core.acting.draws import Draws
from hitab_core.advice.confidence import FAR
from hitab_core.agent_library import AgentLibrary
from hitab_core.assistant.caution import CautionMonitor, WhenUnsure
from hitab_core.domain import Domain
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.running.mode import Mode
from hitab_core.running.run_context import Clock, Running
from hitab_core.running.seeding import agent_seed
from hitab_core.term import Term
from hitab_core.training_session import TrainingSession


class ActingAgent(AgentLibrary):
    """What of an agent takes percepts and acts on them; `Agent` adds what is done to it.

    Attributes:
        body: the body, made by the domain.
        cycle: the world's cycle, in the last percept.
        monitor: judges whether decisions are sure, and holds the agent's caution.
        breakpoints: where it holds its world; a robot's agent only says so.
        course: what it performed in the last minute.
    """

    def __init__(
        self,
        name: str,
        domain: Domain,
        library: BehaviorLibrary,
        journal_folder: Path | None,
        without: Collection[str],
        seed: int,
    ) -> None:
        super().__init__(name, domain, library, journal_folder, without)
        self.body = domain.body(name)
        self.cycle = 0
        self._episode_since = 0
        self._shown_again = False  # the world shows its cycle again, but nothing was changed
        self._draws = Draws(agent_seed(seed, 0, name))
        self.clock = Clock()
        self.monitor = CautionMonitor()
        self.breakpoints = Breakpoints(keeps=bool(domain.link))
        self.course = Course(self.clock, self._draws)

    def _stop(self) -> None:
        self.monitor.forget()
        running = self.running
        if running is not None:
            running.stop()

    def hand_back(self) -> None:
        """End a test or a performance, since the agent is unsure."""
        raise NotImplementedError

    @property
    def draws(self) -> int:
        """How many random numbers it has drawn."""
        return self._draws.count

    @property
    def held(self) -> str:
        """The breakpoint at which it holds its world before it acts; empty if it does not."""
        met = self.breakpoints.held
        return f"{self.name}: {met}" if met else ""

    @property
    def running(self) -> Running | None:
        """The performed behavior, which may be in training, or None."""
        return self._performed if self.trained is None else self.trained.running

    @property
    def active_path(self) -> list[str]:
        """Labels of the active states, outermost first."""
        running = self.running
        return running.active_path if running is not None else []

    @property
    def trained(self) -> TrainingSession | None:
        """The training, unless it waits while something else is performed."""
        mode = self.mode  # `is` is much faster than a comparison of texts
        return self.session if mode is Mode.TRAINING or mode is Mode.TESTING else None

    @property
    def _performed(self) -> Running | None:
        return self._performance if self.mode is Mode.PERFORMING else None

    @property
    def _performs(self) -> Term | None:
        return self.top if self.mode is Mode.PERFORMING else None

    def sense(
        self,
        values: Sequence[float],
        heard: Sequence[str],
        cycle: int = 0,
        time: float = 0.0,
        *,
        jumped: bool = False,
    ) -> None:
        """Take a percept.

        Args:
            values: values in the layout of the domain.
            heard: the messages heard.
            cycle: the world's cycle.
            time: simulated time, or the robot's time, s.
            jumped: whether the situation does not follow from the last one, as when something was
                placed.
        """
        jumped, self._shown_again = jumped and not self._shown_again, False
        if cycle < self.cycle:
            self._episode_since = cycle  # the world counts from its beginning again
        self.cycle = cycle
        self.context.clock.now = time
        self.body.sense(values, heard)
        self.context.feature_cache.forget()
        self.course.note(cycle, self.running, self._performs)
        if self.session is not None and (session := self.trained) is not None:
            session.perceive(cycle, time, jumped=jumped)

    def restart(self, seed: int, episode: int) -> None:
        """Begin an episode: reseed the agent's random numbers, put the behavior in Start."""
        self._episode_since = self.cycle
        self._draws.seed(agent_seed(seed, episode, self.name))
        self.breakpoints.forget()
        if self.trained is not None:
            self.trained.restart()
        elif self._performed is not None:
            self._performed.stop()
            self._performed.start()
        self.course.forget()
        self.course.note(self.cycle, self.running, self._performs)

    def go_back(self, cycle: int) -> None:
        """Be in the states in which the agent met the percept of an earlier cycle.

        The percept itself follows. Timers, flags and random numbers are those of then, percepts
        from then on are forgotten, and a training's examples stay. What is trained, if that began
        later, is in Start, and so is what is performed, if the library has changed since. A body
        that remembers more than its last percept is not restored.
        """
        if self.session is not None and (session := self.trained) is not None:
            session.go_back(cycle)
        self.monitor.forget()
        if cycle != self.cycle:  # else the breakpoint that it holds at would hold it for ever
            self.breakpoints.forget()
        self.cycle, self._shown_again = cycle, True
        moment, running = self.course.back(cycle), self.running
        if running is None:
            return
        if moment is not None and moment.running is not running:
            term = moment.term
            if term is None or self._performances.get(term) is not moment.running:
                moment = None
            else:
                running.stop()
                self.top, self._performance = term, moment.running
        if moment is None:
            running.stop()
            running.start()
        else:
            moment.running.restore(moment.memento)
            self._draws.back(moment.draws)

    def tick(self) -> None:
        """Perform one timestep on the last percept.

        Raises:
            FeatureValueError: if a feature that a decision needs has no value.
        """
        trained = None if self.mode is Mode.PERFORMING else self.trained
        active = self._performed if trained is None else trained
        if active is None:
            self.breakpoints.forget()
            return
        if self.breakpoints.set and self._holds():
            return
        if self.mode is Mode.TRAINING or not self.monitor.judges:
            active.tick()
            return
        examples = () if trained is None else trained.examples
        sure = self.monitor.watch(active.tick, self.running, self.context, examples)
        if not sure and self.monitor.caution.when_unsure is WhenUnsure.HAND_BACK:
            self.hand_back()

    def _holds(self) -> bool:
        """Return whether the world has to hold before the agent acts."""
        decides = self.mode is not Mode.TRAINING
        met = self.breakpoints.look(self.running, self._draws, self._doubt, decides=decides)
        self._shown_again = met and not self.domain.link
        return self._shown_again

    def _doubt(self) -> str:
        trained, distance = self.trained, self.monitor.caution.distance or FAR
        if trained is not None and self.mode is Mode.TRAINING:
            return trained.preview.now().unsure
        examples = () if trained is None else trained.examples
        return self.monitor.doubts(self.running, self.context, examples, distance)

    def break_at(self, texts: Sequence[str]) -> None:
        """Set the breakpoints; these replace earlier ones.

        Raises:
            VocabularyError: if one names no behavior.
        """
        self.breakpoints.set = tuple(Breakpoint.parse(one, self.repertoire) for one in texts)
        self.breakpoints.forget()
