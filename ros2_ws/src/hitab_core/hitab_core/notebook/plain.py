"""A domain made of plain functions of a percept, for notebooks and scripts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from inspect import signature
from typing import Any

from hitab_core.domain import BasicBehavior, Domain, Feature, Target
from hitab_core.plain_body import Action, Percept, PlainBody
from hitab_core.texts.errors import FeatureValueError, VocabularyError


def plain_domain(
    name: str,
    behaviors: Mapping[str, Action | Callable[[Percept], Action]] | Iterable[str],
    features: Mapping[str, Callable[[Percept], float]] | Iterable[str | Feature],
    version: str = "1",
) -> Domain:
    """Return a domain whose features and basic behaviors are functions of the percept.

    Args:
        name: name of the domain.
        behaviors: by name, the action of each basic behavior, or a function from the percept to
            the action. A list of names makes behaviors without an action, if only the decisions
            matter.
        features: by name, a function from the percept to the value of each feature. A list of
            names stands for the percept's values in this order. A `Feature` is taken as it is,
            with a `PlainBody` as its body; so angles and categories can be declared.
        version: version, to be raised when the meaning of a name changes.

    Raises:
        VocabularyError: if a name is malformed or used twice.

    Examples:
        >>> from hitab_core import plain_domain
        >>> cart = plain_domain("cart", {"Left": [-1.0], "Right": [1.0]}, ["Position"])
        >>> sorted(cart.behaviors), sorted(cart.features)
        (['Left', 'Right'], ['Position'])
    """
    if not isinstance(behaviors, Mapping):
        behaviors = dict.fromkeys(behaviors, ())
    for word in (*behaviors, *features):
        if isinstance(word, str) and any(mark in word for mark in ";\t\ufeff"):
            raise VocabularyError(
                f"{word!r} is not a name but the head of a file with other marks between its "
                'columns: read it with csv.DictReader(open(path, encoding="utf-8-sig"), '
                'delimiter=";")'
            )
    made = [_behavior(word, action) for word, action in behaviors.items()]
    if isinstance(features, Mapping):
        read = [Feature(word, _reader(word, function)) for word, function in features.items()]
    else:
        read = [
            feature if isinstance(feature, Feature) else _value(feature, place)
            for place, feature in enumerate(features)
        ]
    return Domain.of(name, version, PlainBody, behaviors=made, features=read)


def _behavior(name: str, action: Action | Callable[..., Action], **more: Any) -> BasicBehavior:
    def pulse(body: PlainBody, *targets: Any) -> None:
        body.action = action(body.percept, *targets) if callable(action) else action

    if not callable(action) and (isinstance(action, str) or not isinstance(action, Sequence)):
        raise VocabularyError(
            f'the action of "{name}" is {action!r}; give a list of numbers, or a function of the '
            "percept that returns one"
        )
    return BasicBehavior(name, pulse, **more)


def _reader(name: str, function: Callable[..., float]) -> Callable[..., float]:
    if not callable(function):
        raise VocabularyError(
            f'feature "{name}" is {function!r}; give a function of the percept that returns a '
            "number"
        )

    def read(body: PlainBody, *targets: Any) -> float:
        try:
            return float(function(body.percept, *targets))
        except Exception as error:
            raise FeatureValueError(
                f'feature "{name}" cannot be computed from the percept {body.percept}: '
                f"{type(error).__name__}: {error}"
            ) from error

    return read


def _value(name: str, place: int) -> Feature:
    return Feature(name, partial(_at, name=name, place=place))


def _at(body: PlainBody, *, name: str, place: int) -> float:
    if place >= len(body.percept):
        raise FeatureValueError(
            f'feature "{name}" is value {place + 1} of the percept, which has '
            f"{len(body.percept)}; pass one value for each feature"
        )
    return body.percept[place]


def behavior(function: Callable[..., Action] | None = None, /, **more: Any) -> Any:
    """Make a basic behavior of a function of the percept that returns the action.

    Args:
        function: function of the percept and, if it has parameters, of their targets.
        more: other fields of `BasicBehavior`, such as ``@behavior(one_shot=True)``.
    """
    if function is None:
        return partial(behavior, **more)
    return _behavior(function.__name__, function, **_declared(function), **more)


def feature(function: Callable[..., float] | None = None, /, **more: Any) -> Any:
    """Make a feature of a function of the percept that returns its value.

    Args:
        function: function of the percept and, if it has parameters, of their targets.
        more: other fields of `Feature`, such as ``@feature(unit="m")``.
    """
    if function is None:
        return partial(feature, **more)
    name = function.__name__
    return Feature(name, _reader(name, function), **_declared(function), **more)


def target(function: Callable[[Percept], Any]) -> Target:
    """Make a target of a function of the percept, which returns the features' argument."""
    return Target(function.__name__, lambda body: function(body.percept), function.__doc__ or "")


def _declared(function: Callable[..., Any]) -> dict[str, Any]:
    """Return the parameters and the description of a word, taken from its function."""
    _, *parameters = signature(function).parameters
    return {"parameters": tuple(parameters), "description": function.__doc__ or ""}
