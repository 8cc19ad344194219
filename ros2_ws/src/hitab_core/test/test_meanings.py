"""What the paper's terms mean here, one test or more for each."""

import random

import pytest

from hitab_core.automaton import START, Automaton
from hitab_core.domain import BasicBehavior, Domain, Feature, FeatureKind, Target
from hitab_core.example import Example, ExampleKind
from hitab_core.repertoire import Repertoire
from hitab_core.running import RunContext, performance
from hitab_core.running.feature_cache import FeatureCache
from hitab_core.term import Term
from hitab_core.texts.errors import TrainingError, VocabularyError
from hitab_core.training import Curriculum, Trainer
from hitab_core.training.events import Given
from hitab_core.transition_function import HandWritten


class Recorder:
    """A body that records what is done with it and sees what the test sets."""

    def __init__(self, name="it"):
        self.log = []
        self.sees = {"x": 0.0, "y": 0.0, "angle": 0.0, "gear": 0.0}

    def sense(self, values, heard):
        self.sees.update(values)

    def act(self):
        return [], ""


def behavior(name, parameters=(), one_shot=False):
    def note(what):
        return lambda body, *targets: body.log.append(
            f"{what} {name}" + (f"({', '.join(targets)})" if targets else "")
        )

    return BasicBehavior(
        name, note("pulse"), note("start"), note("stop"), parameters=parameters, one_shot=one_shot
    )


def seen(name, kind=FeatureKind.CONTINUOUS, **more):
    return Feature(name, lambda body: body.sees[name], kind, **more)


DOMAIN = Domain.of(
    "recorder",
    "1",
    Recorder,
    behaviors=[
        behavior("A"),
        behavior("B"),
        behavior("C"),
        behavior("GoTo", parameters=("X",)),
        behavior("Once", one_shot=True),
    ],
    features=[
        seen("x"),
        seen("y"),
        seen("angle", FeatureKind.TOROIDAL),
        seen("gear", FeatureKind.CATEGORICAL, categories=("low", "high", "reverse")),
        Feature("Of", lambda body, target: body.sees[target], parameters=("X",)),
    ],
    targets=[Target("x", lambda body: "x"), Target("y", lambda body: "y")],
)


def terms(*texts):
    return tuple(Term.parse(text) for text in texts)


def automaton(name, states, functions, features=("x",), parameters=()):
    """Return an automaton whose functions are written as functions of all features."""
    columns = tuple(range(len(features)))
    return Automaton(
        name,
        terms(*states),
        terms(*features),
        {state: HandWritten(choose, columns) for state, choose in functions.items()},
        parameters,
    )


class Agent:
    """One body, with its automata."""

    def __init__(self, *automata, seed=1, most_probable=False):
        self.body = Recorder()
        self.repertoire = Repertoire(DOMAIN, {made.name: made for made in automata})
        self.feature_cache = FeatureCache(self.body, DOMAIN)
        draw = random.Random(seed).random
        self.context = RunContext(
            self.repertoire, self.body, self.feature_cache, draw, most_probable
        )

    def perform(self, text):
        running = performance(self.context, Term.parse(text))
        running.start()
        return running

    def train(self, name="T", features=("x",), **more):
        return Trainer(self.context, Curriculum(name, terms(*features), **more))

    def see(self, **values):
        self.body.sense(values, [])
        self.feature_cache.forget()

    def log(self):
        said, self.body.log = self.body.log, []
        return said


# 1 ---------------------------------------------------------------------------------------------


def test_exactly_one_state_is_active_in_each_automaton():
    inner = automaton("Inner", ["A", "B"], {START: lambda x: "A", "A": lambda x: "B"})
    outer = automaton("Outer", ["Inner", "C"], {START: lambda x: "Inner"})
    running = Agent(inner, outer).perform("Outer")
    assert running.active_path == [START]
    running.tick()
    assert running.active_path == ["Inner", "A"]
    running.tick()
    assert running.active_path == ["Inner", "B"]


def test_an_automaton_that_uses_itself_through_others_is_refused():
    high = automaton("High", ["Low"], {START: lambda x: "Low"})
    with pytest.raises(VocabularyError, match="recursive"):
        Agent(high, automaton("Low", ["High"], {START: lambda x: "High"}))


