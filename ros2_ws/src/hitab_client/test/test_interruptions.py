"""Ctrl-C, SIGTERM and SIGHUP wait for the end of changes that must not be left half done."""

import signal
import subprocess
import sys

import pytest

BEGIN = """
import signal
from hitab_client.terminal.interruptions import *
handle_interruptions()
"""
DEFERRED = (
    BEGIN
    + """
try:
    with not_interrupted():
        signal.raise_signal({number})
        with not_interrupted():
            pass
        print("done", flush=True)
    print("not reached")
except KeyboardInterrupt:
    print("interrupted")
"""
)
TWICE = (
    BEGIN
    + """
with not_interrupted():
    signal.raise_signal(signal.SIGINT)
    print("first", flush=True)
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt:
        print("second", flush=True)
"""
)


def run(code: str, **options) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, **options
    )


def test_ctrl_c_is_deferred_to_the_end_of_what_must_be_done_whole():
    done = run(DEFERRED.format(number="signal.SIGINT"))
    assert (done.returncode, done.stdout) == (0, "done\ninterrupted\n"), done.stderr


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP], ids=["term", "hup"])
def test_other_signals_are_deferred_too_and_end_with_their_status(number):
    done = run(DEFERRED.format(number=int(number)))
    assert (done.returncode, done.stdout) == (128 + number, "done\n"), done.stderr


def test_the_second_ctrl_c_is_not_deferred():
    done = run(TWICE)
    assert done.stdout == "first\nsecond\n", done.stderr


def test_a_process_that_was_started_to_ignore_ctrl_c_does_so():
    code = BEGIN + "signal.raise_signal(signal.SIGINT)\nprint('goes on')"
    done = run(code, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN))
    assert (done.returncode, done.stdout) == (0, "goes on\n"), done.stderr


def test_ctrl_c_while_a_command_is_loaded_ends_it_with_the_usual_status_and_a_word():
    code = """
import builtins, os, signal
load = builtins.__import__
def interrupted(name, *more):
    if name == "hitab_cli.main":
        os.kill(os.getpid(), signal.SIGINT)
    return load(name, *more)
builtins.__import__ = interrupted
from hitab_cli.program import main
main()
"""
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "interrupted\n")


def test_ctrl_c_in_a_function_that_is_called_from_c_is_not_lost():
    done = run(
        BEGIN
        + """
import pymunk
space = pymunk.Space()
for _ in range(2):
    body = pymunk.Body(1.0, 1.0)
    space.add(body, pymunk.Circle(body, 1.0))
space.on_collision(pre_solve=lambda *_: signal.raise_signal(signal.SIGINT))
try:
    space.step(0.1)
    print("stepped", flush=True)
    while True:
        pass
except KeyboardInterrupt:
    print("interrupted")
"""
    )
    assert (done.returncode, done.stdout) == (0, "stepped\ninterrupted\n"), done.stderr


def test_ctrl_c_that_was_handled_ends_with_the_status_also_while_a_class_is_defined(tmp_path):
    """Without `forget_handled` Python 3.11 ends by the signal, with return code -2."""
    (tmp_path / "command.py").write_text(
        "import sys\n"
        "from hitab_client.terminal.interruptions import forget_handled\n"
        "try:\n"
        "    exec('raise KeyboardInterrupt')\n"
        "except KeyboardInterrupt:\n"
        "    forget_handled()\n"
        "    sys.exit(130)\n"
    )
    run = [sys.executable, "-m", "command"]
    assert subprocess.run(run, cwd=tmp_path, check=False).returncode == 130
