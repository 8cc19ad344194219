from .order import ALL_OTHERS as ALL_OTHERS
from .order import Order as Order
from .order import OrderId as OrderId
from .order import Report as Report
from .subordinate import Subordinate as Subordinate
