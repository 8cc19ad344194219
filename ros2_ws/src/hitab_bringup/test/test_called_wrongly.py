"""Whoever calls the command wrongly reads which argument is wrong, and what it may be."""

import re
from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

from hitab_bringup.main import make_app
from hitab_client import swarm_choice


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    monkeypatch.setenv("HITAB_HOME", str(tmp_path))
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)


def told(*arguments: str) -> str:
    environment = {"COLUMNS": "160", "TERM": "dumb"}
    result = CliRunner().invoke(make_app(), list(arguments), env=environment)
    assert result.exit_code in (0, 1, 2), result.output
    return re.sub(r"[\s│╭╮╰╯─]+", " ", result.output)


def test_the_error_names_the_argument_and_what_it_may_be():
    for call, expected in [
        ("world step x", """'cycles': it must be a whole number of at least 1, not "x\""""),
        ("world step -30", "cycles must be a whole number of at least 1, not a negative number"),
        ("world pace realtime --factor x", "'--factor': it must be a number"),
        ("logs --levle warn", "No such option: --levle. Did you mean --level?"),
        ("world place keeper_1", 'where to put "keeper_1"? Write keeper_1 x=1 y=2 heading=90'),
        ("stop keeper_1", "it stops all robots; `hitab perform keeper_1` stops one of them"),
        ("reaction -1", "-1 is no option, and no negative number is expected here"),
        ("world place keeper_1 z=1", "such as keeper_1 x=1; the fields are x (m), y (m), "),
        ("world place keeper_1 x=far", '"x=far": write a name, then its fields, each with a'),
    ]:
        assert expected in told(*call.split())


def test_who_names_no_agent_reads_which_are_up(monkeypatch):
    up = (None, SimpleNamespace(agents=("keeper_1", "keeper_2")))
    monkeypatch.setattr(swarm_choice, "find_running", lambda which: up)
    assert "Missing argument 'agent'. These are up: keeper_1, keeper_2" in told("vocabulary")
