"""Launches a swarm from its description, with an installed ROS 2 Jazzy.

    ros2 launch hitab_bringup swarm.launch.py swarm:=keepaway
    ros2 launch hitab_bringup swarm.launch.py swarm:=my_swarm.yaml run_dir:=my_run

Starts the same processes as `hitab up`, in this terminal and in this ROS domain.
"""

import os
from pathlib import Path

from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction, Shutdown
from launch.events.process import ProcessExited
from launch.substitutions import LaunchConfiguration

from hitab_bringup.libraries import prepare
from hitab_bringup.swarm_file import read_swarm
from hitab_bringup.swarm_processes import processes
from hitab_client.dds_profile import choose_profile, profile_for
from hitab_client.identity import new_identity
from hitab_client.run_folder import RunFolder
from hitab_client.shipped import find_file
from hitab_ros.exit_codes import FINAL
from launch import LaunchContext, LaunchDescription


def start(context: LaunchContext) -> list[ExecuteProcess]:
    """Return the processes of the requested swarm."""
    given = LaunchConfiguration("swarm").perform(context)
    run_dir = LaunchConfiguration("run_dir").perform(context)
    swarm = read_swarm(find_file(given, "swarms", "swarm"))
    folder = RunFolder.of_swarm(swarm.name, Path(run_dir) if run_dir else None)
    folder.prepare()
    prepare(swarm, folder.path)
    profile = dict(os.environ)
    started = processes(swarm, folder.path, new_identity(swarm.name))
    choose_profile(profile, profile_for(folder.path, len(started)))
    return [
        ExecuteProcess(
            cmd=process.command,
            name=process.name,
            env=profile,
            output="screen",
            on_exit=shut_down_if_final,
            respawn=True,
            respawn_delay=1.0,
        )
        for process in started
    ]


def shut_down_if_final(event: ProcessExited, context: LaunchContext) -> Shutdown | None:
    """Shut everything down if restarting a process would not help."""
    if event.returncode != FINAL:
        return None
    return Shutdown(reason=f"{event.process_name} cannot start; see its error above")


def generate_launch_description() -> LaunchDescription:
    """Return the launch description."""
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "swarm",
                default_value="keepaway",
                description="A swarm description, or the name of a shipped one",
            ),
            DeclareLaunchArgument(
                "run_dir",
                default_value="",
                description="Folder for libraries and journals; empty: that of `hitab up`",
            ),
            OpaqueFunction(function=start),
        ]
    )
