"""Behavior bootstrapping: generations of what a team performs."""

from __future__ import annotations

from hitab_client import SwarmError
from hitab_client.bootstrapping import Configuration, Evaluation
from hitab_studio.actions.registry import Data, action
from hitab_studio.generations import Making, Step
from hitab_studio.page_state import PageState

MOST_EPISODES = 1000
LONGEST_NOTE = 200
"""Characters."""

AS_IT_IS = "as it is"
SNAPSHOT = "snapshot "
"""Before a snapshot's name, in the choice of the situation in which a training goes on."""


@action("generations-dialog")
async def generations_dialog(session: PageState, data: Data) -> None:
    """List the generations of a behavior, to make the next one or to go back."""
    agent, training = str(data.get("agent") or session.agent), session.training
    behavior = str(data.get("name") or (training.name if training is not None else ""))
    if not behavior:
        raise SwarmError("There is nothing to make a generation from yet: begin a training first.")
    session.close_dialog()
    session.dialog = {"kind": "generations", "agent": agent, "behavior": behavior}
    if session.shared.store.known.world_answers and not session.shared.generations.why_busy:
        listed = await session.ask_world(lambda world: world.snapshot("list"))
        session.shared.store.snapshots = tuple(listed.names)


@action("generation-next")
async def generation_next(session: PageState, data: Data) -> None:
    """Make the next generation of what is being trained."""
    values, agent = data["values"], session.dialog["agent"]
    note = str(values.get("note", "")).strip()[:LONGEST_NOTE]
    evaluation, chosen = _evaluation(values), _configuration(values)
    _begin(
        session,
        lambda steps: steps.next(agent, note=note, evaluation=evaluation, configuration=chosen),
    )


@action("generation-back")
async def generation_back(session: PageState, data: Data) -> None:
    """Go back to a generation: the team performs it again, and the training goes on from it."""
    values, number = data["values"], int(data["number"])
    agent, behavior = session.dialog["agent"], session.dialog["behavior"]
    discard = values.get("discard") == "on"
    evaluation, chosen = _evaluation(values), _configuration(values)
    _begin(
        session,
        lambda steps: steps.back(
            agent,
            behavior,
            number,
            discard=discard,
            evaluation=evaluation,
            configuration=chosen,
        ),
    )


@action("generation-stop")
async def generation_stop(session: PageState, data: Data) -> None:
    """Stop what is under way."""
    session.shared.generations.stop()


@action("generation-dismiss")
async def generation_dismiss(session: PageState, data: Data) -> None:
    """Close what the last one has said."""
    session.shared.generations.dismiss()


def _begin(session: PageState, step: Step) -> None:
    known, agent = session.shared.store.known, session.dialog["agent"]
    if session.player is not None:
        raise SwarmError("This is a recording: close it first (Esc) to act on the swarm.")
    if not known.answers(agent):
        raise SwarmError(f"{agent} does not respond: wait until it answers again.")
    session.hold(agent)
    making = Making(agent, session.dialog["behavior"])
    session.shared.generations.begin(making, step, known, session.demonstrator)


def _evaluation(values: Data) -> Evaluation:
    text = str(values.get("episodes", "")).strip()
    if not text.isdigit() or int(text) > MOST_EPISODES:
        raise SwarmError(f"Give a number of episodes up to {MOST_EPISODES}; 0: no score.")
    return Evaluation(int(text))


def _configuration(values: Data) -> Configuration | None:
    """Return the situation in which the training goes on; None: that of the generation before."""
    chosen = str(values.get("from", ""))
    if chosen.startswith(SNAPSHOT):
        return Configuration(snapshot=chosen.removeprefix(SNAPSHOT))
    return Configuration() if chosen == AS_IT_IS else None
