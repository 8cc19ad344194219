"""A description that comes over the network is written only if it is data in its own folder."""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from hitab_msgs.msg import MachineFile
from hitab_msgs.srv import ReadFiles

from hitab_client import MachineSigns, RosLink, SwarmError, domain_ids
from hitab_machines import fetch_description

SWARM = "agents: {a: {}}\nmachines: {lab_1: {}}\n"
Send = Callable[[dict[str, str]], None]


@pytest.fixture
def send(monkeypatch: pytest.MonkeyPatch) -> Iterator[Send]:
    """Return a function that chooses what a machine of swarm field sends."""
    files: dict[str, str] = {}

    def read(request: ReadFiles.Request, response: ReadFiles.Response) -> ReadFiles.Response:
        response.success = True
        for path in request.paths[:1] or files:
            data = files[path].encode()
            digest = hashlib.sha256(data).hexdigest()
            sent = data if request.paths else b""
            response.files.append(MachineFile(path=path, digest=digest, data=sent))
        return response

    over = threading.Event()
    with domain_ids.reserved() as number, RosLink(number) as link:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
        link.node.create_service(ReadFiles, "/lab_1/read_files", read)
        signs = MachineSigns(link.node, "", "field-0123abcd", "lab_1")

        def spin() -> None:
            while not over.is_set():
                link.spin()

        thread = threading.Thread(target=spin)
        thread.start()
        yield files.update
        over.set()
        thread.join()
        assert not signs.heard


def test_all_files_are_written_in_place_of_those_of_an_earlier_start(send: Send, tmp_path: Path):
    (tmp_path / "description").mkdir()
    (tmp_path / "description" / "old.yaml").touch()
    sent = {"kinds/squad.yaml": "orders: {}", "swarms/field.yaml": SWARM, "mine/Go.hfa.yaml": ""}
    send(sent)
    file = fetch_description("field", tmp_path)
    assert file == tmp_path / "description" / "swarms" / "field.yaml"
    found = (path for path in (tmp_path / "description").rglob("*") if path.is_file())
    assert {
        path.relative_to(tmp_path / "description").as_posix(): path.read_text() for path in found
    } == sent


@pytest.mark.parametrize(
    ("path", "expected"),
    [
        (
            "../field.yaml",
            'lab_1 sends files, but "../field.yaml" is not a path in a shared folder',
        ),
        (
            "/tmp/field.yaml",
            'is not a path in a shared folder; paths are relative, without ".."; copy',
        ),
        ("a//field.yaml", "is not a path in a shared folder"),
        ("a\\..\\field.yaml", "is not a path in a shared folder"),
        ("walk.py", r"lab_1 sends walk\.py, but only .* are taken; copy the swarm file"),
        (".bashrc", "but only .* are taken"),
    ],
)
def test_nothing_is_written_if_a_path_leads_out_or_is_code(
    send: Send, tmp_path: Path, path: str, expected: str
):
    send({"field.yaml": SWARM, path: SWARM})
    with pytest.raises(SwarmError, match=expected):
        fetch_description("field", tmp_path)
    assert not [*tmp_path.iterdir()]
