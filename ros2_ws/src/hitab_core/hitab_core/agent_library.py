"""The library of an agent, and how it changes: wholly or not at all.

A change is first prepared, which raises if it does not fit the active behavior or the training,
then made on disk, and last in the agent.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from hitab_core.assistant.lateness import Lateness
from hitab_core.assistant.people import people_from, texts_of
from hitab_core.domain import Domain
from hitab_core.example import Example
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.library.change import refused_name
from hitab_core.library.contents import LostBehaviors
from hitab_core.library.loaded_library import LoadedLibrary
from hitab_core.library.provenance import Provenance
from hitab_core.library.saving import SavedBehavior, loaded_with
from hitab_core.repertoire import Repertoire
from hitab_core.running.mode import Mode
from hitab_core.running.run_context import RunContext, Running
from hitab_core.running.running_automaton import performance
from hitab_core.term import Term
from hitab_core.texts.errors import (
    FolderInUseError,
    LibraryError,
    LostBehaviorError,
    TrainingError,
    VocabularyError,
)
from hitab_core.texts.remedies import Fix, Remedy
from hitab_core.training.curriculum import Curriculum
from hitab_core.training.operation import Outcome, Outcomes, Shipment
from hitab_core.training.resuming import resumed
from hitab_core.training.training_journal import SAVED, Record, TrainingJournal
from hitab_core.training_session import TrainingSession

_State = tuple[LoadedLibrary, RunContext, Term | None, Running | None]
"""The next state of an agent: its library, its context and an unstarted behavior."""


class AgentLibrary:
    """The part of an agent that concerns its library; `Agent` performs behaviors.

    Args:
        name: name of the agent.
        domain: domain of the agent.
        library: library of its behaviors.
        journal_folder: folder of the training journal; None to keep no journal.
        without: assistants to leave out of trainings, by name (`ASSISTANTS`).

    Raises:
        FolderInUseError: if another process keeps the library locked.

    Attributes:
        context: shared by all performed behaviors.
        loaded: the library as loaded.
        session: the training under way, whatever the agent does meanwhile; None if there is none.
        top: the performed top-level behavior.
        pending_behavior: started as soon as its file is usable again; None if nothing waits.
        people: delay of the commands of each demonstrator.
        outcomes: outcomes of the last operations, including those before a crash.
        stopped: why its robot may not act; empty if it may, or without one.
        open_library: function that opens the library in a folder.
        send: function that sends a behavior to other agents, and returns the number of that.
    """

    context: RunContext

    def __init__(
        self,
        name: str,
        domain: Domain,
        library: BehaviorLibrary,
        journal_folder: Path | None,
        without: Collection[str],
    ) -> None:
        self.name = name
        self.domain = domain
        self.library = library
        self.loaded = _first_loaded(library)
        self.journal = TrainingJournal(journal_folder, domain.name)
        self.people: dict[str, Lateness] = {}
        self.mode = Mode.IDLE
        self.session: TrainingSession | None = None
        self.top: Term | None = None
        self.pending_behavior: Term | None = None
        self._without = without
        self._latest_saved = ""
        self._performance: Running | None = None
        self._performances: dict[Term, Running] = {}
        self.outcomes = Outcomes()
        self.stopped = ""
        self.open_library: Callable[[Path, Domain], BehaviorLibrary] = BehaviorLibrary
        self.send: Callable[[Shipment], int] = _alone

    @property
    def repertoire(self) -> Repertoire:
        """All behaviors that the agent can perform."""
        return self.context.repertoire

    @property
    def training(self) -> str:
        """The automaton of the training under way, whatever it does meanwhile; empty if none."""
        return "" if self.session is None else self.session.curriculum.name

    @property
    def unsaved(self) -> int:
        """The number of examples of the training under way."""
        return 0 if self.session is None else len(self.session.log)

    def check_saved(self, name: str) -> None:
        """Check that a behavior is not one that is being trained and was never saved.

        Raises:
            TrainingError: saying how to save it.
        """
        if name == self.training and name not in self.repertoire:
            raise TrainingError(
                f'"{name}" is being trained and not saved yet', Fix.SAVE(agent=self.name)
            )

    def under_way(self, *, to_save: bool = False) -> TrainingSession:
        """Return the training under way.

        Raises:
            TrainingError: if there is none.
        """
        if self.session is None:
            refused = "nothing can be saved: " if to_save else ""
            if to_save and self._latest_saved:
                refused += f'"{self._latest_saved}" has been saved already, and '
            raise TrainingError(
                f"{refused}it is not training anything", Fix.TRAIN(agent=self.name)
            )
        return self.session

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

    def save(
        self,
        name: str = "",
        bindings: Mapping[str, str] | None = None,
        description: str = "",
        *,
        keep_unused: bool = False,
        note: str = "",
    ) -> SavedBehavior:
        """Trim the learned automaton, add it to the library and end the training.

        Args:
            name: name of the saved behavior; empty for the name that training began with.
            bindings: targets or parameters to replace, and their replacements.
            description: text for people who browse the library; empty to keep the present one.
            keep_unused: keep features that no transition function uses yet, so that training can
                be resumed with them, as in behavior bootstrapping.
            note: note on its origin, for the provenance.

        If the agent is performing a behavior that does not fit the saved one, saving wins;
        the agent becomes idle and the notes say so.

        Raises:
            TrainingError: if there is no training, or no example leaves Start.
            LibraryError: if it cannot be written; nothing has changed.
            VocabularyError: if it does not fit the repertoire; nothing has changed.
        """
        session = self.under_way(to_save=True)
        curriculum = session.curriculum
        self.repertoire.check_name(name or curriculum.name)
        automaton, notes = session.trimmed(name, bindings, keep_unused=keep_unused)
        automaton = replace(automaton, description=description or automaton.description)
        then = self.top if self.mode is Mode.PERFORMING else None
        if self.mode is Mode.TESTING and automaton.parameters == curriculum.parameters:
            then = Term(automaton.name, curriculum.arguments)
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
            record = {"do": SAVED, "automaton": saved.name, "checksum": saved.checksum}
            self.journal.write(record)
            change.commit()
        self.journal.people.update(texts_of(self.people))
        self.journal.archive()
        self._latest_saved = saved.name
        notes += self._swap(state, self.library, ends_training=True)
        path = self.library.on_disk.file(saved.name)
        return SavedBehavior(saved.automaton, path, notes, change.replaced(saved.name))

    def reload(self, library: BehaviorLibrary | None = None) -> list[str]:
        """Read the library again, or another one; restart the active behavior in Start.

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
        start: Term | None = None,
        library: BehaviorLibrary | None = None,
    ) -> list[str]:
        """Switch to a loaded library that is already on disk.

        Args:
            loaded: the library to switch to, as loaded.
            start: behavior to perform instead of the active one.
            library: library that the loaded library comes from, if not the agent's own.

        Returns:
            Notes on behaviors that could not be stopped or started.

        Raises:
            VocabularyError: if the active behavior or training does not fit; nothing has changed.
        """
        state = self._state(loaded, self.check_fit(loaded, start))
        return self._swap(state, library or self.library)

    def check_fit(self, loaded: LoadedLibrary, start: Term | None = None) -> Term | None:
        """Check that the active behavior, or ``start``, and the training fit a loaded library.

        Returns:
            The behavior to perform with it.

        Raises:
            VocabularyError: naming the misfit, and the way out.
        """
        term = start or (self.top if self.mode is Mode.PERFORMING else None)
        if term is None and self.mode is Mode.IDLE and self.pending_behavior is not None:
            with suppress(VocabularyError):
                loaded.repertoire.check_performable(self.pending_behavior)
                term = self.pending_behavior
        losses = loaded.losses
        gone = sorted(losses.reasons.keys() & self.loaded.files.keys())
        kept = "it keeps its present library:"
        if gone:
            raise LostBehaviorError(
                f"{kept} {', '.join(gone)} would be lost: {'; '.join(losses.faults)}",
                *(remedy for name in gone for remedy in losses.remedies[name]),
            )
        try:
            if term is not None:
                loaded.repertoire.check_performable(term)
        except VocabularyError as error:
            raise VocabularyError(
                f'{kept} it could no longer perform "{term}": {error}; have it perform something '
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
        return term

    def _state(self, loaded: LoadedLibrary, term: Term | None) -> _State:
        """Return the state that the agent would switch to, without switching.

        Raises:
            VocabularyError: if it cannot be performed.
        """
        context = replace(self.context, repertoire=loaded.repertoire)
        if term is None:
            return loaded, context, None, None
        loaded.repertoire.check_performable(term)
        return loaded, context, term, performance(context, term)

    def _swap(
        self, state: _State, library: BehaviorLibrary, *, ends_training: bool = False
    ) -> list[str]:
        """Switch to a prepared state. It is on disk already, so this must not fail."""
        notes = []
        try:
            self._stop()
        except Exception as error:  # a domain's code, a user's
            notes.append(f"what {self.name} performed could not be stopped: {error!r}")
        self.library = library
        self.loaded, self.context, term, performed = state
        self._performances.clear()
        self.top, self._performance = term, performed
        if ends_training:
            self.session = None
        if self.session is not None:
            self.session.rebuild(self.context)
        elif self.journal.damage:
            with suppress(LibraryError):  # it may fit again
                self.session = self._resumed()
        if term is not None and performed is not None:
            self.pending_behavior = None
            self._performances[term] = performed
            self.mode = Mode.PERFORMING
            try:
                performed.start()
            except Exception as error:
                self.top = self._performance = None
                self.mode = Mode.IDLE
                notes.append(f'{self.name} is idle: "{term}" could not be begun: {error!r}')
        elif self.session is None or self.mode is Mode.PERFORMING:
            self.mode = Mode.IDLE
        return notes

    def _stop(self) -> None:
        """Stop the active behavior."""
        raise NotImplementedError

    def _resumed(self) -> TrainingSession | None:
        def replay(records: Sequence[Record]) -> TrainingSession:
            with_what = self.context, self.journal.write, self._known_people(), self._without
            return TrainingSession.replayed(records, *with_what)

        resumed = self.journal.resume(replay, self.library.has_saved)
        self._known_people()
        for id in self.journal.done:
            self.outcomes.keep(id, Outcome("done before the restart"))
        return resumed

    def _known_people(self) -> dict[str, Lateness]:
        """Return the lateness of each person, including people known only from the journal."""
        for who, known in people_from(self.journal.people).items():
            self.people.setdefault(who, known)
        return self.people

    def _prepared(self, term: Term) -> Running:
        """Return the performer of a behavior, cached because orders repeat."""
        performed = self._performances.get(term)
        if performed is None:
            self.repertoire.check_performable(term)
            performed = self._performances[term] = performance(self.context, term)
        return performed

    def _continued(
        self, curriculum: Curriculum, resume: str
    ) -> tuple[Curriculum, tuple[Example, ...]]:
        """Return a curriculum and the examples to continue from; see `Agent.begin`."""
        earlier, _, version = resume.partition("@")
        name = curriculum.name or earlier
        losses = self.loaded.losses
        if name in losses.reasons:
            raise LostBehaviorError(refused_name(name, "trained", losses), *losses.remedies[name])
        if not resume:
            return curriculum, ()
        of = (
            self.library.on_disk.version(earlier, int(version)).automaton
            if version.isdecimal()
            else self.repertoire.get(resume)
        )
        return resumed(curriculum, of, self.repertoire)


def _alone(shipment: Shipment) -> int:
    raise LibraryError(f"there is no other agent to send {shipment.term.name} to")


def _first_loaded(library: BehaviorLibrary) -> LoadedLibrary:
    """Return the sound part of a library; empty if its folder cannot be read."""
    try:
        return library.loaded(strict=False)
    except FolderInUseError:
        raise
    except LibraryError as error:
        return library.reader.of({}, LostBehaviors.of_unread(error.problem, library.domain))
