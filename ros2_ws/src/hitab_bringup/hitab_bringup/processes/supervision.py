"""Supervision of a swarm's processes by supervisord: start, restart and stop.

The supervisor listens only on a socket file. Every process has the run folder in its environment,
so that `stop` finds them all, even if the supervisor itself was killed.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Mapping

import psutil  # type: ignore[import-untyped]

from hitab_bringup.libraries.run_libraries import prepare
from hitab_bringup.processes.supervisor_config import (
    SOCKET_VARIABLE,
    program,
    set_parameter,
    supervisor_config,
    write_commands,
)
from hitab_bringup.processes.swarm_processes import all_processes, process_names, processes
from hitab_bringup.swarm_files.described_files import keep_description
from hitab_bringup.swarm_files.swarm_description import SwarmDescription
from hitab_client import RunFolder, RunRecord, SwarmError
from hitab_client.connecting.dds_profile import RANGE, choose_profile, profile_for
from hitab_client.runs.run_folder import MARK
from hitab_client.runs.run_processes import ENDED_STATES, answers, process_states, start_process
from hitab_client.runs.swarm_choice import way_to_stop
from hitab_ros.nodes.exit_codes import DO_NOT_RESTART
from hitab_ros.timing import ANSWER_S, DISCOVERY_S, PROMPT_S


def environment(folder: RunFolder, domain_id: int, processes: int = 1) -> dict[str, str]:
    """Return the environment of a swarm's processes."""
    variables = {
        **os.environ,
        MARK: str(folder.path),
        "ROS_DOMAIN_ID": str(domain_id),
        "PYTHONUNBUFFERED": "1",
        # One core per process: numpy's threads would only compete with the other processes.
        "OMP_NUM_THREADS": os.environ.get("OMP_NUM_THREADS", "1"),
        "OPENBLAS_NUM_THREADS": os.environ.get("OPENBLAS_NUM_THREADS", "1"),
    }
    choose_profile(variables, profile_for(folder.path, processes))
    return variables


def refuse_running(folder: RunFolder) -> None:
    """Check that no swarm is up in a run folder.

    Raises:
        SwarmError: if a swarm is up.
    """
    before = folder.read()
    if before is not None and folder.supervisor(before) is not None:
        raise SwarmError(f'swarm "{before.swarm}" is already up', way_to_stop(folder, before))


def launch(
    swarm: SwarmDescription, folder: RunFolder, domain_id: int, *, temporary: bool = False
) -> RunRecord:
    """Start a swarm's processes; they are not ready yet when this returns.

    Leftovers of an earlier swarm in the same folder are stopped first.

    Args:
        swarm: the description.
        folder: run folder.
        domain_id: ROS domain of the swarm.
        temporary: whether to end the swarm with this process, and hide it from other verbs.

    Raises:
        SwarmError: if the supervisor does not start.
    """
    folder.prepare()
    stop(folder)
    prepare(swarm, folder.path)
    description = keep_description(swarm, folder.path) if swarm.machine else swarm.file
    socket = folder.socket_path()
    identity = swarm.identity()
    started = processes(swarm, folder.path, identity)
    everywhere = all_processes(swarm, folder.path, identity)
    for process in started:
        folder.log(process.name).unlink(missing_ok=True)
    write_commands([*everywhere, *started], folder.path)
    folder.configuration.write_text(supervisor_config(started), encoding="utf-8")
    variables = environment(folder, domain_id, len(started))
    variables[SOCKET_VARIABLE] = str(socket)
    supervisor = _spawn(variables, folder, temporary)
    record = RunRecord(
        swarm.name,
        str(description.resolve()),
        domain_id,
        variables[RANGE],
        swarm.agent_names,
        swarm.world is not None,
        supervisor.pid,
        str(socket),
        identity,
        tuple(commander.name for commander in swarm.commanders),
        {process.name: process.agents for process in everywhere},
        swarm.namespace,
        swarm.machine,
        process_names(swarm, everywhere) if swarm.machine else {},
    )
    folder.write(record, register=not temporary)
    _await_answer(supervisor, record, folder)
    return record


def add_process(folder: RunFolder, record: RunRecord, process: str, lease: int) -> None:
    """Start a process of a running swarm that its supervisor does not run, under a lease.

    Raises:
        SwarmError: if the supervisor does not start it.
    """
    set_parameter(process, folder.path, "lease", lease)
    if process not in {state["name"] for state in process_states(record, DISCOVERY_S)}:
        with folder.configuration.open("a", encoding="utf-8") as file:
            file.write(program(process))
    start_process(record, process)


