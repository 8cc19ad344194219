from .agent_main import run_agent as run_agent
from .agent_node import AgentNode as AgentNode
from .robot_link import OnPercept as OnPercept
from .round_gate import RoundGate as RoundGate
