"""The strip of a demonstration: its behaviors in time, and the confidence in them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from hitab_core.agent import Agent
from hitab_core.domain import Domain
from hitab_core.labeling.labels import Progress, Run, label, no_progress
from hitab_core.labeling.shown_actions import ShownAction, behaviors_meant, features_meant, runs_of
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.library.saving import SavedBehavior
from hitab_core.numeric.arrays import Booleans, Floats, Integers
from hitab_core.term import Term
from hitab_core.texts.errors import LibraryError, TrainingError
from hitab_core.texts.vocabulary import check_known
from hitab_core.texts.wording import quantity
from hitab_core.training.curriculum import Curriculum

UNSURE = 0.8
"""Labels below this probability are unsure."""

UNEXPLAINED_MAX = 0.5
"""The share of moments that may be explained by no behavior."""


@dataclass(frozen=True)
class Span:
    """Consecutive moments of one behavior.

    Attributes:
        begin, end: times, s; the end is the beginning of the next span.
        behavior: the label.
        sure: mean probability of the label over the moments.
        moments: number of moments.
        unexplained: number of moments at which no behavior explains the action.
        corrected: whether a person labeled some of the moments.
    """

    begin: float
    end: float
    behavior: str
    sure: float
    moments: int
    unexplained: int
    corrected: bool


class Strip:
    """Labels of one agent's actions, to be corrected by hand and learned from.

    Attributes:
        behaviors: behaviors to choose from.
        known: by moment, the index of the behavior that a person chose.
        rounds: number of alternations that the labels took.
    """

    def __init__(
        self,
        moments: Sequence[ShownAction],
        domain: Domain,
        agent: str,
        behaviors: Iterable[str],
        features: Iterable[str],
        corrections: Iterable[tuple[float, float, str]] = (),
        *,
        told: Progress = no_progress,
    ) -> None:
        """Label a demonstration.

        Args:
            moments: the moments in their order.
            domain: domain of the agent.
            agent: name of the agent.
            behaviors: basic behaviors to choose from; by default all without targets.
            features: features on which the choice of a behavior may have depended.
            corrections: see `correct`.
            told: called with the progress.

        Raises:
            TrainingError: if there is nothing to label, or the behaviors do not explain it.
            VocabularyError: naming the unknown word.
        """
        self.agent, self.domain, self.moments = agent, domain, moments
        self._uses = behaviors_meant(domain, behaviors)
        self._features = features_meant(domain, features)
        self.behaviors = tuple(map(str, self._uses))
        if len(moments) < 2 or all(moment.did is None for moment in moments):
            raise TrainingError(f"there are not two moments of which is known what {agent} did")
        self._runs, done = runs_of(moments, domain, agent, self._uses, self._features, told)
        self._varied = np.nanstd(done, axis=0)
        self.known: dict[int, int] = {}
        for begin, end, behavior in corrections:
            self.correct(begin, end, behavior)
        self.label(told)

    def label(self, progress: Progress = no_progress) -> None:
        """Label again; the labels that a person chose stay."""
        runs: list[Run] = []
        begin = 0
        for run in self._runs:
            end = begin + len(run.features)
            known = {i - begin: which for i, which in self.known.items() if begin <= i < end}
            runs.append(replace(run, known=known))
            begin = end
        scales = [self.domain.scale_of(term) for term in self._features]
        shown = label(runs, self.behaviors, scales, progress=progress)
        unexplained = np.concatenate(shown.unexplained)
        unexplained[[*self.known]] = False
        varies = self._varied > 0
        in_vain = varies.any() and (shown.spread >= self._varied)[varies].all()
        if in_vain or unexplained.mean() > UNEXPLAINED_MAX:
            what = "" if in_vain else f" at {unexplained.mean():.0%} of the moments"
            raise TrainingError(
                f"these behaviors do not explain what {self.agent} did{what}: "
                f"{', '.join(self.behaviors)}; choose possible ones"
            )
        self.labels: Integers = np.concatenate(shown.labels)
        self.confidence: Floats = np.concatenate(shown.confidence)
        self.unexplained: Booleans = unexplained
        self.rounds = shown.rounds

    def correct(self, begin: float, end: float, behavior: str) -> None:
        """Set the behavior of a span of time; `label` then labels the rest again.

        Raises:
            TrainingError: if there is no moment then.
            VocabularyError: if it is none of the behaviors.
        """
        check_known("behavior", behavior, self.behaviors)
        there = [i for i, moment in enumerate(self.moments) if begin <= moment.when < end]
        if not there:
            raise TrainingError(
                f"there is no moment from {begin:g} to {end:g} s; they are from "
                f"{self.moments[0].when:.2f} to {self.moments[-1].when:.2f} s"
            )
        self.known |= dict.fromkeys(there, self.behaviors.index(behavior))

    def is_sure(self, moment: int) -> bool:
        """Whether the label of a moment is probable enough."""
        return bool(self.confidence[moment] >= UNSURE)

    @property
    def spans(self) -> list[Span]:
        """The spans, in their order; a new one begins with each episode."""
        found, begin = [], 0
        for (_, which), group in groupby(
            zip((m.episode for m in self.moments), self.labels.tolist(), strict=True)
        ):
            end = begin + len(list(group))
            found.append(
                Span(
                    self.moments[begin].when,
                    self.moments[end].when if end < len(self.moments) else self._end,
                    self.behaviors[which],
                    float(self.confidence[begin:end].mean()),
                    end - begin,
                    int(self.unexplained[begin:end].sum()),
                    any(i in self.known for i in range(begin, end)),
                )
            )
            begin = end
        return found

    @property
    def _end(self) -> float:
        """End of the last moment, which is taken to be as long as the previous moment."""
        return 2 * self.moments[-1].when - self.moments[-2].when

    def train(self, name: str, library: BehaviorLibrary, source: str) -> SavedBehavior:
        """Train a behavior as if each change of the label had been commanded, and save it.

        Args:
            name: name of the behavior.
            library: library to save it in.
            source: name of the recording, for the provenance.

        Raises:
            LibraryError: if the library has another domain, or cannot be written.
            TrainingError, VocabularyError: see `Trainer`.
        """
        if library.domain.name != self.domain.name:
            raise LibraryError(
                f'{library.folder} is of domain "{library.domain.name}", what {self.agent} did of '
                f'"{self.domain.name}"; choose another library'
            )
        agent = Agent(self.agent, self.domain, library)
        agent.begin(Curriculum(name, self._features))
        for moment, term, begins in self._changes():
            agent.sense(moment.values, moment.heard, moment.cycle, moment.time)
            if begins:
                agent.restart(0, moment.episode)
            if term is not None:
                agent.command(term)
        said = f", {quantity(len(self.known), 'moment')} corrected" if self.known else ""
        note = f"labeled from {source}: {quantity(len(self.moments), 'moment')}{said}"
        return agent.save(note=note)

    def _changes(self) -> Iterator[tuple[ShownAction, Term | None, bool]]:
        """Yield each moment, its commanded behavior, and whether an episode begins."""
        episode, before = None, -1
        for moment, which in zip(self.moments, self.labels.tolist(), strict=True):
            begins = moment.episode != episode
            yield moment, self._uses[which] if begins or which != before else None, begins
            episode, before = moment.episode, which
