"""A domain: the basic behaviors, features and targets that a robot or a simulated body has.

A domain is written once per kind of robot and found under the entry-point group
``hitab.domains``. Everything in it acts on a *body*, an object of the domain's own that holds one
agent's current percept and next action. The engine never looks inside it.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, Protocol

from hitab_core.automaton import FLAGS, OWN_FEATURES, OWN_NAMES, SECONDS_IN_STATE, SECONDS_SINCE
from hitab_core.number import BoundedNumber
from hitab_core.plain_body import PlainBody
from hitab_core.source_file import load_file, loaded_file
from hitab_core.term import VOCABULARY_NAME, VOCABULARY_NAME_RULE, Term, wrong_number
from hitab_core.texts.errors import VocabularyError
from hitab_core.texts.vocabulary import check_known, has

if TYPE_CHECKING:
    from hitab_core.automaton import Automaton

ENTRY_POINT_GROUP = "hitab.domains"


class FeatureKind(StrEnum):
    """Kind of a feature: how values compare, and how a transition tree may split on them."""

    CONTINUOUS = "continuous"
    TOROIDAL = "toroidal"  # wraps around after `period`, like an angle
    CATEGORICAL = "categorical"
    BOOLEAN = "boolean"

    @property
    def is_measured(self) -> bool:
        """Whether a value can lie between others; values of other kinds are equal or not."""
        return self in (FeatureKind.CONTINUOUS, FeatureKind.TOROIDAL)


@dataclass(frozen=True, slots=True)
class Target:
    """Something in the world that a parameter can be bound to, such as the closest taker.

    ``resolve(body)`` returns the argument that the domain's features and behaviors expect. It is
    called at each use, since the closest thing changes.
    """

    name: str
    resolve: Callable[[Any], Any]
    description: str = ""


@dataclass(frozen=True, slots=True)
class Feature:
    """One observable number: ``read(body, *targets)`` gives its value now.

    A categorical feature's value is an index into ``categories``; a boolean one's is 0 or 1.
    ``period`` is the length of a toroidal feature's circle, in its own ``unit``.

    Where a feature has no value (NaN, None or a raised `FeatureValueError`), a learned tree
    decides by the others. If it is ``required``, an automaton that has it does nothing without it,
    in whatever state, so that no robot drives on blindly.
    """

    name: str
    read: Callable[..., float]
    kind: FeatureKind = FeatureKind.CONTINUOUS
    parameters: tuple[str, ...] = ()
    unit: str = ""
    period: float = 2 * math.pi
    categories: tuple[str, ...] = ()
    description: str = ""
    required: bool = False

    @property
    def scale(self) -> Scale:
        """Scale on which values of this feature compare."""
        return Scale(
            self.kind, self.period if self.kind is FeatureKind.TOROIDAL else 0.0, self.categories
        )


@dataclass(frozen=True, slots=True)
class Scale:
    """Scale of a feature's values: everything that a classifier needs to know of the feature."""

    kind: FeatureKind = FeatureKind.CONTINUOUS
    period: float = 0.0
    categories: tuple[str, ...] = ()


def _not_of_a_body(body: Any, *targets: Any) -> float:
    raise TypeError("the engine fills this feature in")


FLAGS_AND_TIMERS = {
    name: Feature(name, _not_of_a_body, description=description, **more)
    for name, description, more in (
        ("Done", "whether the active state's behavior is done", {"kind": FeatureKind.BOOLEAN}),
        ("Failed", "whether the active state's behavior failed", {"kind": FeatureKind.BOOLEAN}),
        (SECONDS_IN_STATE, "time since the active state was entered", {"unit": "s"}),
        (
            SECONDS_SINCE,
            "time since the automaton last saw this flag up, or was started",
            {"unit": "s", "parameters": ("flag",)},
        ),
    )
}
"""The engine's own features by name; see `hitab_core.automaton.OWN_FEATURES`."""


def _nothing(body: Any, *targets: Any) -> None:
    """Do nothing: the default start and stop of a basic behavior."""


@dataclass(frozen=True, slots=True)
class BasicBehavior:
    """A behavior hard-coded in the agent.

    ``start``, ``pulse`` and ``stop`` are called with the body and the resolved targets: start once
    when its state is entered, pulse once per tick, stop when the state is left. Keep state between
    pulses in the body, never in the behavior, which all agents share. A ``one_shot`` behavior is
    pulsed once per entry and records no default example. One that ``stands_still`` never moves
    the robot: it is obeyed even when no example of it can be recorded. ``pulse`` gets the
    ``numbers`` that the behavior is performed with after the targets.
    """

    name: str
    pulse: Callable[..., None] = _nothing
    start: Callable[..., None] = _nothing
    stop: Callable[..., None] = _nothing
    parameters: tuple[str, ...] = ()
    one_shot: bool = False
    description: str = ""
    stands_still: bool = False
    numbers: tuple[BoundedNumber, ...] = ()


