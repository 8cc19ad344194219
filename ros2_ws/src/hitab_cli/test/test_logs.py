"""`hitab logs`: the logs of a swarm's processes, in the order of time."""

from datetime import datetime

import pytest
from typer.testing import CliRunner

from hitab_cli.main import make_app
from hitab_cli.verbs.swarm import logs_verbs as verb
from hitab_client import RunFolder, RunRecord

NOON = datetime(2026, 5, 1, 12).timestamp()
TEAM = RunRecord(
    "team", "t.yaml", 7, "LOCALHOST", ("a", "b", "c"), True, 1, "s", "team-1", (),
    {"world": (), "a": ("a",), "host_1": ("b", "c")},
)  # fmt: skip


def ros(seconds: float, logger: str, text: str, level: str = "INFO") -> str:
    return f"[{level}] [{NOON + seconds:.9f}] [{logger}]: {text}\n"


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Make a run folder with logs; the swarm is up."""
    monkeypatch.setenv("HITAB_HOME", str(tmp_path))
    folder = RunFolder.of_swarm("team")
    folder.prepare()
    folder.write(TEAM, register=True)
    monkeypatch.setattr(RunFolder, "supervisor", lambda *_: object())
    folder.log("a").write_text(
        ros(1, "a.agent", "first") + "Traceback:\n" + ros(4, "a.agent", "fourth", "ERROR")
    )
    folder.log("host_1").write_text(ros(2, "b.agent", "second"))
    (folder.path / "supervisord.log").write_text(
        "2026-05-01 12:00:03,100 CRIT Server 'unix_http_server' running without any check\n"
        "2026-05-01 12:00:03,250 INFO spawned: 'a' with pid 5\n"
    )
    return folder


def hitab(*arguments: str):
    return CliRunner().invoke(make_app(), list(arguments))


def test_all_logs_are_merged_with_names(run):
    result = hitab("logs")
    assert result.exit_code == 0
    assert result.stdout.splitlines() == [
        "a | 2026-05-01 12:00:01.000 INFO  first",
        "a | Traceback:",
        "host_1 | 2026-05-01 12:00:02.000 INFO  b: second",
        "supervisor | 2026-05-01 12:00:03.250 INFO  spawned: 'a' with pid 5",
        "a | 2026-05-01 12:00:04.000 ERROR fourth",
    ]
    assert result.stderr == f"from {run.path}/logs\n"


def test_following_shows_what_is_added_until_the_swarm_is_down(run, monkeypatch):
    log = run.log("a")

    def append_half() -> None:
        with log.open("a") as file:
            file.write(ros(5, "a.agent", "fi")[:-1])

    def append_rest() -> None:
        with log.open("a") as file:
            file.write("fth\n")

    def rotate() -> None:
        log.rename(log.with_name("a.log.1"))
        log.write_text(ros(6, "a.agent", "sixth"))

    def add_process() -> None:
        run.log("world").write_text(ros(7, "world.world", "seventh"))

    events = iter((append_half, append_rest, rotate, add_process, run.forget))
    monkeypatch.setattr(verb.time, "sleep", lambda _: next(events)())
    result = hitab("logs", "--follow", "-n", "1")
    assert result.exit_code == 0
    assert result.stdout.splitlines() == [
        "a | 2026-05-01 12:00:04.000 ERROR fourth",
        "a | 2026-05-01 12:00:05.000 INFO  fifth",
        "a | 2026-05-01 12:00:06.000 INFO  sixth",
        "world | 2026-05-01 12:00:07.000 INFO  seventh",
    ]
    assert result.stderr.splitlines()[-1] == "team is down"


def test_rotated_logs_are_read_too(run):
    run.log("a").with_name("a.log.1").write_text(ros(0, "a.agent", "zeroth"))
    run.log("a").with_name("a.log.2").write_text(ros(-1, "a.agent", "before"))
    shown = hitab("logs", "a").stdout.splitlines()
    assert [line[-6:] for line in shown][:3] == ["before", "zeroth", " first"]


def test_only_warnings_and_errors_are_shown_with_all_that_belongs_to_them(run):
    run.log("a").write_text(
        ros(1, "a.agent", "first")
        + ros(2, "a.agent", "careful", "WARN")
        + "more about it\n"
        + ros(3, "a.agent", "all is well")
        + "Traceback (most recent call last):\nOSError\n"
    )
    assert hitab("logs", "--level", "warn").stdout.splitlines() == [
        "a | 2026-05-01 12:00:02.000 WARN  careful",
        "a | more about it",
        "a | Traceback (most recent call last):",
        "a | OSError",
    ]
    assert "careful" not in hitab("logs", "a", "--level", "error").stdout
    nothing = hitab("logs", "host_1", "--level", "warn")
    assert (nothing.exit_code, nothing.stdout) == (0, "")
    assert "no lines of level warn or above" in nothing.stderr
