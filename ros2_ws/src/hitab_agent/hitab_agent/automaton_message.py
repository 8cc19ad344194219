"""Automata, trainings and questions as messages."""

from __future__ import annotations

from array import array
from typing import Any

from hitab_msgs import msg

from hitab_core import Automaton, Domain, HitabError, Term, TrainingSession, TransitionTree
from hitab_core.assistant import Question
from hitab_core.learning import (
    TREE,
    Arc,
    Categories,
    ClassifierSpec,
    Leaf,
    Node,
    Threshold,
    learn_transitions,
    nodes,
)
from hitab_ros.conversions import example_message, feature_message, number_messages


def automaton_message(automaton: Automaton, domain: Domain, **more: Any) -> msg.Automaton:
    """Return an automaton as a message.

    Args:
        automaton: the automaton.
        domain: the agent's domain.
        more: further fields of the message.
    """
    return msg.Automaton(
        name=automaton.name,
        description=automaton.description,
        parameters=list(automaton.parameters),
        states=list(automaton.labels),
        with_numbers=[
            msg.Behavior(name=name, numbers=number_messages(numbers))
            for name in sorted({state.name for state in automaton.states})
            if (numbers := domain.numbers_of(Term(name)))
        ],
        features=[
            feature_message(str(term), domain.feature(term.name), domain.scale_of(term))
            for term in automaton.features
        ],
        readable=list(map(str, automaton.readable)),
        examples=list(map(example_message, automaton.examples)),
        trees=[
            _tree_message(state, tree)
            for state, tree in automaton.transitions.items()
            if isinstance(tree, TransitionTree)
        ],
        **more,
    )


def training_message(session: TrainingSession, domain: Domain) -> msg.Automaton:
    """Return the state of a training as a message."""
    curriculum, examples = session.curriculum, session.examples
    automaton = Automaton(
        curriculum.name,
        tuple(map(Term.parse, session.states)),
        curriculum.features,
        _learned(session, domain),
        curriculum.parameters,
        examples,
        readable=session.history.readable,
    )
    chosen = list(map(str, curriculum.states))
    message = automaton_message(
        automaton,
        domain,
        classifier=curriculum.classifier,
        arguments=list(curriculum.arguments),
        chosen_states=chosen,
    )
    message.states = [*chosen, *(s for s in session.states if s not in chosen)]
    return message


def _learned(session: TrainingSession, domain: Domain) -> Any:
    curriculum = session.curriculum
    if ClassifierSpec.parse(curriculum.classifier).name != TREE:
        return {}
    scales = [domain.scale_of(term) for term in curriculum.features]
    names = list(map(str, curriculum.features))
    try:
        return learn_transitions(session.examples, scales, curriculum.classifier, names)
    except HitabError:  # a test or a save reports the reason
        return {}


def question_message(question: Question, session: TrainingSession) -> msg.Question:
    """Return a question as a message."""
    features = map(str, session.curriculum.features)
    return msg.Question(
        number=question.number,
        kind=question.kind.value,
        text=question.text,
        state=question.state,
        examples=list(question.examples),
        choices=[
            msg.Choice(name=choice.name, effect=choice.effect) for choice in question.choices
        ],
        situation=[
            msg.Reading(feature=feature, value=value)
            for feature, value in zip(features, question.situation, strict=False)
        ],
    )


def _tree_message(state: str, tree: TransitionTree) -> msg.TransitionTree:
    return msg.TransitionTree(
        state=state, labels=tree.labels, nodes=list(map(_node_message, nodes(tree.root_)))
    )


def _node_message(node: Node) -> msg.TreeNode:
    kinds, message = msg.TreeNode, msg.TreeNode(counts=array("d", node.counts))
    if isinstance(node, Leaf):
        return message
    message.feature = node.feature
    match node.test:
        case Threshold(threshold):
            message.kind, numbers = kinds.THRESHOLD, [threshold]
        case Arc(start, end, period):
            message.kind, numbers = kinds.ARC, [period, start, end]
        case Categories(categories):
            message.kind, numbers = kinds.CATEGORY, list(map(float, categories))
    message.numbers = array("d", numbers)
    return message
