from .agent_main import run_agent as run_agent
from .agent_node import AgentNode as AgentNode
from .line_memory import LineMemory as LineMemory
from .robot_link import OnPercept as OnPercept
from .round_gate import RoundGate as RoundGate
from .settings import AgentSettings as AgentSettings
from .shared import Shared as Shared