class Body(Protocol):
    """Body of one agent, with its percept and action, for basic behaviors and features."""

    def sense(self, values: Sequence[float], heard: Sequence[str]) -> None:
        """Take this cycle's percept; the layout of ``values`` is the domain's own."""

    def act(self) -> tuple[Sequence[float], str]:
        """Return this cycle's action, in the domain's own layout, and a message to say, or ""."""


@dataclass(frozen=True)
class Domain:
    """Everything specific to a kind of robot.

    Attributes:
        name: identifier, as registered under the entry-point group.
        version: raised when the meaning of a behavior, feature or target changes.
        body: function that returns the body of an agent, given the agent's name.
        behaviors, features, targets: the vocabulary, by name.
        automata: hand-written automata, usable beside trained ones, by name.
        link: ``"module:Class"`` of the ROS side of the body, unless it is the standard link to a
            world node (percepts in, actions out).
        version_of: function that returns the version of some words, if their meaning is data; None
            if all have the domain's version.
    """

    name: str
    version: str
    body: Callable[[str], Any]
    behaviors: Mapping[str, BasicBehavior]
    features: Mapping[str, Feature]
    targets: Mapping[str, Target] = field(default_factory=dict)
    automata: Mapping[str, Automaton] = field(default_factory=dict)
    link: str = ""
    version_of: Callable[[Container[str]], str] | None = None

    @classmethod
    def of(
        cls,
        name: str,
        version: str,
        body: Callable[[str], Any],
        *,
        behaviors: Iterable[BasicBehavior],
        features: Iterable[Feature],
        targets: Iterable[Target] = (),
        automata: Iterable[Automaton] = (),
        link: str = "",
    ) -> Domain:
        """Make a domain from lists.

        Raises:
            VocabularyError: if a name is malformed, there twice in one list, or the engine's own.

        Examples:
            >>> class Cart:
            ...     def __init__(self, name):
            ...         self.position = self.speed = 0.0
            ...     def sense(self, values, heard):
            ...         (self.position,) = values
            ...     def act(self):
            ...         return [self.speed], ""
            ...     def drive(self, speed):
            ...         self.speed = speed
            >>> cart = Domain.of(
            ...     "cart",
            ...     "1",
            ...     Cart,
            ...     behaviors=[
            ...         BasicBehavior("Left", lambda body: body.drive(-1.0)),
            ...         BasicBehavior("Right", lambda body: body.drive(1.0)),
            ...     ],
            ...     features=[Feature("Position", lambda body: body.position, unit="m")],
            ... )
            >>> sorted(cart.behaviors)
            ['Left', 'Right']
        """
        groups: list[list[Any]] = [list(g) for g in (behaviors, features, targets, automata)]
        for group, taken in zip(groups, ((), OWN_NAMES, FLAGS, ()), strict=True):
            names = [thing.name for thing in group]
            for thing_name in names:
                if VOCABULARY_NAME.match(thing_name) is None:
                    raise VocabularyError(
                        f'domain "{name}": "{thing_name}" is not a name; {VOCABULARY_NAME_RULE}'
                    )
                if names.count(thing_name) > 1:
                    raise VocabularyError(f'domain "{name}" has "{thing_name}" twice')
                if thing_name in taken:
                    raise VocabularyError(
                        f'domain "{name}": "{thing_name}" is a name of the engine\'s own, which '
                        "every automaton has; choose another one"
                    )
        made = [{thing.name: thing for thing in group} for group in groups]
        return cls(name, version, body, made[0], made[1], made[2], made[3], link)

    @cached_property
    def signature(self) -> str:
        """A short digest of the vocabulary."""
        return self.signature_of(self.behaviors, self.features, self.targets)

    def signature_of(
        self, behaviors: Container[str], features: Container[str], targets: Container[str]
    ) -> str:
        """Return a short digest of these words, without unknown ones."""
        described = {
            "name": self.name,
            "behaviors": sorted(
                (b.name, list(b.parameters), b.one_shot, *([str(b.numbers)] if b.numbers else []))
                for b in self.behaviors.values()
                if b.name in behaviors
            ),
            "features": sorted(
                (f.name, list(f.parameters), f.kind.value, f.period, list(f.categories))
                for f in self.features.values()
                if f.name in features
            ),
            "targets": sorted(target for target in self.targets if target in targets),
        }
        return hashlib.sha256(json.dumps(described).encode()).hexdigest()[:16]

    def numbers_of(self, state: Term) -> tuple[BoundedNumber, ...]:
        """Return the numbers of a state's behavior; none unless it is a basic one with numbers."""
        behavior = self.behaviors.get(state.name)
        return () if behavior is None else behavior.numbers

    def feature(self, name: str) -> Feature:
        """Return a feature by name, of the domain or of the engine itself."""
        return FLAGS_AND_TIMERS[name] if name in FLAGS_AND_TIMERS else self.features[name]

    def scale_of(self, term: Term) -> Scale:
        """Return how the values of a feature compare."""
        return self.feature(term.name).scale

    def check_feature(self, term: Term, parameters: Iterable[str] = ()) -> None:
        """Check that ``term`` can be a feature of an automaton with these parameters.

        Raises:
            VocabularyError: naming the unknown or wrongly bound word.
        """
        if term in OWN_FEATURES:
            return
        if term.name in OWN_NAMES:
            there = [str(own) for own in OWN_FEATURES if own.name == term.name]
            raise VocabularyError(f'feature "{term}" must read {" or ".join(there)}')
        self.check_use(term, self._feature_parameters, parameters, what="feature")

    @cached_property
    def _feature_parameters(self) -> dict[str, tuple[str, ...]]:
        known = {**self.features, **FLAGS_AND_TIMERS}
        return {name: feature.parameters for name, feature in known.items()}

    def check_use(
        self,
        term: Term,
        known: Mapping[str, tuple[str, ...]],
        parameters: Iterable[str] = (),
        *,
        what: str,
    ) -> None:
        """Check that ``term`` names something in ``known`` with arguments that exist.

        Args:
            term: the term to check.
            known: the parameters of each behavior or feature that may be used, by name.
            parameters: parameters of the automaton that contains the term.
            what: kind of the words in ``known``, for the error: "behavior" or "feature".

        Raises:
            VocabularyError: naming the unknown and the known words.
        """
        check_known(what, term.name, known)
        expected = known[term.name]
        if len(term.arguments) != len(expected):
            raise VocabularyError(wrong_number(what, term, expected, {*self.targets, *parameters}))
        targets = {*self.targets, *parameters} if term.arguments else ()
        for argument in term.arguments:
            check_known("target", argument, targets, f' for {what} "{term.name}"')


