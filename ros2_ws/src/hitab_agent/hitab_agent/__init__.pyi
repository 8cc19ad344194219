from .agent_main import run_agent as run_agent
from .agent_node import AgentNode as AgentNode
from .offline_agent import OfflineAgent as OfflineAgent
from .retracing import Retraced as Retraced
from .retracing import Retracer as Retracer
from .retracing import Step as Step
from .robot_link import OnPercept as OnPercept
from .round_gate import RoundGate as RoundGate
