"""Choice among the swarms that are up."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hitab_client.connecting.identity import is_by_hand, is_identity
from hitab_client.errors import SwarmError
from hitab_client.runs.run_folder import (
    Found,
    RunFolder,
    RunRecord,
    registered_swarms,
    running_swarms,
    state_home,
)
from hitab_core import Fix, Remedy, has
from hitab_ros.timing import FOUND_S, PROMPT_S, SETTLE_S

if TYPE_CHECKING:
    from hitab_client.connecting.ros_link import RosLink

WAY_TO_CHOOSE = "choose one with --swarm NAME"


def only(
    found: Sequence[Found], what: str = "swarms are up", way: Fix | None = None
) -> Found | None:
    """Return the only swarm of several; None if there is none.

    Args:
        found: the swarms.
        what: text that describes the swarms.
        way: what can be done with one of them, to propose it for each.

    Raises:
        SwarmError: if there are several; names each with a distinguishing property.
    """
    if len(found) > 1:
        names = [record.swarm for _, record in found]
        if len(set(names)) < len(names):
            names = [record.identity or str(folder.path) for folder, record in found]
        lines = [
            f"  {name}: ROS domain {record.domain_id}, {folder.path}"
            for name, (folder, record) in zip(names, found, strict=True)
        ]
        ways = [way(swarm=name) for name in names] if way is not None else []
        raise SwarmError("\n".join((f"several {what}; {WAY_TO_CHOOSE}:", *lines)), *ways)
    return found[0] if found else None


def meant(which: str, among: Iterable[Found]) -> list[Found]:
    """Return the swarms that match a name, an identity or a namespace, or else a run folder."""
    among = list(among)
    path = Path(which).resolve()
    named = [(f, r) for f, r in among if which in (r.swarm, r.identity, r.namespace)]
    return named or [found for found in among if found[0].path == path]


def folder_called(which: str) -> RunFolder:
    """Return the run folder at a path, or the default one of a swarm with a name."""
    return RunFolder(Path(which) if os.sep in which else state_home() / which)


def find_running(which: str | None) -> Found | None:
    """Return the named swarm, or the only one that is up; None if none is up.

    Args:
        which: name, identity, namespace or run folder; None for the only swarm.

    Raises:
        SwarmError: if several are up and none is named, or the named swarm is not up.
    """
    up = list(running_swarms())
    if which is None:
        return only(up)
    if os.sep in which:
        folder = RunFolder(Path(which))
        record = folder.read()  # temporary ones too
        if record is not None and folder.supervisor(record) is not None:
            return folder, record
    found = only(meant(which, up), _called(which))
    if found is None:
        names = [name_to_choose(record) for _, record in up]
        if names:
            raise SwarmError(f'no swarm "{which}" is up {has(names, which)}')
        raise SwarmError(f'no swarm "{which}" is up, and no other', Fix.UP(swarm=which))
    return found


def _called(which: str) -> str:
    return f'swarms called "{which}" are up'


def is_namespace(which: str) -> bool:
    """Whether a text is a namespace, such as ``/red``, or ``/`` for none; not a run folder."""
    return which == "/" or (
        re.fullmatch(r"(/[A-Za-z_]\w*)+", which) is not None and not Path(which).exists()
    )


def find_meant(which: str | None, domain_id: int | None) -> Found | None:
    """Return the swarm to connect to; see `find_running`.

    Also return None for an identity or a namespace that the registry does not know: its swarm may
    have been started elsewhere.

    Args:
        which: name, identity, namespace or run folder; None for the only swarm.
        domain_id: ROS domain of the swarm, if no swarm is named; None for any.

    Raises:
        SwarmError: if several are up and none is named, or the named swarm is not up.
    """
    elsewhere = which is not None and (is_identity(which) or is_namespace(which))
    if elsewhere and not meant(str(which), running_swarms()):
        return None
    if which is not None or domain_id is None:
        return find_running(which)
    in_domain = [found for found in running_swarms() if found[1].domain_id == domain_id]
    return only(in_domain, f"swarms are up in ROS domain {domain_id}")


def whose(identities: Iterable[str]) -> Iterator[str]:
    """Yield a sentence for each swarm that the registry does not know.

    Args:
        identities: identities in the statuses of nodes that have answered.
    """
    # Leftovers of a registered swarm were reported before the search for others began.
    own = {record.identity for _, record in registered_swarms()}
    for identity in sorted(set(identities) - own):
        if not is_by_hand(identity):
            yield (
                f"{identity} was not started from here (another HITAB_HOME, user or computer); "
                f"commands that change it need --swarm {identity}"
            )


def name_to_choose(record: RunRecord) -> str:
    """Return the argument of ``--swarm`` for a swarm: its name, or else its identity.

    The identity is needed while another swarm of the same name is registered.
    """
    others = [other for _, other in registered_swarms() if other.swarm == record.swarm]
    return record.swarm if len(others) < 2 else record.identity


def way_to_stop(folder: RunFolder, record: RunRecord) -> Remedy:
    """Return the remedy that stops a registered swarm, or ends its leftovers."""
    if folder.path == RunFolder.of_swarm(record.swarm).path:
        return Fix.DOWN(swarm=name_to_choose(record))
    return Fix.DOWN_FOLDER(folder=folder.path)


def none_is_up(domain_id: int | None) -> tuple[str, list[Remedy]]:
    """Return the problem and its remedies when `find_meant` found no swarm."""
    remedies: list[Remedy] = []
    where = f"under {state_home()}" if domain_id is None else f"in ROS domain {domain_id}"
    known = [f"No swarm runs {where}."]
    for folder, record in registered_swarms():
        if folder.supervisor(record) is None:
            known.append(f'"{record.swarm}" has ended without being stopped: {folder.path}.')
            remedies.append(way_to_stop(folder, record))
        else:
            known.append(
                f'"{record.swarm}" runs in ROS domain {record.domain_id}; '
                f"choose it with --swarm {name_to_choose(record)}, or unset ROS_DOMAIN_ID."
            )
    known.append("Looking for one that was started elsewhere ...")
    return " ".join(known), remedies


def reported_on(link: RosLink) -> Iterator[str]:
    """Yield the topics on which agents and worlds report their status."""
    from hitab_ros import names

    for kind in names.STATUS_TYPES:
        for topic in link.topics_of_type(kind):
            if link.node.count_publishers(topic):
                yield topic


def look_elsewhere(link: RosLink, namespace: str = "", identity: str = "") -> str:
    """Return the namespace of a swarm that was started by hand, or on another computer.

    Args:
        link: the node to use.
        namespace: the swarm's namespace, see `is_namespace`; empty for any.
        identity: the swarm's identity; empty for any swarm.

    Raises:
        SwarmError: if there are no such nodes, or nodes in several namespaces.
    """
    from hitab_client.showing.agent_presence import AgentPresence

    where = f"ROS domain {link.node.context.get_domain_id()}"

    def spaces() -> set[str]:
        found = {topic.rsplit("/", 2)[0] for topic in reported_on(link)}
        return found & {namespace.rstrip("/")} if namespace else found

    def is_occupied() -> bool:
        return len(link.node.get_node_names()) > 1

    if not (link.spin_until(is_occupied, PROMPT_S) and link.spin_until(spaces, FOUND_S)):
        which = f"namespace {namespace} of {where}" if namespace else where
        raise SwarmError(f"no swarm answers in {which}", Fix.UP(swarm="keepaway"))
    prefixes: set[str] = set()
    while prefixes != (prefixes := spaces() or prefixes):
        link.spin_until(lambda: False, SETTLE_S)
    agents = [AgentPresence(link, prefix=space, identity=identity) for space in sorted(prefixes)]
    if len(agents) > 1:
        for some_agents in agents:
            some_agents.discover()
        link.spin_until(lambda: all(a.statuses or a.strangers for a in agents), SETTLE_S)
        agents = [a for a in agents if a.statuses] or agents
    if len(agents) > 1:
        namespaces = ", ".join(a.prefix or "/" for a in agents)
        raise SwarmError(
            f"swarms answer in several namespaces of {where}; {WAY_TO_CHOOSE}: {namespaces}"
        )
    return agents[0].prefix


def to_take_down(which: str | None) -> tuple[RunFolder, RunRecord | None] | None:
    """Return the swarm to take down: a running one, else the leftovers of a crashed one.

    Raises:
        SwarmError: if the choice is ambiguous, or the named swarm is missing.
    """
    up = list(running_swarms())
    left = [found for found in registered_swarms() if found[0].supervisor(found[1]) is None]
    ended = "have ended without being stopped"
    if which is None:
        return only(up, way=Fix.DOWN) or only(left, f"swarms {ended}", Fix.DOWN)
    found = only(meant(which, up), _called(which), Fix.DOWN) or only(
        meant(which, left), f'swarms called "{which}" {ended}', Fix.DOWN
    )
    if found is not None:
        return found
    folder = folder_called(which)
    record = folder.read()
    if record is not None or folder.processes():
        return folder, record
    return find_running(which)
