"""Demonstrator: a person who trains agents by keys or buttons, and the outcome of each key.

Keys and buttons arrive in callbacks of the node, which must not wait; `Demonstrator.work` carries
them out outside of the callbacks. The emergency stop and driving by hand never wait: they take
effect in the callback, even while a command waits for an agent.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import replace

from hitab_msgs.msg import AgentStatus, WorldState
from hitab_msgs.srv import Control

from hitab_client.demonstrating.agent_vocabulary import AgentVocabulary, WordsOfAgents
from hitab_client.demonstrating.behavior_keys import Keys
from hitab_client.demonstrating.key_actions import command, put_earlier, toggled
from hitab_client.demonstrating.pressed import Pressed, Prompt
from hitab_client.demonstrating.steering import Steering
from hitab_client.errors import SwarmError
from hitab_client.stops import Stops
from hitab_client.swarm_client import SwarmClient
from hitab_client.world_client import WorldClient
from hitab_core import START, HitabError, Term, natural, numbers_of, some
from hitab_core.operations import Perform, Redo, SaveBehavior, TakeOver, Undo
from hitab_ros import EmergencySwitch, give_signs_of_operator, names
from hitab_ros.timing import FOUND_S, PROMPT_S

KEY_AGE_MAX_S = 1.0
"""Maximum age of a key, s: an older key was meant for another situation."""

PENDING_MAX = 8
"""Maximum number of keys that wait until an agent has answered."""

DRIVING_BY_HAND = "driving by hand"

PARTS, BACKSPACES, ENTERS = "0123456789.-", "\x7f\b", "\r\n"
"""Keys that type a number."""


class Demonstrator:
    """Demonstrator: a person who commands with keys or buttons.

    Args:
        agents: client of the swarm's agents.
        world: client of the swarm's world, which may be absent.
        asks: whether the person can be asked for targets and numbers.
        keys: keys of behaviors, stored for all processes; None for keys of this process alone.
        clock: returns the time of any steady clock, s.

    Attributes:
        agent: name of the commanded agent.
        said: outcome of the last key.
        failed: whether that outcome is an error.
        told: number of outcomes so far.
        switch: switch of the emergency stop.
        steering: drives the robot by hand.
        prompt: the prompt that waits for the person's answer, or None.
    """

    def __init__(
        self,
        agents: SwarmClient,
        world: WorldClient,
        *,
        asks: bool = True,
        keys: Keys | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.agent = ""
        self.said = ""
        self.failed = False
        self.told = 0
        self.prompt: Prompt | None = None
        # `hands_on`: the topic is open before it is needed, so that a stop arrives at once.
        self.switch = EmergencySwitch(agents.link.node, hands_on=True)
        give_signs_of_operator(agents.link.node, agents.prefix, lambda: True)
        self._stops = Stops(agents.link, switch=self.switch)
        self.steering = Steering(agents.link.node, agents.prefix, self._is_at_rest, clock)
        self._agents = agents
        self._world = world
        self._words = WordsOfAgents(agents, keys or Keys())
        self._asks = asks
        self._clock = clock
        self._pending: deque[Pressed] = deque()
        self._not_taken: dict[str, str] = {}
        self._chosen_at = -math.inf
        self._is_driven = False
        self._refused_until = -math.inf
        self._does = {
            "test": self._toggle,
            "undo": lambda agent: str(agents.do(agent, Undo()).message),
            "redo": lambda agent: str(agents.do(agent, Redo()).message),
            "earlier": lambda agent: put_earlier(agents, world, agent),
            "nothing": self._perform_nothing,
            "save": self._save,
            "arm": self._arm,
            "stop": self._pause,
        }

    @property
    def status(self) -> AgentStatus | None:
        """The last status of the agent."""
        return self._agents.statuses.get(self.agent)

    @property
    def words(self) -> AgentVocabulary:
        """Vocabulary of the agent, as far as known."""
        return self._words.known(self.agent)

    def tell(self, text: str, *, failed: bool = False) -> None:
        """Note the outcome of a key."""
        self.said, self.failed = text, failed
        self.told += 1

    def close(self, seconds: float) -> None:
        """Release the robot; wait at most this long until all robots have an emergency stop."""
        self.let_go()
        if self.switch.engaged:
            self.switch.delivered(seconds)

    # -- in callbacks -----------------------------------------------------------------------

    def choose(self, agent: str) -> None:
        """Command another agent from now on."""
        self.agent = agent
        self.prompt = None
        self.let_go()
        self.steering.choose(agent)
        self._chosen_at = self._clock()

    def press(self, action: str) -> None:
        """Queue one of the `ACTIONS`; emergency stop and choice of agent take effect at once."""
        if action == "go" or (action == "stop" and not self._is_simulated()):
            self._switch(engaged=action == "stop")
        elif action in ("previous", "next"):
            self._step(1 if action == "next" else -1)
        else:
            self._wait(self.pressed("", action))

    def pressed(self, behavior: str, what: str = "") -> Pressed:
        """Return a record of a key pressed now, for a behavior or another action."""
        now = self._clock()
        state = self._world.state
        seen = 0 if state is None or self._world.status is None else int(state.cycle)
        return Pressed(what or behavior, self.agent, behavior, now, seen)

    def press_behavior(self, behavior: str, first: Pressed | None = None) -> None:
        """Queue a behavior to be commanded in training, or performed without one.

        Args:
            behavior: behavior with its targets and numbers.
            first: key pressed before the targets and numbers were given; None for this key.
        """
        now = self.pressed(behavior)
        pressed = now if first is None else replace(first, behavior=behavior, at=now.at)
        # Prompt at once, since the answer may be pressed before an agent has answered.
        agent, words = pressed.agent, self._words
        if words.is_old(agent) or not self._ask(pressed, words.known(agent)):
            self._wait(pressed)

    def answer(self, key: str) -> None:
        """Take a key as the answer to the prompt; a key that is no answer cancels the command.

        Args:
            key: number of a target, from 1; or a character of a number, Backspace, or Enter.
        """
        prompt, self.prompt = self.prompt, None
        if prompt is None:
            return
        self.tell("")
        number = prompt.number
        if number is None:
            target = dict(zip("123456789", prompt.targets, strict=False)).get(key)
            if target is not None:
                self.press_behavior(str(prompt.with_target(target)), prompt.pressed)
        elif key in PARTS:
            self.prompt = replace(prompt, typed=prompt.typed + key)
        elif key in BACKSPACES:
            self.prompt = replace(prompt, typed=prompt.typed[:-1])
        elif key in ENTERS:
            given = f"{number.name}={prompt.typed}"
            try:
                numbers_of(Term(prompt.term.name, (given,)), [number])
            except HitabError as error:
                self.tell(str(error), failed=True)
                self.prompt = replace(prompt, typed="")
                return
            term = Term(prompt.term.name, (*prompt.term.arguments, given))
            self.press_behavior(str(term), prompt.pressed)

    def steer(self, velocity: Sequence[float], seconds: float) -> None:
        """Drive the robot by hand for some seconds; zeros stop it.

        The agent first gives up its behavior, so that nothing else drives the robot afterwards.
        A command to the agent meanwhile ends the driving until the person releases the keys.
        """
        if not any(velocity) or not all(map(math.isfinite, velocity)):
            self.let_go()
            self._refused_until = -math.inf
            return
        now = self._clock()
        if now <= self._refused_until:
            self._refused_until = now + seconds
            return
        begins = not self.steering.is_held
        self._is_driven = self._is_at_rest() or (self._is_driven and not begins)
        self.steering.hold(velocity, seconds)
        if self.switch.engaged:
            self._refuse_steering("the emergency stop holds the robots")
        elif not self.steering.reaches_relay and now <= self._chosen_at + FOUND_S:
            self.steering.release()  # the relay may still be discovered
        elif not self.steering.reaches_relay:
            self._refuse_steering(
                f"{self.agent} cannot be driven by hand: no {names.VELOCITY_RELAY} listens on "
                f"{self.steering.topic_name}, as those of robots with standard messages do"
            )
        elif not self._is_at_rest() and self._is_driven:
            self._refuse_steering(f"{self.agent} acts again: let go, then drive it again")
        elif not self._is_at_rest() and begins:
            self._wait(self.pressed("", DRIVING_BY_HAND))

    def _refuse_steering(self, why: str) -> None:
        self.let_go()
        self.tell(why, failed=True)

    def let_go(self) -> None:
        """Stop the robot; held keys have to be released before the robot drives again."""
        if self.steering.until > self._clock():
            self._refused_until = self.steering.until
        self._is_driven = False
        self.steering.release()

    def _wait(self, pressed: Pressed) -> None:
        if len(self._pending) < PENDING_MAX:
            self._pending.append(pressed)
        else:
            self.tell(f"{pressed.what} is left out: {self.agent} has not answered", failed=True)

    def _switch(self, *, engaged: bool) -> None:
        self.let_go()
        self._pending.clear()  # keys from before the stop
        self.switch.set(engaged, self._agents.demonstrator)
        if not engaged:
            self.tell("released: simulated worlds go on, and each robot waits to be re-armed")
            return
        acting = self._stops.names()
        who = f": {some(acting)}" if acting else "; nothing that acts is there, late ones obey"
        self.tell(f"emergency stop: all have to stand still{who}", failed=not acting)

    def _step(self, by: int) -> None:
        agents = sorted({*self._agents.expected, *self._agents.agents()}, key=natural)
        if agents:
            place = agents.index(self.agent) + by if self.agent in agents else 0
            self.choose(agents[place % len(agents)])
            self.tell(f"{self.agent} obeys from now on")

    def _is_at_rest(self) -> bool:
        """Whether the agent does nothing that could drive its robot."""
        status = self.status
        if status is None:
            return False
        at_start = list(status.active_path) in ([], [START])
        return status.mode == AgentStatus.IDLE or (
            status.mode == AgentStatus.TRAINING and at_start
        )

    # -- outside of callbacks ---------------------------------------------------------------

    def work(self) -> None:
        """Carry out the pressed keys; errors are noted in `said`."""
        while self._pending:
            pressed = self._pending.popleft()
            try:
                self._carry_out(pressed)
            except HitabError as error:
                if pressed.behavior:
                    self._not_taken.setdefault(pressed.agent, pressed.behavior)
                self.tell(str(error), failed=True)
        self._not_taken.clear()

    def look(self) -> None:
        """Request the agent's vocabulary, if it may have changed.

        Raises:
            SwarmError: if the agent does not answer.
        """
        self._stops.look()
        if self.agent not in self._agents.statuses or self._words.is_old(self.agent):
            self._words.ask(self.agent)

    def _carry_out(self, pressed: Pressed) -> None:
        late = self._clock() - pressed.at
        if late > KEY_AGE_MAX_S:
            raise SwarmError(
                f"{pressed.what} is left out: it was pressed {late:.1f} s ago, while an agent did "
                "not answer"
            )
        if pressed.what not in ("stop", DRIVING_BY_HAND):  # what stops is never left out
            self._check_seen(pressed)
        if pressed.behavior:
            said = self._command(pressed)
        elif pressed.what in self._does:
            said = self._does[pressed.what](pressed.agent)
        else:
            said = self._halt(pressed.agent)
        if said:
            self.tell(said)

    def _check_seen(self, pressed: Pressed) -> None:
        """Check that the person can have seen the outcomes of all commands before."""
        if behavior := self._not_taken.get(pressed.agent):
            # An undo, for example, was meant for that command, not for the one before.
            raise SwarmError(
                f"{pressed.what} is left out: it was pressed after {behavior}, which was not taken"
            )

    def _command(self, pressed: Pressed) -> str:
        agent, agents = pressed.agent, self._agents
        self.let_go()
        words = self._words.ask(agent)
        if self._ask(pressed, words):
            return ""
        term = Term.parse(pressed.behavior)
        words.check_bound(term, agent)
        return command(agents, self._world, agent, str(term), seen=pressed.seen, seconds=PROMPT_S)

    def _ask(self, pressed: Pressed, words: AgentVocabulary) -> bool:
        """Prompt for a missing target or number; return whether one is missing."""
        prompt = words.open_part(pressed) if self._asks else None
        if prompt is None:
            return False
        self.let_go()
        self.prompt = prompt
        self.tell("")
        return True

    def _toggle(self, agent: str) -> str:
        self.let_go()
        return str(self._agents.do(agent, toggled(self._agents.await_agent(agent))).message)

    def _perform_nothing(self, agent: str) -> str:
        self.let_go()
        self._agents.do(agent, Perform())
        return f"{agent} performs nothing"

    def _save(self, agent: str) -> str:
        answer = self._agents.do(agent, SaveBehavior())
        left_out = f"; left out because unused: {some(answer.trimmed)}" if answer.trimmed else ""
        return f"{answer.message}: {answer.path}{left_out}"

    def _is_simulated(self) -> bool:
        """Whether everything that acts is in a simulated world."""
        return {*self._stops.names()} == {f"{self._agents.prefix}/{names.WORLD}".strip("/")}

    def _pause(self, agent: str) -> str:
        self.let_go()
        is_paused = self._world.wait().mode == WorldState.PAUSED
        actions = Control.Request
        action = actions.RESUME if is_paused else actions.PAUSE
        return f"the world is {self._world.control(action).message}"

    def _arm(self, agent: str) -> str:
        self._stops.arm(f"{self._agents.prefix}/{agent}".strip("/"), PROMPT_S)
        return f"{agent} may act"

    def _halt(self, agent: str) -> str:
        """Stop the agent; in training, restart at Start."""
        if self._is_at_rest():
            return ""  # pressed twice before the first was carried out
        mode = self._agents.await_agent(agent).mode
        self._agents.do(agent, Perform())
        if mode not in (AgentStatus.TRAINING, AgentStatus.TESTING):
            return f"{agent} performs nothing while you drive it by hand"
        self._agents.do(agent, TakeOver())
        return f"{agent} performs nothing while you drive it by hand; its training is at {START}"
