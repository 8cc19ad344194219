from .action_clients import ActionClients as ActionClients
from .action_clients import check_actions as check_actions
from .goal import Limits as Limits
from .offered_action import OfferedAction as OfferedAction
