"""The operations of an agent as services of its node, and its two reports.

An operation arrives with a request, or with a message on the command topic. It goes through one
function, `AgentBase.do`, which also publishes what became of it.
"""

from __future__ import annotations

from contextlib import suppress
from functools import partial
from typing import Any

from hitab_msgs import msg, srv

from hitab_agent.node.agent_base import AgentBase
from hitab_core import (
    FLAGS,
    OWN_FEATURES,
    BasicBehavior,
    Fix,
    HitabError,
    Term,
    TrainingError,
    has,
    operations,
    quantity,
)
from hitab_core.assistant import training_costs
from hitab_core.codec import from_dict
from hitab_core.training.operation import Operation
from hitab_ros import names, qos
from hitab_ros.answering import refuse
from hitab_ros.messages.checks import BadMessage, check
from hitab_ros.messages.conversions import feature_message, message_of


class CommandTopic:
    """Receives commands that need no answer; the agent's status shows what became of them."""

    def __init__(self, node: AgentBase) -> None:
        """Subscribe to commands."""
        self._node = node
        # Checked below, so that the status shows the sender what is wrong.
        node.create_subscription(
            msg.Command, names.COMMAND, self._on_command, qos.EVENTS, checked=False
        )

    def _on_command(self, command: msg.Command) -> None:
        try:
            check(command)
        except BadMessage as error:
            self._node.answered(error)
            return
        with suppress(HitabError):  # a refusal, which the status shows
            self._node.do(from_dict(operations.Command, command))


class AgentServices:
    """Offers an agent's services; a refusal is a reply with ``success`` false and the reason."""

    def __init__(self, node: AgentBase) -> None:
        """Offer the services of an agent's node."""
        self._node = node
        for name, kind in operations.OPERATIONS.items():
            serve = partial(self._serve, kind)
            node.create_service(getattr(srv, kind.__name__), name, serve)
        node.create_service(srv.GetReport, names.GET_REPORT, self._get_report)
        node.create_service(srv.GetVocabulary, names.GET_VOCABULARY, self._get_vocabulary)

    def _serve(self, kind: type[Operation], request: Any, response: Any) -> Any:
        """Carry out the operation of a request; the reply has the status after it."""
        try:
            outcome = self._node.do(from_dict(kind, request))
            response = message_of(type(response), outcome, success=True)
        except HitabError as error:
            refuse(response, error)
        response.status = self._node.status.message
        return response

    def _get_report(
        self, request: srv.GetReport.Request, response: srv.GetReport.Response
    ) -> srv.GetReport.Response:
        agent = self._node.agent
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
        response.costs = [message_of(msg.TrainingCost, cost) for cost in costs]
        response.success, response.message = True, quantity(len(costs), "training")
        return response

    def _get_vocabulary(
        self, request: srv.GetVocabulary.Request, response: srv.GetVocabulary.Response
    ) -> srv.GetVocabulary.Response:
        agent = self._node.agent
        domain, repertoire = agent.domain, agent.repertoire
        behaviors = [repertoire.get(name) for name in repertoire.names()]
        features = sorted(domain.features.values(), key=lambda feature: feature.name)
        response.domain = domain.name
        response.signature = domain.signature
        response.behaviors = [
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
        response.features = [feature_message(term, feature) for term, feature in words]
        response.targets = sorted(domain.targets)
        return response