def _spawn(
    environment: Mapping[str, str], folder: RunFolder, temporary: bool
) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "supervisor.supervisord", "-c", str(folder.configuration)]
    with (folder.path / "supervisord.out").open("wb") as out:
        return subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=subprocess.STDOUT,
            env=environment,
            cwd=folder.path,
            start_new_session=True,  # the terminal's Ctrl-C is for the command only
            preexec_fn=_end_with_parent if temporary and sys.platform == "linux" else None,
        )


def _end_with_parent() -> None:
    set_parent_death_signal = 1
    ctypes.CDLL(None).prctl(set_parent_death_signal, signal.SIGTERM)


def _await_answer(
    supervisor: subprocess.Popen[bytes], record: RunRecord, folder: RunFolder
) -> None:
    """Wait until the supervisor answers, which it does once it has started all processes.

    Raises:
        SwarmError: if the supervisor does not answer; its processes are stopped.
    """
    deadline = time.monotonic() + ANSWER_S + PROMPT_S * len(record.processes_here)
    while not answers(record):
        if supervisor.poll() is not None or time.monotonic() > deadline:
            out = (folder.path / "supervisord.out").read_text(errors="replace").strip()
            stop(folder)
            raise SwarmError(
                f"supervisord did not start: {out.splitlines()[-1] if out else 'no output'} "
                f"(see {folder.path}/supervisord.log)"
            )
        time.sleep(0.01)


FAILED = (*ENDED_STATES, "BACKOFF")


def refuse_failed(record: RunRecord, folder: RunFolder) -> None:
    """Check that no process of a starting swarm has ended.

    Raises:
        SwarmError: if a process has ended; has the last lines of its log.
    """
    for state in process_states(record):
        if state["statename"] in FAILED:
            raise SwarmError(_failure(state["name"], state["exitstatus"], folder))


def _failure(process: str, exit_code: int, folder: RunFolder) -> str:
    lines = folder.tail(process)
    if exit_code == DO_NOT_RESTART and lines:
        return f"{process}: {lines[-1].removeprefix('error: ')} (log: {folder.log(process)})"
    excerpt = "\n".join(f"  | {line}" for line in lines) if lines else "  | (empty)"
    # Only the supervisor's log has the kind, as in "exit status 127" or "terminated by SIGSEGV".
    text = (folder.path / "supervisord.log").read_text(encoding="utf-8", errors="replace")
    how = [f" ({how})" for how in re.findall(rf" exited: {process} \(([^;]*);", text)]
    end = f"the end of {folder.log(process)}{''.join(how[-1:])}"
    return f"{process} ended while starting; {end}:\n{excerpt}"


def stop(folder: RunFolder) -> list[int]:
    """Stop every process of a run folder, and check that no process is left.

    Returns:
        The ids of the processes that did not stop and were killed.

    Raises:
        SwarmError: if a process cannot be stopped.
    """
    record = folder.read()
    supervisor = folder.supervisor(record) if record is not None else None
    if record is not None and supervisor is not None:
        with contextlib.suppress(psutil.Error):
            supervisor.terminate()
            deadline = time.monotonic() + ANSWER_S
            while supervisor.is_running() and time.monotonic() < deadline:
                answers(record)  # makes it handle signals now, not after a second
                with contextlib.suppress(psutil.TimeoutExpired):
                    supervisor.wait(0.02)
    killed = _end(folder)
    folder.forget()
    return killed


def _end(folder: RunFolder) -> list[int]:
    """End all remaining processes, the supervisor first: terminate, then kill."""
    killed: list[int] = []
    for end, timeout in ((psutil.Process.terminate, 3.0), (psutil.Process.kill, 20.0)):
        left = folder.processes()
        if not left:
            return killed
        left.sort(key=lambda process: process.pid)
        for process in left:
            with contextlib.suppress(psutil.Error):
                end(process)
                if end is psutil.Process.kill:
                    killed.append(process.pid)
        psutil.wait_procs(left, timeout=timeout)
    if left := folder.processes():
        numbers = ", ".join(str(process.pid) for process in left)
        raise SwarmError(
            f"processes {numbers} of {folder.path} could not be killed; end them by hand"
        )
    return killed
