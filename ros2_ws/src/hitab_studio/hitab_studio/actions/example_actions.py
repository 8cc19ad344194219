"""Actions that correct the recorded examples."""

from __future__ import annotations

from hitab_client import SwarmError
from hitab_core import Example, Term, with_numbers
from hitab_core.operations import RelabelExamples
from hitab_studio.actions.operation_actions import carry_out, operation_of
from hitab_studio.actions.registry import Data, action, number_from
from hitab_studio.actions.world_actions import go_there
from hitab_studio.pages.page import Page


@action("mark", repeats=True)
async def mark(page: Page, data: Data) -> None:
    """Select or deselect an example."""
    page.table.marked ^= {int(data["number"])}


@action("mark-none")
async def mark_none(page: Page, data: Data) -> None:
    """Deselect all examples."""
    page.table.marked.clear()


@action("sort", repeats=True)
async def sort(page: Page, data: Data) -> None:
    """Sort the examples by a column, or reverse the order."""
    table, column = page.table, str(data["column"])
    table.descending = not table.descending if table.sort == column else False
    table.sort = column


@action("examples-text", repeats=True)
async def examples_text(page: Page, data: Data) -> None:
    """Show only examples whose states contain a text."""
    page.table.text = str(data["value"])


@action("examples-kind", repeats=True)
async def examples_kind(page: Page, data: Data) -> None:
    """Show only examples of one kind."""
    page.table.kind = str(data["value"])


@action("examples-column", repeats=True)
async def examples_column(page: Page, data: Data) -> None:
    """Show or hide a feature's column."""
    table, name = page.table, str(data["name"])
    if data["value"]:
        table.hidden.discard(name)
    else:
        table.hidden.add(name)
        if table.sort == name:
            table.sort = "number"


@action("renumber")
async def renumber(page: Page, data: Data) -> None:
    """Change a number in the command of an example."""
    training, example = page.training, _example(page, data)
    if training is None or example is None:
        return
    state = Term.parse(example.next_state)
    numbers = training.numbers_of(state)
    given = {n.name: value for n, value in zip(numbers, example.numbers, strict=True)}
    name = str(data["name"])
    given[name] = number_from({name: data["value"]}, name)
    changed = str(with_numbers(state, [given[n.name] for n in numbers], numbers))
    edit = operation_of(RelabelExamples, page, data, numbers=[example.number], next_state=changed)
    await carry_out(page, edit)


@action("situation")
async def situation(page: Page, data: Data) -> None:
    """Restore the positions of all things at the time of an example."""
    training, example, number, scene = page.training, _example(page, data), data["number"], None
    if training is not None and example is not None:
        key = (page.agent, training.name, example.number, example.cycle)
        scene = page.studio.known.moments.get(key)
    if scene is None:
        raise SwarmError(
            f"The positions of example {number} are unknown: the studio was not watching then."
        )
    await go_there(page, scene.everything())
    page.tell(f"This is where example {number} was recorded; the world is paused")


def _example(page: Page, data: Data) -> Example | None:
    """Return the example of a request; None if deleted meanwhile."""
    examples = page.training.examples if page.training is not None else ()
    return next((e for e in examples if e.number == int(data["number"])), None)
