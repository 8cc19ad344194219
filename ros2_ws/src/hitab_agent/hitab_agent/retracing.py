"""Training again from a recorded session, step by step, and comparing with what was recorded."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from hitab_msgs import msg

from hitab_agent.offline_agent import OfflineAgent
from hitab_core import Do, HitabError, Mode
from hitab_ros import names, session_topics

COMPARED = ("behavior", "mode", "examples", "default_examples", "active_path")
"""Fields of a status that say what was done in a training."""

IN_TRAINING = (Mode.TRAINING.value, Mode.TESTING.value)


@dataclass(frozen=True, slots=True)
class Step:
    """A message of the recorded agent.

    Attributes:
        sent: by the agent, ns since 1970.
        name: last part of its topic.
        message: it.
    """

    sent: int
    name: str
    message: Any


@dataclass
class Retraced:
    """What was done again.

    Attributes:
        percepts, commands, requests: how many were given to the agent.
        compared: how many recorded statuses it agreed with.
        saved: names of the behaviors that it saved, in order.
    """

    percepts: int = 0
    commands: int = 0
    requests: int = 0
    compared: int = 0
    saved: list[str] = field(default_factory=list)


class Retracer:
    """Gives an agent the steps of a recorded one, and compares what both do.

    Only trainings are compared: what the recorded agent performed before the first is unknown.
    """

    def __init__(self, offline: OfflineAgent) -> None:
        self.done = Retraced()
        self._offline = offline
        self._sequence: int | None = None
        self._begun = False
        self._sent: set[tuple[str, str, int]] = set()

    def take(self, steps: Iterable[Step]) -> Retraced:
        """Take the steps, in the order in which they were sent.

        Raises:
            HitabError: if a step is missing, or the agent did something else than the recorded
                one.
        """
        for step in steps:
            if step.name == session_topics.PERCEIVED:
                self._perceive(step.message)
            elif step.name == session_topics.COMMANDED:
                self.done.commands += 1
                self._offline.command(step.message)
            elif step.name == session_topics.REQUESTED:
                self._ask(step.message.data)
            elif step.name == names.STATUS:
                self._compare_status(step.message)
        return self.done

    def _perceive(self, percept: msg.Percept) -> None:
        before, self._sequence = self._sequence, percept.sequence
        if before == percept.sequence:
            return  # repeated for another one who records
        trains = self._offline.agent.mode.value in IN_TRAINING
        if before is not None and percept.sequence != before + 1 and trains:
            raise HitabError(
                f"percepts are missing between cycle {self._offline.agent.cycle} and cycle "
                f"{percept.cycle}: whoever recorded was too slow, or another world began; record "
                "again with less to do, or slower",
                Do.PACE(),
            )
        self.done.percepts += 1
        self._offline.perceive(percept)

    def _ask(self, text: str) -> None:
        try:
            service, request = session_topics.request_of(text)
        except ValueError as error:
            raise HitabError(
                f"the recording has a request that this version of HiTAB does not know: {error}"
            ) from None
        self._begun |= service == names.BEGIN
        answer = self._offline.ask(service, request)
        sent = service, getattr(request, "client", ""), getattr(request, "request", 0)
        if sent[2] and sent in self._sent:
            return  # sent again, and answered again
        self._sent.add(sent)
        self.done.requests += 1
        if service == names.SAVE and answer.success:
            self.done.saved.append(answer.path.rpartition("/")[2].partition(".")[0])

    def _compare_status(self, was: msg.AgentStatus) -> None:
        if not self._begun:
            if was.mode in IN_TRAINING and was.examples:
                raise HitabError(
                    f'the recording begins in a training: "{was.behavior}" has {was.examples} '
                    "examples already; start to record before the training"
                )
            return
        now = self._offline.status()
        if was.library_digest != now.library_digest:
            raise self._difference(
                f"the library of {was.agent} had the digest {was.library_digest[:12]}…",
                f"it is {now.library_digest[:12]}…; behaviors that another agent sent, and files "
                "that were changed by hand, are not in a recording",
            )
        if was.mode not in IN_TRAINING and now.mode not in IN_TRAINING:
            return
        for name in COMPARED:
            there, here = getattr(was, name), getattr(now, name)
            if there != here:
                raise self._difference(f"{name} was {_said(there)}", f"it is {_said(here)}")
        self.done.compared += 1

    def _difference(self, was: str, now: str) -> HitabError:
        return HitabError(
            f"in cycle {self._offline.agent.cycle} {was}; trained from the recording, {now}. The "
            "recording lacks something that mattered; start to record before the swarm's first "
            "cycle, or at the beginning of an episode"
        )


def _said(value: Any) -> str:
    return "/".join(value) or "nothing" if isinstance(value, list) else str(value or "nothing")
