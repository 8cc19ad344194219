"""A swarm's supervisor is up once it answers, and leaves nothing behind once stopped."""

import subprocess
import sys

import pytest

from hitab_bringup.processes import supervision
from hitab_client import RunFolder, RunRecord, SwarmError

BINDS_ONLY = """
import socket, sys, time
s = socket.socket(socket.AF_UNIX)
s.bind(sys.argv[1])
print("bound", flush=True)
time.sleep(0.3)
"""


def test_a_supervisor_whose_socket_is_there_but_nobody_listens_has_not_started(tmp_path):
    folder = RunFolder(tmp_path / "run")
    folder.prepare()
    socket = folder.socket_path()
    (folder.path / "supervisord.out").write_text("no port\n")
    command = [sys.executable, "-c", BINDS_ONLY, str(socket)]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as started:
        assert started.stdout.readline() == b"bound\n"
        record = RunRecord(
            "red", "r.yaml", 7, "LOCALHOST", ("a",), False, started.pid, str(socket), "red-1"
        )
        folder.write(record, register=False)
        with pytest.raises(SwarmError, match="supervisord did not start: no port"):
            supervision._await_answer(started, record, folder)
    assert folder.read() is None
    assert not socket.exists()
