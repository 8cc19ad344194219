from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hitab_core.errors import LibraryError
from hitab_core.training.example_journal import ExampleJournal

RECORDS = [{"do": "begin", "features": ["DistanceTo(ball)"]}, {"do": "command", "value": 0.1}]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Return the path of a journal with two records."""
    path = tmp_path / "keeper_1" / "training.jsonl"
    journal = ExampleJournal.open(path)
    for record in RECORDS:
        journal.append(record)
    journal.close()
    return path


def records_of(path: Path) -> list[dict[str, object]]:
    journal = ExampleJournal.open(path)
    found = journal.records
    journal.close()
    return found


def test_records_come_back_in_order_and_are_gone_on_with(path: Path) -> None:
    journal = ExampleJournal.open(path)
    assert journal.records == RECORDS
    journal.append({"do": "undo"})
    assert len(journal.records) == 3
    journal.close()
    assert records_of(path) == [*RECORDS, {"do": "undo"}]
    numbers = [json.loads(line)["number"] for line in path.read_text().splitlines()]
    assert numbers == [1, 2, 3]


json_values = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=10,
)


@given(records=st.lists(st.dictionaries(st.text(), json_values), max_size=4))
@settings(max_examples=40)
def test_any_record_comes_back_exactly(
    tmp_path_factory: pytest.TempPathFactory, records: list[dict[str, object]]
) -> None:
    path = tmp_path_factory.mktemp("journal") / "training.jsonl"
    journal = ExampleJournal.open(path)
    for record in records:
        journal.append(record)
    journal.close()
    assert records_of(path) == records


@given(cut=st.integers(0, 250))
@settings(max_examples=40)
def test_wherever_it_is_cut_off_all_complete_records_are_there_and_it_goes_on(
    tmp_path_factory: pytest.TempPathFactory, cut: int
) -> None:
    path = tmp_path_factory.mktemp("journal") / "training.jsonl"
    journal = ExampleJournal.open(path)
    for record in RECORDS:
        journal.append(record)
    journal.close()
    data = path.read_bytes()[:cut]
    path.write_bytes(data)
    complete = RECORDS[: data.count(b"\n")]
    assert records_of(path) == complete
    journal = ExampleJournal.open(path)
    journal.append({"do": "test"})
    journal.close()
    assert records_of(path) == [*complete, {"do": "test"}]


def test_zeros_that_a_power_failure_leaves_at_the_end_are_dropped(path: Path) -> None:
    with path.open("ab") as file:
        file.write(b"\0" * 100 + b"\n")
    assert records_of(path) == RECORDS


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        (b'"begin"', b'"begun"', "training.jsonl:1: was damaged or edited"),
        (b'"number": 2', b'"number": 3', "training.jsonl:2: has number 3 instead of 2"),
        (b'"journal": 2, "number": 2', b'"journal": 7, "number": 2', "has format version 7"),
        (b'"do": "begin"', b'"do": "begin', "training.jsonl:1: is not a record of a journal"),
        (b"0.1}", b"0.2}", "training.jsonl:2: was damaged or edited"),
        (b"\n{", b"\n[]\n{", "training.jsonl:2: is not a record of a journal"),
    ],
)
def test_damage_anywhere_else_is_told_by_line(
    path: Path, old: bytes, new: bytes, complaint: str
) -> None:
    data = path.read_bytes()
    assert old in data
    path.write_bytes(data.replace(old, new))
    with pytest.raises(LibraryError, match=complaint):
        ExampleJournal.open(path)
    assert path.read_bytes() == data.replace(old, new), "nothing is changed"


def test_only_one_process_at_a_time_has_it_open(path: Path) -> None:
    journal = ExampleJournal.open(path)
    with pytest.raises(LibraryError, match="in use by another process"):
        ExampleJournal.open(path)
    journal.close()
    assert records_of(path) == RECORDS
    with pytest.raises(LibraryError, match="is closed; reopen it"):
        journal.append({})


def test_what_json_cannot_say_is_refused_and_nothing_is_written(path: Path) -> None:
    before = path.read_bytes()
    journal = ExampleJournal.open(path)
    for record in ({"value": float("nan")}, {"value": object()}):
        with pytest.raises(LibraryError, match="cannot hold"):
            journal.append(record)
    journal.close()
    assert path.read_bytes() == before


def test_a_record_that_could_not_be_written_leaves_nothing_behind(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = path.read_bytes()
    journal = ExampleJournal.open(path)

    def half(descriptor: int, data: bytes) -> None:
        os.write(descriptor, data[: len(data) // 2])
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("hitab_core.training.example_journal.write_all", half)
        with pytest.raises(LibraryError, match="make room on the disk"):
            journal.append({"do": "command"})
    assert path.read_bytes() == before
    journal.append({"do": "command"})
    assert len(journal.records) == 3
    journal.close()
    assert records_of(path) == [*RECORDS, {"do": "command"}]


def test_an_archived_journal_makes_room_for_a_new_one(path: Path) -> None:
    first = ExampleJournal.open(path).archive()
    assert first == path.with_name("training.1.jsonl")
    assert records_of(first) == RECORDS
    journal = ExampleJournal.open(path)
    assert journal.records == []
    assert journal.archive() == path.with_name("training.2.jsonl")


def test_a_discarded_journal_is_gone(path: Path) -> None:
    ExampleJournal.open(path).discard()
    assert not path.exists()
    assert records_of(path) == []


def test_a_path_that_cannot_be_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(LibraryError, match=r"file/training.jsonl: cannot open it"):
        ExampleJournal.open(tmp_path / "file" / "training.jsonl")


APPENDING = """
import sys
from hitab_core.training.example_journal import ExampleJournal
journal = ExampleJournal.open(sys.argv[1])
while True:
    number = len(journal.records) + 1
    journal.append({"number": number, "padding": "x" * 5000})
    print(number, flush=True)
"""


@pytest.mark.parametrize("acknowledged", [1, 7, 30])
def test_a_killed_agent_loses_no_record_that_it_acknowledged(
    tmp_path: Path, acknowledged: int
) -> None:
    path = tmp_path / "training.jsonl"
    agent = subprocess.Popen(
        [sys.executable, "-c", APPENDING, str(path)], stdout=subprocess.PIPE, text=True
    )
    assert agent.stdout is not None
    for _ in range(acknowledged):
        last = agent.stdout.readline()
    agent.send_signal(signal.SIGKILL)  # while it is at one of the next ones
    told = [int(line) for line in [last, *agent.stdout] if line.endswith("\n")]
    agent.stdout.close()
    assert agent.wait(10) == -signal.SIGKILL
    found = [record["number"] for record in records_of(path)]
    assert found == list(range(1, len(found) + 1))
    assert len(found) >= told[-1] >= acknowledged
