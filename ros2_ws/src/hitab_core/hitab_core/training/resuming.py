"""Resuming the training of a saved behavior."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

from hitab_core.automaton import Automaton
from hitab_core.domain import BasicBehavior
from hitab_core.example import Example
from hitab_core.repertoire import Repertoire
from hitab_core.term import Term
from hitab_core.texts.errors import TrainingError, VocabularyError
from hitab_core.training.curriculum import Curriculum
from hitab_core.training.exchange import exchanged, realigned
from hitab_core.training.percepts import readable


def resumed(
    curriculum: Curriculum, earlier: BasicBehavior | Automaton, repertoire: Repertoire
) -> tuple[Curriculum, tuple[Example, ...]]:
    """Return a curriculum completed from a trained behavior, and that behavior's examples.

    Args:
        curriculum: the automaton to train; an empty name, features or parameters are taken
            from ``earlier``, trimmed features included.
        earlier: the trained behavior whose examples to continue from.
        repertoire: repertoire of the agent.

    Raises:
        TrainingError: if it has no examples, or they lack a value for one of the features.
        VocabularyError: if there is no such feature.
    """
    if not isinstance(earlier, Automaton) or not earlier.examples:
        raise TrainingError(f'"{earlier.name}" was not trained; there is nothing to resume')
    features = curriculum.features or _chosen(earlier, repertoire)
    completed = replace(
        curriculum,
        name=curriculum.name or earlier.name,
        features=features,
        parameters=curriculum.parameters or earlier.parameters,
    )
    for feature in features:
        repertoire.domain.check_feature(feature, completed.parameters)
    examples: Sequence[Example] = earlier.examples
    if tuple(features) != earlier.features:
        examples = exchanged(examples, earlier.features, features, earlier.readable, earlier.name)
    names = readable(repertoire.domain, completed.parameters)
    return completed, realigned(examples, earlier.readable, names)


def _chosen(earlier: Automaton, repertoire: Repertoire) -> tuple[Term, ...]:
    """Return the features chosen for a saved training that are still there for its examples."""

    def is_there(term: Term) -> bool:
        if term in earlier.features:
            return True
        with suppress(VocabularyError, TrainingError):
            repertoire.domain.check_feature(term, earlier.parameters)
            exchanged(earlier.examples, earlier.features, [term], earlier.readable, earlier.name)
            return True
        return False

    return tuple(filter(is_there, earlier.chosen)) or earlier.features
