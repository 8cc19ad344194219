"""Arguments that the verbs for keys and gamepads refuse before they connect."""

import pytest
import typer

from hitab_cli.verbs.train.driving_verbs import drive
from hitab_client import DescriptionError
from hitab_gamepad.verb import joystick


@pytest.mark.parametrize("wrong", [{"speed": 0.0}, {"speed": float("nan")}, {"turn": -1.0}])
def test_a_speed_that_makes_no_sense_is_refused(monkeypatch, wrong):
    for stream in ("stdin", "stdout"):
        monkeypatch.setattr(f"sys.{stream}.isatty", lambda: True, raising=False)
    with pytest.raises(typer.BadParameter, match="it must be above 0"):
        drive(**wrong)


def test_a_mapping_that_is_not_there_is_refused_before_the_swarm_is_looked_for():
    with pytest.raises(DescriptionError, match='no mapping "my_gamepad"'):
        joystick(mapping="my_gamepad")
