"""The actions of a page's requests, registered by the modules of this package."""

from importlib import import_module
from pkgutil import iter_modules

from hitab_studio.actions.operation_actions import register_operations
from hitab_studio.actions.registry import REGISTERED_ACTIONS, REPEATED, URGENT, Data

__all__ = ["REGISTERED_ACTIONS", "REPEATED", "URGENT", "Data"]

for _module in iter_modules(__path__):
    import_module(f"{__name__}.{_module.name}")
register_operations()
