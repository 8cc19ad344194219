"""Signs of life are heard in the swarm's namespace, of its own processes alone."""

from types import SimpleNamespace
from typing import Any

from hitab_msgs.msg import Alive

from hitab_client.showing.agent_presence import AgentPresence


def test_signs_are_heard_in_the_namespace_of_the_swarm_and_of_no_other_swarm():
    takes: dict[str, Any] = {}

    def create_subscription(kind: Any, topic: str, take: Any, quality: Any) -> None:
        takes[topic] = take

    node = SimpleNamespace(create_subscription=create_subscription)
    link: Any = SimpleNamespace(node=node, subscribe=lambda *rest: None)
    agents = AgentPresence(link, ["one", "two"], prefix="/team", identity="mine")
    signs = agents.signs_of_life(has_world=True)
    assert takes.keys() == {"/team/alive", "/team/hosts"}
    signers = (("one", "mine"), ("two", "other"), ("two", ""), ("world", ""), ("by_hand", ""))
    for name, swarm in signers:
        takes["/team/alive"](Alive(process=name, swarm=swarm))
    assert signs.last_signs.keys() == {"one", "by_hand"}
