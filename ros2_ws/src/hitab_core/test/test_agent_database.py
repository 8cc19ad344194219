"""What is acknowledged is on disk, whatever happens to the process, its disk or its files."""

from __future__ import annotations

import os
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import pytest
from faulty_disk import files_end_at

from hitab_core.texts.errors import FolderInUseError, LibraryError
from hitab_core.training.agent_database import AgentDatabase

RECORDS: list[dict[str, Any]] = [{"do": "begin", "features": ["x"]}, {"do": "command", "at": 0.1}]


class Journal:
    """The records of one training in a database."""

    def __init__(self, folder: Path) -> None:
        self.database = AgentDatabase(folder)
        with self.database.transaction(keep=True) as tables:
            self.records = self.database.records(tables, 1)

    def append(self, *records: dict[str, Any]) -> None:
        for record in records:
            with self.database.transaction(keep=True) as tables:
                self.database.append(tables, 1, len(self.records) + 1, record)
            self.records.append(record)


def records_in(folder: Path) -> list[dict[str, Any]]:
    journal = Journal(folder)
    journal.database.close()
    return journal.records


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with two records."""
    folder = tmp_path / "state" / "keeper_1"
    journal = Journal(folder)
    journal.append(*RECORDS)
    journal.database.close()
    return folder


def test_wherever_the_last_writes_are_torn_all_records_before_are_there(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "written")
    sizes = []
    for number in range(4):
        journal.append({"number": number, "padding": "x" * 3000})
        sizes.append((tmp_path / "written" / "agent.db-wal").stat().st_size)
    log = (tmp_path / "written" / "agent.db-wal").read_bytes()
    shutil.copy(journal.database.path, tmp_path)
    journal.database.close()
    for at in (0, 20, *(size + more for size in sizes for more in (-4100, -1, 0, 1, 30))):
        for torn in (log[:at], log[:at] + bytes(len(log[at:]))):
            folder = Path(tempfile.mkdtemp(dir=tmp_path))
            shutil.copy(tmp_path / "agent.db", folder)
            (folder / "agent.db-wal").write_bytes(torn)
            again = Journal(folder)
            complete = sum(size <= at for size in sizes)
            assert [record["number"] for record in again.records] == [*range(complete)]
            again.append({"number": complete})
            again.database.close()
            assert len(records_in(folder)) == complete + 1


def test_only_one_process_at_a_time_has_it_open(folder: Path) -> None:
    journal = Journal(folder)
    used = [sys.executable, "-c", APPENDING, str(folder)]
    errors = subprocess.run(used, capture_output=True, text=True, check=False).stderr
    assert "agent.db: is in use by another process; end it" in errors
    journal.append({"do": "undo"})
    journal.database.close()
    assert records_in(folder) == [*RECORDS, {"do": "undo"}]


def test_what_json_cannot_say_is_refused_and_the_journal_goes_on(folder: Path) -> None:
    journal = Journal(folder)
    with pytest.raises(LibraryError, match=r"agent.db: cannot hold this record"):
        journal.append({"value": float("nan")})
    journal.append({"do": "undo"})
    assert journal.records == [*RECORDS, {"do": "undo"}]


@pytest.mark.parametrize("more", [0, 10, 24, 3000, 4120, 5000])
def test_a_record_that_is_written_in_part_is_not_there_and_the_next_one_is(
    folder: Path, more: int
) -> None:
    journal = Journal(folder)
    journal.append({"do": "test"})
    size = len((folder / "agent.db-wal").read_bytes())
    long = {"do": "command", "padding": "x" * 9000}
    with (
        files_end_at(size + more),
        pytest.raises(LibraryError, match=r"agent.db: .*check the disk and try again"),
    ):
        journal.append(long)
    journal.append({"do": "undo"})
    expected = [*RECORDS, {"do": "test"}, {"do": "undo"}]
    assert journal.records == expected
    journal.database.close()
    assert records_in(folder) == expected


def test_a_full_disk_is_named_with_the_way_out_and_loses_nothing(folder: Path) -> None:
    journal = Journal(folder)
    with journal.database.transaction() as tables:
        (pages,) = tables.execute("PRAGMA page_count").fetchone()
        tables.execute(f"PRAGMA max_page_count = {pages}")
    with pytest.raises(LibraryError, match=r"agent.db: .*full; make room on the disk"):
        journal.append({"padding": "x" * 9000})
    journal.append({"do": "undo"})
    journal.database.close()
    assert records_in(folder) == [*RECORDS, {"do": "undo"}]


def test_a_database_of_a_newer_version_is_refused(folder: Path) -> None:
    connection = sqlite3.connect(folder / "agent.db")
    connection.execute("PRAGMA user_version = 7")
    connection.close()
    with pytest.raises(LibraryError, match=r"agent.db: has format version 7.*update HiTAB"):
        records_in(folder)


def test_a_path_that_cannot_be_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(LibraryError, match=r"file/agent.db: cannot use it: "):
        Journal(tmp_path / "file")


APPENDING = """
import sys
from pathlib import Path
from hitab_core.training.agent_database import AgentDatabase
database = AgentDatabase(Path(sys.argv[1]))
number = 0
while True:
    number += 1
    with database.transaction(keep=True) as tables:
        database.append(tables, 1, number, {"number": number, "padding": "x" * 5000})
    print(number, flush=True)
"""


@pytest.mark.parametrize("acknowledged", [1, 7, 30, 600])
def test_a_killed_agent_loses_no_record_that_it_acknowledged(
    tmp_path: Path, acknowledged: int
) -> None:
    agent = subprocess.Popen(
        [sys.executable, "-c", APPENDING, str(tmp_path)], stdout=subprocess.PIPE, text=True
    )
    assert agent.stdout is not None
    for _ in range(acknowledged):
        last = agent.stdout.readline()
    agent.send_signal(signal.SIGKILL)  # while it is at one of the next ones
    printed = [int(line) for line in [last, *agent.stdout] if line.endswith("\n")]
    agent.stdout.close()
    assert agent.wait(10) == -signal.SIGKILL
    found = [record["number"] for record in records_in(tmp_path)]
    assert found == list(range(1, len(found) + 1))
    assert len(found) >= printed[-1] >= acknowledged


def test_a_database_replaced_by_another_is_not_written_to(folder: Path, tmp_path: Path) -> None:
    journal = Journal(folder)
    Journal(tmp_path / "other").append({"do": "begin"})
    os.replace(tmp_path / "other" / "agent.db", folder / "agent.db")
    with pytest.raises(FolderInUseError, match=r"agent.db: was replaced by another file"):
        journal.append({"do": "undo"})
