"""Training an agent by demonstration from a notebook or a script: no ROS, no files needed."""

from __future__ import annotations

import math
import tempfile
import warnings
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Self

import numpy as np

from hitab_core.agent import Agent
from hitab_core.automaton import Automaton
from hitab_core.domain import Domain
from hitab_core.example import Example
from hitab_core.learning.transition_learning import rules_of
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.running.mode import Mode
from hitab_core.term import Term
from hitab_core.texts.errors import FeatureValueError, HitabError, TrainingError
from hitab_core.texts.wording import quantity
from hitab_core.training.curriculum import Curriculum

MISSING = ("NAType", "NaTType")
"""Types of pandas' missing values, given by name so that pandas is not imported."""

MANY_RULES = 20
"""An automaton with fewer is small enough to be read, however few its examples."""


class LearningAgent:
    """An agent that is trained step by step, in the process of its trainer.

    Each step takes a percept and, during a training, the name of a behavior that the agent
    should perform; each command records an example. `learn` turns the examples into an automaton
    that then decides; a command after that corrects it. `save` adds the automaton to the library,
    so that the next training can use it as a state.

    It uses the engine's `Agent`, which also runs inside a ROS node: a behavior saved in a library
    folder here can be performed by a swarm whose agents have the same domain.

    Attributes:
        agent: the engine's agent.

    Examples:
        >>> from hitab_core import LearningAgent, plain_domain
        >>> cart = plain_domain("cart", {"Left": [-1.0], "Right": [1.0]}, ["Position"])
        >>> agent = LearningAgent(cart).train("Shuttle")
        >>> agent.step([0.0], command="Right")
        (1.0,)
        >>> agent.step([5.0], command="Left")
        (-1.0,)
        >>> agent.step([0.0], command="Right")
        (1.0,)
        >>> automaton = agent.learn()
        >>> agent.decide([4.0]), agent.decide([5.0]), agent.decide([1.0])
        ('Right', 'Left', 'Left')
    """

    def __init__(
        self,
        domain: Domain,
        library: Path | str | None = None,
        *,
        name: str = "agent",
        seed: int = 0,
        period: float = 0.1,
    ) -> None:
        """Make an agent with the behaviors of a domain and of a library.

        Args:
            domain: domain with the basic behaviors, features and targets; see `plain_domain`.
            library: folder of the trained behaviors, made on the first save; by default a folder
                that is deleted with the agent.
            name: name of the agent.
            seed: seed of the agent's random numbers.
            period: duration of a step, s.

        Behaviors that cannot be used are warnings that name the way out.

        Raises:
            LibraryError: if the library's folder cannot be read.
        """
        if library is None:
            self._temporary = tempfile.TemporaryDirectory(prefix="hitab-")
            library = self._temporary.name
        self.agent = Agent(name, domain, BehaviorLibrary(library, domain), seed=seed)
        for fault in self.agent.faults:
            ways = self.agent.loaded.losses.ways_out
            warnings.warn(str(HitabError(fault, *ways)), stacklevel=2)
        self._cycle = 0
        self._period = period
        self._size: int | None = None

    def train(
        self,
        behavior: str,
        features: Iterable[str] | None = None,
        *,
        states: Iterable[str] = (),
        parameters: Mapping[str, str] | None = None,
        classifier: str = "tree",
        discard: bool = False,
    ) -> Self:
        """Begin to train a behavior.

        Args:
            behavior: name of the behavior.
            features: available to decisions, such as ``["DistanceTo(ball)"]``; None
                for all features of the domain without parameters.
            states: behaviors that may be commanded; empty for all.
            parameters: parameters of the behavior, each with its target in training.
            classifier: see `hitab_core.learning.transition_learning.learner`.
            discard: discard an unsaved training.

        Returns:
            The agent itself.

        Raises:
            TrainingError: if another training has not been saved.
            VocabularyError: naming the unknown word and the known ones.
        """
        if features is None:
            words = self.agent.domain.features.values()
            features = [feature.name for feature in words if not feature.parameters]
            if not features:
                raise TrainingError(
                    f'all features of domain "{self.agent.domain.name}" have parameters; say '
                    'which to use, for example features=["DistanceTo(ball)"]'
                )
        curriculum = Curriculum.parse(behavior, features, states, parameters or {}, classifier)
        if self.agent.unsaved and not discard:
            raise TrainingError(
                f'"{self.agent.training}" has {quantity(self.agent.unsaved, "unsaved example")}; '
                "call save() first, or train with discard=True"
            )
        self.agent.begin(curriculum, discard=discard)
        self._size = None
        return self

    def step(
        self,
        percept: Sequence[Any],
        command: Any = None,
        heard: Sequence[str] = (),
        *,
        ago: float = 0.0,
    ) -> tuple[float, ...]:
        """Perform one timestep.

        Args:
            percept: values in the layout of the domain; None, NaN or pandas' NA where there is no
                value.
            command: the behavior to perform from now on, such as ``"GoTo(ball)"``, or a flag;
                None, an empty text or NaN for no command.
                A command is recorded as an example; after `learn` as a correction, and the
                demonstrator stays in control until `learn` is called again.
            heard: the messages heard.
            ago: time since the command was due, s; it is recorded with the percept of that time.

        Returns:
            The action, in the layout of the domain, or empty.

        Raises:
            TrainingError: if nothing is being trained; if no behavior has been commanded yet.
            VocabularyError: if there is no such behavior or target, naming the known ones.
            FeatureValueError: if the percept is not a list of numbers, as many as before, or a
                feature has no value.
        """
        agent = self.agent
        known, name = self._checked(percept), _name_of(command)
        self._cycle += 1
        agent.sense(known, heard, self._cycle, self._cycle * self._period)
        if name is not None:
            term = Term.parse(name)
            if agent.mode is not Mode.TRAINING and agent.session is not None:
                agent.take_over()
            recorded = agent.command(term)
            if ago and agent.session is not None:
                agent.session.retime([example.number for example in recorded], ago)
        elif agent.mode is Mode.IDLE or (agent.mode is Mode.TRAINING and not self.examples):
            self._size = len(percept)
            raise TrainingError(
                f"{agent.name} does not know what to do; command a behavior with "
                f'step(percept, command="{next(iter(agent.domain.behaviors), "Name")}")'
                + ("" if agent.session is not None else ", after train(name)")
            )
        agent.tick()
        self._size = len(percept)  # not before: the error may be in the size
        return tuple(map(float, agent.body.act()[0]))

    def learn(self) -> Automaton:
        """Learn from the examples; the learned automaton decides from now on, beginning at Start.

        More rules than examples can support are a warning.

        Returns:
            The automaton, untrimmed; ``print(automaton_as_text(automaton))`` shows it.

        Raises:
            TrainingError: if nothing is being trained, or nothing was commanded.
        """
        self.agent.test(restart=True)
        assert self.agent.session is not None
        automaton = self.agent.session.automaton()
        rules = sum(map(len, rules_of(automaton).values()))
        if rules > MANY_RULES and 3 * rules > len(automaton.examples):
            warnings.warn(
                f"it has {rules} rules for {len(automaton.examples)} examples: what was commanded "
                f"hardly depends on {', '.join(automaton.feature_labels)}; choose other features",
                stacklevel=2,
            )
        return automaton

    def decide(self, percept: Sequence[Any], heard: Sequence[str] = ()) -> str:
        """Perform one timestep and return the state that the automaton is in afterwards.

        Raises:
            TrainingError: if `learn` or `perform` has not been called.
            FeatureValueError: see `step`.
        """
        agent = self.agent
        if agent.mode not in (Mode.TESTING, Mode.PERFORMING):
            raise TrainingError(
                f"{agent.name} has not learned yet; call learn() after commanding, or "
                "perform(name)"
            )
        self.step(percept, heard=heard)
        path = agent.active_path
        return path[0] if path else agent.behavior

    def perform(self, behavior: str) -> Self:
        """Perform a behavior of the library, or a basic one, from its beginning.

        Raises:
            VocabularyError: if there is no such behavior or target, naming the known ones.
        """
        self.agent.perform(Term.parse(behavior))
        return self

    def save(self, name: str = "", description: str = "") -> Path:
        """Trim the learned automaton and add it to the library; this ends the training.

        Signs of an automaton that does not work are warnings.

        Args:
            name: name to save it under; empty to keep the name.
            description: text for people who browse the library.

        Returns:
            Its file.

        Raises:
            TrainingError: if nothing is being trained, or nothing was commanded.
            LibraryError, VocabularyError: if it cannot be written, or does not fit.
        """
        remarks = self.agent.remarks(look=True)
        path = self.agent.save(name, description=description).path
        for remark in remarks:
            warnings.warn(str(HitabError(str(remark), remark.remedy)), stacklevel=2)
        return path

    @property
    def examples(self) -> tuple[Example, ...]:
        """The examples of the training under way."""
        session = self.agent.session
        return () if session is None else session.examples

    def _checked(self, percept: Sequence[Any]) -> list[float]:
        """Return the percept with NaN for missing values."""
        try:
            right = not isinstance(percept, str) and not any(
                isinstance(v, str) or np.ndim(v) for v in percept
            )
        except TypeError:  # it is one number
            right = False
        if not right:
            raise FeatureValueError(
                f"a percept is a list of numbers, such as [1.0, 0.5], not {percept!r}"
            )
        if self._size is not None and len(percept) != self._size:
            raise FeatureValueError(
                f"this percept has {quantity(len(percept), 'value')}, the first one had "
                f"{self._size}; pass the same values in each step; if the first one was wrong, "
                "begin again with train(name, discard=True)"
            )
        return [_number(value, place) for place, value in enumerate(percept, 1)]


def _number(value: Any, place: int) -> float:
    """Return a value of a percept; NaN if it is missing."""
    if value is None or type(value).__name__ in MISSING:
        return math.nan
    try:
        return float(value)
    except (TypeError, ValueError):
        raise FeatureValueError(
            f"value {place} of the percept is {value!r}, which is no number; give a number, or "
            "None where there is none"
        ) from None


def _name_of(command: Any) -> str | None:
    """Return the name of a command; None if it is None, an empty cell or NaN."""
    if isinstance(command, str):
        return command or None
    if command is None or type(command).__name__ in MISSING or command != command:
        return None
    raise TrainingError(
        f"the command is {command!r}; give the name of a behavior, or None if there is none"
    )
