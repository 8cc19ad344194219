"""The training of an agent: the trainer, its assistants, and edits of the examples."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Self

from hitab_core.advice.remarks import Remark
from hitab_core.assistant.late_commands import LateCommands
from hitab_core.assistant.lateness import Lateness
from hitab_core.assistant.loops import Loops
from hitab_core.assistant.preview import Previews
from hitab_core.assistant.question import ASKED, Question, choice_of
from hitab_core.assistant.questions import Questions
from hitab_core.assistant.trial_statistics import TrialStatistics
from hitab_core.automaton import START, Automaton
from hitab_core.codec import from_dict
from hitab_core.example import Example
from hitab_core.repertoire import Repertoire
from hitab_core.running.run_context import RunContext
from hitab_core.term import Term
from hitab_core.texts.errors import FeatureValueError, LibraryError, TrainingError
from hitab_core.texts.remedies import Fix
from hitab_core.texts.wording import some
from hitab_core.training.curriculum import Curriculum, check_curriculum, check_state
from hitab_core.training.events import NOW, Given
from hitab_core.training.exchange import exchange
from hitab_core.training.retiming import retiming
from hitab_core.training.trainer import Journal, Trainer
from hitab_core.training.undo import Edit

ASSISTANTS = ("reaction", "questions", "loops", "episodes", "preview", *ASKED)
"""Names of the assistants: they estimate when late commands were due, ask about the examples, find
loops in the learned automaton, remark on the results of many test episodes, and tell what it would
do next. The last ones are the kinds of questions that can be left out
(`hitab_core.assistant.question`)."""


class TrainingSession(Trainer):
    """A training with assistants and edits, which comes back after a crash.

    A robot must always be able to be stopped: a behavior that stands still is performed even if
    its command cannot be recorded. While a required feature has no value, only such behaviors
    are performed; the agent is otherwise in Start, and stays there until the next command. After a
    crash the agent is in Start, and everything in the journal can still be undone.

    Attributes:
        late: estimates when late commands were due.
        questions: questions of the agent to the demonstrator.
        preview: what it would do next by what it has learned so far.
    """

    def __init__(
        self,
        context: RunContext,
        curriculum: Curriculum,
        examples: Iterable[Example] = (),
        journal: Journal = lambda record: None,
        names: Sequence[Term] = (),
        people: dict[str, Lateness] | None = None,
        without: Collection[str] = (),
    ) -> None:
        """Start in training mode, in Start; see `Trainer`.

        Args:
            people: delay of the commands of each demonstrator; kept up to date.
            without: assistants to leave out, by name (`ASSISTANTS`).
        """
        super().__init__(context, curriculum, examples, journal, names)
        self.late = LateCommands(self, {} if people is None else people)
        self.questions = Questions(self, self.late, without)
        self._loops = Loops(self)
        self._trial = TrialStatistics(self)
        self.preview = Previews(self)
        guests: tuple[Any, ...] = self.late, self.questions, self._loops, self._trial, self.preview
        for name, guest in zip(ASSISTANTS, guests, strict=False):
            if name not in without:
                guest.subscribe()

    # -- standing still ---------------------------------------------------------------------

    def tick(self) -> None:
        """Perform one timestep; see `Trainer.tick`."""
        if self.testing:
            super().tick()
            return
        try:
            if not self.context.repertoire.stands_still(Term.parse(self.running.active)):
                self.running.vector.check_required()
            super().tick()
        except Exception as error:
            if self.running.active != START:
                self.note = f"stands still until the next command: {error}"
            self.running.stop()
            self._taken_over = False
            raise

    def command(self, state: Term, given: Given = NOW) -> list[Example]:
        """Perform a behavior now and record the resulting examples; see `Trainer.command`.

        Returns:
            The examples; empty if a behavior that stands still cannot be recorded, see `note`.
        """
        self._check_in_control()
        plain, _ = self.context.repertoire.commanded(state)
        try:
            return super().command(state, given)
        except (FeatureValueError, TrainingError, LibraryError) as error:
            if not self.context.repertoire.stands_still(plain):
                raise
            return self._enter(plain, f"stands still, but {plain} was not recorded: {error}")

    def bring_into(self, state: Term) -> list[Example]:
        """Perform a behavior now and record nothing, such as to reach a situation to correct.

        Raises:
            TrainingError, VocabularyError: see `command`.
        """
        self._check_in_control()
        state, numbers = self.context.repertoire.commanded(state)
        check_state(state, self.curriculum, self.context.repertoire)
        self._enter(state, f"was brought into {state}; no example was recorded")
        self.running.set_numbers(numbers)
        return []

    def _enter(self, state: Term, note: str) -> list[Example]:
        """Perform a behavior without recording an example."""
        self.note = note
        self.running.take_down_flags()
        self.running.add_state(state)
        self.running.go_to(str(state))
        self.events.begun(self.history.restart(str(state)))
        self._taken_over = False
        return []

    def go_back(self, cycle: int) -> None:
        """Forget the percepts from a cycle on; the examples stay, and percepts follow again."""
        self.events.interrupted(self.running.active)
        self.history.back(cycle)
        self.events.back(cycle)
        self._taken_over = False

    # -- after a crash, and with another library ----------------------------------------------

    @classmethod
    def replayed(
        cls,
        records: Sequence[Mapping[str, Any]],
        context: RunContext,
        journal: Journal,
        people: dict[str, Lateness],
        without: Collection[str],
    ) -> Self:
        """Return a training as its journal describes it, in Start.

        Raises:
            VocabularyError: if an example uses a behavior that no longer exists.
            HitabError, KeyError, TypeError, ValueError: if the records are no journal.
        """
        begin, *rest = records
        training = cls(
            context,
            from_dict(Curriculum, begin["curriculum"]),
            [from_dict(Example, e) for e in begin["examples"]],
            journal,
            tuple(map(Term.parse, begin["readable"])),
            people,
            without,
        )
        for record in rest:
            training.make(record, training.prepared(record))
        for percept in training.history.kept():
            training.events.perceived(percept)
        training.check_on(context.repertoire)
        training.rebuild(context)
        return training

    def check_on(self, repertoire: Repertoire) -> None:
        """Check that the training could continue with another repertoire.

        Raises:
            VocabularyError: naming the missing word.
        """
        check_curriculum(self.curriculum, repertoire)
        for label in self.states:
            repertoire.check_state(Term.parse(label), self.curriculum.parameters)

    def rebuild(self, context: RunContext) -> None:
        """Restart at Start, since behaviors of the repertoire may have changed."""
        self.context = context
        self.running = self._in_start()
        if self.testing:
            automaton = self.automaton()
            self.running.set_transitions(automaton.transitions, automaton.numbers)

    # -- assistants -------------------------------------------------------------------------

    def search(self) -> Iterator[None]:
        """Look for questions in steps, see `Questions.search`, and for loops."""
        yield from self.questions.search()
        self.remarks(look=True)

    def remarks(self, *, look: bool = False) -> list[Remark]:
        """Return signs that the learned automaton does not work.

        Args:
            look: search for loops again if the examples have changed.
        """
        return [*self._loops.remarks(look=look), *self._trial.remarks()]

    def answer(self, number: int, choice: str = "", *, dismiss: bool = False) -> Question:
        """Answer a question; undo takes the answer back.

        Args:
            number: number of the question.
            choice: the name of one of its choices; empty for the proposed one.
            dismiss: change nothing, and do not ask this again.

        Raises:
            TrainingError: if the question is not open, or has no such choice.
        """
        question = self.questions.get(number)
        if dismiss:
            self._do({"do": "dismiss", "key": list(question.words)})
            return question
        chosen = choice_of(question, choice)
        self.edit({**chosen.record, "proposed": chosen.name == question.proposed})
        self.questions.answered.append(f"{question.text} {chosen.name}")
        return question

    # -- edits ------------------------------------------------------------------------------

    def delete(self, numbers: Iterable[int]) -> None:
        """Delete examples by number.

        Raises:
            TrainingError: if one of the numbers is unknown.
        """
        self.edit({"do": "delete_examples", "numbers": sorted(set(numbers))})

    def relabel(self, numbers: Iterable[int], next_state: Term) -> None:
        """Change the next state of examples, and their commands' default examples.

        Raises:
            TrainingError: if one of the numbers is unknown.
            VocabularyError: if there is no such behavior, or a number of its own is wrong.
        """
        repertoire = self.context.repertoire
        check_state(next_state, self.curriculum, repertoire)
        state, given = repertoire.commanded(next_state)
        record = {
            "do": "relabel_examples",
            "numbers": sorted(set(numbers)),
            "next_state": str(state),
        }
        goes_on = not repertoire.is_one_shot(state)
        self.edit({**record, "goes_on": goes_on, **({"with": list(given)} if given else {})})

    def retime(self, numbers: Iterable[int], ago: float) -> None:
        """Change the time at which commands were due.

        All examples of a command get the situation of that time; the first of them leaves the
        state that was active then.

        Args:
            numbers: numbers of examples; each stands for its command.
            ago: time from when it was due to the command, s of simulated time.

        Raises:
            TrainingError: if one of the numbers is unknown, or that time is not kept.
            FeatureValueError: if no feature had a value then, or one was infinite.
        """
        self.edit({"do": "retime_examples", "numbers": sorted(set(numbers)), "ago": ago})

    def choose_features(self, features: Sequence[Term]) -> None:
        """Learn from other features of the same examples.

        Raises:
            TrainingError: if a feature has no value in any example.
            VocabularyError: if there is no such feature.
        """
        self._check_features(features)
        self.edit({"do": "choose_features", "features": [str(term) for term in features]})

    def with_features(self, features: Sequence[Term]) -> Automaton:
        """Return the automaton learned from other features of the same examples, untrimmed.

        Raises:
            TrainingError: if a feature has no value in any example, or no example leaves Start.
            VocabularyError: if there is no such feature.
        """
        self._check_features(features)
        edit = exchange(self, features)
        return self._learned(self.log.after(edit), "shown", edit.features)

    def _check_features(self, features: Sequence[Term]) -> None:
        chosen = replace(self.curriculum, features=tuple(features))
        check_curriculum(chosen, self.context.repertoire)
        unread = [term for term in features if term not in self.history.readable]
        if unread and not self.log.examples:
            raise TrainingError(
                f"{some([str(term) for term in unread])} cannot be chosen any more: of a domain "
                "with so many features, a training reads some only if they are chosen when it "
                "begins",
                Fix.TRAIN(behavior=self.curriculum.name, feature=unread[0]),
            )

    def make(self, record: Mapping[str, Any], edit: Edit | None) -> None:
        """Make a step that is on disk; see `Trainer.make`."""
        super().make(record, edit)
        if edit is not None and edit.features is not None:
            features = tuple(map(Term.parse, edit.features))
            self.curriculum = replace(self.curriculum, features=features)
            self.running.set_features(features)

    def prepared(self, record: Mapping[str, Any]) -> Edit | None:
        """Return the edit that a record describes; see `Trainer.prepared`."""
        match record["do"]:
            case "retime_examples":
                return retiming(self, record["numbers"], float(record["ago"]))
            case "choose_features":
                return exchange(self, tuple(map(Term.parse, record["features"])))
        return self.log.prepared(record)
