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


@pytest.mark.parametrize(
    ("call", "expected"),
    [
        ("world step x", """'cycles': it must be a whole number of at least 1, not "x\""""),
        ("world step 0", """'cycles': it must be a whole number of at least 1, not "0\""""),
        ("world step -30", "cycles must be a whole number of at least 1, not a negative number"),
        ("library diff A x", """'before': it must be a whole number of at least 1, not "x\""""),
        ("library restore A 0", """'version': it must be a whole number of at least 1"""),
        ("logs -n x", """'-n': it must be a whole number of at least 0, not "x\""""),
        ("world pace realtime --factor x", "'--factor': it must be a number"),
        ("world pace realtime --factor 0", "0 is not above 0; `hitab world pause` stops the"),
        ("logs --levle warn", "No such option: --levle. Did you mean --level?"),
        ("down --quickly", "No such option: --quickly (known: --all, --run-dir, --swarm)"),
        ("logs --level loud", '--level: "loud" is not one of debug, info, warn, error, fatal'),
        ("step", "No such command 'step'. Did you mean `hitab world step`?"),
        ("world place keeper_1", 'where to put "keeper_1"? Write keeper_1 x=1 y=2 heading=90'),
        ("demonstrate GoFast", "name the agent and the behavior, as in `hitab demonstrate keeper"),
        ("stop keeper_1", "it stops all robots; `hitab perform keeper_1` stops one of them"),
        ("go keeper_1", "`hitab go` takes no names: it releases all robots"),
        ("reaction -1", "-1 is no option, and no negative number is expected here"),
        ("reaction 7", "a reaction time of 7 s is too long: give a number from 0 to"),
        ("world place keeper_1 z=1", 'keeper_1 has no field "z"; its fields are x (m), y (m), '),
        ("world place keeper_1 9 0", '"9": say what it is, for example keeper_1 x=9'),
        ("world place keeper_1 -9 0", "-9: say what it is, for example x=-9"),
        ("world place keeper_1 x=far", 'x must be a number, not "far"'),
        (
            "down thousand",
            'no swarm "thousand" is up, and no other; `hitab up thousand` starts',
        ),
        ("down keepway", 'no swarm "keepway" is up, and no other; `hitab up` starts one'),
        ("upp", "No such command 'upp'. Did you mean 'up'?"),
    ],
)
def test_the_error_names_the_argument_and_what_it_may_be(call, expected):
    assert expected in told(*call.split())


def test_a_mistyped_swarm_gets_the_closest_name_and_no_list():
    assert told("up", "keepawy").rstrip().endswith('Did you mean "keepaway"?')
    assert "keepaway, " in told("up", "nothing_like_it")


def test_a_mistyped_file_gets_the_one_beside_it(tmp_path):
    (tmp_path / "swarm.yaml").write_text("")
    assert 'Did you mean "' in (said := told("up", str(tmp_path / "swarm.yml")))
    assert "swarm.yaml" in said


def test_who_names_no_agent_reads_which_are_up(monkeypatch):
    up = (None, SimpleNamespace(agents=("keeper_1", "keeper_2")))
    monkeypatch.setattr(swarm_choice, "find_running", lambda which: up)
    assert "Missing argument 'agent'. These are up: keeper_1, keeper_2" in told("vocabulary")


def test_beginners_come_first_in_the_help():
    panels = re.findall(r"(?m)^╭─ (.+?) ─+╮$", CliRunner().invoke(make_app(), ["--help"]).stdout)
    assert panels[:3] == ["Options", "Begin here", "Swarm"]
    assert "Commands" not in panels
