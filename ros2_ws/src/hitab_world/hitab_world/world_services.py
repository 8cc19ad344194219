"""The services of a world: pause, step, reset, play, place, snapshot."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from hitab_msgs import srv

from hitab_core.errors import HitabError, has
from hitab_ros import names
from hitab_ros.answering import Serve, answering
from hitab_world.settings import check_factor, check_pace
from hitab_world.world import Placement

if TYPE_CHECKING:
    from hitab_world.world_node import WorldNode


SNAPSHOTS_MAX = 100
"""Each is a whole world in memory."""


class WorldServices:
    """Offers a world's services; a refusal is a reply with ``success`` false and the reason."""

    def __init__(self, node: WorldNode) -> None:
        self._node = node
        offered: list[tuple[Any, str, Serve]] = [
            (srv.Control, names.CONTROL, self._control),
            (srv.Play, names.PLAY, self._play),
            (srv.Place, names.PLACE, self._place),
            (srv.Snapshot, names.SNAPSHOT, self._snapshot),
        ]
        for kind, name, serve in offered:
            node.create_service(kind, name, answering(serve))

    def _control(self, request: srv.Control.Request, response: srv.Control.Response) -> str:
        node, actions = self._node, srv.Control.Request
        told = self._do(request)
        node.keeper.touch()
        response.cycle = node.world.cycle + node.steps_left
        if request.action != actions.STEP:
            node.publish_status()
        return told

    def _do(self, request: srv.Control.Request) -> str:
        node, actions = self._node, srv.Control.Request
        match request.action:
            case actions.PAUSE:
                node.paused = True
                node.steps_left = 0
                node.disturbed = True
                return "paused"
            case actions.RESUME:
                node.paused = False
                node.steps_left = 0
                return "running"
            case actions.STEP:
                if not request.cycles:
                    raise HitabError("step needs a number of cycles greater than 0")
                self._need_agents()
                node.paused = True
                node.steps_left = request.cycles
                return f"stepping {request.cycles} cycles"
            case actions.RESET:
                node.begin_episode()
                return f"episode {node.world.episode}"
            case actions.PACE:
                check_factor(request.factor or node.factor)
                if request.pace:
                    check_pace(request.pace)
                    node.pace = request.pace
                    node.disturbed = True  # the agents have to know whether the world waits
                if request.factor:
                    node.factor = request.factor
                return f"pace {node.pace}, factor {node.factor:g}"
            case unknown:
                known = (actions.PAUSE, actions.RESUME, actions.STEP, actions.RESET, actions.PACE)
                raise HitabError(f'unknown action "{unknown}" {has(known)}')

    def _need_agents(self) -> None:
        node = self._node
        node.look_who_is_there()
        if len(node.attendance.missing) == len(node.world.agents):
            raise HitabError(
                f"no agent has joined the world; start {', '.join(node.world.agents)}"
            )

    def _play(self, request: srv.Play.Request, response: srv.Play.Response) -> str:
        node = self._node
        node.look_who_is_there()
        if node.attendance.missing:
            raise HitabError(
                f"no node answers for {', '.join(node.attendance.missing)}; start them first"
            )
        node.episodes_left = request.episodes
        node.begin_run(request.seed)
        node.paused = False
        node.steps_left = 0
        node.report_error("")
        node.publish_status()
        return f"playing {request.episodes or 'endless'} episodes, seed {request.seed}"

    def _place(self, request: srv.Place.Request, response: srv.Place.Response) -> str:
        node = self._node
        node.world.place(
            [Placement(e.name, e.x, e.y, e.heading, e.vx, e.vy) for e in request.entities],
            new_episode=request.new_episode,
        )
        node.disturbed = True
        node.keeper.touch()
        if request.new_episode:
            node.mark_restart()
        return f"placed {len(request.entities)}"

    def _snapshot(self, request: srv.Snapshot.Request, response: srv.Snapshot.Response) -> str:
        keeper, actions = self._node.keeper, srv.Snapshot.Request
        kept = keeper.named
        name = request.name
        if request.action != actions.LIST and not name:
            raise HitabError("a snapshot needs a name")
        if request.action in (actions.RESTORE, actions.DELETE) and name not in kept:
            raise HitabError(f'no snapshot "{name}" {has(kept)}')
        match request.action:
            case actions.SAVE:
                if name not in kept and len(kept) >= SNAPSHOTS_MAX:
                    raise HitabError(f"there are {len(kept)} snapshots; delete one of them first")
                keeper.save(name, self._node.world.snapshot())
                told = f'saved "{name}"'
            case actions.RESTORE:
                self._node.world.restore(kept[name])
                self._node.disturbed = True
                keeper.touch()
                told = f'restored "{name}"'
            case actions.DELETE:
                keeper.delete(name)
                told = f'deleted "{name}"'
            case actions.LIST:
                told = f"{len(kept)} snapshots"
            case unknown:
                known = (actions.SAVE, actions.RESTORE, actions.DELETE, actions.LIST)
                raise HitabError(f'unknown action "{unknown}" {has(known)}')
        response.names = sorted(kept)
        return told
