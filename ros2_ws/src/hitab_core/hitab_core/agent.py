"""One agent without its robot or middleware: its library, behavior and training.

A node (`hitab_agent.node.agent_node`) passes in percepts and a demonstrator's commands and
publishes the actions. Errors that a user can fix raise `HitabError` and leave the agent unchanged.
"""

from __future__ import annotations

from collections.abc import Collection
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from hitab_core.acting.acting_agent import ActingAgent
from hitab_core.advice.remarks import Remark
from hitab_core.assistant.people import texts_of
from hitab_core.automaton import FLAGS
from hitab_core.domain import Domain
from hitab_core.example import Example
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.running.feature_cache import NO_PERCEPT_YET, FeatureCache
from hitab_core.running.mode import Mode
from hitab_core.running.observing import Observe
from hitab_core.running.run_context import RunContext
from hitab_core.term import Term
from hitab_core.texts.errors import FeatureValueError, HitabError, TrainingError
from hitab_core.texts.remedies import Fix
from hitab_core.texts.wording import quantity
from hitab_core.training.curriculum import Curriculum
from hitab_core.training.events import NOW, Given
from hitab_core.training.operation import Operation, Outcome
from hitab_core.training_session import TrainingSession


class Agent(ActingAgent):
    """An agent: a body, a repertoire and, at any time, one top-level behavior or one training.

    A training and its examples are kept while the agent performs something else and, given a
    journal folder, across restarts of the process.

    Attributes:
        mode: whether the demonstrator or the agent decides, or neither.
    """

    def __init__(
        self,
        name: str,
        domain: Domain,
        library: BehaviorLibrary,
        journal_folder: Path | None = None,
        *,
        seed: int = 0,
        most_probable: bool = False,
        observe: Observe | None = None,
        without: Collection[str] = (),
    ) -> None:
        """Load the library and resume an interrupted training from the journal.

        Behaviors that cannot be used, and a training that cannot be resumed, are `faults`.

        Args:
            name: name of the agent.
            domain: the robot's domain, which makes the body.
            library: library of its behaviors.
            journal_folder: folder of the training journal; None to keep no journal.
            seed: seed of the agent's random numbers.
            most_probable, observe: see `RunContext`.
            without: assistants to leave out of trainings, by name (`ASSISTANTS`).

        Raises:
            FolderInUseError: if another process uses the journal, or keeps the library locked.
        """
        super().__init__(name, domain, library, journal_folder, without, seed)
        self.context = RunContext(
            self.loaded.repertoire,
            self.body,
            FeatureCache(self.body, domain),
            self._draws,
            most_probable,
            observe,
            self.clock,
            self.monitor.number_range,
        )
        self.session = self._resumed()
        if self.session is not None:
            self.mode = Mode.TRAINING

    @property
    def behavior(self) -> str:
        """The top-level behavior, or the automaton being trained; empty if idle."""
        if self.trained is not None:
            return self.trained.curriculum.name
        return "" if self.mode is Mode.IDLE or self.top is None else str(self.top)

    def remarks(self, *, look: bool = False) -> list[Remark]:
        """Return signs that the training does not play; see `TrainingSession.remarks`."""
        found = [] if self.session is None else self.session.remarks(look=look)
        return [remark.of(self.name) for remark in found]

    @property
    def raised(self) -> frozenset[str]:
        """The flags that the top-level behavior has raised and that are still up."""
        running = self.running
        return frozenset() if running is None else frozenset(running.raised)

    # -- operations -------------------------------------------------------------------------

    def do(self, operation: Operation) -> Outcome:
        """Carry out an operation, or return its outcome if it was done before.

        A refused one is not kept: sent again, it may succeed.

        Raises:
            HitabError: if it is refused; nothing has changed.
        """
        done: Outcome | None = self.outcomes.get(operation.id)
        if done is not None:
            return done
        with self.journal.recording(operation):
            try:
                outcome = operation.apply(self)
            except Exception as error:
                if isinstance(error, HitabError):
                    error.remedies = tuple(remedy.of(self.name) for remedy in error.remedies)
                if self.journal.recorded:
                    self.outcomes.keep(operation.id, Outcome(f"recorded, but then: {error}"))
                raise
        self.outcomes.keep(operation.id, outcome)
        return outcome

    # -- performing -------------------------------------------------------------------------

    def perform(self, term: Term | None) -> None:
        """Perform a behavior as the top-level one, from Start; None to become idle.

        If it cannot be begun, the agent is idle.

        Raises:
            VocabularyError: if there is no such behavior or target.
            TrainingError: if it is being trained and not saved yet.
            FeatureValueError: if it cannot be begun before the first percept.
        """
        if term is not None:
            self.check_saved(term.name)
        performed = None if term is None else self._prepared(term)
        self.pending_behavior = None
        self._stop()
        if self.session is not None:
            self.session.leave()
        self.top = term
        self._performance = performed
        self.mode = Mode.IDLE if performed is None else Mode.PERFORMING
        if performed is None:
            return
        try:
            with self.context.feature_cache.blind_unless_perceived():
                performed.start()
        except Exception:
            with suppress(Exception):
                performed.stop()
            self.top, self._performance, self.mode = None, None, Mode.IDLE
            raise

    def _stop(self) -> None:
        self.monitor.forget()
        running = self.running
        if running is not None:
            running.stop()

    # -- training ---------------------------------------------------------------------------

    def begin(
        self, curriculum: Curriculum, *, resume: str = "", discard: bool = False
    ) -> TrainingSession:
        """Begin to train an automaton, in Start.

        Args:
            curriculum: the automaton to train; without features, use those chosen for ``resume``.
            resume: a trained behavior whose examples to continue from, or a version of it, such as
                ``Chase@2``.
            discard: discard an unsaved training.

        Raises:
            TrainingError: if there is an unsaved training, or ``resume`` has no examples.
            VocabularyError: if the curriculum names an unknown word.
        """
        if self.unsaved and not discard:
            raise TrainingError(
                f'"{self.training}" has {quantity(self.unsaved, "unsaved example")}',
                Fix.SAVE(agent=self.name),
                Fix.DISCARD(agent=self.name),
            )
        if self.journal.damage and not discard:
            raise TrainingError(self.journal.damage, Fix.DISCARD(agent=self.name))
        curriculum, examples = self._continued(curriculum, resume)
        session = TrainingSession(
            self.context,
            curriculum,
            examples,
            self.journal.write,
            people=self.people,
            without=self._without,
        )
        self.journal.begin(curriculum, examples, session.history.readable)
        self._stop()
        self.session = session
        self.mode = Mode.TRAINING
        self.pending_behavior = None
        return session

    def command(
        self, term: Term, given: Given = NOW, *, unrecorded: bool = False
    ) -> list[Example]:
        """Obey a demonstrator; see `TrainingSession.command`.

        Args:
            term: the behavior to perform, or a flag.
            given: who gives the command, and when it was due; the cycle is set here.
            unrecorded: perform it without recording an example.

        Raises:
            TrainingError: if the agent is not in training mode, or if the demonstrator saw an
                earlier episode.
            FeatureValueError: if it has perceived nothing yet.
        """
        session = self.under_way()
        if self.mode in (Mode.IDLE, Mode.PERFORMING):
            raise TrainingError(
                f'it is {self.mode}, and the training of "{self.training}" waits',
                Fix.RESUME(agent=self.name),
            )
        if self.mode is Mode.TESTING:
            raise TrainingError(f'"{self.training}" is being tested', Fix.RESUME(agent=self.name))
        if 0 < given.seen < self._episode_since:
            raise TrainingError(
                f"the command was for cycle {given.seen}, but a new episode has begun in cycle "
                f"{self._episode_since}; command what is right in the new episode"
            )
        given = replace(given, cycle=self.cycle)
        if session.history.latest is None:
            given = replace(given, seen=0)  # nothing has changed since training began
        if self.awaits_percept:
            raise FeatureValueError(NO_PERCEPT_YET)
        with self.context.feature_cache.blind_unless_perceived():
            if unrecorded:
                return session.bring_into(term)
            return session.command(term, given)

    @property
    def awaits_percept(self) -> bool:
        """Whether a command has to wait for the first percept, which its examples need."""
        chosen = () if self.session is None else self.session.curriculum.features
        return not self.context.feature_cache.perceived and any(
            f.name not in FLAGS for f in chosen
        )

    def test(self, *, restart: bool = False) -> None:
        """Learn from the examples and give control to the learned automaton.

        Raises:
            TrainingError: if there is no training, or no example leaves Start.
        """
        self.under_way().test(restart=restart)
        self._go_on(Mode.TESTING)

    def take_over(self) -> None:
        """Give control to the demonstrator, at the active state.

        Raises:
            TrainingError: if there is no training.
        """
        self.under_way().take_over()
        self._go_on(Mode.TRAINING)

    def hand_back(self) -> None:
        """End a test or a performance, since the agent is unsure."""
        if self.mode is Mode.TESTING:
            self.take_over()
        else:
            self.perform(None)

    def _go_on(self, mode: Mode) -> None:
        if self.trained is None:
            self._stop()
            self.under_way().restart()
        self.mode = mode

    def discard(self) -> None:
        """Give up the training under way and perform nothing.

        Raises:
            TrainingError: if there is none.
            LibraryError: if its journal cannot be archived; nothing has changed.
        """
        if self.session is None and not self.journal.damage:
            raise TrainingError("it has no training to discard")
        self.journal.people.update(texts_of(self.people))
        self.journal.discard()
        self._stop()
        self.session = self.top = self._performance = None
        self.mode = Mode.IDLE
