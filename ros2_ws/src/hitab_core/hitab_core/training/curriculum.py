"""Curriculum of a training: the automaton's name, features and states."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

from hitab_core.automaton import FLAGS, Automaton
from hitab_core.learning.transition_learning import learner
from hitab_core.repertoire import Repertoire
from hitab_core.term import VOCABULARY_NAME, VOCABULARY_NAME_RULE, Term
from hitab_core.texts.errors import TrainingError, VocabularyError
from hitab_core.texts.vocabulary import check_known, did_you_mean, has, unknown
from hitab_core.texts.wording import quantity


@dataclass(frozen=True)
class Curriculum:
    """The choices made before training begins.

    Attributes:
        name: name of the automaton to be trained.
        features: available to the transition functions.
        states: states that may be commanded; empty for anything in the repertoire.
        parameters: free variables of the automaton.
        arguments: the targets that the parameters are bound to during training.
        classifier: ``"tree"`` or a scikit-learn classifier (`scikit_learn_adapter`).
    """

    name: str
    features: tuple[Term, ...]
    states: tuple[Term, ...] = ()
    parameters: tuple[str, ...] = ()
    arguments: tuple[str, ...] = ()
    classifier: str = "tree"

    @classmethod
    def parse(
        cls,
        name: str,
        features: Iterable[str],
        states: Iterable[str],
        bindings: Mapping[str, str],
        classifier: str,
    ) -> Curriculum:
        """Return a curriculum whose features and states are given as texts.

        Args:
            bindings: the target of each parameter during training.

        Raises:
            VocabularyError: if a text is not a use of a behavior or feature.

        Examples:
            >>> wanted = Curriculum.parse("GoTo", ["DistanceTo(A)"], [], {"A": "ball"}, "tree")
            >>> wanted.features
            (Term(name='DistanceTo', arguments=('A',)),)
        """
        return cls(
            name,
            tuple(map(Term.parse, features)),
            tuple(map(Term.parse, states)),
            tuple(bindings),
            tuple(bindings.values()),
            classifier,
        )


def check_curriculum(curriculum: Curriculum, repertoire: Repertoire) -> None:
    """Check that everything a curriculum names exists, including its classifier.

    Raises:
        VocabularyError: naming the unknown word.
    """
    name = curriculum.name
    for text in (name, *curriculum.parameters):
        if VOCABULARY_NAME.match(text) is None:
            raise VocabularyError(f'"{text}" is not a name; {VOCABULARY_NAME_RULE}')
    if len(set(curriculum.parameters)) < len(curriculum.parameters):
        raise VocabularyError(f'"{name}" has a parameter twice; give each a name of its own')
    if len(curriculum.parameters) != len(curriculum.arguments):
        raise VocabularyError(
            f'"{name}" has {quantity(len(curriculum.parameters), "parameter")} but '
            f"{quantity(len(curriculum.arguments), 'target')} to train with; give one for each"
        )
    for argument in curriculum.arguments:
        check_known("target", argument, repertoire.domain.targets)
    if len(set(curriculum.features)) < len(curriculum.features):
        raise VocabularyError(f'"{name}" has a feature twice')
    for term in (*curriculum.features, *curriculum.states):
        _check_arguments(term, {*repertoire.domain.targets, *curriculum.parameters})
    for feature in curriculum.features:
        repertoire.domain.check_feature(feature, curriculum.parameters)
    for state in curriculum.states:
        repertoire.check_state(state, curriculum.parameters)
    repertoire.check_name(name)
    # An empty automaton shows whether parameters are targets.
    repertoire.check(Automaton(name, (), curriculum.features, {}, curriculum.parameters))
    learner(curriculum.classifier, [repertoire.domain.scale_of(f) for f in curriculum.features])


def _check_arguments(term: Term, known: Collection[str]) -> None:
    for argument in term.arguments:
        if argument not in known and not did_you_mean(argument, known):
            where = f' in "{term}"'
            raise VocabularyError(
                f"{unknown('target', argument, known, where)}; if it is a parameter, give the "
                f"target that it stands for in training, as `-p {argument}=TARGET` does"
            )


def check_state(state: Term, curriculum: Curriculum, repertoire: Repertoire) -> None:
    """Check that a behavior can be a state of the automaton in training.

    Raises:
        TrainingError: if it is not among the states that were chosen.
        VocabularyError: if there is no such behavior or target, or it uses the automaton.
    """
    name = curriculum.name
    if state.name == name:
        raise VocabularyError(
            f'recursive automaton: "{name}" is what is being trained; a behavior cannot use itself'
        )
    repertoire.check_state(state, curriculum.parameters)
    if state.name not in FLAGS and name in repertoire.needed_by(state.name):
        raise VocabularyError(
            f'recursive automaton: "{state.name}" uses "{name}", which is being trained'
        )
    chosen = curriculum.states
    if chosen and state not in chosen:
        raise TrainingError(
            f'"{state}" is not among the states chosen for "{name}" {has(chosen, state)}; begin '
            "again with this state, or without a choice of states"
        )
