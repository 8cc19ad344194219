"""Going on with the training of a behavior that was saved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from hitab_core.automaton import Automaton
from hitab_core.domain import BasicBehavior
from hitab_core.errors import TrainingError
from hitab_core.example import Example
from hitab_core.training.training_session import Curriculum
from hitab_core.use import Use
from hitab_core.vocabulary import has


def resumed(
    curriculum: Curriculum, earlier: BasicBehavior | Automaton
) -> tuple[Curriculum, tuple[Example, ...]]:
    """Return a curriculum completed from a trained behavior, and that behavior's examples.

    Args:
        curriculum: what to train; without a name, features or parameters, those of ``earlier``.
        earlier: whose examples to continue from.

    Raises:
        TrainingError: if it has no examples, or they lack a value for one of the features.
    """
    if not isinstance(earlier, Automaton) or not earlier.examples:
        raise TrainingError(f'"{earlier.name}" was not trained; there is nothing to resume')
    features = curriculum.features or earlier.features
    completed = replace(
        curriculum,
        name=curriculum.name or earlier.name,
        features=features,
        parameters=curriculum.parameters or earlier.parameters,
    )
    return completed, _with_features(earlier, features)


def _with_features(earlier: Automaton, features: Sequence[Use]) -> tuple[Example, ...]:
    """Return the examples of ``earlier`` for a training with ``features``.

    Raises:
        TrainingError: if its examples lack a value for one of them.
    """
    if tuple(features) == earlier.features:
        return earlier.examples
    missing = [str(f) for f in features if f not in earlier.features]
    if missing:
        raise TrainingError(
            f'the examples of "{earlier.name}" have no value for {", ".join(missing)} '
            f"{has(earlier.features)}; save with unused features kept to resume with them, "
            "or begin without these features"
        )
    columns = [earlier.features.index(f) for f in features]
    return tuple(e.with_columns(columns) for e in earlier.examples)
