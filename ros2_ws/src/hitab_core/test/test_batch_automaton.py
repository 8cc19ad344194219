"""Many agents ticked together decide exactly what each would decide alone."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hitab_core.automaton import FLAGS, START, Automaton
from hitab_core.domain import BasicBehavior, BatchPercepts, Domain, Feature, FeatureKind, Target
from hitab_core.errors import FeatureValueError
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.repertoire import Repertoire
from hitab_core.running.agent_batch import AgentBatch
from hitab_core.running.live_features import live_features
from hitab_core.running.observing import Change
from hitab_core.running.running_automaton import RunContext
from hitab_core.running.senses import Senses
from hitab_core.transition_function import HandWritten
from hitab_core.use import Use

NAN = float("nan")
THINGS = ("ball", "goal")
COLUMNS = {"Distance": 0, "Direction": 2, "Role": 4, "Lit": 5}
VALUES = {
    "Distance": (0.0, 1.5, 2.5, 7.0, -3.0, float("inf")),
    "Direction": (0.0, 90.0, -90.0, 179.0, 359.0, -1e-12, 720.5),
    "Role": (0.0, 1.0, 2.0),
    "Lit": (0.0, 1.0),
}


@dataclass
class LoggingBody:
    """A body that writes down everything that is done with it."""

    values: Sequence[float] = ()
    done: list[str] = field(default_factory=list)


def basic(name: str, parameters: tuple[str, ...] = (), *, one_shot: bool = False) -> BasicBehavior:
    """Return a basic behavior that records its calls."""

    def writes(what: str) -> object:
        return lambda body, *targets: body.done.append(f"{what} {name}{targets}")

    told = {what: writes(what) for what in ("start", "pulse", "stop")}
    return BasicBehavior(name, parameters=parameters, one_shot=one_shot, **told)  # type: ignore[arg-type]


def feature(
    name: str, kind: FeatureKind, *, parameters: tuple[str, ...] = (), all_at_once: bool
) -> Feature:
    """Return a feature that reads a column of the percept."""
    column = COLUMNS[name]

    def read(body: LoggingBody, thing: int = 0) -> float:
        return body.values[column + thing]

    def read_all(percepts: BatchPercepts, thing: int = 0) -> np.ndarray:
        return percepts.values[:, column + thing]

    return Feature(
        name,
        read,
        kind,
        parameters,
        period=360.0,
        categories=("a", "b", "c") if kind is FeatureKind.CATEGORICAL else (),
        read_all=read_all if all_at_once else None,
    )


def robot(all_at_once: bool) -> Domain:
    """Return a domain with features of every kind."""
    return Domain.of(
        "logging",
        "1",
        lambda name: LoggingBody(),
        behaviors=[basic("Go", ("X",)), basic("Kick", one_shot=True), basic("Wait")],
        features=[
            feature(
                "Distance", FeatureKind.CONTINUOUS, parameters=("X",), all_at_once=all_at_once
            ),
            feature("Direction", FeatureKind.TOROIDAL, parameters=("X",), all_at_once=True),
            feature("Role", FeatureKind.CATEGORICAL, all_at_once=all_at_once),
            feature("Lit", FeatureKind.BOOLEAN, all_at_once=False),
        ],
        targets=[
            Target(name, lambda body, i=i: i, resolve_all=lambda percepts, i=i: i)
            for i, name in enumerate(THINGS)
        ],
    )


@st.composite
def automata(draw: st.DrawFn, domain: Domain, levels: int) -> Repertoire:
    """Return a repertoire with an automaton ``L1``, ``L2``, ... for each level."""
    repertoire = Repertoire(domain)
    below = ["Go", "Kick", "Wait"]
    for level in range(1, levels + 1):
        parameters = draw(st.sampled_from([(), ("A",)])) if level < levels else ()
        arguments = st.sampled_from([*THINGS, *parameters])
        states: list[Use] = []
        for name in draw(st.lists(st.sampled_from([*below, *FLAGS]), min_size=1, max_size=4)):
            taken = () if name in FLAGS else repertoire.parameters_of(name)
            use = Use(name, tuple(draw(arguments) for _ in taken))
            if use not in states:
                states.append(use)
        if level > 1 and not any(use.name == below[-1] for use in states):
            taken = repertoire.parameters_of(below[-1])
            states.append(Use(below[-1], tuple(draw(arguments) for _ in taken)))
        features: list[Use] = []
        for name in draw(st.lists(st.sampled_from([*COLUMNS, *FLAGS]), max_size=3)):
            taken = () if name in FLAGS else domain.features[name].parameters
            use = Use(name, tuple(draw(arguments) for _ in taken))
            if use not in features:
                features.append(use)
        labels = [str(use) for use in states]
        learned = {}
        for state in [START, *labels]:
            scales = [repertoire.scale_of(use) for use in features]
            rows = draw(
                st.lists(
                    st.tuples(
                        st.tuples(
                            *(
                                st.sampled_from(
                                    [v for v in VALUES.get(use.name, (0.0, 1.0)) if np.isfinite(v)]
                                )
                                for use in features
                            )
                        ),
                        st.sampled_from(labels),
                    ),
                    min_size=int(state == START),
                    max_size=5,
                )
            )
            if rows:
                X = np.array([values for values, _ in rows]).reshape(len(rows), len(features))
                learned[state] = TransitionTree(scales).fit(X, [label for _, label in rows])
        name = f"L{level}"
        repertoire.add(Automaton(name, tuple(states), tuple(features), learned, parameters))
        below.append(name)
    return repertoire


def percept(rng: random.Random, missing: float) -> list[float]:
    """Return random values of all features, some of them missing."""
    kinds = ["Distance"] * 2 + ["Direction"] * 2 + ["Role", "Lit"]
    return [NAN if rng.random() < missing else rng.choice(VALUES[kind]) for kind in kinds]


class Alone:
    """An agent that is ticked by itself."""

    def __init__(self, repertoire: Repertoire, use: Use, seed: int) -> None:
        self.body = LoggingBody()
        self.senses = Senses(self.body, repertoire.domain)
        self.random = random.Random(seed)
        self.context = RunContext(
            repertoire, self.body, self.senses, self.random.random, observe=self._observe
        )
        self.running = self.context.perform(use)
        self.seen: list[str] = []

    def _observe(self, change: Change) -> None:
        why = change.explanation()
        values = [change.values[i] for i in why.features] if why is not None else []
        path = list(change.automata)
        self.seen.append(f"{path}: {change.source} -> {change.destination}, {why}, {values}")

    def tick(self) -> None:
        """Tick, writing down what goes wrong."""
        try:
            self.running.tick()
        except FeatureValueError as error:
            self.body.done.append(str(error))


@settings(max_examples=100)
@given(data=st.data())
def test_a_batch_does_what_its_members_would_do_alone(data: st.DataObject) -> None:
    domain = robot(data.draw(st.booleans(), label="all at once"))
    levels = data.draw(st.integers(1, 4), label="levels")
    repertoire = data.draw(automata(domain, levels), label="repertoire")
    use = Use(f"L{levels}")
    seed = data.draw(st.integers(0, 2**32), label="seed")
    missing = data.draw(st.sampled_from([0.0, 0.05]), label="missing")
    size, rng = 9, random.Random(seed)

    alone = [Alone(repertoire, use, seed + i) for i in range(size)]
    together = [Alone(repertoire, use, seed + i) for i in range(size)]
    percepts = BatchPercepts(np.zeros((size, 6)))
    batch = AgentBatch([one.context for one in together], use, percepts)
    for one, other, member in zip(alone, together, batch.members, strict=True):
        other.running = member
        one.running.start()
        member.start()

    for cycle in range(12):
        percepts.values[:] = [percept(rng, missing) for _ in range(size)]
        if cycle == 6:  # they go on in another batch
            conditions = [member.condition() for member in batch.members]
            batch = AgentBatch([one.context for one in together], use, percepts)
            for other, member, condition in zip(together, batch.members, conditions, strict=True):
                member.go_on_from(condition)
                other.running = member
        batch.forget()
        for row, values in enumerate(percepts.values.tolist()):
            for one in (alone[row], together[row]):
                one.body.values = values
                one.senses.forget()
                if (cycle + row) % 7 == 5:
                    one.running.stop()
                    one.running.start()
        ticking = np.flatnonzero([rng.random() < 0.9 for _ in range(size)])
        batch.decide(np.array([row for row in ticking.tolist() if rng.random() < 0.8], np.int64))
        for row in ticking.tolist():
            alone[row].tick()
            together[row].tick()
        for row in range(size):
            assert together[row].body.done == alone[row].body.done
            assert together[row].seen == alone[row].seen
            assert together[row].random.getstate() == alone[row].random.getstate()
            if not any("feature" in line for line in alone[row].body.done):
                assert batch.members[row].active_path == alone[row].running.active_path
            assert batch.members[row].raised == alone[row].running.raised


def test_a_batch_goes_on_where_its_members_were_alone() -> None:
    domain = robot(True)
    goes = TransitionTree([domain.features["Distance"].scale])
    automaton = Automaton(
        "L1",
        (Use("Wait"), Use("Kick")),
        (Use("Distance", ("ball",)),),
        {START: goes.fit([[0.0], [5.0]], ["Wait", "Kick"])},
    )
    repertoire = Repertoire(domain, {"L1": automaton})
    agents = [Alone(repertoire, Use("L1"), seed) for seed in range(3)]
    for agent, distance in zip(agents, (0.0, 5.0, 5.0), strict=True):
        agent.body.values = [distance] * 6
        agent.running.start()
        agent.running.tick()
    percepts = BatchPercepts(np.zeros((3, 6)))
    batch = AgentBatch([agent.context for agent in agents], Use("L1"), percepts)
    for agent, member in zip(agents, batch.members, strict=True):
        member.go_on_from(agent.running.condition())
    batch.forget()
    batch.decide(np.arange(3))
    for member in batch.members:
        member.tick()
    assert [member.active_path for member in batch.members] == [["Wait"], ["Kick"], ["Kick"]]
    pulses = [[line for line in a.body.done if "pulse" in line] for a in agents]
    assert pulses == [["pulse Wait()"] * 2, ["pulse Kick()"], ["pulse Kick()"]]
    assert [line for line in agents[1].body.done if "start" in line] == ["start Kick()"]


def test_a_member_that_nobody_decided_for_decides_by_itself() -> None:
    domain = robot(False)
    chooses = HandWritten(lambda distance: "Wait" if distance < 2.0 else "Go(ball)", (0,))
    automaton = Automaton(
        "L1",
        (Use("Wait"), Use("Go", ("ball",))),
        (Use("Distance", ("ball",)),),
        {START: chooses, "Wait": chooses, "Go(ball)": chooses},
    )
    agent = Alone(Repertoire(domain, {"L1": automaton}), Use("L1"), 1)
    (member,) = AgentBatch([agent.context], Use("L1")).members
    member.start()
    for distance in (1.0, 1.0, 3.0):
        agent.body.values = [distance]
        member.tick()
    assert agent.body.done[-3:] == ["stop Wait()", "start Go(0,)", "pulse Go(0,)"]


def test_members_do_nothing_where_an_automaton_is_empty() -> None:
    """An automaton is empty where a hand-written one was taken out, see `Domain.without`."""
    domain = robot(True)
    chooses = HandWritten(lambda distance: "Wait" if distance < 2.0 else "Gap", (0,))
    outer = Automaton(
        "L1",
        (Use("Wait"), Use("Gap")),
        (Use("Distance", ("ball",)),),
        dict.fromkeys((START, "Wait", "Gap"), chooses),
    )
    repertoire = Repertoire(domain, {"Gap": Automaton("Gap", (), (), {}), "L1": outer})
    agents = [Alone(repertoire, Use("L1"), seed) for seed in range(2)]
    batch = AgentBatch([agent.context for agent in agents], Use("L1"))
    for distance in (3.0, 3.0, 1.0, 3.0):
        for agent in agents:
            agent.body.values = [distance] * 6
            agent.senses.forget()
        batch.forget()
        batch.decide(np.arange(2))
        for member in batch.members:
            member.tick()
    assert [member.active_path for member in batch.members] == [["Gap", START]] * 2
    for agent in agents:
        assert [line for line in agent.body.done if "pulse" in line] == ["pulse Wait()"]


def test_a_basic_behavior_is_not_performed_in_batches() -> None:
    agent = Alone(Repertoire(robot(False)), Use("Wait"), 1)
    with pytest.raises(TypeError, match="only automata"):
        AgentBatch([agent.context], Use("Wait"))


def watchers(
    size: int, last: Sequence[Feature], transitions: dict[str, HandWritten]
) -> list[Alone]:
    """Return agents with the automaton ``L1`` of Wait and Kick; observers look at all features."""
    domain = robot(True)
    domain = Domain.of(
        "logging",
        "1",
        domain.body,
        behaviors=list(domain.behaviors.values()),
        features=[*(f for f in domain.features.values() if f.name != last[0].name), *last],
        targets=list(domain.targets.values()),
    )
    features = (Use("Lit"), Use(last[0].name))
    automaton = Automaton("L1", (Use("Wait"), Use("Kick")), features, transitions)
    repertoire = Repertoire(domain, {"L1": automaton})
    return [Alone(repertoire, Use("L1"), seed) for seed in range(size)]


def test_observing_does_not_need_features_that_the_decision_did_not_look_at() -> None:
    goes = TransitionTree([robot(True).features["Lit"].scale, robot(True).features["Role"].scale])
    automaton = {START: goes.fit([[0.0, 0.0], [1.0, 0.0]], ["Wait", "Kick"])}
    role = robot(True).features["Role"]
    agents = watchers(2, [role], automaton)
    told: list[Sequence[float | None]] = []
    for agent in agents:
        context = replace(
            agent.context,
            observe=lambda change: told.append(change.values),
        )
        agent.context, agent.running = context, context.perform(Use("L1"))
        agent.body.values = [0.0, 0.0, 0.0, 0.0, NAN, 1.0]  # without a role
    agents[0].running.start()
    agents[0].running.tick()
    percepts = BatchPercepts(np.array([agents[1].body.values]))
    batch = AgentBatch([agents[1].context], Use("L1"), percepts)
    batch.members[0].start()
    batch.decide(np.arange(1))
    batch.members[0].tick()
    assert batch.members[0].active_path == agents[0].running.active_path == ["Kick"]
    assert [list(values) for values in told] == [[1.0, None]] * 2


def test_a_feature_that_cannot_be_read_for_all_is_read_for_each_and_stops_nobody_else() -> None:
    def read(body: LoggingBody) -> float:
        return body.values[6]

    def read_all(percepts: BatchPercepts) -> np.ndarray:
        return percepts.values[:, 6]  # there is no such column

    goes = HandWritten(lambda lit, beat: "Kick" if beat else "Wait", (0, 1))
    beat = Feature("Beat", read, FeatureKind.CONTINUOUS, read_all=read_all)
    agents = watchers(2, [beat], {START: goes})
    percepts = BatchPercepts(np.zeros((2, 6)))
    batch = AgentBatch([agent.context for agent in agents], Use("L1"), percepts)
    agents[0].body.values, agents[1].body.values = [0.0] * 6, [1.0] * 7
    for member in batch.members:
        member.start()
    batch.decide(np.arange(2))
    with pytest.raises(IndexError):
        batch.members[0].tick()
    batch.members[1].tick()
    assert [member.active_path for member in batch.members] == [["Start"], ["Kick"]]


def test_what_a_member_perceives_now_is_told_also_when_nothing_has_been_decided_on_it() -> None:
    goes = HandWritten(lambda lit, role: "Wait", (0, 1))
    (agent,) = watchers(1, [robot(True).features["Role"]], {START: goes})
    percepts = BatchPercepts(np.array([[0.0, 0.0, 0.0, 0.0, 1.0, 0.0]]))
    batch = AgentBatch([agent.context], Use("L1"), percepts)
    batch.members[0].start()
    agent.body.values = percepts.values[0].tolist()
    batch.decide(np.arange(1))
    batch.members[0].tick()
    agent.body.values = [0.0, 0.0, 0.0, 0.0, 2.0, 0.0]  # a paused world was rearranged
    agent.senses.forget()
    assert [value for _, _, value in live_features(batch.members[0], agent.context)] == [0.0, 2.0]
