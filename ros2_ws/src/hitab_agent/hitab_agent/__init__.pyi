from .agent_main import run_agent as run_agent
from .endpoints import HeardTopic as HeardTopic
from .endpoints import PublishedTopic as PublishedTopic
from .links.robot_link import OnPercept as OnPercept
from .links.round_gate import RoundGate as RoundGate
from .node.agent_node import AgentNode as AgentNode
