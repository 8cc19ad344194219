"""Policy for SROS2: what each node of a swarm may publish, subscribe to, offer and ask.

All names follow from the swarm file. ``ros2 security`` makes keys and permissions from a policy.
An enclave has the rights of all of its nodes; each process has one, see `Process.enclave`.

What no swarm file tells is left out: robots' topics, further ``processes:``, and the links and
actions of a domain.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from xml.etree import ElementTree

from hitab_bringup.processes.swarm_processes import is_host, is_in_world, shared_members
from hitab_bringup.swarm_files.swarm_description import (
    CLOCK_TOPIC,
    SIM_TIME,
    AgentDescription,
    CommanderDescription,
    SwarmDescription,
)
from hitab_core import operations
from hitab_ros import names
from hitab_ros.names import WORLD

VERSION = "0.2.0"
"""Version of SROS2's format."""

Rights = Mapping[str, Sequence[str]]
NOTHING: Mapping[str, str] = MappingProxyType({})

VERBS = {"publish": "topic", "subscribe": "topic", "reply": "service", "request": "service"}
TYPES = "~/get_type_description"
PARAMETERS = (
    *("~/describe_parameters", "~/get_parameter_types", "~/get_parameters", TYPES),
    *("~/list_parameters", "~/set_parameters", "~/set_parameters_atomically"),
)
EVENTS = "/parameter_events"
DIAGNOSTICS = "/diagnostics"
INSPECTION = (names.GET_REPORT, names.GET_VOCABULARY, names.GET_BEHAVIOR, names.READ_FEATURES)
OF_MACHINE = (names.READ_FILES, names.READ_LOG, names.RUN_PROCESS, names.TAKE_DOWN)
OF_WORLD = (names.CONTROL, names.PLAY, names.PLACE, names.SNAPSHOT)
STOPS = (names.EMERGENCY_STOP, names.EMERGENCY_STATE)
CONSOLES = {"hitab": (), "hitab_studio": ("/studio/markers",)}
"""Nodes of people's programs, with the topics that only they publish."""


@dataclass(frozen=True)
class NodeRights:
    """Rights of one node.

    Attributes:
        enclave: enclave of its process.
        namespace, name: those of the node.
        allowed: full names, by the keys of `VERBS`.
    """

    enclave: str
    namespace: str
    name: str
    allowed: Mapping[str, Collection[str]]


def security_policy(swarm: SwarmDescription) -> str:
    """Return the policy of a swarm, and of the programs that people use with it, as XML."""
    policy = ElementTree.Element("policy", version=VERSION)
    enclaves = ElementTree.SubElement(policy, "enclaves")
    profiles: dict[str, ElementTree.Element] = {}
    for node in node_rights(swarm):
        if node.enclave not in profiles:
            enclave = ElementTree.SubElement(enclaves, "enclave", path=node.enclave)
            profiles[node.enclave] = ElementTree.SubElement(enclave, "profiles")
        at = {"ns": node.namespace, "node": node.name}
        profile = ElementTree.SubElement(profiles[node.enclave], "profile", at)
        for verb, element in VERBS.items():
            if node.allowed[verb]:
                rule = ElementTree.SubElement(profile, f"{element}s", {verb: "ALLOW"})
                for name in sorted(node.allowed[verb]):
                    ElementTree.SubElement(rule, element).text = name
    ElementTree.indent(policy)
    return ElementTree.tostring(policy, encoding="unicode", xml_declaration=True) + "\n"


def node_rights(swarm: SwarmDescription) -> list[NodeRights]:
    """Return the rights of each node; a host may run on each machine."""
    found = [*_Nodes(swarm).all()]
    published = {name for node in found for name in node.allowed["publish"]}
    offered = {name for node in found for name in node.allowed["reply"]}
    own = tuple(name[1:] for name in PARAMETERS)
    exchanged = map(swarm.full_name, (names.HOSTS, names.STATUSES, names.MACHINES))
    heard = published.union(STOPS, exchanged) - {EVENTS, names.ROSOUT}
    for console, topics in CONSOLES.items():
        rights = {
            "publish": {*topics, EVENTS, swarm.full_name(names.OPERATORS), names.EMERGENCY_STATE},
            "subscribe": heard,
            "reply": set[str](),
            "request": {name for name in offered if not name.endswith(own)},
        }
        found.append(NodeRights(f"/{console}", "/", console, rights))
    return found


