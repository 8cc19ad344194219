"""The read-only services of an agent: they show its behaviors and what it perceives."""

from __future__ import annotations

from typing import Any

from hitab_msgs import msg, srv

from hitab_agent.guarded_tick import failing
from hitab_core import (
    FLAGS,
    Agent,
    Automaton,
    BasicBehavior,
    Domain,
    TrainingError,
    Use,
    quantity,
    to_be_saved,
)
from hitab_core.library import difference
from hitab_core.running import live_features
from hitab_ros import GuardedNode, names
from hitab_ros.conversions import example_message, feature_message

Origin: Any = srv.GetBehavior.Response


class InspectionServices:
    """Offers the services; the node's guard turns what they raise into a reply."""

    def __init__(self, node: GuardedNode, agent: Agent) -> None:
        self._agent = agent
        node.create_service(srv.GetBehavior, names.GET_BEHAVIOR, self._get_behavior)
        node.create_service(srv.ReadFeatures, names.READ_FEATURES, self._read_features)

    # -- what it perceives ------------------------------------------------------------------

    def _read_features(
        self, request: srv.ReadFeatures.Request, answer: srv.ReadFeatures.Response
    ) -> srv.ReadFeatures.Response:
        agent, also = self._agent, [Use.parse(text) for text in request.also]
        readings = live_features(agent.running, agent.context, also)
        answer.readings = [
            msg.Reading(automaton=automaton, feature=feature, value=value)
            for automaton, feature, value in readings
        ]
        answer.cycle = self._agent.cycle
        answer.message = failing(self._agent)
        answer.success = True
        return answer

    # -- what it can do ---------------------------------------------------------------------

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
        session = self._agent.session
        if session is None:
            raise TrainingError(f"{self._agent.name} is not training anything; name a behavior")
        curriculum = session.curriculum
        answer.chosen_states = list(map(str, curriculum.states))
        if request.with_features:
            chosen = list(map(Use.parse, request.with_features))
            _fill_in(answer, session.with_features(chosen), self._agent.domain)
            answer.origin, answer.classifier = Origin.TRAINING, curriculum.classifier
            return
        answer.origin = Origin.TRAINING
        answer.classifier = curriculum.classifier
        answer.arguments = list(curriculum.arguments)
        if request.trim:
            if len(request.bind_from) != len(request.bind_to):
                raise TrainingError(
                    f"bind_from has {quantity(len(request.bind_from), 'name')}, "
                    f"bind_to {len(request.bind_to)}"
                )
            bindings = dict(zip(request.bind_from, request.bind_to, strict=True))
            automaton, answer.trimmed = to_be_saved(
                session, bindings=bindings, keep_unused=request.keep_unused
            )
            answer.arguments = []
            _fill_in(answer, automaton, self._agent.domain)
            return
        states = list(map(str, curriculum.states))
        states += [s for s in session.states if s not in states]
        blank = Automaton(
            curriculum.name,
            tuple(map(Use.parse, states)),
            curriculum.features,
            {},
            curriculum.parameters,
            session.examples,
        )
        _fill_in(answer, blank, self._agent.domain)

    def _show_behavior(
        self, request: srv.GetBehavior.Request, answer: srv.GetBehavior.Response
    ) -> None:
        repertoire, library = self._agent.repertoire, self._agent.library
        name = request.name
        # A behavior that was removed from the library may still have versions there.
        answer.versions = library.versions(name) if name not in FLAGS else []
        known = self._agent.edition.files
        if name not in known and not request.version:
            behavior = repertoire.get(name)
            if isinstance(behavior, BasicBehavior):
                answer.name, answer.description = behavior.name, behavior.description
                answer.parameters = list(behavior.parameters)
                answer.origin = Origin.BASIC
                return
            answer.origin = Origin.HAND_WRITTEN
            _fill_in(answer, behavior, self._agent.domain)
            return
        file = library.version(name, request.version) if request.version else known[name]
        answer.origin = Origin.TRAINED
        answer.classifier = file.classifier
        answer.version = file.provenance.version
        answer.created = file.provenance.created
        answer.note = _origin(file.provenance)
        _fill_in(answer, file.automaton, self._agent.domain)
        if request.compare_with:
            before = library.version(name, request.compare_with)
            answer.difference = difference(before, file)


def _origin(provenance: Any) -> str:
    """Return a text that says where a version comes from."""
    parts = [f"trained by {provenance.agent}"] if provenance.agent else []
    parts += [text for text in (provenance.author, provenance.note) if text]
    return ", ".join(parts)


def _fill_in(answer: srv.GetBehavior.Response, automaton: Automaton, domain: Domain) -> None:
    answer.name = automaton.name
    answer.description = automaton.description
    answer.parameters = list(automaton.parameters)
    answer.states = list(automaton.labels)
    answer.features = [
        feature_message(str(feature), domain.feature(feature.name), domain.scale_of(feature))
        for feature in automaton.features
    ]
    answer.examples = [example_message(example) for example in automaton.examples]
