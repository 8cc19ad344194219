"""Launches a swarm from its description, with an installed ROS 2 Jazzy.

    ros2 launch hitab_bringup swarm.launch.py swarm:=keepaway
    ros2 launch hitab_bringup swarm.launch.py swarm:=my_swarm.yaml namespace:=left pace:=lockstep

Starts the same processes as `hitab up`, in this terminal and in this ROS domain. With launch_ros,
what an including launch file says about namespaces, remappings and parameters holds for them too.
"""

import os
from pathlib import Path
from typing import Any

from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction, Shutdown
from launch.events.process import ProcessExited
from launch.substitutions import LaunchConfiguration

from hitab_bringup.libraries.run_libraries import prepare
from hitab_bringup.processes.swarm_processes import processes
from hitab_bringup.swarm_files.swarm_description import PACES, Process
from hitab_bringup.swarm_files.swarm_options import described_swarm
from hitab_client.connecting.dds_profile import choose_profile, profile_for
from hitab_client.runs.run_folder import RunFolder
from hitab_core import HitabError
from hitab_ros.nodes.exit_codes import DO_NOT_RESTART
from launch import LaunchContext, LaunchDescription

try:
    from launch_ros.actions import Node
    from launch_ros.parameter_descriptions import ParameterValue
except ImportError:
    Node = None

SWITCH = ["true", "false"]
ARGUMENTS = (
    ("swarm", "keepaway", "A swarm description, or the name of a shipped one", None),
    ("run_dir", "", "Folder for libraries and journals; empty for that of `hitab up`", None),
    ("namespace", "", "Of all nodes; empty for that of the description", None),
    (
        "use_sim_time",
        "false",
        "Whether all nodes but the world take their time from it",
        SWITCH,
    ),
    ("pace", "", "lockstep or realtime; empty for that of the description", ["", *PACES]),
    ("paused", "false", "Whether the world is paused at first", SWITCH),
    ("library", "", "Library for all agents; empty for folders of their own", None),
    ("machine", "", "This machine, of a swarm on several", None),
    ("agents", "0", "How many, for a world in one file; 0 for the number in the file", None),
)


def start(context: LaunchContext) -> list[ExecuteProcess]:
    """Return the processes of the requested swarm."""

    def given(name: str) -> str:
        return str(LaunchConfiguration(name).perform(context))

    if not (agents := given("agents")).isdecimal():
        raise HitabError(f"agents:={agents}: give a whole number, such as agents:=3")
    run_dir = Path(given("run_dir")) if given("run_dir") else None
    swarm = described_swarm(
        given("swarm"),
        run_dir,
        namespace=given("namespace"),
        use_sim_time=given("use_sim_time") == "true",
        pace=given("pace"),
        paused=given("paused") == "true",
        library=given("library"),
        machine=given("machine"),
        agents=int(agents),
    )
    folder = RunFolder.of_swarm(swarm.name, run_dir)
    folder.prepare()
    prepare(swarm, folder.path)
    profile = dict(os.environ)
    started = processes(swarm, folder.path, swarm.identity(launched=True))
    choose_profile(profile, profile_for(folder.path, len(started)))
    common: dict[str, Any] = {
        "env": profile,
        "output": "screen",
        "on_exit": shut_down_if_final,
        "respawn": True,
        "respawn_delay": 1.0,
    }
    return [action(process, common) for process in started]


def action(process: Process, common: dict[str, Any]) -> ExecuteProcess:
    """Return the action that runs a process: a node's, if launch_ros is there."""
    if Node is None or not process.is_node:
        return ExecuteProcess(cmd=process.command, name=process.name, **common)
    program, *arguments = process.program
    return Node(
        executable=program,
        arguments=arguments,
        # Relative, to be inside the namespace of an including launch file.
        namespace=process.namespace.lstrip("/"),
        remappings=list(process.remap.items()),
        parameters=[
            {name: ParameterValue(value, value_type=type_of(value))}
            for name, value in process.parameters.items()
        ],
        ros_arguments=["--disable-external-lib-logs", "--enclave", process.enclave],
        **common,
    )


def type_of(value: Any) -> Any:
    """Return the type of a parameter: a text stays one that reads like a number."""
    return list[type(value[0])] if isinstance(value, tuple) else type(value)


def shut_down_if_final(event: ProcessExited, context: LaunchContext) -> Shutdown | None:
    """Shut everything down if restarting a process would not help."""
    if event.returncode != DO_NOT_RESTART:
        return None
    return Shutdown(reason=f"{event.process_name} cannot start; see its error above")


def generate_launch_description() -> LaunchDescription:
    """Return the launch description."""
    declared = [
        DeclareLaunchArgument(
            name, default_value=default, description=description, choices=choices
        )
        for name, default, description, choices in ARGUMENTS
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=start)])
