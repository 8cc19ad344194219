"""A distribution has a number of its own, whatever the time in the world."""

from hitab_msgs import srv
from rclpy.parameter import Parameter

from hitab_agent.agent_node import AgentNode
from hitab_agent.shared import Shared
from hitab_core.automaton import Automaton
from hitab_core.domain import BasicBehavior, Domain
from hitab_core.use import Use
from hitab_ros import names


class Body:
    """A body that does nothing."""

    def sense(self, values, heard):
        """Take a percept."""

    def act(self):
        """Do nothing."""
        return (), ""


DOMAIN = Domain.of(
    "idlers", "1", lambda name: Body(), behaviors=[BasicBehavior("Wait")], features=[]
)


def test_distributions_are_told_apart_while_simulated_time_stands_still(process, tmp_path):
    desk = process.node
    shared = Shared(desk)
    shared.domains["idlers"] = DOMAIN
    settings = {"domain": "idlers", "state_dir": str(tmp_path), "use_sim_time": True}
    node = AgentNode(
        namespace="/teacher",
        context=desk.context,
        parameter_overrides=[Parameter(name, value=value) for name, value in settings.items()],
        use_global_arguments=False,
        shared=shared,
    )
    process.add(node)
    node.join()
    taught = Automaton("Taught", (Use("Wait"),), (), {})
    node.agent.library.save(taught, agent="teacher", classifier="tree")
    node.agent.reload()  # an agent gives away what it knows itself
    client = desk.create_client(srv.Distribute, f"/teacher/{names.DISTRIBUTE}")
    process.until(client.service_is_ready)
    sequences = []
    for _ in range(2):
        future = client.call_async(srv.Distribute.Request(behavior="Taught"))
        process.until(future.done)
        assert future.result().success
        sequences.append(future.result().sequence)
    assert 0 < sequences[0] < sequences[1]
