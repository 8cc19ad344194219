"""Unsaved trainings, separated by library: each resumes only with its own library.

An agent's database keeps the current training, whatever the agent's library. Started with another
library, the agent would resume the training and save it into the wrong library. The training is
therefore set aside before such a start, and brought back before a start with its own library.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path

from hitab_msgs.msg import AgentStatus

from hitab_client.terminal.cli_remedies import with_commands
from hitab_core import Fix, natural, quantity
from hitab_core.assistant import unsaved_cost
from hitab_core.training import TrainingJournal

TOLD_MAX = 5
"""Maximum number of trainings that are described individually."""


def set_aside(before: Mapping[str, Path], now: Mapping[str, Path], folder: Path) -> None:
    """Set aside the trainings of agents with another library than before.

    Args:
        before: each agent's library at the last start, by name.
        now: each agent's library at this start, by name.
        folder: run folder of the swarm.
    """
    for agent, library in now.items():
        own = before.get(agent, library)
        if own != library:
            TrainingJournal(folder / "state" / agent).wait(str(own))


def bring_back(now: Mapping[str, Path], folder: Path) -> None:
    """Bring back the trainings that were set aside and fit the libraries of this start."""
    for agent, library in now.items():
        journal = TrainingJournal(folder / "state" / agent)
        if str(library) in journal.waiting():
            journal.wait("", instead_of=str(library))


def waiting(folder: Path) -> Iterator[tuple[str, Path]]:
    """Yield the agents with trainings set aside, each with the library of one training."""
    for state in sorted(folder.glob("state/*")):
        for library in TrainingJournal(state).waiting():
            yield state.name, Path(library)


def announcements(
    statuses: Iterable[AgentStatus], folder: Path, commanders: Collection[str] = ()
) -> list[str]:
    """Return sentences about the unsaved trainings of a swarm, with the ways out.

    Args:
        statuses: statuses of the agents, just started.
        folder: run folder of the swarm.
        commanders: the agents that are commanders.
    """
    sentences = []
    for status in sorted(statuses, key=lambda status: natural(status.agent)):
        if status.mode in (AgentStatus.TRAINING, AgentStatus.TESTING):
            agent, examples = status.agent, status.training.examples
            sentence = f'{agent} resumes the training of "{status.behavior}"'
            sentence += f" ({quantity(examples, 'example')}) and waits for commands"
            sentence += "; its group waits for its orders" if agent in commanders else ""
            ways = [Fix.TEST(agent=agent), Fix.SAVE(agent=agent), Fix.DISCARD(agent=agent)]
            sentences.append(with_commands(sentence, ways if examples else ways[2:]))
    for agent, library in waiting(folder):
        own = library.is_relative_to(folder / "libraries")
        way = "without --library" if own else f"with --library {library}"
        sentences.append(
            f"{agent} has another unsaved training; start the swarm {way} to resume it"
        )
    return _first(sentences)


def left_to_resume(folder: Path) -> list[str]:
    """Return sentences about the trainings that the next start of a swarm resumes.

    Args:
        folder: run folder of the swarm, which has ended.
    """
    sentences = []
    for state in sorted(folder.glob("state/*"), key=lambda path: natural(path.name)):
        unsaved = unsaved_cost(TrainingJournal(state))
        if unsaved is not None and unsaved.examples:
            sentences.append(
                f'{state.name} has an unsaved training of "{unsaved.automaton}" '
                f"({quantity(unsaved.examples, 'example')}); it is kept, and the next start of "
                "the swarm resumes it"
            )
    return _first(sentences)


def _first(sentences: list[str]) -> list[str]:
    more = len(sentences) - TOLD_MAX
    return [*sentences[:TOLD_MAX], *([f"... and {more} more"] if more > 0 else [])]
