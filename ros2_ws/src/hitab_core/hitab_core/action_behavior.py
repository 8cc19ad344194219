"""Basic behaviors that another program carries out, such as the server of a ROS action.

The engine knows no ROS: a domain names the action and describes its goal as plain data. Performing
such a behavior makes an `ActionCall`, and a `Carrier`, which the agent's node provides, carries it
out and reports the outcome.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

from hitab_core.automaton import FLAGS
from hitab_core.domain import BasicBehavior, Domain, Feature
from hitab_core.term import Term
from hitab_core.texts.errors import HitabError, NoValueError, VocabularyError

DONE, FAILED = FLAGS


@dataclass(frozen=True, slots=True, kw_only=True)
class ActionBehavior(BasicBehavior):
    """A basic behavior that is the client of an action.

    Its first pulse after its state is entered sends a goal, leaving the state cancels it. The
    flag ``Done`` is up from the action's success until the state is left; ``Failed`` from its
    refusal, its failure, or the absence of a server. ``start``, ``pulse`` and ``stop`` work as in
    any basic behavior, for example to do something beside the action.

    Attributes:
        action_type: such as ``"nav2_msgs/action/NavigateToPose"``.
        action: name of the action, such as ``"navigate_to_pose"``; in the agent's namespace
            unless it begins with a slash.
        goal: values of the goal's fields, by path, such as ``"pose.header.frame_id"``. A value
            is a constant, or a function of the body and the resolved targets. Fields that are
            left out keep their defaults.
        feedback_within: time without feedback of the server after which the action fails, s; 0
            if the server may be silent.

    Examples:
        >>> go = ActionBehavior(
        ...     "GoTo",
        ...     parameters=("X",),
        ...     action_type="nav2_msgs/action/NavigateToPose",
        ...     action="navigate_to_pose",
        ...     goal={
        ...         "pose.header.frame_id": "map",
        ...         "pose.pose.orientation.w": 1.0,
        ...         "pose.pose.position.x": lambda body, point: point[0],
        ...         "pose.pose.position.y": lambda body, point: point[1],
        ...     },
        ... )
        >>> goal_of(go, None, [(2.0, 3.0)])["pose.pose.position.y"]
        3.0
    """

    action_type: str
    action: str
    goal: Mapping[str, Any] = field(default_factory=dict, hash=False)
    feedback_within: float = 0.0


@dataclass(frozen=True, slots=True)
class FeedbackFeature(Feature):
    """A feature that is a field of an action's feedback; see `feedback_feature`.

    Attributes:
        behavior: name of the `ActionBehavior`.
        path: path of the field in the feedback.
        converts: whether a function of the domain converts the field to a number.
    """

    behavior: str = ""
    path: str = ""
    converts: bool = False


def feedback_feature(
    name: str,
    behavior: str,
    path: str,
    value: Callable[[Any], float] | None = None,
    *,
    otherwise: float = math.nan,
    **more: Any,
) -> FeedbackFeature:
    """Return a feature that is a field of an action's feedback.

    Args:
        name: name of the feature.
        behavior: name of the `ActionBehavior`.
        path: path of the field in the feedback, such as ``"distance_remaining"``.
        value: function that converts the field to a number. Without it the field must be a
            number, a boolean, or a duration or time, whose value is in seconds.
        otherwise: value while the behavior is not performed, and until there is feedback.
        more: ``kind``, ``unit``, ``description`` and so on; see `Feature`.
    """
    convert = value or _number

    def read(body: Any) -> float:
        call = calls_of(body).current
        if call is None or call.behavior.name != behavior or call.feedback is None:
            if math.isnan(otherwise):
                raise NoValueError(
                    f'feature "{name}" has no value: there is no feedback of "{behavior}", which '
                    "is performed by the server of an action"
                )
            return otherwise
        found = call.feedback
        for part in path.split("."):
            found = getattr(found, part)
        return convert(found)

    return FeedbackFeature(
        name, read, **more, behavior=behavior, path=path, converts=value is not None
    )


def _number(value: Any) -> float:
    if hasattr(value, "nanosec"):
        return float(value.sec + value.nanosec * 1e-9)
    return float(value)


@dataclass(eq=False, slots=True)
class ActionCall:
    """One goal of an action, from entering a state until the state is left.

    Attributes:
        behavior: the behavior that has this goal.
        term: the behavior with its targets.
        goal: values of the goal's fields, by path.
        outcome: the flag raised at the end; empty before.
        why: reason of the failure, for people.
        accepted: whether the server has taken the goal.
        feedback: the last one, as an object with the fields of the action's feedback, or None.
        left: whether the state was left.
        pulses: number of pulses of the behavior.
    """

    behavior: ActionBehavior
    term: Term
    goal: Mapping[str, Any]
    outcome: str = ""
    why: str = ""
    accepted: bool = False
    feedback: Any = None
    left: bool = False
    pulses: int = 0

    @property
    def is_open(self) -> bool:
        """Whether it may still succeed or fail."""
        return not (self.left or self.outcome)

    def succeed(self) -> None:
        """Raise ``Done``, unless it is over or its state was left."""
        if self.is_open:
            self.outcome = DONE

    def fail(self, why: str) -> bool:
        """Raise ``Failed``, unless it is over or its state was left; return whether it did.

        Args:
            why: reason of the failure, for people.
        """
        if not self.is_open:
            return False
        self.outcome, self.why = FAILED, why
        return True


class Carrier(Protocol):
    """Carries out the calls of one agent."""

    def begin(self, call: ActionCall) -> None:
        """Send the goal; call `ActionCall.succeed` or `ActionCall.fail` once it is over."""

    def leave(self, call: ActionCall) -> None:
        """Cancel the goal, unless it is over."""

    def failed(self, call: ActionCall) -> None:
        """Report a call that failed before it could be begun."""


class ActionCalls:
    """Connects one body to ROS actions, which other nodes carry out.

    Attributes:
        carrier: carries out the calls; without one (None) each call fails.
        current: the call whose state is active, or None.
    """

    def __init__(self) -> None:
        self.carrier: Carrier | None = None
        self.current: ActionCall | None = None

    def begin(self, behavior: ActionBehavior, term: Term, goal: Callable[[], Any]) -> ActionCall:
        """Make a call and pass it to the carrier.

        Args:
            behavior: the behavior to perform.
            term: the behavior with its targets.
            goal: returns the goal; see `goal_of`.
        """
        call = self.current = ActionCall(behavior, term, {})
        try:
            call.goal = goal()
        except HitabError as error:
            call.fail(str(error))
        if self.carrier is None:
            call.fail("this program carries out no actions; only an agent's ROS node does")
        elif call.outcome:
            self.carrier.failed(call)
        else:
            self.carrier.begin(call)
        return call

    def leave(self, call: ActionCall) -> None:
        """Cancel a call, since its state is left."""
        call.left = True
        if self.current is call:
            self.current = None
        if self.carrier is not None:
            self.carrier.leave(call)


def calls_of(body: Any) -> ActionCalls:
    """Return the connection of a body to actions, kept as its attribute ``action_calls``.

    Raises:
        VocabularyError: if the body cannot have this attribute.
    """
    calls = getattr(body, "action_calls", None)
    if not isinstance(calls, ActionCalls):
        calls = ActionCalls()
        try:
            body.action_calls = calls
        except AttributeError:
            raise VocabularyError(
                f'the body {type(body).__name__} cannot have an attribute "action_calls", which '
                "behaviors that are actions need; add it to the __slots__ of the class"
            ) from None
    return calls


def goal_of(behavior: ActionBehavior, body: Any, targets: Sequence[Any]) -> dict[str, Any]:
    """Return the values of a goal's fields, by path.

    Raises:
        VocabularyError: naming the field whose value could not be made.
    """
    made = {}
    for path, value in behavior.goal.items():
        try:
            made[path] = value(body, *targets) if callable(value) else value
        except Exception as error:  # domain code
            raise VocabularyError(
                f'the field "{path}" of its goal could not be made: '
                f"{type(error).__name__}: {error}"
            ) from error
    return made


def action_behaviors(domain: Domain) -> list[ActionBehavior]:
    """Return the behaviors of a domain that are actions."""
    return [one for one in domain.behaviors.values() if isinstance(one, ActionBehavior)]


def uses_actions(domain: Domain) -> bool:
    """Whether a domain has behaviors that are actions, or features of their feedback."""
    features = domain.features.values()
    return bool(action_behaviors(domain)) or any(isinstance(f, FeedbackFeature) for f in features)
