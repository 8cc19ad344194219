"""scripts/setup and scripts/env.sh, in a small checkout with nothing to download or compile."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = sorted(path.parent for path in ROOT.glob("ros2_ws/src/*/package.xml"))
# Stands for colcon: notes that it was called, and goes on when it may.
COLCON = """#!/bin/sh
echo build >> {root}/builds
while [ -e {root}/hold ]; do sleep 0.05; done
"""


class Checkout:
    """A checkout whose lock files are empty and whose colcon does nothing."""

    def __init__(self, root: Path):
        self.root = root
        self.venv = root / ".venv"
        self.stamps = self.venv / ".hitab"
        shutil.copytree(ROOT / "scripts", root / "scripts")
        (root / "requirements").mkdir()
        for name in ("uv", "wheels", "installed-jazzy"):
            (root / f"requirements/{name}.lock").write_text("# nothing\n")
        self.message = root / "ros2_ws/src/hitab_msgs/msg/Command.msg"
        self.message.parent.mkdir(parents=True)
        self.message.write_text("string behavior\n")
        self.stubs = root / "stubs"
        self.stubs.mkdir()
        self.stub("colcon", COLCON.format(root=root))

    def stub(self, name: str, text: str) -> None:
        path = self.stubs / name
        path.write_text(text)
        path.chmod(0o755)

    def environment(self, path: str | None = None) -> dict[str, str]:
        return {
            "HOME": str(self.root),
            "HITAB_ROS": "wheels",
            "PATH": f"{self.stubs}:{path or machine_path()}",
            "PIP_NO_INDEX": "1",
        }

    def start(self, *arguments: str, path: str | None = None) -> subprocess.Popen:
        return subprocess.Popen(
            [self.root / "scripts/setup", *arguments],
            env=self.environment(path),
            stdin=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )

    def setup(self, *arguments: str, path: str | None = None) -> tuple[int, str]:
        process = self.start(*arguments, path=path)
        said = process.communicate()[1]
        return process.returncode, said

    def builds(self) -> int:
        log = self.root / "builds"
        return len(log.read_text().split()) if log.exists() else 0


def machine_path() -> str:
    """The PATH without this test's own environment."""
    folders = os.environ["PATH"].split(":")
    return ":".join(folder for folder in folders if not folder.startswith(sys.prefix))


def path_without(folder: Path, *names: str) -> str:
    """A PATH with every program of this machine except those whose names match one of `names`."""
    folder.mkdir()
    for place in machine_path().split(":"):
        for program in Path(place).iterdir() if Path(place).is_dir() else ():
            link = folder / program.name
            if not link.exists() and not any(re.fullmatch(name, link.name) for name in names):
                link.unlink(missing_ok=True)
                link.symlink_to(program)
    return str(folder)


