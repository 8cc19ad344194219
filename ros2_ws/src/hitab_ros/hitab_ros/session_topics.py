"""The topics of a recorded session: what an agent took in, in the order in which it did.

An agent in a process of its own publishes them while somebody subscribes to the percepts
(`hitab_agent.session_log`). All come from its one thread, so the times at which they were sent put
them in the order in which the agent handled them. That is what a training from a recording needs:
who receives a percept and a command from two other processes does not know which the agent took
first.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from hitab_msgs import msg, srv
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

from hitab_ros import names

PERCEIVED, COMMANDED, REQUESTED = "perceived", "commanded", "requested"
KNOWN = "known"

TOPICS: Mapping[str, Any] = {
    PERCEIVED: msg.Percept,
    COMMANDED: msg.Command,
    REQUESTED: String,
    KNOWN: msg.Distribution,
}
"""Each percept, command and request as it is taken up; and first the files of all that it knows.

A request is JSON, since readers of bags do not know the types of ROS 2's own topics of services.
"""

SERVICES: Mapping[str, Any] = {
    names.BEGIN: srv.BeginTraining,
    names.SET_MODE: srv.SetMode,
    names.EDIT_EXAMPLES: srv.EditExamples,
    names.ANSWER_QUESTION: srv.AnswerQuestion,
    names.SET_CAUTION: srv.SetCaution,
    names.SAVE: srv.SaveBehavior,
    names.PERFORM: srv.Perform,
    names.LOAD_LIBRARY: srv.LoadLibrary,
}
"""The services whose requests change what an agent learns or does."""

SEARCHED = "list_questions"
"""Stands for a request without fields: the agent has looked for questions, and numbered them."""

PERCEPTS_QOS = QoSProfile(
    history=HistoryPolicy.KEEP_LAST, depth=1000, reliability=ReliabilityPolicy.RELIABLE
)
"""In a fast lockstep the one who records may be behind."""


def request_text(service: str, request: Any) -> str:
    """Return a request to one of these services as JSON; `request_of` returns the same request."""
    there = request.get_fields_and_field_types() if request is not None else ()
    fields = {name: _plain(getattr(request, name)) for name in there}
    return json.dumps({"service": service, "request": fields})


def request_of(text: str) -> tuple[str, Any]:
    """Return a service and the request to it.

    Raises:
        ValueError: if the text is no request to one of these services.
    """
    try:
        read = json.loads(text)
        service, fields = read["service"], read["request"]
        if service == SEARCHED:
            return service, None
        kind = SERVICES[service].Request
        if fields.keys() != kind.get_fields_and_field_types().keys():
            raise ValueError("it has other fields")
        return service, kind(**fields)
    except (AssertionError, AttributeError, KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{text[:80]} is no request to an agent: {error!r}") from None


def _plain(value: Any) -> Any:
    return value if isinstance(value, str | bool | int | float) else list(value)
