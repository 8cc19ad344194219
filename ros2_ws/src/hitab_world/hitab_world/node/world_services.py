"""The services of a world: pause, step, reset, play, place, snapshot."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hitab_msgs import srv

from hitab_core import Fix, HitabError, has, quantity, unknown
from hitab_ros import GuardedNode, names
from hitab_ros.answering import Serve, answering
from hitab_world.node.settings import WorldSettings
from hitab_world.node.world_topics import WorldTopics
from hitab_world.simulating.run_state import RunState
from hitab_world.simulating.world_memory import WorldMemory
from hitab_world.world import Placement

_CONTROL = srv.Control.Request
ACTIONS = (
    _CONTROL.PAUSE,
    _CONTROL.RESUME,
    _CONTROL.STEP,
    _CONTROL.RESET,
    _CONTROL.PACE,
    _CONTROL.TEACHING,
    _CONTROL.BACK,
)

SNAPSHOTS_MAX = 100
"""Maximum number of saved snapshots, each of which is a whole world in memory."""


class WorldServices:
    """Offers a world's services; a refusal is a reply with ``success`` false and the reason."""

    def __init__(
        self,
        node: GuardedNode,
        run_state: RunState,
        memory: WorldMemory,
        topics: WorldTopics,
        look: Callable[[], Any],
    ) -> None:
        """Offer the services.

        Args:
            node: the node to offer them on.
            run_state: the world's run state, which the services change.
            memory: the memory with the snapshots.
            topics: the world's topics, which publish changes at once.
            look: updates which agents have joined the world.
        """
        self._run_state = run_state
        self._memory = memory
        self._topics = topics
        self._look = look
        offered: list[tuple[Any, str, Serve]] = [
            (srv.Control, names.CONTROL, self._control),
            (srv.Play, names.PLAY, self._play),
            (srv.Place, names.PLACE, self._place),
            (srv.Snapshot, names.SNAPSHOT, self._snapshot),
        ]
        for kind, name, serve in offered:
            node.create_service(kind, name, answering(self._saving(serve)))

    def _saving(self, serve: Serve) -> Serve:
        """Return a service function that saves the world's state after each request."""

        def served(request: Any, response: Any) -> str:
            done = serve(request, response)
            self._run_state.changes += 1
            response.change = self._run_state.changes
            self._memory.save_now()
            return done

        return served

    def _control(self, request: srv.Control.Request, response: srv.Control.Response) -> str:
        run_state, control, actions = self._run_state, self._run_state.control, srv.Control.Request
        if request.action in (actions.RESUME, actions.STEP):
            self._need_release()
        match request.action:
            case actions.PAUSE:
                control.pause()
                run_state.disturbed = True
                done = "paused"
            case actions.RESUME:
                control.resume()
                done = "running"
            case actions.STEP:
                self._step(request.cycles)
                done = f"stepping {quantity(request.cycles, 'cycle')}"
            case actions.RESET:
                run_state.begin_episode()
                done = f"episode {run_state.world.episode}"
            case actions.PACE:
                pace = request.pace or control.pace
                checked = WorldSettings(pace=pace, factor=request.factor or control.factor)
                if request.pace:
                    run_state.disturbed = True  # the agents must know whether the world waits
                control.pace, control.factor = checked.pace, checked.factor
                done = f"pace {control.pace}, factor {control.factor:g}"
            case actions.TEACHING:
                if run_state.last_minute is None:
                    raise HitabError(
                        "a world that runs by itself, as on another server, cannot be slowed down"
                    )
                control.teaching = WorldSettings(teaching=request.factor).teaching
                done = f"pace while an agent is taught: {control.teaching:g} of the usual"
            case actions.BACK:
                run_state.go_back(request.to)
                done = f"back at cycle {request.to}, paused"
            case action:
                raise HitabError(unknown("action", action, ACTIONS))
        run_state.touched = True
        response.cycle = run_state.world.cycle + control.steps_left
        if request.action != actions.STEP:
            self._topics.publish_status()
        return done

    def _step(self, cycles: int) -> None:
        if not cycles:
            raise HitabError("step needs a number of cycles greater than 0")
        self._look()
        if not self._run_state.round_answers.present:
            agents = ", ".join(self._run_state.world.agents)
            raise HitabError(f"no agent has joined the world; start any of {agents}")
        self._run_state.control.step(cycles)

    def _need_release(self) -> None:
        if held := self._run_state.control.held:
            raise HitabError(held, Fix.GO())

    def _play(self, request: srv.Play.Request, response: srv.Play.Response) -> str:
        run_state = self._run_state
        self._need_release()
        self._look()
        if missing := run_state.round_answers.missing:
            raise HitabError(f"no node answers for {', '.join(missing)}", Fix.STATUS())
        run_state.control.episodes_left = request.episodes
        run_state.begin_run(request.seed)
        response.run = run_state.control.run
        run_state.control.resume()
        self._topics.report_error("")
        self._topics.publish_status()
        count = quantity(request.episodes, "episode") if request.episodes else "endlessly"
        return f"playing {count}, seed {request.seed}"

    def _place(self, request: srv.Place.Request, response: srv.Place.Response) -> str:
        run_state = self._run_state
        run_state.world.place(
            [Placement(e.name, e.x, e.y, e.heading, e.vx, e.vy) for e in request.entities],
            new_episode=request.new_episode,
        )
        run_state.change()
        if request.new_episode:
            run_state.mark_restart()
        return f"placed {len(request.entities)}"

    def _snapshot(self, request: srv.Snapshot.Request, response: srv.Snapshot.Response) -> str:
        memory, actions = self._memory, srv.Snapshot.Request
        kept = memory.named
        name = request.name
        if request.action != actions.LIST and not name:
            raise HitabError("a snapshot needs a name, such as corner")
        if request.action in (actions.RESTORE, actions.DELETE) and name not in kept:
            raise HitabError(f'no snapshot "{name}" {has(kept, name)}')
        match request.action:
            case actions.SAVE:
                if name not in kept and len(kept) >= SNAPSHOTS_MAX:
                    raise HitabError(f"there are {len(kept)} snapshots", Fix.DELETE_SNAPSHOT())
                memory.save(name, self._run_state.world.snapshot())
                done = f'saved "{name}"'
            case actions.RESTORE:
                self._run_state.world.restore(kept[name])
                self._run_state.change()
                done = f'restored "{name}"'
            case actions.DELETE:
                memory.delete(name)
                done = f'deleted "{name}"'
            case actions.LIST:
                done = quantity(len(kept), "snapshot")
            case action:
                known = (actions.SAVE, actions.RESTORE, actions.DELETE, actions.LIST)
                raise HitabError(unknown("action", action, known))
        response.names = sorted(kept)
        return done