def wait_until(condition, seconds: float = 60.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "did not happen in time"
        time.sleep(0.02)


@pytest.fixture
def checkout(tmp_path):
    return Checkout(tmp_path / "checkout")


@pytest.fixture(scope="module")
def ready(tmp_path_factory):
    """A checkout that is set up, and how many seconds that took."""
    checkout = Checkout(tmp_path_factory.mktemp("ready") / "checkout")
    start = time.monotonic()
    code, said = checkout.setup()
    assert code == 0, said
    checkout.seconds = time.monotonic() - start
    return checkout


def test_a_second_set_up_does_nothing_and_takes_a_fraction_of_the_time(ready):
    stamps = {path: path.stat().st_mtime_ns for path in ready.stamps.iterdir()}
    builds = ready.builds()
    start = time.monotonic()
    code, said = ready.setup("--quiet")
    assert time.monotonic() - start < ready.seconds / 4
    assert (code, said) == (0, "")
    assert stamps == {path: path.stat().st_mtime_ns for path in ready.stamps.iterdir()}
    assert ready.builds() == builds


@pytest.mark.parametrize("called", ["scripts/hitab", "{root}/scripts/hitab", "hitab"])
def test_hitab_is_told_how_it_was_called(ready, called):
    (command := ready.venv / "bin/hitab").write_text('#!/bin/sh\necho "$HITAB_CALLED_AS"\n')
    command.chmod(0o755)
    environment = ready.environment()
    if called == "hitab":
        environment["PATH"] = f"{ready.root}/scripts:{environment['PATH']}"
    typed = called.format(root=ready.root)
    done = subprocess.run(
        ["bash", "-c", typed], cwd=ready.root, env=environment, capture_output=True, text=True
    )
    assert (done.returncode, done.stdout) == (0, f"{typed}\n"), done.stderr


def test_a_changed_message_is_built_and_nothing_else_is_made_again(ready):
    environment = (ready.stamps / "environment").stat().st_mtime_ns
    builds = ready.builds()
    ready.message.write_text("string behavior\nstring[] targets\n")
    assert ready.setup("--check")[1].endswith(": messages\n")
    assert ready.setup()[0] == 0
    assert ready.builds() == builds + 1
    assert (ready.stamps / "environment").stat().st_mtime_ns == environment


@pytest.mark.parametrize(
    ("gone", "names", "remedy"),
    [
        ("compiler", [r".*\+\+.*", r"(.*-)?(gcc|clang|cc)(-\d+)?"], "apt install build-essential"),
        ("Python", [r"python.*"], "apt install python3 python3-venv"),
    ],
)
def test_what_the_machine_lacks_is_said_in_one_line_with_the_remedy(
    checkout, tmp_path, gone, names, remedy
):
    code, said = checkout.setup(path=path_without(tmp_path / "programs", *names))
    assert code == 1
    assert said.count("\n") == 1
    assert gone in said
    assert remedy in said
    assert not checkout.venv.exists()


def test_a_folder_that_holds_something_else_is_left_alone(checkout):
    checkout.venv.mkdir()
    (checkout.venv / "thesis.tex").write_text("mine")
    code, said = checkout.setup()
    assert code == 1
    assert "holds something else" in said
    assert (checkout.venv / "thesis.tex").read_text() == "mine"


def test_a_set_up_killed_while_it_built_the_messages_builds_them_from_scratch(ready):
    ready.message.write_text("string other\n")
    (ready.root / "hold").touch()
    builds = ready.builds()
    process = ready.start()
    wait_until(lambda: ready.builds() == builds + 1)
    process.send_signal(signal.SIGKILL)
    (ready.root / "hold").unlink()
    process.communicate()
    half_built = ready.venv / "build/hitab_msgs"
    half_built.mkdir(parents=True)
    assert ready.setup("--check")[1].endswith(": messages\n")
    code, said = ready.setup()
    assert code == 0, said
    assert not half_built.exists()


def test_a_second_set_up_at_once_waits_and_says_so(ready):
    ready.message.write_text("string yet_another\n")
    (ready.root / "hold").touch()
    builds = ready.builds()
    first = ready.start()
    wait_until(lambda: ready.builds() == builds + 1)
    second = ready.start()
    assert "waiting" in second.stderr.readline()
    assert second.poll() is None
    (ready.root / "hold").unlink()
    first.communicate()
    second.communicate()
    assert (first.returncode, second.returncode) == (0, 0)
    assert ready.builds() == builds + 1


def test_the_environment_file_takes_another_ros_out_of_the_shell(checkout):
    environment = checkout.environment() | {
        "AMENT_PREFIX_PATH": "/home/me/ws/install/a:/opt/ros/humble",
        "PYTHONPATH": "/opt/ros/humble/lib/python3.10/site-packages",
        "LD_LIBRARY_PATH": "/opt/ros/humble/lib:/home/me/ws/install/a/lib:/opt/cuda/lib",
        "RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp",
        "ROS_DISTRO": "humble",
    }
    environment["PATH"] += ":/opt/ros/humble/bin"
    shown = sourced(checkout, environment)
    assert shown["PATH"].split(":")[0] == f"{checkout.venv}/bin"
    assert "humble" not in "".join(f"{name}={value}" for name, value in shown.items())
    assert shown["LD_LIBRARY_PATH"] == "/opt/cuda/lib"
    assert shown["ROS_DISTRO"] == "jazzy"
    assert "PYTHONPATH" not in shown
    assert "RMW_IMPLEMENTATION" not in shown


@pytest.mark.parametrize(
    ("said", "counts", "bound"),
    [
        ({}, "SYSTEM_DEFAULT", True),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}, "SUBNET", False),
        ({"RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp", "ROS_DISTRO": "jazzy"}, "LOCALHOST", False),
    ],
)
def test_a_prepared_shell_has_a_profile_that_binds_to_this_machine(checkout, said, counts, bound):
    """SYSTEM_DEFAULT is safe with that profile only."""
    profile = "ros2_ws/src/hitab_client/hitab_client/connecting/dds_loopback.xml"
    (checkout.root / profile).parent.mkdir(parents=True)
    shutil.copy(ROOT / profile, checkout.root / profile)
    installed = checkout.root / "jazzy"
    installed.mkdir()
    (installed / "setup.bash").touch()
    environment = checkout.environment() | {"HITAB_ROS": str(installed)} | said
    shown = sourced(checkout, environment)
    assert shown["ROS_AUTOMATIC_DISCOVERY_RANGE"] == counts
    expected = str(checkout.root / profile) if bound else None
    assert shown.get("FASTRTPS_DEFAULT_PROFILES_FILE") == expected
    assert sourced(checkout, shown) == shown
    subnet = sourced(checkout, shown | {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"})
    assert "FASTRTPS_DEFAULT_PROFILES_FILE" not in subnet


def sourced(checkout: Checkout, environment: dict[str, str]) -> dict[str, str]:
    """What the environment is after sourcing scripts/env.sh, in a shell that allows no slip."""
    script = 'set -eu; . "$0"; env -0'
    shown = subprocess.run(
        ["bash", "-c", script, checkout.root / "scripts/env.sh"],
        env=environment,
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    pairs = (line.split("=", 1) for line in shown.split("\0") if line)
    return {name: value for name, value in pairs if name not in ("_", "SHLVL", "PWD")}


def test_lock_files_pin_all_with_hashes_and_name_no_host():
    locks = sorted(ROOT.glob("requirements/*.lock"))
    assert len(locks) == 4
    for lock in locks:
        text = lock.read_text()
        assert "://" not in text
        entries = re.split(r"\n(?=\S)", re.sub(r"^\s*#.*\n", "", text, flags=re.MULTILINE))
        assert all("==" in entry and "--hash=sha256:" in entry for entry in entries)


def test_the_ament_index_leads_to_the_packages_as_they_are_in_the_checkout():
    shown = subprocess.run(
        ["bash", "-c", '. "$0" && python -c "$@"', ROOT / "scripts/env.sh", LOCATE]
        + [package.name for package in PACKAGES],
        check=True,
        capture_output=True,
        text=True,
    ).stdout.splitlines()
    assert len(shown) == len(PACKAGES)
    for package, folder in zip(PACKAGES, shown, strict=True):
        assert Path(folder, "package.xml").read_text() == (package / "package.xml").read_text()


LOCATE = """
import sys
from ament_index_python import get_package_share_directory
for name in sys.argv[1:]:
    print(get_package_share_directory(name))
"""
