"""Actions for the operations on an agent, which are made from their table."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from hitab_core.operations import OPERATIONS
from hitab_core.training.operation import Operation
from hitab_studio.actions.registry import REGISTERED_ACTIONS, Data, action, number_from
from hitab_studio.pages.page import Page
from hitab_studio.pages.ui_remedies import answer_text

Op = TypeVar("Op", bound=Operation)

REPEATING = frozenset({"undo", "redo", "retime_examples"})
"""Names of the operations that a double click repeats."""

FROM_REQUEST: Mapping[str, Callable[[Any], Any]] = {
    "str": lambda value: str(value).strip(),
    "bool": bool,
    "int": int,
    "Sequence[str]": lambda value: [str(one) for one in _several(value)],
    "Sequence[int]": lambda value: [int(one) for one in _several(value)],
}
"""Converters of a request's values, by the type of the field."""


def operation_of(kind: type[Op], page: Page, data: Data, **known: Any) -> Op:
    """Return the operation that a request of a page asks for.

    Keys of the request and inputs of its form have the names of fields; that of a single control
    is given as ``field``. Numbers of examples are those of the marked ones if there are none, and
    inputs such as ``bindings:ball`` are pairs.

    Args:
        kind: the operation.
        page: origin of the request.
        data: the request.
        known: fields that the request does not give.
    """
    given = {"numbers": sorted(page.table.marked), **data, **data.get("values", {})}
    if "field" in data:
        given[data["field"]] = data["value"]
    fields: dict[str, Any] = {}
    for name, field in kind.own_fields().items():
        type_ = str(field.type)
        if type_.startswith("Mapping"):
            pairs = ((key.partition(":"), str(value).strip()) for key, value in given.items())
            fields[name] = {key: value for (to, _, key), value in pairs if to == name and value}
        elif name in given and type_ == "float":
            fields[name] = number_from(given, name)
        elif name in given:
            fields[name] = FROM_REQUEST[type_](given[name])
    return kind(**fields | known, id=str(data.get("id", "")))


async def carry_out(page: Page, operation: Operation) -> None:
    """Have the agent carry out an operation, and show the outcome on the page."""
    answer = await page.do(operation)
    page.close_dialog()
    page.table.marked -= {*getattr(operation, "numbers", ())}
    page.tell(answer_text(answer).replace("; ", "\n"), "note" if answer.remedies else "good")


def register_operations() -> None:
    """Register an action for each operation that has none of its own."""
    for kind in OPERATIONS.values():
        if kind.name not in REGISTERED_ACTIONS:
            action(kind.name, repeats=kind.name in REPEATING)(_of(kind))


def _of(kind: type[Operation]) -> Callable[[Page, Data], Any]:
    async def do(page: Page, data: Data) -> None:
        await carry_out(page, operation_of(kind, page, data))

    return do


def _several(value: Any) -> Any:
    return value if isinstance(value, list) else [value]
