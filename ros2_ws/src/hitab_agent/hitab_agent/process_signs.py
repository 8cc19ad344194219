"""Signs of life of a process, and of those that run the subordinates of its commanders."""

from __future__ import annotations

from collections.abc import Callable

from hitab_msgs.msg import Alive

from hitab_agent.scheduler import Job, JobQueue
from hitab_core.orders import Subordinate
from hitab_ros import GuardedNode, names, qos

Follow = Callable[[Alive], None]

NOTHING = (0, 0, 0, 0.0)


class ProcessSigns:
    """Passes signs of life on to all commanders of a process, and completes its own signs.

    Thousands of subordinates do not cost more messages than the processes that run them: the
    signs tell the last percepts of all, and within the process no message is needed.
    """

    def __init__(self, node: GuardedNode) -> None:
        self._node = node
        self._process = names.own_name(node)
        self._followers: dict[str, dict[Follow, None]] = {}
        self._perceiving: list[Subordinate] = []
        self._reporting: list[Callable[[], object]] = []
        # Hundreds of commanders that decide at a sign must not delay a percept or an order.
        self._later = JobQueue(node)

    def tell_of(self, subordinate: Subordinate) -> None:
        """Tell in the process's signs of life what an agent last perceived."""
        self._perceiving.append(subordinate)

    def unless_told(self, report: Callable[[], object]) -> None:
        """Call a guarded function at each own sign that tells no percepts."""
        self._reporting.append(report)

    def fill(self, sign: Alive) -> None:
        """Complete a sign of life of this process, and pass it on to its own commanders.

        It tells the last percepts if they are all of one cycle, as of agents in one world.
        """
        perceived = {subordinate.perceived for subordinate in self._perceiving}
        told = perceived.pop() if len(perceived) == 1 else NOTHING
        sign.cycle, sign.episode, sign.seed, sign.seconds = told
        if told is NOTHING:
            for report in self._reporting:
                report()
        self._pass_on(sign)

    def follow(self, process: str, call: Follow) -> None:
        """Call a guarded function with each sign of life of a process; of all if it is empty."""
        if process != self._process and not self._followers.keys() - {self._process}:
            topic = names.in_swarm(self._node, names.ALIVE)
            self._node.create_subscription(Alive, topic, self._hear, qos.SIGNS_OF_LIFE)
        self._followers.setdefault(process, {})[call] = None

    def _hear(self, sign: Alive) -> None:
        if sign.process != self._process:
            self._pass_on(sign)

    def _pass_on(self, sign: Alive) -> None:
        if followers := [f for name in (sign.process, "") for f in self._followers.get(name, ())]:
            self._later.do(_calls(followers, sign))


def _calls(followers: list[Follow], sign: Alive) -> Job:
    for call in followers:
        call(sign)
        yield None
