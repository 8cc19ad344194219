"""The paper's four automata, trained by a domain, a trainer and a body, and nothing else."""

import math
import random
from collections.abc import Sequence

from hitab_core import Automaton, Repertoire, Term
from hitab_core.running import FeatureCache, RunContext, performance
from hitab_core.training import Curriculum, Trainer
from keepaway_world.domain import DOMAIN

FAR = 9.0


def percept(
    ball: float = FAR, direction: float = 0.0, taker: float = FAR, mate: float = 2 * FAR
) -> list[float]:
    """Return what keeper 1 of two sees: distances, m, and the direction of the ball, rad."""
    itself = [1.0, 2.0, 1.0, 20.0, 20.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    return [*itself, ball, direction, 0.0, 0.0, mate, math.pi, taker, math.pi]


class Keeper:
    """A body that is trained, or performs what it has learned."""

    def __init__(self) -> None:
        self.body = DOMAIN.body("keeper_1")
        self.known: dict[str, Automaton] = {}

    def context(self) -> RunContext:
        repertoire = Repertoire(DOMAIN, self.known)
        self.cache = FeatureCache(self.body, DOMAIN)
        return RunContext(repertoire, self.body, self.cache, random.Random(1).random)

    def see(self, values: list[float], heard: Sequence[str] = ()) -> None:
        self.body.sense(values, heard)
        self.cache.forget()

    def trainer(self, name: str, features: str) -> Trainer:
        return Trainer(self.context(), Curriculum(name, tuple(map(Term.parse, features.split()))))

    def save(self, trainer: Trainer) -> None:
        trainer.test(restart=True)
        automaton, _ = trainer.trimmed(keep_unused=False)
        self.known[automaton.name] = automaton

    def performs(self, name: str, *percepts: list[float]) -> list[str]:
        """Return the states that an automaton is in after each percept."""
        running, states = performance(self.context(), Term(name)), []
        running.start()
        for values in percepts:
            self.see(values)
            running.tick()
            states.append(running.active_path[0])
        return states

    def teach(self, trainer: Trainer, *lesson: tuple[str, list[float]]) -> None:
        for behavior, values in lesson:
            self.see(values)
            trainer.command(Term(behavior))
            trainer.tick()


HELD, PRESSED, LOST = percept(0.5), percept(0.5, taker=1.5), percept(5.0, taker=1.5)
BEHIND = percept(9.0, math.pi, mate=1.0)


def taught() -> Keeper:
    """Return a keeper that was taught the four automata, in the paper's order."""
    keeper = Keeper()
    approach = keeper.trainer("ApproachBall", "DistanceTo(ball)")
    paces = {12.0: "GoFast", 5.0: "GoMedium", 2.4: "GoSlow", 1.0: "Stop"}
    rolls_away = {1.3: "GoSlow", 3.0: "GoMedium", 6.0: "GoFast"}
    for distance, pace in (*paces.items(), *rolls_away.items()):
        keeper.teach(approach, (pace, percept(distance)))
    assert len(approach.examples) == 14, "each with its default example"
    keeper.save(approach)

    goto = keeper.trainer("GotoBall", "DirectionTo(ball)")
    for direction in (1.5, 0.05, 0.2, -0.05, -0.2):
        behavior = "ApproachBall" if abs(direction) < 0.1 else "TurnToBall"
        keeper.teach(goto, (behavior, percept(direction=direction)))
    keeper.save(goto)

    control = keeper.trainer("ControlBall", "DistanceTo(closest_taker) BallIsKickable")
    keeper.teach(control, ("GotoBall", percept(3.0)), ("Stop", HELD))
    keeper.teach(control, ("Pass", percept(0.5, taker=2.5)), ("Done", percept(3.0, taker=2.5)))
    control.restart()
    keeper.teach(control, ("Stop", HELD), ("GotoBall", percept(3.0)))
    assert len(control.examples) == 10, "Pass is one-shot, and a flag is raised once"
    keeper.save(control)

    keepaway = keeper.trainer("Keepaway", "ATeammateIsCloserToBall IWasYelledAt Done")
    keeper.teach(keepaway, ("ControlBall", percept(3.0)))
    keepaway.restart()
    keeper.teach(keepaway, ("GetOpen", BEHIND))
    keepaway.test(restart=True)
    for values in (percept(3.0), HELD, PRESSED, LOST):
        keeper.see(values)
        keepaway.tick()
    assert keepaway.running.active_path == ["ControlBall", "Done"], "it passes, and stays there"
    keepaway.take_over()
    keepaway.command(Term("GetOpen"))
    keeper.see(BEHIND, ["pass 1"])
    keepaway.command(Term("ControlBall"))
    assert [e.kind.value for e in keepaway.examples if not e.is_default][-2:] == ["correction"] * 2
    keeper.save(keepaway)
    return keeper


def test_the_four_automata_play_as_they_were_taught() -> None:
    keeper = taught()
    paces = keeper.performs("ApproachBall", *map(percept, (12.0, 5.0, 4.0, 2.0, 0.9)))
    assert paces == ["GoFast", "GoMedium", "GoMedium", "GoSlow", "Stop"]
    turned = keeper.performs("GotoBall", *(percept(direction=d) for d in (-2.0, 0.0, -2.0)))
    assert turned == ["TurnToBall", "ApproachBall", "TurnToBall"]
    game = percept(3.0), HELD, PRESSED, LOST
    assert keeper.performs("ControlBall", *game) == ["GotoBall", "Stop", "Pass", "Done"]
    assert keeper.performs("Keepaway", *game, LOST) == [*["ControlBall"] * 4, "GetOpen"]
    assert keeper.performs("Keepaway", BEHIND, BEHIND) == ["GetOpen", "GetOpen"]


def test_an_automaton_uses_those_that_were_trained_before_it() -> None:
    keeper = taught()
    assert keeper.known["Keepaway"].behaviors_used == {"ControlBall", "GetOpen"}
    assert keeper.known["ControlBall"].behaviors_used == {"GotoBall", "Stop", "Pass"}
    running = performance(keeper.context(), Term("Keepaway"))
    running.start()
    for _ in range(2):  # it turns to the ball first
        keeper.see(percept(12.0))
        running.tick()
    assert running.active_path == ["ControlBall", "GotoBall", "ApproachBall", "GoFast"]
    assert keeper.body.act()[0], "a command for the soccer server"
