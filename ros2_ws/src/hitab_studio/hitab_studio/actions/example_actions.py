"""Actions that correct the recorded examples."""

from __future__ import annotations

from hitab_client import SwarmClient, SwarmError
from hitab_core import Example, Term, numbered, with_numbers
from hitab_studio.actions.registry import Data, action, number_from
from hitab_studio.actions.world_actions import go_there
from hitab_studio.page import Page


@action("undo", repeats=True)
async def undo(page: Page, data: Data) -> None:
    """Undo the last command or edit."""
    page.unseen.check(page.agent, "undo")
    await page.request(SwarmClient.undo)
    page.tell("Undone")


@action("redo", repeats=True)
async def redo(page: Page, data: Data) -> None:
    """Redo the last undone command or edit."""
    await page.request(SwarmClient.redo)
    page.tell("Redone")


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


def _numbers(page: Page, data: Data) -> list[int]:
    if "number" in data:
        return [int(data["number"])]
    if not page.table.marked:
        raise SwarmError("Choose examples first, by clicking on them.")
    return sorted(page.table.marked)


@action("delete")
async def delete(page: Page, data: Data) -> None:
    """Delete examples."""
    numbers = _numbers(page, data)
    await page.request(SwarmClient.delete, numbers)
    page.table.marked.clear()
    page.tell(f"Deleted {numbered('example', numbers)}; Undo brings {_them(numbers)} back")


@action("relabel")
async def relabel(page: Page, data: Data) -> None:
    """Change the next state of examples."""
    numbers, state = _numbers(page, data), str(data["value"])
    if not state:
        return
    answer = await page.request(SwarmClient.relabel, numbers, state)
    page.table.marked.clear()
    page.tell(answer.message)


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
    meant = str(with_numbers(state, [given[n.name] for n in numbers], numbers))
    await page.request(SwarmClient.relabel, [example.number], meant)
    page.tell(f"Example {example.number} now leads to {meant}")


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


def _them(numbers: list[int]) -> str:
    return "it" if len(numbers) == 1 else "them"
