"""Correcting what was recorded."""

from __future__ import annotations

from hitab_client import SwarmClient, SwarmError
from hitab_core import Use, numbered, with_numbers
from hitab_studio.actions.arranging import go_there
from hitab_studio.actions.registry import Data, action, number_from
from hitab_studio.page_state import PageState


@action("undo", repeats=True)
async def undo(session: PageState, data: Data) -> None:
    """Undo the last command or edit."""
    session.unseen.check(session.agent, "undo")
    await session.request(SwarmClient.undo)
    session.tell("Undone")


@action("redo", repeats=True)
async def redo(session: PageState, data: Data) -> None:
    """Redo what was undone last."""
    await session.request(SwarmClient.redo)
    session.tell("Redone")


@action("mark", repeats=True)
async def mark(session: PageState, data: Data) -> None:
    """Select or deselect an example."""
    session.table.marked ^= {int(data["number"])}


@action("mark-none")
async def mark_none(session: PageState, data: Data) -> None:
    """Deselect all examples."""
    session.table.marked.clear()


@action("sort", repeats=True)
async def sort(session: PageState, data: Data) -> None:
    """Sort by a column, or reverse the order."""
    table, column = session.table, str(data["column"])
    table.descending = not table.descending if table.sort == column else False
    table.sort = column


@action("examples-text", repeats=True)
async def examples_text(session: PageState, data: Data) -> None:
    """Show examples with this in their states."""
    session.table.text = str(data["value"])


@action("examples-kind", repeats=True)
async def examples_kind(session: PageState, data: Data) -> None:
    """Show examples of one kind."""
    session.table.kind = str(data["value"])


@action("examples-column", repeats=True)
async def examples_column(session: PageState, data: Data) -> None:
    """Show a feature's column, or leave it out."""
    table, name = session.table, str(data["name"])
    if data["value"]:
        table.hidden.discard(name)
    else:
        table.hidden.add(name)
        if table.sort == name:
            table.sort = "number"


def _numbers(session: PageState, data: Data) -> list[int]:
    if "number" in data:
        return [int(data["number"])]
    if not session.table.marked:
        raise SwarmError("Choose examples first, by clicking on them.")
    return sorted(session.table.marked)


@action("delete")
async def delete(session: PageState, data: Data) -> None:
    """Delete examples."""
    numbers = _numbers(session, data)
    await session.request(SwarmClient.delete, numbers)
    session.table.marked.clear()
    session.tell(f"Deleted {numbered('example', numbers)}; Undo brings {_them(numbers)} back")


@action("relabel")
async def relabel(session: PageState, data: Data) -> None:
    """Change the next state of examples."""
    numbers, state = _numbers(session, data), str(data["value"])
    if not state:
        return
    answer = await session.request(SwarmClient.relabel, numbers, state)
    session.table.marked.clear()
    session.tell(answer.message)


@action("renumber")
async def renumber(session: PageState, data: Data) -> None:
    """Change a number with which an example was commanded."""
    number, training = int(data["number"]), session.training
    found = [e for e in training.examples if e.number == number] if training else []
    if training is None or not found:
        return
    state = Use.parse(found[0].next_state)
    numbers = training.numbers_of(state)
    given = {n.name: value for n, value in zip(numbers, found[0].numbers, strict=True)}
    name = str(data["name"])
    given[name] = number_from({name: data["value"]}, name)
    meant = str(with_numbers(state, [given[n.name] for n in numbers], numbers))
    await session.request(SwarmClient.relabel, [number], meant)
    session.tell(f"Example {number} now leads to {meant}")


@action("situation")
async def situation(session: PageState, data: Data) -> None:
    """Move everything to where it was when an example was recorded."""
    number = int(data["number"])
    training = session.training
    found = [e for e in training.examples if e.number == number] if training else []
    scene = (
        session.shared.store.known.moments.get(
            (session.agent, training.name, number, found[0].cycle)
        )
        if training is not None and found
        else None
    )
    if scene is None:
        raise SwarmError(
            f"Where everything was when example {number} was recorded is not known: "
            "the studio was not watching then."
        )
    await go_there(session, scene.everything())
    session.tell(f"This is where example {number} was recorded; the world is paused")


def _them(numbers: list[int]) -> str:
    return "it" if len(numbers) == 1 else "them"