def test_training_an_automaton_refuses_itself_and_what_uses_it_as_a_state():
    low = automaton("Low", ["A"], {START: lambda x: "A"})
    high = automaton("High", ["Low"], {START: lambda x: "Low"})
    session = Agent(low, high).train("Low")
    for refused in ("Low", "High"):
        with pytest.raises(VocabularyError, match="recursive"):
            session.command(Term.parse(refused))
    assert not session.examples


# 2 ---------------------------------------------------------------------------------------------


def flagging(delay=0):
    """Return an automaton that performs A and is done at once, or, with a delay, after C."""
    functions = {START: lambda x: "A", "A": lambda x: "Done"}
    states = ["A", "Done"]
    if delay:
        functions |= {"A": lambda x: "C", "C": lambda x: "Done"}
        states.append("C")
    return automaton("Child", states, functions)


def watching(queries, states=("Child", "B")):
    """Return a parent that writes down the flag seen at each query."""

    def look(done):
        queries.append(done)
        return "Child"

    return automaton(
        "Parent", states, {START: lambda done: "Child", "Child": look}, features=("Done",)
    )


def test_start_is_left_at_once():
    agent = Agent(automaton("M", ["A"], {START: lambda x: "A"}))
    running = agent.perform("M")
    running.tick()
    assert running.active == "A"
    assert agent.log() == ["start A", "pulse A"]


def test_the_parent_sees_a_flag_at_its_next_query_and_only_once():
    queries = []
    running = Agent(flagging(), watching(queries)).perform("Parent")
    for _ in range(5):
        running.tick()
    # Ticks of the child: A, Done, Start and A, Done, ...
    assert queries == [0.0, 1.0, 0.0, 1.0]


def test_after_a_flag_the_automaton_begins_again_at_start():
    agent = Agent(flagging(), watching([]))
    running = agent.perform("Parent")
    paths = []
    for _ in range(4):
        running.tick()
        paths.append(running.active_path)
    assert paths == [["Child", "A"], ["Child", "Done"], ["Child", "A"], ["Child", "Done"]]
    assert agent.log() == ["start A", "pulse A", "stop A", "start A", "pulse A", "stop A"]


def test_a_flag_is_down_after_the_child_was_started_again():
    agent = Agent(flagging())
    child = agent.perform("Child")
    child.tick()
    child.tick()
    assert child.raised == {"Done"}
    child.stop()
    child.start()
    assert not child.raised


def test_a_demonstrator_sees_a_flag_until_the_next_command():
    agent = Agent(flagging())
    session = agent.train(features=("Done",))
    session.command(Term("Child"))
    for _ in range(5):
        session.tick()  # no automaton queries, so the flag stays up
    session.command(Term("B"))
    session.command(Term("Child"))
    flags = [e.features for e in session.examples if e.kind is ExampleKind.DEMONSTRATED]
    assert flags == [(0.0,), (1.0,), (0.0,)]


# 3 ---------------------------------------------------------------------------------------------


def test_a_tick_queries_then_changes_then_pulses_and_inside_the_same():
    inner = automaton("Inner", ["A", "B"], {START: lambda x: "A", "A": lambda x: "B"})
    outer = automaton(
        "Outer",
        ["Inner", "C"],
        {START: lambda x: "Inner", "Inner": lambda x: "C" if x else "Inner"},
    )
    agent = Agent(inner, outer)
    running = agent.perform("Outer")
    running.tick()
    assert agent.log() == ["start A", "pulse A"]
    running.tick()
    assert agent.log() == ["stop A", "start B", "pulse B"]
    agent.see(x=1.0)
    running.tick()
    assert agent.log() == ["stop B", "start C", "pulse C"], "innermost is stopped, C pulsed once"


def test_each_feature_is_read_at_most_once_per_tick():
    reads = []
    domain = Domain.of(
        "counting", "1", Recorder,
        behaviors=[behavior("A")],
        features=[Feature("x", lambda body: reads.append(1) or 0.0)],
    )  # fmt: skip
    stay = {START: HandWritten(lambda x: "A", (0,)), "A": HandWritten(lambda x: "A", (0,))}
    low = Automaton("Low", terms("A"), terms("x"), stay)
    functions = {
        START: HandWritten(lambda x: "Low", (0,)),
        "Low": HandWritten(lambda x: "Low", (0,)),
    }
    high = Automaton("High", terms("Low"), terms("x"), functions)
    body = Recorder()
    feature_cache = FeatureCache(body, domain)
    repertoire = Repertoire(domain, {"Low": low, "High": high})
    context = RunContext(repertoire, body, feature_cache, random.random)
    running = performance(context, Term("High"))
    running.start()
    running.tick()
    assert len(reads) == 1
    feature_cache.forget()
    running.tick()
    assert len(reads) == 2


