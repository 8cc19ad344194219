"""One trial: a simulated person and a keeper play one situation.

The person is in control and commands what is due (`Trial.guide`), or lets the keeper do what it
has learned, and watches (`Trial.watch`). What is decided reaches the keys after the reaction time,
or later, or not at all; now and then it is the wrong key (`Trial.press`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from random import Random
from types import MappingProxyType

from habits import Diary, Habits, looked_at
from intentions import DONE, DOUBT, OFF, YELLED, Plan, Seen
from practice import Scene
from pupils import WHETHER, Pupil, Sight
from ways import AS_THEY_ARE, GOING_BACK, Timing

from hitab_core import FLAGS, START, HitabError

SLOWEST = 0.25
"""Nobody has the patience to let the world run slower, as a part of its usual pace."""

Kind = tuple[str, str, tuple[tuple[str, bool], ...]]

MOMENTARY = (DONE, YELLED)
"""What is there for one cycle only, and is remembered by who sees it."""


@dataclass(frozen=True)
class _Press:
    """A command that is on its way from eye to finger.

    Attributes:
        state: that is meant.
        at: the cycle in which the finger arrives.
        seen: what the person saw then.
        left: the state that the keeper was seen in then.
        due: the cycle in which it was due.
        frozen: whether the world is frozen when the finger arrives.
    """

    state: str
    at: int
    seen: Seen
    left: str = START
    due: int = 0
    frozen: bool = False


@dataclass
class Memory:
    """What a person remembers of the training of one plan.

    Attributes:
        shown: the decisions that the keeper has been shown.
        lost: those whose commands were deleted and not given again.
        early: where the keeper left a state too early, by state.
        again: a situation in which the keeper began with the wrong state.
        pace: of the world, as a part of its usual one.
        meant: of commands to a world that ran, by the number of the example: how long before the
            command it was due, s of simulated time, and the state that was meant to be left.
    """

    shown: set[Kind] = field(default_factory=set)
    lost: set[Kind] = field(default_factory=set)
    early: dict[str, Seen] = field(default_factory=dict)
    again: Scene | None = None
    pace: float = 1.0
    meant: dict[int, tuple[float, str]] = field(default_factory=dict)


def begins(pupil: Pupil) -> bool:
    """Return whether the keeper has been shown what to begin with."""
    return any(example.state == START for example in pupil.examples())


class Trial:
    """A situation being played.

    Args:
        pupil: plays it.
        plan: what is intended.
        habits: of the person.
        random: of the person.
        diary: of the person.
        memory: of the training of this plan.
        allowance: the most examples that all trainings may hold.
        contradicts: whether the person corrects a wrong change of state by commanding what should
            have been done instead, since the command can be meant for that decision.
        slows: whether the person lets the world run slower once an episode was over before a
            command was given.
        trusts: whether the person takes for recorded what was meant, without looking.
        estimated: whether the agent estimates how late the commands come.
        settle: has the person answer what the keeper asks at once after a command.
        below: the plans that were trained before, by name.
        timing: of the person; None: as the habits are.

    Attributes:
        troubled: those of them that did what was not intended.
    """

    def __init__(
        self,
        pupil: Pupil,
        plan: Plan,
        habits: Habits,
        random: Random,
        diary: Diary,
        memory: Memory,
        allowance: int,
        *,
        contradicts: bool = False,
        slows: bool = False,
        trusts: bool = False,
        estimated: bool = False,
        settle: Callable[[Trial], None] = lambda trial: None,
        below: Mapping[str, Plan] = MappingProxyType({}),
        timing: Timing | None = None,
    ) -> None:
        self.pupil, self.plan, self.habits = pupil, plan, habits
        self.random, self.diary, self.memory = random, diary, memory
        self.allowance, self.contradicts = allowance, contradicts
        self.slows, self.settle = slows, settle
        self.timing = timing or Timing(AS_THEY_ARE, habits, 0)
        self.trusts, self.estimated = trusts, estimated
        self.below, self.troubled = below, set[str]()
        self.wrong_since: dict[str, int] = {}
        self.given: list[int] = []
        self.now = self.blind = self.objections = 0
        self.pending: _Press | None = None
        self.expected: tuple[int, str, Kind, int] | None = None
        self.missed: tuple[str, str] | None = None
        self.slip: tuple[int, str] | None = None
        self.late: int | None = None
        self.hand_back: int | None = None
        self.take_at: int | None = None
        self.guided = self.guiding = self.finished = False
        self.fresh()

    @property
    def pace(self) -> float:
        """The world's pace, as a part of its usual one: a test runs at full pace."""
        return self.memory.pace * (self.timing.ways.pace if self.guiding else 1.0)

    @property
    def exhausted(self) -> bool:
        """Whether no more can be recorded."""
        return self.pupil.held + 2 > self.allowance

    def play(
        self, scene: Scene, *, guided: bool, first: bool = False, seconds: float | None = None
    ) -> bool:
        """Play one situation; return whether the keeper did nothing that was not intended.

        Args:
            scene: to play.
            guided: begin in control.
            first: show what to begin with, even if that state has been begun with before.
            seconds: to play; None: as long as the scene says.
        """
        self.diary.counts["trials"] += 1
        seen = self.last = self.before = self.pupil.place(scene.start)
        self.scene = scene
        self.guided = guided
        twist = scene.twist
        twist_in = -1
        begin = self.wish(START, seen.values)
        shown = self.kind(START, begin, seen.values) in self.memory.shown
        self.guiding = first or not begins(self.pupil) or (guided and not shown)
        if self.guiding:
            self.pupil.take_over()
            self.press(_Press(begin, 0, seen.values), paused=True)
        else:
            self.pupil.test(restart=True)
        over = False
        for _ in range(round((seconds or scene.seconds) / self.pupil.cycle_seconds)):
            before, seen = seen, self.pupil.step()
            self.now += 1
            self.diary.seconds += self.pupil.cycle_seconds
            self.diary.own_seconds += self.pupil.cycle_seconds / self.pace
            if seen.ended:
                if self.pending is not None and self.slows:
                    self.memory.pace = max(SLOWEST, self.memory.pace / 2.0)
                    self.diary.counts["slower"] += 1
                break
            self.attend(before, seen)
            over = scene.over(seen.state, seen.values) and not twist
            if scene.broken(seen.state, seen.values) and self.pending is None:
                break
            if self.finished or (over and self.pending is None):
                break
            if twist and twist_in < 0 and scene.turn(seen.state, seen.values):
                twist_in = self.now + 4
            if twist and self.now == twist_in:
                seen = self.pupil.place(twist, new_episode=False)
                twist = ()
                self.arranged(seen)
        self.repair(force=True)
        if seen.ended and self.now * self.pupil.cycle_seconds < scene.lasts:
            return False
        return self.objections == 0 and (over or self.finished or not scene.ends)

    def arranged(self, seen: Sight) -> None:
        """Command at leisure after arranging the field, if guiding."""
        self.pending = None
        if self.guiding and seen.state not in (START, *FLAGS):
            self.fresh()
            wished = self.wish(seen.state, seen.values)
            if wished != seen.state and not self.exhausted:
                press = _Press(wished, self.now, seen.values, seen.state)
                self.press(press, paused=True)

    # -- deciding ---------------------------------------------------------------------------

    def fresh(self) -> None:
        """Begin a decision: its edges waver anew."""
        w = self.habits.waver
        self.edges = {
            name: edge * self.random.uniform(1.0 - w, 1.0 + w)
            for name, edge in self.plan.edges.items()
        }
        self.errors = self.habits.errors(self.random)

    def wish(self, state: str, seen: Seen, factor: float = 1.0) -> str:
        """Return the state that the person would be in next."""
        edges = {name: edge * factor for name, edge in self.edges.items()}
        return self.plan.rule(state, looked_at(seen, self.errors), edges)

    def kind(self, state: str, wished: str, seen: Seen) -> Kind:
        """Return what makes a decision another one in a person's eyes: on which side, whether."""
        sides = tuple((f, seen[f] > 0.0) for f in self.plan.features if f == OFF or f in WHETHER)
        return state, wished, sides

    def fits(self, state: str, seen: Seen) -> set[str]:
        """Return the next states to which the person would not object."""
        return {self.wish(state, seen, factor) for factor in DOUBT}

    def attend(self, before: Sight, seen: Sight) -> None:
        """Watch one cycle and act on it."""
        if self.timing.ways.foresees:
            seconds = self.pupil.cycle_seconds / self.pace
            seen = replace(seen, values=self.timing.foreseen(before.values, seen.values, seconds))
        self.before, self.last = self.last, seen
        self.look_below(seen)
        self.repair()
        if self.pending is not None:
            if self.now >= self.pending.at:
                press, self.pending = self.pending, None
                self.press(press)
            return
        corrects = self.contradicts and not self.guiding
        if self.now < self.blind or (seen.state in FLAGS and not corrects):
            return
        if self.guiding:
            self.guide(seen)
        else:
            self.watch(before, seen)

    def look_below(self, seen: Sight) -> None:
        """Notice what was trained before and does what was not intended."""
        patience = self.cycles(self.habits.patience)
        for name, plan in self.below.items():
            state = seen.below.get(name, START)
            if state in plan.states and state not in plan.fitting(state, seen.values):
                if self.now - self.wrong_since.setdefault(name, self.now) >= patience:
                    self.troubled.add(name)
            else:
                self.wrong_since.pop(name, None)

    def guide(self, seen: Sight) -> None:
        """Command what is due."""
        state = seen.state
        wished = self.wish(state, seen.values)
        if wished == state:
            self.missed = None
            self.confirm(seen)
            if self.hand_back is not None and self.now >= self.hand_back and not self.guided:
                self.let_go()
        elif (
            self.kind(state, wished, seen.values) in self.memory.shown
            and state not in self.memory.early
        ):
            self.let_go()  # it has been shown this; see whether it can do it
        elif self.missed != (state, wished):
            self.decide(state, wished)

    def let_go(self) -> None:
        """Let the keeper decide, unless it does not know any more what to begin with."""
        self.hand_back = self.expected = None
        if begins(self.pupil):
            self.pupil.test()
            self.guiding = False
        else:
            self.memory.again, self.finished = self.scene, True

    def confirm(self, seen: Sight) -> None:
        """Say once more that a state is right, where the keeper had left it too early."""
        there = self.memory.early.get(seen.state)
        if there is None:
            return
        if all(abs(seen.values[f] - there[f]) <= 0.15 * abs(there[f]) for f in self.plan.features):
            del self.memory.early[seen.state]
            self.decide(seen.state, seen.state)

    def watch(self, before: Sight, seen: Sight) -> None:
        """Look whether the keeper does what was intended."""
        state = seen.state
        if before.state != state:
            self.expected = None
            if before.state in FLAGS:
                return
            if state not in self.fits(before.state, seen.values) | self.fits(
                before.state, before.values
            ):
                self.objections += 1
                if self.contradicts:
                    self.decide(before.state, self.wish(before.state, seen.values), ago=1)
                    return
                if before.state == START:  # only a new beginning can show what to begin with
                    self.memory.again, self.finished = self.scene, True
                    return
                self.memory.early[before.state] = seen.values
                wished = self.wish(state, seen.values)
                if (
                    wished != state
                    and self.kind(state, wished, seen.values) not in self.memory.shown
                ):
                    self.decide(state, wished)
                else:
                    self.finished = True  # there is nothing to be learned from here on
                return
            self.fresh()
            if self.guided:
                self.take_at = self.now + self.cycles(self.habits.reacts(self.random))
        if self.guided and self.take_at is not None and self.now >= self.take_at:
            self.pupil.take_over()
            self.guiding, self.take_at = True, None
            return
        if self.expected is None:
            if state not in self.fits(state, seen.values):
                wait = round(self.habits.patience * self.pace / self.pupil.cycle_seconds)
                wished = self.wish(state, seen.values)
                kind = self.kind(state, wished, seen.values)
                self.expected = (self.now + wait, wished, kind, self.now)
            return
        until, wished, kind, since = self.expected
        if self.now < until:
            return
        self.expected = None
        again = self.wish(state, seen.values)
        self.memory.shown.discard(kind)  # show it again, at the right moment
        momentary = any(f in MOMENTARY for f in self.plan.features)
        if again == state and not (momentary and wished != state):
            return
        self.objections += 1
        self.decide(state, again if again != state else wished, ago=self.now - since)

    def surprises(self) -> bool:
        """Return whether something is so, or not so, that was otherwise a cycle before."""
        before, seen = self.before, self.last
        news = (f for f in self.plan.features if f in WHETHER)
        return before.state != seen.state or any(before.values[f] != seen.values[f] for f in news)

    def decide(self, state: str, wished: str, ago: int = 0) -> None:
        """Decide to command; the finger follows after the reaction time, unless distracted.

        Args:
            state: that is meant to be left.
            wished: what to command.
            ago: how many cycles before it was due.
        """
        if self.exhausted:
            return
        if self.late is None and self.random.random() < self.habits.inattention:
            if self.random.random() < 0.5:
                self.blind = self.now + self.cycles(self.random.uniform(*self.habits.away))
                self.late = self.now
                self.diary.counts["late"] += 1
            else:
                self.missed = (state, wished)
                self.blind = self.now + self.cycles(self.random.uniform(*self.habits.away))
                self.diary.counts["not given"] += 1
            return
        delay, frozen = self.timing.reacts(self.random, surprise=self.surprises())
        at = self.now + self.cycles(delay)
        press = _Press(wished, at, self.last.values, state, self.now - ago, frozen)
        if press.at == self.now:
            self.pending = None
            self.press(press)
        else:
            self.pending = press

    def cycles(self, seconds: float) -> int:
        """Return a time of the person in cycles of the world."""
        return round(seconds * self.pace / self.pupil.cycle_seconds)

    # -- acting -----------------------------------------------------------------------------

    def press(self, press: _Press, *, paused: bool = False) -> None:
        """Command; now and then another behavior than meant."""
        pace = self.pace if self.estimated and not paused and not press.frozen else 0.0
        if not self.guiding:
            self.pupil.take_over()
            self.guiding = True
            self.diary.counts["corrections"] += 1
        state, meant = press.state, press.state
        wrong = self.random.random() < self.habits.wrong
        if wrong:
            state = self.random.choice([s for s in self.plan.states if s != meant])
        late = self.late is not None
        taught = self.pupil.command(state, pace)
        if not taught:
            self.diary.counts["not given"] += 1
            return
        self.given += [e.number for e in taught if not e.is_default]
        self.diary.counts["commands"] += 1
        if not wrong and not paused:
            ago = (self.now - press.due) * self.pupil.cycle_seconds
            self.memory.meant[taught[0].number] = ago, press.left
            self.go_back(taught[0].number, ago)
        left = press.left if self.trusts else taught[0].state
        shown = self.kind(left, state, press.seen)
        if not wrong:
            self.memory.shown.add(shown)
            self.memory.lost.discard(shown)
        self.finished = state in FLAGS
        self.missed = self.late = None
        self.hand_back = self.now + 5
        self.fresh()
        if wrong:
            self.diary.counts["wrong"] += 1
            self.slip = (self.now + self.cycles(self.random.uniform(*self.habits.notices)), meant)
            self.blind = self.slip[0]
        elif late and self.random.random() < self.habits.repairs:
            self.pupil.delete([example.number for example in taught])
            self.memory.shown.discard(shown)
            self.diary.counts["taken back"] += 1
        self.settle(self)

    def go_back(self, number: int, ago: float) -> None:
        """Give a command again for the frame that seems to be the right one.

        The wrongly timed one is deleted, which is what retiming is.
        """
        missed = self.timing.again()
        if missed is None:
            return
        self.diary.counts["went back"] += 1
        self.diary.own_seconds += GOING_BACK
        with suppress(HitabError):
            self.pupil.retime([number], max(0.0, ago + missed))

    def repair(self, *, force: bool = False) -> None:
        """Put a wrong command right once it is noticed."""
        if self.slip is None or (self.now < self.slip[0] and not force):
            return
        _, meant = self.slip
        self.slip = None
        if self.random.random() < self.habits.repairs:
            self.pupil.undo()
            self.diary.counts["taken back"] += 1
        elif not force and not self.exhausted:
            at = self.now + self.cycles(self.habits.reacts(self.random))
            self.pending = _Press(meant, at, self.last.values, self.last.state, self.now)
