"""The state of a foraging field and its change in a cycle: arrays over robots and boxes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.random import PCG64, Generator
from numpy.typing import NDArray

from foraging_world import action
from foraging_world.bodies import Bodies
from foraging_world.laying_out import box_place, obstacle_places, start_places
from foraging_world.parameters import ForagingParameters
from foraging_world.percept import NOT_SEEN_M
from hitab_world.parameters import ParameterError

Floats = NDArray[np.float64]

NO_BOX = -1
AWAY = 1e6  # m: place of the boxes that have come home and do not return


class Field:
    """Robots and boxes on a field; row i is robot i, or box i.

    Attributes:
        xy, velocity: positions and velocities of the robots, m and m/s; shape (foragers, 2).
        heading: headings of the robots, rad.
        held: index of the box that each robot holds, or `NO_BOX`.
        grip: place at which each robot holds its box, relative to the box's center, m.
        waited: time for which the box that each robot holds has not moved, s.
        rested: time since each robot let go of a box by itself, s.
        box_xy, box_velocity: positions and velocities of the boxes, m and m/s; shape (boxes, 2).
        present: whether each box is on the field.
        box_radius, large: sizes of the boxes; fixed. Small boxes come first.
        scouts: which robots are scouts; fixed.
        sight, reach: ranges of each robot, m; fixed. A scout's reach is -1: no box is in it.
        hands: how many robots hold each box.
        obstacles: centers of the obstacles, m; fixed in an episode.
        collected: numbers of small and of large boxes brought home in the episode.
        holding: number of robots that held a box, summed over the cycles of the episode.
    """

    def __init__(self, parameters: ForagingParameters) -> None:
        self.parameters = p = parameters
        boxes = p.small_boxes + p.large_boxes
        self.large = np.arange(boxes) >= p.small_boxes
        self.box_radius = np.where(self.large, p.large_radius, p.small_radius)
        self.needed = np.where(self.large, p.large_pullers, p.small_pullers)
        self.scouts = np.arange(p.foragers) % p.squad_size < p.scouts
        self.sight = np.where(self.scouts, p.scout_sight, p.sight)
        self.reach = np.where(self.scouts, -1.0, p.reach)
        self.random = Generator(PCG64(0))
        self.begin(0)

    def begin(self, seed: int) -> None:
        """Lay everything out for a new episode.

        Raises:
            ParameterError: if there is not enough room.
        """
        p, boxes = self.parameters, len(self.large)
        self.random = random = Generator(PCG64(seed))
        self.xy = start_places(p)
        self.velocity = np.zeros((p.foragers, 2))
        self.heading = random.uniform(-np.pi, np.pi, p.foragers)
        self.held = np.full(p.foragers, NO_BOX)
        self.grip = np.zeros((p.foragers, 2))
        self.waited = np.zeros(p.foragers)
        self.rested = np.full(p.foragers, NOT_SEEN_M)
        self.obstacles = obstacle_places(p, random)
        self.box_xy = np.full((boxes, 2), AWAY)
        self.box_velocity = np.zeros((boxes, 2))
        self.present = np.zeros(boxes, bool)
        self.hands = np.zeros(boxes, np.int64)
        self.collected = np.zeros(2, np.int64)
        self.holding = np.zeros(1, np.int64)
        for box in reversed(range(boxes)):  # the large ones need most room
            if not self._lay(box):
                raise ParameterError(
                    f"there is no room for {p.small_boxes} small and {p.large_boxes} large boxes "
                    f"on {p.width:g} m by {p.height:g} m; use a larger field or fewer boxes"
                )
        self.make_bodies()

    def make_bodies(self) -> None:
        """Create the bodies of the present field."""
        self._bodies = Bodies(self.parameters, self.box_radius, self.obstacles)

    def _lay(self, box: int) -> bool:
        """Put a box somewhere; return whether there was room."""
        p = self.parameters
        others = np.flatnonzero(self.present)
        taken = np.concatenate([self.box_xy[others], self.obstacles, self.xy])
        radii = np.concatenate(
            [
                self.box_radius[others] + p.ring_width,
                np.full(len(self.obstacles), p.obstacle_radius),
                np.full(p.foragers, p.forager_radius),
            ]
        )
        place = box_place(p, self.random, float(self.box_radius[box]), taken, radii)
        if place is not None:
            self.box_xy[box] = place
            self.present[box] = True
        return place is not None

    # -- a cycle ----------------------------------------------------------------------------

    def step(self, commands: action.Commands, seconds: float) -> None:
        """Carry out the robots' commands for some time, s."""
        p = self.parameters
        slips = 1.0 + p.noise * self.random.standard_normal((p.foragers, 2))
        drive = np.clip(commands[:, action.DRIVE], -1.0, 1.0)
        most = p.turn_rate * seconds
        turns = np.clip(commands[:, action.TURN], -most, most) * slips[:, 0]
        self.heading = _wrapped(self.heading + turns)
        self._change_grips(commands[:, action.GRIP])
        self.holding += self.hands.sum()
        ahead = np.stack([np.cos(self.heading), np.sin(self.heading)], axis=1)
        self._move(ahead, drive, slips[:, 1], seconds)
        self._come_home()

    def _change_grips(self, wanted: Floats) -> None:
        letting_go = (wanted == action.RELEASE) & (self.held != NO_BOX)
        self.held[letting_go] = NO_BOX
        self.rested[letting_go] = 0.0
        self.waited[letting_go] = 0.0
        gripping = np.flatnonzero((wanted >= 1.0) & (self.held == NO_BOX))
        if len(gripping):
            p, box = self.parameters, wanted[gripping].astype(np.int64) - 1
            there = (box < len(self.large)) & (wanted[gripping] == box + 1)
            gripping, box = gripping[there], box[there]
            to = self.box_xy[box] - self.xy[gripping]
            gap = np.hypot(to[:, 0], to[:, 1]) - self.box_radius[box] - p.forager_radius
            reached = self.present[box] & (gap <= self.reach[gripping])
            gripping, box = gripping[reached], box[reached]
            self.held[gripping] = box
            self.grip[gripping] = -to[reached]
            self.waited[gripping] = 0.0
        self._count_hands()

    def let_go(self, foragers: NDArray[np.bool_]) -> None:
        """Make the robots of a mask let go of their boxes; this does not count as giving up."""
        foragers = foragers & (self.held != NO_BOX)
        self.held[foragers] = NO_BOX
        self.waited[foragers] = 0.0
        self.rested[foragers] = NOT_SEEN_M
        self._count_hands()

    def _count_hands(self) -> None:
        held = self.held[self.held != NO_BOX]
        self.hands = np.bincount(held, minlength=len(self.large))

    def _pulled(self, ahead: Floats, drive: Floats) -> Floats:
        """Return the velocity of each box: the mean of its pullers', if there are enough of them.

        Pulls in different directions cancel out, so that a box does not move if its pullers
        disagree, however many they are.
        """
        p, boxes = self.parameters, len(self.large)
        pulling = (self.held != NO_BOX) & (drive > 0.0)
        held, force = self.held[pulling], ahead[pulling] * drive[pulling, None]
        pullers = np.bincount(held, minlength=boxes)
        total = [np.bincount(held, force[:, i], minlength=boxes) for i in (0, 1)]
        pulled = p.pull_speed * np.stack(total, axis=1) / np.maximum(pullers, 1)[:, None]
        pulled[pullers < self.needed] = 0.0
        return pulled

    def _move(self, ahead: Floats, drive: Floats, slips: Floats, seconds: float) -> None:
        p, before, boxes_before = self.parameters, self.xy, self.box_xy
        pulled = self._pulled(ahead, drive)
        holds = self.held != NO_BOX
        walking = ahead * (p.speed * drive * slips)[:, None]
        velocity = np.where(holds[:, None], pulled[self.held], walking) if len(pulled) else walking
        found = self._bodies.step(
            np.concatenate([self.xy, self.box_xy]), np.concatenate([velocity, pulled]), seconds
        )
        moves = np.any(pulled != 0.0, axis=1)
        # A box that is not pulled stays in place, whatever bumps into it.
        self.box_xy = np.where(moves[:, None], found[p.foragers :], boxes_before)
        self.xy = found[: p.foragers]
        if len(pulled):
            self._hold_on(holds)
            went = np.hypot(*(self.box_xy - boxes_before).T) > 0.1 * p.pull_speed * seconds
            waits = holds & ~went[self.held]
            self.waited = np.where(waits, self.waited + seconds, 0.0)
        self.rested = np.minimum(self.rested + seconds, NOT_SEEN_M)
        self.velocity = (self.xy - before) / seconds
        self.box_velocity = (self.box_xy - boxes_before) / seconds

    def _hold_on(self, holds: NDArray[np.bool_]) -> None:
        """Keep robots at the boxes that they hold; when pushed, they slide along the edge.

        So later robots find a place, instead of standing behind the first ones.
        """
        boxes, grip = self.box_xy[self.held[holds]], self.grip[holds]
        pushed = self.xy[holds] - boxes
        length = np.hypot(grip[:, 0], grip[:, 1]) / np.hypot(pushed[:, 0], pushed[:, 1])
        self.grip[holds] = pushed * length[:, None]
        self.xy[holds] = boxes + self.grip[holds]

    def _come_home(self) -> None:
        p = self.parameters
        distance = np.hypot(self.box_xy[:, 0], self.box_xy[:, 1])
        home = np.flatnonzero(self.present & (distance <= p.home_radius))
        for box in home.tolist():
            self.collected[int(self.large[box])] += 1
            self.let_go(self.held == box)
            self.present[box] = False
            self.box_xy[box] = AWAY * (1.0 + box)
            self.box_velocity[box] = 0.0
        if p.renew:
            # If there was no room for one, there may be later.
            for box in np.flatnonzero(~self.present).tolist():
                self._lay(box)

    # -- snapshots --------------------------------------------------------------------------

    ARRAYS = (
        *("xy", "velocity", "heading", "held", "grip", "waited", "rested"),
        *("box_xy", "box_velocity", "present", "obstacles", "collected", "holding"),
    )

    def state(self) -> dict[str, Any]:
        """Return everything as JSON-able data."""
        arrays = {name: getattr(self, name).tolist() for name in self.ARRAYS}
        return {**arrays, "random": self.random.bit_generator.state}

    def restore(self, state: dict[str, Any]) -> None:
        """Restore what `state` returned.

        Raises:
            KeyError, TypeError, ValueError: if the state is invalid; then nothing has changed.
        """
        arrays = {}
        for name in self.ARRAYS:
            now = getattr(self, name)
            # Earlier snapshots do not have the sum.
            given = np.array(state.get(name, [0]) if name == "holding" else state[name])
            if given.size and not np.can_cast(given.dtype, now.dtype, "same_kind"):
                raise TypeError(f"{name} has type {given.dtype} instead of {now.dtype}")
            arrays[name] = given.astype(now.dtype).reshape(now.shape)
            if not np.all(np.isfinite(arrays[name])):
                raise ValueError(f"{name} is not finite")
        random = PCG64(0)
        random.state = state["random"]
        if np.any(arrays["held"] >= len(self.large)) or np.any(arrays["held"] < NO_BOX):
            raise ValueError("a robot holds a box that does not exist")
        for name, array in arrays.items():
            setattr(self, name, array)
        self.random = Generator(random)
        self._count_hands()
        self.make_bodies()


def _wrapped(angle: Floats) -> Floats:
    return angle - 2.0 * np.pi * np.round(angle / (2.0 * np.pi))
