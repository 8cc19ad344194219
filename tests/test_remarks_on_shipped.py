"""Nothing that is shipped is said not to play, as it was learned."""

import pytest

from hitab_bringup import open_library
from hitab_client.runs.shipped import shipped_folders
from hitab_core import Agent
from hitab_core.training import Curriculum

LIBRARIES = [path for folder in shipped_folders("libraries") for path in sorted(folder.iterdir())]


def trainees(library):
    """Go through an agent that resumes the training of each behavior of a library."""
    agent = Agent("one", library.domain, library)
    targets = sorted(library.domain.targets)
    for name, automaton in library.load().items():
        bound = automaton.parameters, tuple(targets[: len(automaton.parameters)])
        curriculum = Curriculum(name, automaton.features, (), *bound)
        agent.begin(curriculum, resume=name, discard=True)
        yield name, agent


@pytest.mark.parametrize("folder", LIBRARIES, ids=lambda folder: folder.name)
def test_no_shipped_behavior_goes_round_in_a_circle(folder):
    remarks = {name: agent.remarks(look=True) for name, agent in trainees(open_library(folder))}
    assert remarks
    assert not any(remarks.values())
