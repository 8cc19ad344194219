"""Training from a recording: the recorded agent is given again all that it took in."""

from __future__ import annotations

import tempfile
from pathlib import Path

from hitab_msgs.srv import SaveBehavior

from hitab_agent import OfflineAgent, Retraced, Retracer, Step
from hitab_client.recording import session_of
from hitab_core import LibraryError
from hitab_ros import names


def train_from_recording(
    path: Path, folder: Path, agent: str = "", *, save: bool = False
) -> tuple[str, Retraced, tuple[str, int] | None]:
    """Train an agent from a recording into a new library.

    Args:
        path: of the recording.
        folder: for the library; new or empty.
        agent: whose session; empty: of the only one.
        save: also save the training that the recording ends in.

    Returns:
        The agent that was recorded; what was given to it again, and compared; and the automaton
        whose training was not saved, with its number of examples, None if none.

    Raises:
        SwarmError: if the recording cannot be read, or has no such session.
        HitabError: if something else would be learned than was recorded.
    """
    if folder.exists() and any(folder.iterdir()):
        raise LibraryError(f"{folder} is not empty; name a new folder")
    session = session_of(path, agent)
    with (
        tempfile.TemporaryDirectory(prefix="hitab-") as state,
        OfflineAgent(session.agent, session.domain, folder, Path(state), session.known) as offline,
    ):
        done = Retracer(offline).take(Step(*one) for one in session.sent)
        trained = offline.agent.training
        unsaved = (trained, offline.agent.unsaved) if offline.agent.unsaved else None
        if unsaved and save:
            answer = offline.ask(names.SAVE, SaveBehavior.Request())
            if not answer.success:
                raise LibraryError(answer.message)
            done.saved.append(trained)
            unsaved = None
    return session.agent, done, unsaved
