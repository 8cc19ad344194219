"""A training that goes on with the next generation allows what it allowed before."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import MagicMock

import pytest

from hitab_client.bootstrapping.steps import Bootstrapping
from hitab_client.learned import Learned
from hitab_core import Example


class Swarm:
    """Keeps with what a training was begun."""

    prefix = ""
    demonstrator = "ann"

    def __init__(self) -> None:
        self.link = MagicMock()

    def begin(self, agent: str, automaton: str, **fields: Any) -> Any:
        self.begun = fields
        return SimpleNamespace(message=f'training "{automaton}"; more')


@pytest.mark.parametrize("chosen", [(), ("Stop", "Go")])
def test_the_choice_of_states_is_kept_though_all_of_them_were_commanded(
    chosen: tuple[str, ...], tmp_path: Path
) -> None:
    examples = (Example("Start", (), "Go"), Example("Go", (), "Stop"))
    training = Learned(
        "Ride", "training", "", "tree", (), (), ("Go", "Stop"), (), (), (), examples, chosen=chosen
    )
    swarm: Any = Swarm()
    Bootstrapping(swarm, None, tmp_path)._resume("ann", training)
    assert swarm.begun["states"] == list(chosen)
