"""The read-only services of an agent: its percepts, words, behaviors and costs of training."""

from __future__ import annotations

from typing import Any

from hitab_msgs import msg, srv

from hitab_agent.endpoints import OfferedService
from hitab_agent.node.guarded_tick import failing
from hitab_agent.topics.automaton_message import automaton_message, training_message
from hitab_core import (
    FLAGS,
    OWN_FEATURES,
    Agent,
    BasicBehavior,
    Fix,
    Term,
    TrainingError,
    earlier,
    has,
    quantity,
)
from hitab_core.assistant import training_costs
from hitab_core.library import difference
from hitab_ros import GuardedNode, names
from hitab_ros.messages.conversions import (
    feature_message,
    message_of,
    pairs_of,
)

Origin: Any = srv.GetBehavior.Response


class InspectionServices:
    """The read-only services; the node's guard turns exceptions into replies.

    Attributes:
        endpoints: the services.
    """

    def __init__(self, node: GuardedNode, agent: Agent) -> None:
        self._agent = agent
        self.endpoints = [
            OfferedService(node, kind, name, serve)
            for kind, name, serve in (
                (srv.GetReport, names.GET_REPORT, self._get_report),
                (srv.GetVocabulary, names.GET_VOCABULARY, self._get_vocabulary),
                (srv.GetBehavior, names.GET_BEHAVIOR, self._get_behavior),
                (srv.ReadFeatures, names.READ_FEATURES, self._read_features),
            )
        ]

    # -- percepts ---------------------------------------------------------------------------

    def _read_features(
        self, request: srv.ReadFeatures.Request, answer: srv.ReadFeatures.Response
    ) -> srv.ReadFeatures.Response:
        agent, also = self._agent, [Term.parse(text) for text in request.also]
        then = earlier(agent, request.cycle, also)
        answer.readings = [
            msg.Reading(automaton=automaton, feature=feature, value=value)
            for automaton, feature, value in then.readings
        ]
        answer.cycle, answer.active_path = then.cycle, list(then.active_path)
        answer.preview = message_of(msg.Preview, then.preview)
        answer.message = failing(self._agent)
        answer.success = True
        return answer

    # -- vocabulary and behaviors -----------------------------------------------------------

    def _get_vocabulary(
        self, request: srv.GetVocabulary.Request, answer: srv.GetVocabulary.Response
    ) -> srv.GetVocabulary.Response:
        agent = self._agent
        domain, repertoire = agent.domain, agent.repertoire
        behaviors = [repertoire.get(name) for name in repertoire.names()]
        features = sorted(domain.features.values(), key=lambda feature: feature.name)
        answer.domain = domain.name
        answer.signature = domain.signature
        answer.behaviors = [
            msg.Behavior(
                name=str(Term(b.name, b.parameters)),
                description="; ".join([b.description, *map(str, domain.numbers_of(Term(b.name)))]),
                trained=b.name in agent.loaded.files,
                one_shot=isinstance(b, BasicBehavior) and b.one_shot,
                numbers=[message_of(msg.Number, n) for n in domain.numbers_of(Term(b.name))],
            )
            for b in behaviors
        ]
        words = [(Term(f.name, f.parameters), f) for f in features]
        words += [
            (term, domain.feature(term.name)) for term in OWN_FEATURES if term.name not in FLAGS
        ]
        answer.features = [feature_message(term, feature) for term, feature in words]
        answer.targets = sorted(domain.targets)
        return answer

    def _get_behavior(
        self, request: srv.GetBehavior.Request, answer: srv.GetBehavior.Response
    ) -> Any:
        if request.name:
            self._show_behavior(request, answer)
        else:
            self._show_training(request, answer)
        answer.success = True
        return answer

    def _show_training(
        self, request: srv.GetBehavior.Request, answer: srv.GetBehavior.Response
    ) -> None:
        """Show the training under way, or the automaton that saving would give."""
        session, domain = self._agent.session, self._agent.domain
        if session is None:
            raise TrainingError(f"{self._agent.name} is not training anything; name a behavior")
        answer.origin = Origin.TRAINING
        classifier = session.curriculum.classifier
        if request.with_features:
            chosen = list(map(Term.parse, request.with_features))
            answer.automaton = automaton_message(
                session.with_features(chosen), domain, classifier=classifier
            )
        elif request.trim:
            automaton, answer.trimmed = session.trimmed(
                bindings=dict(pairs_of(request.bindings)), keep_unused=request.keep_unused
            )
            answer.automaton = automaton_message(automaton, domain, classifier=classifier)
        else:
            answer.automaton = training_message(session, domain)

    def _show_behavior(
        self, request: srv.GetBehavior.Request, answer: srv.GetBehavior.Response
    ) -> None:
        repertoire, library = self._agent.repertoire, self._agent.library
        name, domain = request.name, self._agent.domain
        # A behavior that was removed from the library may still have versions there.
        answer.versions = library.on_disk.versions(name) if name not in FLAGS else []
        known = self._agent.loaded.files
        if name not in known and not request.version:
            behavior = repertoire.get(name)
            if isinstance(behavior, BasicBehavior):
                answer.origin = Origin.BASIC
                answer.automaton = message_of(msg.Automaton, behavior)
                return
            answer.origin = Origin.HAND_WRITTEN
            answer.automaton = automaton_message(behavior, domain)
            return
        file = library.on_disk.version(name, request.version) if request.version else known[name]
        answer.origin = Origin.TRAINED
        answer.version = file.provenance.version
        answer.created = file.provenance.created
        answer.note = _origin(file.provenance)
        answer.automaton = automaton_message(file.automaton, domain, classifier=file.classifier)
        if request.compare_with:
            before = library.on_disk.version(name, request.compare_with)
            answer.difference = difference(before, file, self._agent.domain)

    # -- cost -------------------------------------------------------------------------------

    def _get_report(
        self, request: srv.GetReport.Request, answer: srv.GetReport.Response
    ) -> srv.GetReport.Response:
        agent = self._agent
        name = request.automaton or agent.training
        if not name:
            raise TrainingError("it is not training anything", Fix.EXAMPLES_OF(agent=agent.name))
        known = training_costs(agent.journal)
        costs = [cost for cost in known if cost.automaton == name]
        if not costs and name == agent.training:
            raise TrainingError(
                f'nothing was done yet in the training of "{name}"',
                Fix.DEMONSTRATE(agent=agent.name),
            )
        if not costs:
            raise TrainingError(
                f'{agent.name} has no record of a training of "{name}" '
                f"{has([cost.automaton for cost in known], name)}; ask the agent that was trained"
            )
        answer.costs = [message_of(msg.TrainingCost, cost) for cost in costs]
        answer.success, answer.message = True, quantity(len(costs), "training")
        return answer


def _origin(provenance: Any) -> str:
    """Return the origin of a version, in words."""
    parts = [f"trained by {provenance.agent}"] if provenance.agent else []
    parts += [text for text in (provenance.author, provenance.note) if text]
    return ", ".join(parts)
