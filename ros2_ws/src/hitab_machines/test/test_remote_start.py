"""Machines are started by the system's `ssh`, and every failure says what to do.

The `ssh` of most tests is a stub on the PATH that runs the command here.
"""

import getpass
import os
import re
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from hitab_bringup import MachineDescription, SwarmDescription
from hitab_client import SwarmError
from hitab_machines import RemoteStarts, local_machine

SSHD = shutil.which("sshd", path=f"{os.environ['PATH']}:/usr/sbin:/usr/local/sbin")
STUB = """\
#!/bin/sh
[ "$1 $2 $3 $4 $5" = "-tt -o BatchMode=yes -o LogLevel=ERROR" ] || exit 1
[ "$6" = unknown ] && echo "Host key verification failed." && exit 255
shift 6
exec sh -c "$*"
"""
HITAB = (
    '#!/bin/sh\necho "domain $ROS_DOMAIN_ID, range $ROS_AUTOMATIC_DISCOVERY_RANGE: $*"\nexit %d\n'
)


@pytest.fixture
def programs(tmp_path, monkeypatch) -> Path:
    """Return a folder that is the first on the PATH, with a stub of `ssh`."""
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")
    program(tmp_path / "ssh", STUB)
    program(tmp_path / "hitab", HITAB % 0)
    program(tmp_path / "broken", HITAB % 3)
    return tmp_path


def program(path: Path, text: str) -> None:
    path.write_text(text)
    path.chmod(0o755)


def swarm(*machines: tuple[str, str], hitab: str = "hitab") -> SwarmDescription:
    described = tuple(
        MachineDescription(name, ("host",), destination, hitab) for name, destination in machines
    )
    return SwarmDescription("field", Path("field.yaml"), (), machines=described)


def started(described: SwarmDescription, *options: str) -> tuple[list[str], list[str]]:
    """Return what is said while the others start, and why some did not."""
    said: list[str] = []
    here = described.on_machine("desk")
    with RemoteStarts(here, "field", 7, options, said.append) as starts:
        return said, starts.wait()


def test_each_machine_is_told_its_name_the_domain_and_all_options(programs):
    three = swarm(("desk", ""), ("lab_1", "ann@lab1"), ("lab_2", "lab2"))
    said, failures = started(three, "--pace", "it's")
    assert failures == []
    assert sorted(said) == [
        f"{name}: domain 7, range SUBNET: up field --pace it's --machine {name}"
        for name in ("lab_1", "lab_2")
    ]


@pytest.mark.parametrize(
    ("destination", "hitab", "expected"),
    [
        ("unknown", "hitab", "cannot connect to unknown .*Host key verification failed.*try `ssh"),
        ("lab", "~/none/hitab", r"lab has no command ~/none/hitab .*write its path as `hitab:`"),
        ("lab", "broken", "lab_1: `hitab up` ended on lab with exit code 3"),
    ],
)
def test_a_failure_names_the_machine_and_the_way_out(programs, destination, hitab, expected):
    _, (failure,) = started(swarm(("desk", ""), ("lab_1", destination), hitab=hitab))
    assert re.search(expected, failure), failure


def test_nothing_starts_without_ssh_or_with_a_machine_that_has_none(programs, monkeypatch):
    with pytest.raises(SwarmError, match="lab_1 cannot be started from here; add `ssh:`"):
        started(swarm(("desk", ""), ("lab_1", "")))
    monkeypatch.setenv("PATH", str(programs / "none"))
    with pytest.raises(SwarmError, match="there is no program `ssh` on the PATH; install"):
        started(swarm(("desk", ""), ("lab_1", "lab1")))


def test_this_machine_is_the_one_without_ssh():
    assert local_machine(swarm(("lab_1", "lab1"), ("desk", ""))) == "desk"
    with pytest.raises(SwarmError, match="a, b have no `ssh:`; say which this one is with"):
        local_machine(swarm(("a", ""), ("b", "")))
    with pytest.raises(SwarmError, match="every machine has `ssh:`; say which this one is"):
        local_machine(swarm(("a", "x")))
    with pytest.raises(SwarmError, match="has no `machines:`; leave out --all"):
        local_machine(swarm())


@pytest.fixture
def sshd(tmp_path, programs) -> Iterator[str]:
    """Return a destination at which a real sshd of this user answers."""
    assert SSHD is not None
    try:
        getpass.getuser()
    except (KeyError, OSError):
        pytest.skip("ssh knows users by name, and this one has none")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    for key in ("host", "user"):
        line = ["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", str(tmp_path / key)]
        subprocess.run(line, check=True)
    (tmp_path / "sshd_config").write_text(
        f"ListenAddress 127.0.0.1:{port}\nHostKey {tmp_path}/host\nStrictModes no\n"
        f"AuthorizedKeysFile {tmp_path}/user.pub\nPidFile none\n"
    )
    (tmp_path / "ssh_config").write_text(
        f"Host lab\n  HostName 127.0.0.1\n  Port {port}\n  User {getpass.getuser()}\n"
        f"  IdentityFile {tmp_path}/user\n  StrictHostKeyChecking no\n"
        f"  UserKnownHostsFile {tmp_path}/known\n"
    )
    (programs / "ssh").unlink()
    real = shutil.which("ssh")
    program(programs / "ssh", f'#!/bin/sh\nexec {real} -F {tmp_path}/ssh_config "$@"\n')
    if os.geteuid() == 0:  # then sshd wants this folder, which its service makes
        Path("/run/sshd").mkdir(mode=0o755, exist_ok=True)
    server = subprocess.Popen([SSHD, "-D", "-e", "-f", str(tmp_path / "sshd_config")])
    deadline = time.monotonic() + 10.0
    while subprocess.run(["ssh", "lab", "true"], check=False).returncode:
        assert server.poll() is None, "it does not start"
        assert time.monotonic() < deadline
    yield "lab"
    server.terminate()
    server.wait()


@pytest.mark.skipif(SSHD is None, reason="no sshd is installed here")
def test_a_real_sshd_starts_a_machine(sshd, programs):
    said, failures = started(swarm(("desk", ""), ("lab_1", sshd), hitab=str(programs / "hitab")))
    assert failures == []
    assert said == ["lab_1: domain 7, range SUBNET: up field --machine lab_1"]