class _Nodes:
    """Nodes of a swarm with their rights."""

    def __init__(self, swarm: SwarmDescription) -> None:
        self._swarm = swarm
        self._machines = [machine.name for machine in swarm.machines]
        self._alone: list[AgentDescription] = []
        self._hosts: dict[str, list[str]] = {}  # names on each machine, by process
        for process, members in shared_members(swarm).items():
            if is_host(swarm, members):
                first = members[0].name
                named = [names.of_host(first, it) for it in self._machines or [""]]
                self._hosts[process] = named
            else:
                self._alone += members

    def all(self) -> Iterator[NodeRights]:
        """Yield the nodes of all processes."""
        for member in self._alone:
            yield self._member_alone(member)
        for process in self._hosts:
            yield from self._host(process)
        if self._swarm.world is not None:
            yield self._world(self._swarm.world.remap)
        for machine in self._machines:
            yield self._machine(machine)

    def _node(
        self,
        process: str,
        space: str,
        node: str,
        rights: Rights,
        remap: Mapping[str, str] = NOTHING,
    ) -> NodeRights:
        """Return a node with rights to names that are relative to its namespace."""
        space = self._swarm.full_name(space)

        def full(name: str) -> str:
            return name if name[0] == "/" else f"{space}/{name}".replace("~", node)

        to = {full(old): full(new) for old, new in self._swarm.remap(remap).items()}
        allowed = {
            verb: {to.get(name, name) for name in map(full, rights.get(verb, ()))}
            for verb in VERBS
        }
        return NodeRights(self._swarm.enclave(process), space or "/", node, allowed)

    def _in_swarm(self, *given: str) -> list[str]:
        return [self._swarm.full_name(name) for name in given]

    def _member(self, member: AgentDescription) -> Rights:
        """Return the rights of a member's node in any process."""
        publish = [names.STATUS, names.TRAINING, names.TRANSITIONS]
        is_commander = isinstance(member, CommanderDescription)
        publish += [names.ORDER, names.GROUP] if is_commander else [names.PERCEIVED]
        return {
            "publish": publish,
            "subscribe": [names.COMMAND, names.STATUS, *[names.REPORTS] * is_commander],
            "reply": [*operations.OPERATIONS, *INSPECTION],
        }

    def _process(self, members: Collection[AgentDescription], *, host: bool) -> Rights:
        """Return the rights of the node that speaks for a process with some members."""
        alone = {member.name for member in self._alone}
        above = {member.superior for member in members} - {""}
        above = above & alone if host else above  # hosts have topics of their own for the others
        spoken = (names.ALIVE, names.DISTRIBUTION, names.DISTRIBUTION_ACK)
        heard = (names.ALIVE, names.DISTRIBUTION, names.HOSTS, names.OPERATORS)
        reports, orders = ([f"{it}/{n}" for it in above] for n in (names.REPORTS, names.ORDER))
        simulated = any(member.parameters.get(SIM_TIME) for member in members)
        return {
            "publish": [EVENTS, DIAGNOSTICS, *self._in_swarm(*spoken, *reports)],
            "subscribe": [*[CLOCK_TOPIC] * simulated, *self._in_swarm(*heard, *orders)],
        }

    def _member_alone(self, member: AgentDescription) -> NodeRights:
        own = {"publish": [names.ROSOUT], "reply": PARAMETERS}
        in_world: Rights = {}
        if is_in_world(member):
            actions = self._in_swarm(f"{WORLD}/{names.ACTIONS}")
            in_world = {"publish": actions, "subscribe": [names.PERCEPT]}
        node = "commander" if isinstance(member, CommanderDescription) else "agent"
        rights = self._process([member], host=False), self._member(member), own, in_world
        return self._node(member.process, member.name, node, _all(*rights), member.remap)

    def _host(self, process: str) -> Iterator[NodeRights]:
        members = shared_members(self._swarm)[process]
        yield self._node(process, "", "host", {"publish": [EVENTS], "reply": [TYPES]})
        pieces = bool(self._machines)
        others = [
            host for other, named in self._hosts.items() if other != process for host in named
        ]
        for host in self._hosts[process]:
            own = {
                "publish": self._in_swarm(
                    *(names.HOSTS, names.STATUSES, f"{WORLD}/{names.ACTION_BATCHES}"),
                    *[f"{WORLD}/{names.ACTION_PIECES}"] * pieces,
                    *(f"{it}/{name}" for it in others for name in (names.ORDERS, names.REPORTS)),
                ),
                "subscribe": [
                    *(*self._in_swarm(names.COMMANDS), names.ORDERS, names.REPORTS),
                    *(names.PERCEPTS, *[names.PERCEPT_PIECES] * pieces),
                ],
                "reply": [TYPES, operations.LoadLibrary.name],
            }
            rights = _all(self._process(members, host=True), own)
            yield self._node(process, host, "host", rights)
        for member in members:
            node, rights = "agent", self._member(member)
            if isinstance(member, CommanderDescription):
                node, rights = "commander", _all(rights, {"publish": [names.REPORTS]})
            yield self._node(process, member.name, node, rights, member.remap)

    def _world(self, remap: Mapping[str, str]) -> NodeRights:
        hosts = [host for named in self._hosts.values() for host in named]
        pieces = bool(self._machines)
        to_hosts = [names.PERCEPTS, *[names.PERCEPT_PIECES] * pieces]
        percepts = [f"{it.name}/{names.PERCEPT}" for it in self._alone if is_in_world(it)]
        percepts += [f"{host}/{name}" for host in hosts for name in to_hosts]
        own = (names.STATUS, names.STATE, names.EPISODES, names.STOP_STATE)
        common = (EVENTS, names.ROSOUT, DIAGNOSTICS, CLOCK_TOPIC, names.EMERGENCY_STATE)
        actions = [names.ACTIONS, names.ACTION_BATCHES, *[names.ACTION_PIECES] * pieces]
        rights = {
            "publish": [*own, *common, *self._in_swarm(names.ALIVE, *percepts)],
            "subscribe": [names.STATUS, *STOPS, *actions, *self._in_swarm(names.HOSTS)],
            "reply": [*OF_WORLD, *PARAMETERS],
        }
        return self._node(WORLD, WORLD, WORLD, rights, remap)

    def _machine(self, machine: str) -> NodeRights:
        topics = self._in_swarm(names.MACHINES, names.HOSTS, names.ALIVE)
        others = [f"{it}/{names.READ_FILES}" for it in self._machines if it != machine]
        rights = {
            "publish": [EVENTS, *topics],
            "subscribe": topics,
            "reply": [*OF_MACHINE, TYPES],
            "request": self._in_swarm(*others),
        }
        return self._node(machine, machine, "machine", rights)


def _all(*given: Rights) -> Rights:
    """Return all of these rights."""
    return {verb: [name for one in given for name in one.get(verb, ())] for verb in VERBS}
