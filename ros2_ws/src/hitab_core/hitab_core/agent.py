"""One agent without its robot or middleware: its library, behavior and training.

A node (`hitab_agent.agent_node`) passes in percepts and a demonstrator's commands and publishes
the actions. Errors that a user can fix raise `HitabError` and leave the agent unchanged.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import NamedTuple

from hitab_core.advice.remarks import Remark
from hitab_core.automaton import FLAGS
from hitab_core.caution import CautionMonitor, WhenUnsure
from hitab_core.domain import Domain
from hitab_core.errors import (
    FeatureValueError,
    FolderInUseError,
    LibraryError,
    LostBehaviorError,
    TrainingError,
    VocabularyError,
)
from hitab_core.example import Example
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.library.change import refused_name
from hitab_core.library.contents import LostBehaviors
from hitab_core.library.loaded_library import LoadedLibrary
from hitab_core.library.provenance import Provenance
from hitab_core.remedies import Fix, Remedy
from hitab_core.repertoire import Repertoire
from hitab_core.running.feature_cache import NO_PERCEPT_YET, FeatureCache
from hitab_core.running.observing import Observe
from hitab_core.running.run_context import RunContext, Running
from hitab_core.running.running_automaton import performance
from hitab_core.saving import SavedBehavior, loaded_with, to_be_saved
from hitab_core.seeding import agent_seed
from hitab_core.training.curriculum import Curriculum
from hitab_core.training.people_file import read_people, write_people
from hitab_core.training.recent_percepts import KEPT_SECONDS
from hitab_core.training.resuming import resumed
from hitab_core.training.training_journal import TrainingJournal
from hitab_core.training.training_session import Request, TrainingSession
from hitab_core.use import Use
from hitab_core.wording import quantity


class Mode(StrEnum):
    """Modes of an agent, by the source of its decisions."""

    IDLE = "idle"
    PERFORMING = "performing"
    TRAINING = "training"
    TESTING = "testing"


class _State(NamedTuple):
    """The next state of an agent: its library, its context and an unstarted behavior."""

    loaded: LoadedLibrary
    context: RunContext
    use: Use | None
    performance: Running | None


class Agent:
    """An agent: a body, a repertoire and, at any time, one top-level behavior or one training.

    A training and its examples are kept while the agent performs something else and, given a
    journal folder, across restarts of the process.

    Attributes:
        context: shared by all performed behaviors.
        monitor: of unsure decisions: the response, and why the next decision is unsure.
        pending_behavior: started as soon as its file is usable again; None if nothing waits.
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
    ) -> None:
        """Load the library and resume an interrupted training from the journal.

        Behaviors that cannot be used, and a training that cannot be resumed, are `faults`.

        Raises:
            FolderInUseError: if another process uses the journal, or keeps the library locked.
        """
        self.name = name
        self.domain = domain
        self.library = library
        self.body = domain.body(name)
        self.cycle = 0
        self._episode_since = 0
        self.mode = Mode.IDLE
        self.top: Use | None = None
        self.pending_behavior: Use | None = None
        self._random = random.Random(agent_seed(seed, 0, name))
        self._latest_saved = ""
        self.monitor = CautionMonitor()
        self._performance: Running | None = None
        self._performances: dict[Use, Running] = {}
        self.loaded = _first_loaded(library)
        self.context = RunContext(
            self.loaded.repertoire,
            self.body,
            FeatureCache(self.body, domain),
            self._random.random,
            most_probable,
            observe,
            number_range=self.monitor.number_range,
        )
        self.journal = TrainingJournal(journal_folder, domain.name)
        self._folder = journal_folder
        self.people = read_people(journal_folder)
        self.session = self._resumed()
        if self.session is not None:
            self.mode = Mode.TRAINING

    # -- its library ------------------------------------------------------------------------

    def _resumed(self) -> TrainingSession | None:
        return self.journal.resume(self.context, self.library.has_saved, self.people)

    @property
    def repertoire(self) -> Repertoire:
        """All behaviors that the agent can perform."""
        return self.context.repertoire

    @property
    def faults(self) -> tuple[str, ...]:
        """Lost behaviors, and an interrupted training, as sentences."""
        damage = self.journal.damage
        return (*self.loaded.losses.faults, *([damage] if damage else ()))

    @property
    def remedies(self) -> tuple[Remedy, ...]:
        """Remedies for `faults`, and for anything missing in the repertoire."""
        damaged = [Fix.DISCARD(agent=self.name)] if self.journal.damage else []
        return (*self.loaded.losses.ways_out, *damaged)

    @property
    def active_path(self) -> list[str]:
        """Labels of the active states, outermost first."""
        running = self.running
        return running.active_path if running is not None else []

    @property
    def behavior(self) -> str:
        """The top-level behavior, or the automaton being trained; empty if idle."""
        if self._trained is not None:
            return self._trained.curriculum.name
        return "" if self.mode is Mode.IDLE or self.top is None else str(self.top)

    @property
    def training(self) -> str:
        """The automaton of the training under way, whatever it does meanwhile; empty if none."""
        return "" if self.session is None else self.session.curriculum.name

    @property
    def unsaved(self) -> int:
        """The number of examples of the training under way."""
        return 0 if self.session is None else len(self.session.log)

    def remarks(self, *, look: bool = False) -> list[Remark]:
        """Return signs that the training does not play; see `TrainingSession.remarks`."""
        found = [] if self.session is None else self.session.remarks(look=look)
        return [remark.of(self.name) for remark in found]

    @property
    def raised(self) -> frozenset[str]:
        """The flags that the top-level behavior has raised and that are still up."""
        running = self.running
        return frozenset() if running is None else frozenset(running.raised)

    @property
    def running(self) -> Running | None:
        """The performed behavior, which may be in training, or None."""
        return self._performed if self._trained is None else self._trained.running

    @property
    def _trained(self) -> TrainingSession | None:
        """The training, unless it waits while something else is performed."""
        return self.session if self.mode in (Mode.TRAINING, Mode.TESTING) else None

    @property
    def _performed(self) -> Running | None:
        return self._performance if self.mode is Mode.PERFORMING else None

    # -- perceiving and acting --------------------------------------------------------------

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
            values: in the layout of the domain.
            heard: the messages heard.
            cycle: of the world.
            time: simulated, or the robot's, s.
            jumped: whether the situation does not follow from the last one, as when something was
                placed.
        """
        if cycle < self.cycle:
            self._episode_since = cycle  # the world counts from its beginning again
        self.cycle = cycle
        self.context.clock.now = time
        self.body.sense(values, heard)
        self.context.feature_cache.forget()
        if (session := self._trained) is not None:
            session.perception.keep(session.running, cycle, time, jumped=jumped)

    def restart(self, seed: int, episode: int) -> None:
        """Begin an episode: reseed the agent's random numbers, put the behavior in Start."""
        self._episode_since = self.cycle
        self._random.seed(agent_seed(seed, episode, self.name))
        if self._trained is not None:
            self._trained.restart()
        elif self._performed is not None:
            self._performed.stop()
            self._performed.start()

    def tick(self) -> None:
        """Perform one timestep on the last percept.

        Raises:
            FeatureValueError: if a feature that a decision needs has no value.
        """
        active = self._trained or self._performed
        if active is None:
            return
        if self.mode is Mode.TRAINING:
            active.tick()
            return
        examples = () if self._trained is None else self._trained.examples
        if not self.monitor.watch(active.tick, self.running, self.context, examples):
            self._hand_back()

    def _hand_back(self) -> None:
        """Hand back if the agent's caution says so."""
        if self.monitor.caution.when_unsure is not WhenUnsure.HAND_BACK:
            return
        if self.mode is Mode.TESTING:
            self.take_over()
        else:
            self.perform(None)

    # -- performing -------------------------------------------------------------------------

    def check_saved(self, name: str) -> None:
        """Check that a behavior is not one that is being trained and was never saved.

        Raises:
            TrainingError: saying how to save it.
        """
        if name == self.training and name not in self.repertoire:
            raise TrainingError(
                f'"{name}" is being trained and not saved yet', Fix.SAVE(agent=self.name)
            )

    def perform(self, use: Use | None) -> None:
        """Perform a behavior as the top-level one, from Start; None to become idle.

        If it cannot be begun, the agent is idle.

        Raises:
            VocabularyError: if there is no such behavior or target.
            TrainingError: if it is being trained and not saved yet.
            FeatureValueError: if it cannot be begun before the first percept.
        """
        if use is not None:
            self.check_saved(use.name)
        performed = None if use is None else self._prepared(use)
        self.pending_behavior = None
        self._stop()
        if self.session is not None:
            self.session.leave()
        self.top = use
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

    def _prepared(self, use: Use) -> Running:
        """Return the performer of a behavior, cached because orders repeat."""
        performed = self._performances.get(use)
        if performed is None:
            self.repertoire.check_performable(use)
            performed = self._performances[use] = performance(self.context, use)
        return performed

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
            curriculum: what to train; without features, use those chosen for ``resume``.
            resume: a trained behavior whose examples to continue from, or a version of it, such as
                ``Chase@2``.
            discard: give up a training that has not been saved.

        Raises:
            TrainingError: if there is an unsaved training, or ``resume`` has no examples.
            VocabularyError: if the curriculum names what does not exist.
        """
        if self.unsaved and not discard:
            raise TrainingError(
                f'"{self.training}" has {quantity(self.unsaved, "unsaved example")}',
                Fix.SAVE(agent=self.name),
                Fix.DISCARD(agent=self.name),
            )
        if self.journal.damage and not discard:
            raise TrainingError(self.journal.damage, Fix.DISCARD(agent=self.name))
        earlier, _, version = resume.partition("@")
        name = curriculum.name or earlier
        if name in self.loaded.losses.reasons:
            losses = self.loaded.losses
            raise LostBehaviorError(refused_name(name, "trained", losses), *losses.remedies[name])
        examples: tuple[Example, ...] = ()
        if resume:
            of = (
                self.library.on_disk.version(earlier, int(version)).automaton
                if version.isdecimal()
                else self.repertoire.get(resume)
            )
            curriculum, examples = resumed(curriculum, of, self.repertoire)
        session = TrainingSession(
            self.context, curriculum, examples, self.journal.write, people=self.people
        )
        self.journal.begin(curriculum, examples, session.perception.readable)
        self._stop()
        self.session = session
        self.mode = Mode.TRAINING
        self.pending_behavior = None
        return session

    def command(
        self,
        use: Use,
        *,
        ago: float = 0.0,
        seen: int = 0,
        pace: float = 0.0,
        unrecorded: bool = False,
        request: Request | None = None,
    ) -> list[Example]:
        """Obey a demonstrator; see `TrainingSession.command`.

        Args:
            use: what to perform, or a flag.
            ago: how long before what the demonstrator saw it was due, s of simulated time.
            seen: the world's cycle that the demonstrator saw; 0 for that of the last percept.
            pace: simulated seconds in a second of the demonstrator; 0 if the situation has waited.
            unrecorded: only perform it; no example is recorded.
            request: who commands it and with which number.

        Raises:
            TrainingError: if the agent is not in training mode, or if the demonstrator saw an
                earlier episode.
            FeatureValueError: if it has perceived nothing yet.
        """
        session = self._session()
        if self.mode in (Mode.IDLE, Mode.PERFORMING):
            raise TrainingError(
                f'it is {self.mode}, and the training of "{self.training}" waits',
                Fix.RESUME(agent=self.name),
            )
        if self.mode is Mode.TESTING:
            raise TrainingError(f'"{self.training}" is being tested', Fix.RESUME(agent=self.name))
        if 0 < seen < self._episode_since:
            raise TrainingError(
                f"the command was for cycle {seen}, but a new episode has begun in cycle "
                f"{self._episode_since}; command what is right in the new episode"
            )
        if session.perception.moments.latest is None and 0.0 <= ago <= KEPT_SECONDS:
            ago, seen = 0.0, 0  # nothing has changed since the training began
        if self.awaits_percept:
            raise FeatureValueError(NO_PERCEPT_YET)
        with self.context.feature_cache.blind_unless_perceived():
            if unrecorded:
                return session.bring_into(use)
            return session.command(use, self.cycle, ago=ago, seen=seen, pace=pace, request=request)

    @property
    def awaits_percept(self) -> bool:
        """Whether a command has to wait for the first percept, which its examples need."""
        chosen = () if self.session is None else self.session.curriculum.features
        return not self.context.feature_cache.perceived and any(
            f.name not in FLAGS for f in chosen
        )

    def test(self, *, restart: bool = False) -> None:
        """Learn from the examples and give control to what was learned.

        Raises:
            TrainingError: if there is no training, or no example leaves Start.
        """
        self._session().test(restart=restart)
        self._go_on(Mode.TESTING)

    def take_over(self) -> None:
        """Give control to the demonstrator, at the active state.

        Raises:
            TrainingError: if there is no training.
        """
        self._session().take_over()
        self._go_on(Mode.TRAINING)

    def _go_on(self, mode: Mode) -> None:
        if self.mode not in (Mode.TRAINING, Mode.TESTING):
            self._stop()
            self._session().restart()
        self.mode = mode

    def save(
        self,
        name: str = "",
        bindings: Mapping[str, str] | None = None,
        description: str = "",
        *,
        keep_unused: bool = False,
        note: str = "",
    ) -> SavedBehavior:
        """Trim what was learned, add it to the library and end the training.

        Args:
            name: of the saved behavior; empty for the name that training began with.
            bindings: targets or parameters to replace, and their replacements.
            description: for people who browse the library; empty to keep the present one.
            keep_unused: keep features that no transition function uses yet, so that training can
                be resumed with them, as in behavior bootstrapping.
            note: on where it comes from, for its provenance.

        If the agent is performing another behavior that does not fit what is saved, saving wins;
        the agent becomes idle and the notes say so.

        Raises:
            TrainingError: if there is no training, or no example leaves Start.
            LibraryError: if it cannot be written; nothing has changed.
            VocabularyError: if it does not fit the repertoire; nothing has changed.
        """
        session = self._session(to_save=True)
        curriculum = session.curriculum
        self.repertoire.check_name(name or curriculum.name)
        automaton, notes = to_be_saved(
            session, name, bindings, description, keep_unused=keep_unused
        )
        then = self.top if self.mode is Mode.PERFORMING else None
        if self.mode is Mode.TESTING and automaton.parameters == curriculum.parameters:
            then = Use(automaton.name, curriculum.arguments)
        with self.library.change() as change:
            saved = change.save(
                automaton, curriculum.classifier, Provenance(agent=self.name, note=note)
            )
            loaded = loaded_with(saved, change, self.library, self.loaded)
            try:
                state = self._state(loaded, then)
            except VocabularyError as error:
                state = self._state(loaded, None)
                notes += [f'{self.name} is idle now; it cannot perform "{then}": {error}']
            # At the next start this marks a journal that was not archived as saved.
            record = {"do": "save", "automaton": saved.name, "checksum": saved.checksum}
            self.journal.write(record)
            change.commit()
        self.journal.archive()
        write_people(self._folder, self.people)
        self._latest_saved = saved.name
        notes += self._swap(state, self.library, ends_training=True)
        replaced = change.replaced(saved.name)
        return SavedBehavior(
            saved.automaton, self.library.on_disk.file(saved.name), notes, replaced
        )

    def discard(self) -> None:
        """Give up the training under way and perform nothing.

        Raises:
            TrainingError: if there is none.
            LibraryError: if its journal cannot be archived; nothing has changed.
        """
        if self.session is None and not self.journal.damage:
            raise TrainingError("it has no training to discard")
        self.journal.discard()
        write_people(self._folder, self.people)
        self._stop()
        self.session = self.top = self._performance = None
        self.mode = Mode.IDLE

    def _session(self, *, to_save: bool = False) -> TrainingSession:
        if self.session is None:
            refused = "nothing can be saved: " if to_save else ""
            if to_save and self._latest_saved:
                refused += f'"{self._latest_saved}" has been saved already, and '
            raise TrainingError(
                f"{refused}it is not training anything", Fix.TRAIN(agent=self.name)
            )
        return self.session

    # -- library ----------------------------------------------------------------------------

    def reload(self, library: BehaviorLibrary | None = None) -> list[str]:
        """Read the library again, or another one; restart what is being performed at Start.

        Returns:
            The names of the trained behaviors.

        Raises:
            LibraryError, VocabularyError: if something is lost there that was not lost before, or
                the active behavior or training does not fit; nothing has changed.
        """
        library = library or self.library
        loaded = library.loaded(strict=False)
        if loaded.losses.reasons.keys() - self.loaded.losses.reasons.keys():
            raise LibraryError(
                f"it keeps its present library: {'; '.join(loaded.losses.faults)}",
                *loaded.losses.ways_out,
            )
        self.take_up(loaded, library=library)
        return sorted(self.loaded.files)

    def take_up(
        self,
        loaded: LoadedLibrary,
        start: Use | None = None,
        library: BehaviorLibrary | None = None,
    ) -> list[str]:
        """Switch to a loaded library that is already on disk.

        Args:
            loaded: of its library.
            start: what to perform instead of the active behavior.
            library: that the loaded library comes from, if not the agent's own.

        Returns:
            Notes on what could not be stopped or started.

        Raises:
            VocabularyError: if the active behavior or training does not fit; nothing has changed.
        """
        state = self._state(loaded, self.check_fit(loaded, start))
        return self._swap(state, library or self.library)

    def check_fit(self, loaded: LoadedLibrary, start: Use | None = None) -> Use | None:
        """Check that the active behavior, or ``start``, and the training fit a loaded library.

        Returns:
            What to perform with it.

        Raises:
            VocabularyError: naming what does not fit, and the way out.
        """
        use = start or (self.top if self.mode is Mode.PERFORMING else None)
        if use is None and self.mode is Mode.IDLE and self.pending_behavior is not None:
            with suppress(VocabularyError):
                loaded.repertoire.check_performable(self.pending_behavior)
                use = self.pending_behavior
        losses = loaded.losses
        gone = sorted(losses.reasons.keys() & self.loaded.files.keys())
        kept = "it keeps its present library:"
        if gone:
            raise LostBehaviorError(
                f"{kept} {', '.join(gone)} would be lost: {'; '.join(losses.faults)}",
                *(remedy for name in gone for remedy in losses.remedies[name]),
            )
        try:
            if use is not None:
                loaded.repertoire.check_performable(use)
        except VocabularyError as error:
            raise VocabularyError(
                f'{kept} it could no longer perform "{use}": {error}; have it perform something '
                "else first, or nothing"
            ) from None
        try:
            if self.session is not None:
                self.session.check_on(loaded.repertoire)
        except VocabularyError as error:
            raise VocabularyError(
                f'{kept} the training of "{self.training}" could not continue: {error}; '
                "save it or discard it first"
            ) from None
        return use

    def _state(self, loaded: LoadedLibrary, use: Use | None) -> _State:
        """Return what the agent switches to; so far nothing is changed.

        Raises:
            VocabularyError: if it cannot be performed.
        """
        context = replace(self.context, repertoire=loaded.repertoire)
        if use is None:
            return _State(loaded, context, None, None)
        loaded.repertoire.check_performable(use)
        return _State(loaded, context, use, performance(context, use))

    def _swap(
        self, state: _State, library: BehaviorLibrary, *, ends_training: bool = False
    ) -> list[str]:
        """Switch to a prepared state. It is on disk already, so this must not fail."""
        notes = []
        try:
            self._stop()
        except Exception as error:  # a domain's code, a user's
            notes.append(f"what {self.name} performed could not be stopped: {error!r}")
        self.library, self.loaded, self.context = library, state.loaded, state.context
        self._performances.clear()
        self.top, self._performance = state.use, state.performance
        if ends_training:
            self.session = None
        if self.session is not None:
            self.session.rebuild(self.context)
        elif self.journal.damage:
            with suppress(LibraryError):  # it may fit again
                self.session = self._resumed()
        if state.performance is not None:
            assert state.use is not None
            self.pending_behavior = None
            self._performances[state.use] = state.performance
            self.mode = Mode.PERFORMING
            try:
                state.performance.start()
            except Exception as error:
                self.top = self._performance = None
                self.mode = Mode.IDLE
                notes.append(f'{self.name} is idle: "{state.use}" could not be begun: {error!r}')
        elif self.session is None or self.mode is Mode.PERFORMING:
            self.mode = Mode.IDLE
        return notes


def _first_loaded(library: BehaviorLibrary) -> LoadedLibrary:
    """Return what is sound in a library; nothing if its folder cannot be read."""
    try:
        return library.loaded(strict=False)
    except FolderInUseError:
        raise
    except LibraryError as error:
        return library.reader.of({}, LostBehaviors.of_unread(error.problem, library.domain))
