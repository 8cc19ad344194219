"""Questions of an agent about the examples of its training, asked by their consequences.

What is open is found from the present examples (`hitab_core.assistant.findings`), so an answer
that changes them ends its question, and undoing the answer asks it again. The answers are played
on over the situations that were met (`hitab_core.assistant.consequences`), and a question whose
most probable answers differ in none of them is not asked. Contradictions are asked about at once;
of the others, those of which most can be learned (`hitab_core.advice.unshown`). By the share of
the situations met that answers decide otherwise, seldom ones, which decide games, come last.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Hashable, Iterator, Mapping, Sequence
from typing import Any

from hitab_core.assistant.consequences import weighed
from hitab_core.assistant.findings import ambiguous, contradicting, never_shown
from hitab_core.assistant.late_commands import LateCommands
from hitab_core.assistant.material import Material
from hitab_core.assistant.question import Question, QuestionKind
from hitab_core.assistant.situation_sample import SituationSample
from hitab_core.automaton import FLAGS, OWN_FEATURES
from hitab_core.example import Example
from hitab_core.learning import TREE
from hitab_core.learning.classifier_spec import ClassifierSpec
from hitab_core.texts.errors import TrainingError
from hitab_core.texts.vocabulary import has
from hitab_core.training.percepts import PerceptRecord
from hitab_core.training.trainer import Trainer

TIMERS = tuple(term for term in OWN_FEATURES if term.name not in FLAGS)
"""Timers are excluded: their reset is not an event in the world."""

ASKED_MAX = 3
"""The most questions, besides contradictions, that are asked at a time: people answer so many."""

WEIGHED_MAX = 6
"""The most questions, besides open ones, of which the consequences are computed."""


class Questions:
    """The questions of one training, numbered as they come up.

    Args:
        trainer: the trainer.
        late: knows which late commands may be meant for another moment.
        without: kinds of questions that are not asked.

    Attributes:
        answered: the answered questions, in words, oldest first.
    """

    def __init__(
        self, trainer: Trainer, late: LateCommands, without: Collection[str] = ()
    ) -> None:
        self.answered: list[str] = []
        self._trainer, self._late, self._without = trainer, late, without
        self._log = trainer.log
        self._asks = False
        self._situations = SituationSample()
        domain, features = trainer.context.repertoire.domain, trainer.curriculum.features
        readable = trainer.history.readable
        self._discrete = [
            readable.index(term)
            for term in features
            if term not in TIMERS and not domain.scale_of(term).kind.is_measured
        ]
        self._numbers: dict[tuple[Any, ...], int] = {}
        self._made: dict[int, Question] = {}  # without the consequences of their answers
        self._dismissed: set[tuple[str, ...]] = set()
        self._about: tuple[Example, ...] | None = None
        self._contradicting: list[Question] = []
        self._others: list[Question] = []  # those that matter most first
        self._searched: Hashable = None

    def subscribe(self) -> None:
        """Start to collect situations and examples."""
        self._asks = True
        events = self._trainer.events
        events.perceived.subscribe(self._meet)
        events.begun.subscribe(self._begin)
        events.changed.subscribe(self._see_change)
        events.back.subscribe(self._go_back)

    def _meet(self, moment: PerceptRecord) -> None:
        values = (moment.readings[i] for i in self._discrete)
        kind = (moment.state, *(None if math.isnan(value) else value for value in values))
        self._situations.add(kind, moment)

    def _begin(self, moment: PerceptRecord | None) -> None:
        if moment is not None:
            self._situations.forget_from(moment.time)
            self._meet(moment)

    def _go_back(self, cycle: int) -> None:
        """Search again: the cycles of open questions may show something else by then."""
        self._situations.go_back(cycle)
        self._about, self._others = None, []

    def _see_change(self, record: Mapping[str, Any]) -> None:
        if record["do"] == "dismiss":
            self._dismissed.add(tuple(record["key"]))

    @property
    def news(self) -> tuple[int, int]:
        """Counter that changes when situations of a new kind, or many more, have been met."""
        return self._situations.news

    def known(self) -> list[Question]:
        """Return the open questions, without a search that takes long.

        These are all contradictions, and `ASKED_MAX` of the others, those that matter most first.
        """
        self._look_at_examples()
        others = [q for q in self._others if q.words not in self._dismissed]
        asked = [q for q in self._contradicting if q.words not in self._dismissed]
        return [*asked, *others[:ASKED_MAX]]

    def _look_at_examples(self) -> None:
        """Find the contradictions, if the examples have changed; what does not depend stays."""
        log, before = self._log, self._about or ()
        if self._asks and before is not log.examples:
            self._about, self._searched = log.examples, None
            self._others = [
                q for q in self._others if q.situation and _same(q.state, before, log.examples)
            ]
            self._contradicting = contradicting(log.contradictory(), self._question)

    def find(self) -> list[Question]:
        """Return the open questions after a search, which can take a tenth of a second.

        Raises:
            TrainingError, FeatureValueError, VocabularyError: see `Evidence.learn`.
        """
        for _ in self.search():
            pass
        return self.known()

    def search(self) -> Iterator[None]:
        """Look for questions, for `find`, in steps between which something else can be done.

        The effects of answers to the first questions are computed, too. If the examples change
        meanwhile, or the world goes back, the search ends; begin another one.

        Raises:
            TrainingError, FeatureValueError, VocabularyError: see `Evidence.learn`.
        """
        if not self._asks:
            return
        self._look_at_examples()
        examples = self._about
        for _ in self._search():
            yield
            if not self._log.examples is self._about is examples:
                return

    def _search(self) -> Iterator[None]:
        news = self._situations.news
        if self._searched == news:
            return
        given = Material(self._trainer, self._situations)
        # Open questions stay, if only more was met: a person may be about to answer one.
        stays = self._searched is not None
        asked = [q for q in self._others if stays and q.words not in self._dismissed]
        asked = asked[:ASKED_MAX]
        found: list[tuple[float, Question]] = []
        for ranked in never_shown(given, self._question):
            found += [] if ranked is None else [ranked]
            yield
        found.sort(key=lambda ranked: -ranked[0])
        # A person remembers the last commands best.
        late = [*ambiguous(given, self._late.doubts, self._question)][-ASKED_MAX:]
        known = {q.words for q in asked} | self._dismissed
        new = [q for q in (*late, *(q for _, q in found)) if q.words not in known]
        new = [q for q in new if q.kind not in self._without][:WEIGHED_MAX]
        if ClassifierSpec.parse(given.classifier).name == TREE:
            clashes = self._contradicting[:ASKED_MAX]
            consequences: dict[int, Question] = {}
            for question in (*clashes, *asked, *new):
                for result in weighed(self._made[question.number], given, self._trainer):
                    if result is not None:
                        consequences[question.number] = result
                    yield
            clashes, asked, new = (
                [consequences[q.number] for q in those] for those in (clashes, asked, new)
            )
            gains = {question.number: gain for gain, question in found}
            new.sort(key=lambda q: -gains.get(q.number, q.matters))
            self._contradicting[:ASKED_MAX] = clashes
        # Without a tree it is not known what matters.
        self._others = [q for q in (*asked, *new) if not q.matters <= 0.0]
        self._searched = news

    def get(self, number: int) -> Question:
        """Return an open question.

        Raises:
            TrainingError: if it is not open, saying why.
            FeatureValueError, VocabularyError: see `find`.
        """
        found = self.find()
        for question in found:
            if question.number == number:
                return question
        there = [question.number for question in found]
        if number in self._numbers.values():
            raise TrainingError(
                f"question {number} is no longer open: it was answered, or the examples have "
                f"changed {has(there)}"
            )
        raise TrainingError(f"no question {number} {has(there)}")

    def _question(self, kind: QuestionKind, about: tuple[Any, ...], **fields: Any) -> Question:
        """Return a question, with its number if it came up before about the same."""
        key = (kind, *about)
        number = self._numbers.setdefault(key, len(self._numbers) + 1)
        self._made[number] = Question(number, kind, **fields, key=key)
        return self._made[number]


def _same(state: str, before: Sequence[Example], after: Sequence[Example]) -> bool:
    """Return whether the examples of a state are the same."""
    return [e for e in before if e.state == state] == [e for e in after if e.state == state]
