from .agent_main import run_agent as run_agent
from .links.robot_link import OnPercept as OnPercept
from .links.round_gate import RoundGate as RoundGate
from .node.agent_node import AgentNode as AgentNode
