"""Errors of a wrong call name the wrong argument and the possible ones."""

import re

import pytest
from typer.testing import CliRunner

from hitab_cli.main import make_app


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    monkeypatch.setenv("HITAB_HOME", str(tmp_path))
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)


def output_of(*arguments: str) -> str:
    environment = {"COLUMNS": "160", "TERM": "dumb"}
    result = CliRunner().invoke(make_app(), list(arguments), env=environment)
    assert result.exit_code in (0, 1, 2), result.output
    return re.sub(r"[\s│╭╮╰╯─]+", " ", result.output)


def test_the_error_names_the_argument_and_what_it_may_be():
    for call, expected in [
        ("world place keeper_1", 'where to put "keeper_1"? Write keeper_1 x=1 y=2 heading=90'),
        ("stop keeper_1", "it stops all robots; to stop one, make keeper_1 idle: `hitab perform"),
        ("pause", 'No such command "pause". Did you mean `hitab world pause`?'),
        ("world place keeper_1 z=1", "such as keeper_1 x=1; the fields are x (m), y (m), "),
        ("world place keeper_1 x=far", '"x=far": write a name, then its fields, each with a'),
        (
            "world step -5",
            "Invalid value for 'cycles': Input should be greater than or equal to 1",
        ),
        ("world step --five", "No such option: --five"),
    ]:
        assert expected in output_of(*call.split())
