"""Automata, trainings and questions as messages."""

from __future__ import annotations

from typing import Any

from hitab_msgs import msg

from hitab_core import Automaton, Domain, HitabError, Term, TrainingSession, TransitionTree
from hitab_core.assistant import Question
from hitab_core.learning import TREE, ClassifierSpec, learn_transitions, plain_nodes
from hitab_ros.messages.conversions import feature_message, message_of


def automaton_message(automaton: Automaton, domain: Domain, **more: Any) -> msg.Automaton:
    """Return an automaton as a message.

    Args:
        automaton: the automaton.
        domain: the agent's domain.
        more: further fields of the message.
    """
    return message_of(
        msg.Automaton,
        automaton,
        with_numbers=[
            msg.Behavior(name=name, numbers=[message_of(msg.Number, one) for one in numbers])
            for name in sorted({state.name for state in automaton.states})
            if (numbers := domain.numbers_of(Term(name)))
        ],
        features=[feature_message(term, domain.feature(term.name)) for term in automaton.features],
        trees=[
            msg.TransitionTree(
                state=state,
                labels=tree.labels,
                nodes=[message_of(msg.TreeNode, node) for node in plain_nodes(tree.root_)],
            )
            for state, tree in automaton.transitions.items()
            if isinstance(tree, TransitionTree)
        ],
        **more,
    )


def training_message(session: TrainingSession, domain: Domain) -> msg.Automaton:
    """Return the state of a training as a message."""
    curriculum = session.curriculum
    automaton = Automaton(
        curriculum.name,
        tuple(map(Term.parse, session.states)),
        curriculum.features,
        _learned(session, domain),
        curriculum.parameters,
        session.examples,
        readable=session.history.readable,
    )
    return automaton_message(
        automaton,
        domain,
        classifier=curriculum.classifier,
        arguments=list(curriculum.arguments),
        chosen_states=list(map(str, curriculum.states)),
    )


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
    return message_of(
        msg.Question,
        question,
        situation=[
            msg.Reading(feature=feature, value=value)
            for feature, value in zip(features, question.situation, strict=False)
        ],
    )
