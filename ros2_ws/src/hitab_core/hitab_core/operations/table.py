"""The table of all operations."""

from __future__ import annotations

from hitab_core.operations import examples, performing, training
from hitab_core.training.operation import Operation

OPERATIONS: dict[str, type[Operation]] = {
    kind.name: kind
    for module in (training, examples, performing)
    for kind in vars(module).values()
    if isinstance(kind, type) and issubclass(kind, Operation) and kind is not Operation
}
"""All operations, by name."""