def test_a_one_shot_behavior_is_pulsed_once_per_entry():
    other = {
        START: lambda x: "Once",
        "Once": lambda x: "A" if x else "Once",
        "A": lambda x: "Once",
    }
    agent = Agent(automaton("M", ["Once", "A"], other))
    running = agent.perform("M")
    for _ in range(3):
        running.tick()
    assert agent.log() == ["start Once", "pulse Once"]
    agent.see(x=1.0)
    running.tick()
    agent.see(x=0.0)
    running.tick()
    assert agent.log()[-2:] == ["start Once", "pulse Once"]


# 4 ---------------------------------------------------------------------------------------------


def test_a_state_without_examples_is_never_left():
    session = Agent().train()
    session.command(Term("A"))
    session.command(Term("Once"))
    session.test(restart=True)
    function = session.automaton().transitions
    assert set(function) == {START, "A"}
    session.running.go_to("Once")
    for _ in range(5):
        session.tick()
    assert session.running.active == "Once"


def test_without_an_example_leaving_start_there_is_nothing_to_test():
    agent = Agent()
    session = agent.train()
    with pytest.raises(TrainingError, match=r"no example leaves Start; command"):
        session.test()
    assert not session.testing


# 5 ---------------------------------------------------------------------------------------------


def test_a_command_records_an_example_and_a_default_example_with_the_same_features():
    agent = Agent()
    session = agent.train(features=("x", "y"))
    agent.see(x=3.0, y=4.0)
    session.command(Term("A"), Given(cycle=7))
    first, default = session.examples
    assert (first.state, first.features, first.next_state) == (START, (3.0, 4.0), "A")
    assert (default.state, default.features, default.next_state) == ("A", (3.0, 4.0), "A")
    assert not first.is_default
    assert default.is_default
    assert first.cycle == default.cycle == 7
    session.tick()
    assert agent.log() == ["start A", "pulse A"]


def test_a_one_shot_behavior_and_a_flag_get_no_default_example():
    session = Agent().train()
    session.command(Term("Once"))
    session.command(Term("Done"))
    assert [(e.state, e.next_state) for e in session.examples] == [
        (START, "Once"),
        ("Once", "Done"),
    ]


def test_after_a_commanded_flag_the_next_example_leaves_start():
    session = Agent().train()
    session.command(Term("A"))
    session.command(Term("Done"))
    session.command(Term("B"))
    assert session.examples[-2].state == START


def test_commanding_the_running_behavior_again_records_one_ordinary_example():
    agent = Agent()
    session = agent.train()
    session.command(Term("A"))
    agent.log()
    agent.see(x=5.0)
    (again,) = session.command(Term("A"))
    assert (again.state, again.features, again.next_state) == ("A", (5.0,), "A")
    assert not again.is_default
    session.tick()
    assert agent.log() == ["pulse A"], "it is not restarted"


# 6: the classifier; test_splits.py and test_transition_tree.py have the rest --------------------


def test_a_decision_is_drawn_from_the_leaf_with_the_agents_own_generator():
    def decisions(seed, most_probable=False):
        agent = Agent(seed=seed, most_probable=most_probable)
        session = agent.train()
        for number, label in enumerate("AAAB", 1):
            log = session.log
            log.make(log.addition([Example(START, (0.0,), label, number=number)]))
        session.running.add_state(Term("A"))
        session.running.add_state(Term("B"))
        session.test()
        chosen = []
        for _ in range(400):
            session.restart()
            session.tick()
            chosen.append(session.running.active)
        return chosen

    assert decisions(1) == decisions(1)
    assert decisions(1) != decisions(2)
    assert 0.15 < decisions(3).count("B") / 400 < 0.35  # 1/4, five standard deviations
    assert set(decisions(1, most_probable=True)) == {"A"}


# 7 ---------------------------------------------------------------------------------------------


def test_the_demonstrator_takes_over_and_gives_back_without_a_reset():
    agent = Agent()
    session = agent.train()
    session.command(Term("A"))
    agent.see(x=5.0)
    session.command(Term("B"))
    session.test()
    session.tick()
    agent.log()
    session.take_over()
    assert session.running.active == "B"
    session.tick()
    session.test()
    session.tick()
    assert agent.log() == ["pulse B", "pulse B"], "neither stopped nor started"