def load_domain(name: str) -> Domain:
    """Return the installed domain called ``name``, or the one at ``"module:ATTRIBUTE"``.

    A name that ends in ``.py`` is the path of a file whose functions are the words; see
    `hitab_core.notebook.plain`. Once loaded, it is found by its name, as libraries keep it. It can
    run any code: take a name that a data file gives to `named_domain`.

    Raises:
        VocabularyError: if there is none, or it is not a domain.
    """
    if name.endswith(".py"):
        if (stem := Path(name).stem) in entry_points(group=ENTRY_POINT_GROUP).names:
            raise VocabularyError(f'{name}: domain "{stem}" is installed; rename the file')
        return _domain_of(load_file(Path(name)))
    module, _, attribute = name.partition(":")
    if not attribute:
        return named_domain(name)
    try:
        found = getattr(import_module(module), attribute)
    except (ImportError, AttributeError) as error:
        raise VocabularyError(
            f'domain "{name}" cannot be imported: {error}; it must read "module:ATTRIBUTE", '
            "with the module where Python finds it"
        ) from error
    return _checked(name, found)


def named_domain(name: str) -> Domain:
    """Return a domain that is installed, or whose file was loaded, by its name alone.

    Raises:
        VocabularyError: if there is none, or it is not a domain.
    """
    if (file := loaded_file(name)) is not None:
        return _domain_of(file)
    points = entry_points(group=ENTRY_POINT_GROUP)
    if name not in points.names:
        raise VocabularyError(
            f'no domain "{name}" is installed {has(points.names, name)}; a package provides one '
            f'under the entry-point group "{ENTRY_POINT_GROUP}". Of a world in one file, give the '
            "file: hitab up my_world.py, hitab library --file my_world.py list. A swarm file may "
            'say "module:ATTRIBUTE"'
        )
    return _checked(name, points[name].load())


def _checked(name: str, found: object) -> Domain:
    if not isinstance(found, Domain):
        raise VocabularyError(f'"{name}" is not a Domain but a {type(found).__name__}')
    return found


def _domain_of(file: ModuleType) -> Domain:
    """Return the domain of the words in a file, or its ``DOMAIN``, named after the file."""
    path = Path(str(file.__file__))
    if isinstance(own := getattr(file, "DOMAIN", None), Domain):
        return replace(own, name=path.stem)

    def words(kind: type[Any]) -> list[Any]:
        return [word for word in vars(file).values() if isinstance(word, kind)]

    try:
        return Domain.of(
            path.stem,
            str(getattr(file, "VERSION", "1")),
            PlainBody,
            behaviors=words(BasicBehavior),
            features=words(Feature),
            targets=words(Target),
        )
    except VocabularyError as error:
        raise VocabularyError(f"{path}: {error}") from error
