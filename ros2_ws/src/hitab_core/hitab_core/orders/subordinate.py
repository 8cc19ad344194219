"""An agent under a commander: it obeys orders and reports its state."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import Any

from hitab_core.agent import Agent
from hitab_core.orders.order import Order, Report
from hitab_core.running.feature_cache import resolved, value_or_nan
from hitab_core.running.mode import Mode
from hitab_core.term import Term
from hitab_core.texts.errors import HitabError, LostBehaviorError

NAN = math.nan


class Subordinate:
    """The part of an agent that obeys and reports, independent of the middleware.

    An order sets the agent's top-level behavior. An order that is not newer than the last changes
    nothing, and a behavior that is already performed is not restarted. An order waits while a
    demonstrator trains or tests the agent, or while it cannot be obeyed, for example because the
    behavior is missing; `settle` carries it out once nothing prevents it.

    Attributes:
        order: the newest one received, or None.
        stopped: whether its robot may not act.
        ordered: the behavior that the order demands of the agent, or None.
        waits: whether the order is still pending.
        refusal: why the order cannot be obeyed, and the way out; empty if it can.
        episode, seed, seconds: episode, seed and time of the last percept, for the reports.
        round: number of the last percept, in lockstep; 0 in real time.
    """

    def __init__(self, agent: Agent, role: str = "") -> None:
        self.agent = agent
        self.stopped = False
        self.role = role
        self.order: Order | None = None
        self.ordered: str | None = None
        self.waits = False
        self.refusal = ""
        self.episode = 0
        self.seed = 0
        self.seconds = 0.0
        self.round = 0
        self._asked: tuple[str, ...] = ()
        self._readers: list[Callable[[], float] | None] = []
        self._reported: tuple[object, ...] = ()
        self._reported_at = -math.inf
        self._reported_cycle = -1
        self._beaten = False
        self._again = False

    # -- obeying ----------------------------------------------------------------------------

    def take(self, order: Order) -> bool:
        """Receive an order and obey if nothing prevents it; return whether it was newer.

        In lockstep an order given outside a round, for example by a person while the world is
        paused, is obeyed at the end of the next round, which repeats it: it must not matter
        whether it arrives before or after a percept. Until then only its report requests take
        effect, as a restarted commander needs them.
        """
        if self.round and not order.round:
            order = replace(order, sequence=0)
        again, self._again = self._again, self._again and not order.sequence
        if self.order is not None and order.number <= self.order.number and not again:
            return False
        self.order = order
        if order.report != self._asked:
            self._asked = order.report
            self._readers = [self._reader(text) for text in order.report]
        if not order.sequence:
            return True  # a commander that has ordered nothing yet: continue
        behavior = order.behavior_for(self.agent.name, self.role)
        running = self.agent.running
        if running is not None and not again:
            running.raised.clear()
        if behavior is None:
            self.waits, self.refusal = False, ""
        else:
            self.ordered, self.waits = behavior, True
            self.settle()
        return True

    def went_back(self) -> None:
        """Take the order in force when it comes again: the agent now performs what it did then."""
        self._again = True

    def settle(self) -> bool:
        """Carry out a pending order if nothing prevents it; return whether it was carried out."""
        agent = self.agent
        if self.ordered is not None and agent.mode in (Mode.TRAINING, Mode.TESTING):
            # That in force as well: the training has taken its place.
            self.waits, self.refusal = True, ""
            return False
        if not self.waits or self.ordered is None:
            return False
        try:
            term = Term.parse(self.ordered) if self.ordered else None
            if not self._performs(term):
                agent.perform(term)
        except Exception as error:  # starting and stopping run domain code
            name = self.order.name if self.order is not None else ""
            why = str(error)
            if not isinstance(error, HitabError):
                why = f'"{self.ordered}" could not be started: {error!r}'
            if not isinstance(error, HitabError) or isinstance(error, LostBehaviorError):
                with suppress(Exception):
                    # Neither a half-started behavior nor the previously ordered one.
                    agent.perform(None)
            self.refusal = f'cannot obey the order "{name}": {why}'
            return False
        self.waits, self.refusal = False, ""
        return True

    def _performs(self, term: Term | None) -> bool:
        if term is None:
            return self.agent.mode is Mode.IDLE
        return self.agent.mode is Mode.PERFORMING and self.agent.top == term

    @property
    def is_asked(self) -> bool:
        """Whether the commander has requested values or the position."""
        return self.order is not None and self.order.asks

    @property
    def perceived(self) -> tuple[int, int, int, float]:
        """Cycle, episode, seed and time of the last percept."""
        return self.agent.cycle, self.episode, self.seed, self.seconds

    # -- reporting --------------------------------------------------------------------------

    def news(self, seconds: float) -> Report | None:
        """Return a report if there is something to report now.

        That is the case when the agent's activity has changed and, if values are requested,
        periodically; see `Order.report_period`.

        Args:
            seconds: the agent's own time, from its percepts.
        """
        doing = self._doing()
        if doing == self._reported:
            order = self.order
            if order is None or not order.asks:
                return None
            # Tolerate half a millisecond, since times are sums of cycles.
            if 0.0 <= seconds - self._reported_at < order.report_period - 5e-4:
                return None
        self._reported_at = seconds
        return self._report(doing)

    def round_begins(
        self, number: int, *, look: bool, restart: bool, back: bool = False
    ) -> Report:
        """Return the report that is due in a round of lockstep.

        Args:
            number: number of the round and of its percept.
            look: whether the percept is for observation only.
            restart: whether the percept begins an episode.
            back: whether the world went back to the percept's cycle.
        """
        self.round = number
        return self._report(self._doing(), look=look, restart=restart, back=back)

    def rounds_end(self) -> bool:
        """Switch to real time; return whether it was in lockstep."""
        was, self.round = self.round, 0
        return bool(was)

    def heartbeat(self) -> Report | None:
        """Return a report of the agent's cycle, unless there was a report since the last call.

        There is none without a new percept, since signs of life of the agent's process suffice,
        and none in lockstep, where each round has a report.
        """
        beaten, self._beaten = self._beaten, False
        if self.round or beaten or self.agent.cycle == self._reported_cycle:
            return None
        report = self.report()
        self._beaten = False
        return report

    def report(self, *, back: bool = False) -> Report:
        """Return a report of the agent's activity now; ``back`` as in `round_begins`."""
        return self._report(self._doing(), back=back)

    def _doing(self) -> tuple[Any, ...]:
        """Return the report's fields without values and times, which change all the time."""
        agent = self.agent
        taken = None if self._again else self.order
        epoch, sequence = taken.number if taken is not None else (0, 0)
        path: tuple[str, ...] = ()
        if agent.mode is not Mode.IDLE and not self.stopped:
            inside = self.order is not None and self.order.report_states
            path = (agent.behavior, *(agent.active_path if inside else ()))
        raised = agent.raised
        flags = tuple(sorted(raised)) if raised else ()
        doing = epoch, sequence, self.waits, agent.mode.value, self.stopped, path, flags
        return (*doing, self.episode, self.seed, self.round)

    def _report(
        self,
        doing: tuple[Any, ...],
        *,
        look: bool = False,
        restart: bool = False,
        back: bool = False,
    ) -> Report:
        self._reported = doing
        self._reported_cycle = self.agent.cycle
        self._beaten = True
        values = tuple(NAN if read is None else value_or_nan(read) for read in self._readers)
        epoch, sequence, waits, mode, stopped, path, flags, episode, seed, number = doing
        return Report(
            self.agent.name,
            epoch,
            sequence,
            waits,
            mode,
            stopped,
            path,
            flags,
            values,
            self._position(),
            self.agent.cycle,
            episode,
            seed,
            self.seconds,
            number,
            look,
            restart,
            back,
        )

    def _reader(self, text: str) -> Callable[[], float] | None:
        """Return a function that reads a feature; None if the feature or target is missing."""
        domain = self.agent.domain
        try:
            term = Term.parse(text)
            known = {name: feature.parameters for name, feature in domain.features.items()}
            domain.check_use(term, known, what="feature")
        except HitabError:
            return None
        read: Callable[[], float] = resolved(
            domain.features[term.name].read, self.agent.body, domain, term
        )
        return read

    def _position(self) -> tuple[float, ...]:
        if self.order is None or not self.order.report_position:
            return ()
        try:
            position = self.agent.body.position
            return () if position is None else (float(position[0]), float(position[1]))
        except Exception:  # a body without a position, or without a percept yet
            return ()