def test_a_command_while_testing_is_refused_and_changes_nothing():
    session = Agent().train()
    session.command(Term("A"))
    session.test()
    with pytest.raises(TrainingError, match="is being tested"):
        session.command(Term("B"))
    assert len(session.examples) == 2


def test_what_is_demonstrated_after_taking_over_is_a_correction():
    agent = Agent()
    session = agent.train()
    session.command(Term("A"))
    session.test()
    session.take_over()
    agent.see(x=2.0)
    correction, _ = session.command(Term("B"))
    assert correction.kind is ExampleKind.CORRECTION
    session.test()
    assert "B" in session.automaton().labels


# 8 ---------------------------------------------------------------------------------------------


def going(name="Approach"):
    """Return an automaton with a parameter that goes to G until it is near."""
    return automaton(
        name,
        ["GoTo(G)", "A"],
        {START: lambda near: "GoTo(G)", "GoTo(G)": lambda near: "A" if near < 1 else "GoTo(G)"},
        features=("Of(G)",),
        parameters=("G",),
    )


def test_two_instances_of_an_automaton_with_different_bindings_work_side_by_side():
    both = automaton(
        "Both",
        ["Approach(x)", "Approach(y)"],
        {START: lambda x: "Approach(x)", "Approach(x)": lambda x: "Approach(y)"},
    )
    agent = Agent(going(), both)
    agent.see(x=0.5, y=9.0)
    running = agent.perform("Both")
    for _ in range(3):
        running.tick()
    assert agent.log() == [
        "start GoTo(x)", "pulse GoTo(x)", "stop GoTo(x)",
        "start GoTo(y)", "pulse GoTo(y)", "pulse GoTo(y)",
    ]  # fmt: skip


def test_what_cannot_be_commanded_is_refused_with_what_could_be():
    for wrong, message in [
        ("GoTo", r"takes 1 target, not 0; write, for example, GoTo\(\w+\)"),
        ("GoTo(x, y)", r"takes 1 target, not 2; write, for example, GoTo\(x\)"),
        ("A(x)", r"takes no targets, not 1; write A"),
        ("GoTo(z)", r'unknown target "z".*known: x, y'),
        ("Fly", r'unknown behavior "Fly" \(known: A, B, C, GoTo, Once\)'),
        ("Start", "cannot be commanded"),
    ]:
        session = Agent().train()
        with pytest.raises(VocabularyError, match=message):
            session.command(Term.parse(wrong))
        assert not session.examples


def test_an_automaton_with_parameters_is_trained_with_them_bound_to_targets():
    agent = Agent()
    session = agent.train(features=("Of(G)",), parameters=("G",), arguments=("y",))
    agent.see(y=3.0)
    session.command(Term.parse("GoTo(G)"))
    session.tick()
    assert agent.log() == ["start GoTo(y)", "pulse GoTo(y)"]
    assert session.examples[0].features == (3.0,)
    agent = Agent(session.automaton())
    agent.perform("T(x)").tick()
    assert agent.log() == ["start GoTo(x)", "pulse GoTo(x)"]


# 9: saving; test_trimming.py and test_behavior_library.py have the rest ------------------------


def test_a_trained_automaton_takes_the_place_of_a_hand_written_one_beside_the_others():
    """The paper's case at RoboCup 2011: one hard-coded behavior deleted and trained instead."""
    hand = Domain.of(
        "hand", "1", Recorder,
        behaviors=DOMAIN.behaviors.values(),
        features=DOMAIN.features.values(),
        automata=[
            automaton("Servo", ["A"], {START: lambda x: "A"}),
            automaton("Kick", ["B"], {START: lambda x: "B"}),
            automaton(
                "Play", ["Servo", "Kick"], {START: lambda x: "Servo", "Servo": lambda x: "Kick"},
            ),
        ],
    )  # fmt: skip
    trained = automaton("Servo", ["C"], {START: lambda x: "C"})
    body = Recorder()
    repertoire = Repertoire(hand, {"Servo": trained})
    context = RunContext(repertoire, body, FeatureCache(body, hand), random.random)
    running = performance(context, Term("Play"))
    running.start()
    running.tick()
    running.tick()
    assert body.log == ["start C", "pulse C", "stop C", "start B", "pulse B"]
