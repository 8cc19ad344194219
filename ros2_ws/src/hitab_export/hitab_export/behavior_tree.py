"""The export of a behavior to a tree for BehaviorTree.CPP 4, in XML.

Each automaton is a subtree. Its state is an entry of the blackboard. Scripts query and change the
state, one for each node of a decision tree; nested `WhileDoElse` nodes tick the state's behavior,
and halt it before the next behavior is started. Groot shows the names: a sequence for each state,
in it a script for each test and each transition.
"""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree.ElementTree import Comment, Element, SubElement, indent, tostring

from hitab_core import FLAGS, START
from hitab_core.learning.compiled_tree import LARGEST_DRAW
from hitab_export.hierarchy_form import (
    INTERNAL,
    AutomatonForm,
    Hierarchy,
    StateForm,
    TestForm,
)
from hitab_export.names import identifiers

BUILT_IN = """
Action AlwaysFailure AlwaysSuccess AsyncFallback AsyncSequence BehaviorTree Condition Control
Decorator Delay Draw EntryUpdated Fallback ForceFailure ForceSuccess IfThenElse Inverter
KeepRunningUntilFailure LoopBool LoopDouble LoopInt LoopString ManualSelector Parallel ParallelAll
Precondition ReactiveFallback ReactiveSequence Repeat RetryUntilSuccessful RunOnce Script
ScriptCondition Sequence SequenceWithMemory SetBlackboard SkipUnlessUpdated Sleep SubTree Switch2
Switch3 Switch4 Switch5 Switch6 TestNode Timeout TreeNodesModel TryCatch UnsetBlackboard Updated
WaitValueUpdate WasEntryUpdated WhileDoElse include root
"""
GIVEN = ("hitab_begin", "now")

HEAD = """
The robot's program registers these actions. Each is stateful: it begins in onStart, goes on in
onRunning, ends in onHalted, and always returns RUNNING; one with "once" acts in onStart only.
{actions}
  Draw: config().blackboard->set("drawn", a random number from [0, 1)), and SUCCESS

Before each tick it sets these entries, each of type double, then calls tickExactlyOnce(). After
SUCCESS nothing is performed in that tick; the tree is ticked on.
  now: seconds on a clock that never goes back
  hitab_begin: 1 to begin in Start: before the first tick, and after haltTree();
    the tree sets it to 0
{entries}
A missing value is NaN; booleans are 0 or 1, a category is its index. Nothing is decided without a
required value: do not tick. After a tick {top}_Done or {top}_Failed is 1 if
the behavior has raised this flag; set it to 0 once seen.
"""


def as_behavior_tree(hierarchy: Hierarchy, origin: str) -> str:
    """Return the file's text; ``origin`` describes where the behavior comes from."""
    return _Writer(hierarchy).text(origin)


class _Writer:
    """Writes one file.

    Attributes:
        names: names of the subtrees and actions, by the behavior that they perform.
        values: the entries of the blackboard, by the features' labels.
        labels: the features' labels, by the entries.
    """

    def __init__(self, hierarchy: Hierarchy) -> None:
        self._hierarchy = hierarchy
        used = [str(automaton.term) for automaton in hierarchy.automata]
        self.names = identifiers([*used, *map(str, hierarchy.basics)], BUILT_IN.split())
        labels = [feature.label for feature in hierarchy.features]
        taken = {"drawn", "true", "false", *GIVEN}
        self.values = identifiers(labels, taken)
        self.labels = {value: label for label, value in self.values.items()}
        # Names behind this prefix differ from all features.
        self._prefix = "hitab_"
        while any(name.startswith(self._prefix) for name in self.values.values()):
            self._prefix += "x_"

    def text(self, origin: str) -> str:
        top = str(self._hierarchy.top.term)
        root = Element("root", BTCPP_format="4", main_tree_to_execute=self.names[top])
        begun = [self._begun(automaton.term) for automaton in self._hierarchy.automata]
        for automaton in reversed(self._hierarchy.automata):
            body = SubElement(root, "BehaviorTree", ID=self.names[str(automaton.term)])
            body = SubElement(body, "ReactiveSequence")
            if automaton is self._hierarchy.top:
                _script(body, "hitab_begin == 0", "hitab_begin := 0.0", *begun, name="begin")
            self._query(body, automaton)
            self._decide(body, automaton)
            self._enter(body, automaton)
            self._perform(body, automaton.states, self._entry(automaton.term, "state"))
        indent(root)
        comment = tostring(Comment(self._head(origin)), encoding="unicode")
        tree = tostring(root, encoding="unicode")
        return f'<?xml version="1.0" encoding="UTF-8"?>\n{comment}\n{tree}\n'

    def _head(self, origin: str) -> str:
        actions = [
            f"  {self.names[str(term)]} = {term}{', once' * one_shot}"
            for term, one_shot in self._hierarchy.basics.items()
        ]
        entries = []
        for feature in self._hierarchy.features:
            inside = f", in [-2p, 2p) with p = {feature.period!r}" if feature.period else ""
            required = ", required" * feature.required
            unit = feature.unit and f", {feature.unit}"
            name = self.values[feature.label]
            entries.append(f"  {name} = {feature.label}{unit}{inside}{required}")
        head = HEAD.format(
            actions="\n".join(actions),
            entries="\n".join(entries),
            top=self._entry(self._hierarchy.top.term, "")[:-1],
        )
        return f"\n{origin}\n{head}".replace("--", "- -")

    def _entry(self, term: object, what: str) -> str:
        """Return the blackboard entry of an automaton for its state, flags and times."""
        return f"{self._prefix}{self.names[str(term)]}_{what}"

    def _begun(self, term: object) -> str:
        """Return the script that puts an automaton into Start."""
        zero = [f"{self._entry(term, flag)} := 0.0" for flag in FLAGS]
        times = [f"{self._entry(term, at)} := now" for at in ("entered", *_SEEN.values())]
        return "; ".join([f"{self._entry(term, 'state')} := '{START}'", *zero, *times])

    def _query(self, body: Element, automaton: AutomatonForm) -> None:
        """Leave Start and flag states at once; read and lower the flags, and read the timers."""
        term, state = automaton.term, self._entry(automaton.term, "state")
        is_idle = _any(state, (s.label for s in automaton.states if s.performs is None))
        _script(body, "", f"{state} := ({is_idle}) ? '{START}' : {state}", name="leave flags")
        nodes = [node for form in automaton.states for node in form.tree or ()]
        if not any(isinstance(node, TestForm) and node.feature < len(INTERNAL) for node in nodes):
            return
        _script(body, "", *(f"{self._prefix}{flag} := 0.0" for flag in FLAGS))
        for form in automaton.states:
            if form.is_automaton:
                seen, lowered = [], []
                for flag in FLAGS:
                    raised = self._entry(form.performs, flag)
                    seen.append(f"{self._prefix}{flag} := {raised}")
                    lowered.append(f"{raised} := 0.0")
                _script(body, f"!({_is(state, form.label)})", *seen, *lowered)
        for flag, seen_at in _SEEN.items():
            at = self._entry(term, seen_at)
            _script(body, f"{self._prefix}{flag} == 0", f"{at} := now")
            _script(body, "", f"{self._prefix}Since{flag} := now < {at} ? 0.0 : now - {at}")
        entered = self._entry(term, "entered")
        stays = f"({_is(state, START)} || now < {entered}) ? 0.0 : now - {entered}"
        _script(body, "", f"{self._prefix}SecondsInState := {stays}")

    def _value(self, feature: int) -> str:
        if feature < len(INTERNAL):
            return (
                self._prefix + (*FLAGS, "SecondsInState", *(f"Since{f}" for f in FLAGS))[feature]
            )
        return self.values[self._hierarchy.features[feature - len(INTERNAL)].label]

    def _decide(self, body: Element, automaton: AutomatonForm) -> None:
        """Walk down the tree of the state; every node comes before its successors."""
        state, node_at = self._entry(automaton.term, "state"), f"{self._prefix}node"
        following = f"{self._prefix}next"
        begin = f"{following} := {state}; {node_at} := 0 - 1; drawn := 0.0 - 1.0"
        _script(body, "", begin, name="decide")
        first = 0
        for form in automaton.states:
            if form.tree is None:
                continue
            elsewhere = f"!({_is(state, form.label)})"
            there = SubElement(body, "Sequence", name=f"in {form.label}", _skipIf=elsewhere)
            _script(there, "", f"{node_at} := {first}", name="begin")
            for number, node in enumerate(form.tree, first):
                elsewhere = f"{node_at} != {number}"
                if isinstance(node, TestForm):
                    self._test(there, node, first, elsewhere)
                    continue
                *others, (_, last) = node.chances
                script = [f"{following} := '{automaton.states[last].label}'"]
                for below, to in reversed(others):
                    chosen = f"drawn < {below!r} ? '{automaton.states[to].label}' : {following}"
                    script.append(f"{following} := {chosen}")
                if others:
                    _draw(there, elsewhere)
                tos = [automaton.states[to].label for _, to in node.chances]
                shown = " or ".join("stays" if to == form.label else f"-> {to}" for to in tos)
                _script(there, elsewhere, *script, name=f"{form.label} {shown}")
            first += len(form.tree)

    def _test(self, body: Element, test: TestForm, first: int, elsewhere: str) -> None:
        node_at, value = f"{self._prefix}node", self._value(test.feature)
        label = self.labels.get(value, value.removeprefix(self._prefix))
        yes, no = first + test.yes, first + test.no
        if test.feature >= len(INTERNAL):  # a value may be missing: NaN differs from itself
            known = f"{elsewhere} || {value} == {value}"
            _draw(body, known)
            left = f"(drawn - {test.share!r}) / (1 - {test.share!r})"
            _script(
                body,
                known,
                f"{node_at} := drawn < {test.share!r} ? {yes} : {no}",
                f"drawn := drawn < {test.share!r} ? drawn / {test.share!r} : {left}",
                f"drawn := drawn < {LARGEST_DRAW!r} ? drawn : {LARGEST_DRAW!r}",
                name=f"{label} is missing",
            )
        script = []
        if test.period:
            place = f"{self._prefix}place"
            script = [f"{place} := {value}"]
            script += [f"{place} := {place} < 0 ? {place} + {test.period!r} : {place}"] * 2
            script += [
                f"{place} := {place} >= {test.period!r} ? {place} - {test.period!r} : {place}"
            ]
            value = place
        limits = [f"{value} > {_number(test.low)}"] * (test.low > -float("inf"))
        limits += [f"{value} <= {_number(test.high)}"] * (test.high < float("inf"))
        script.append(f"{node_at} := ({' && '.join(limits)}) ? {yes} : {no}")
        above = f"{test.low:.4g} < " * (test.low > -float("inf"))
        below = f" <= {test.high:.4g}" * (test.high < float("inf"))
        _script(body, elsewhere, *script, name=f"{above}{label}{below}?")

    def _enter(self, body: Element, automaton: AutomatonForm) -> None:
        state, following = self._entry(automaton.term, "state"), f"{self._prefix}next"
        for form in automaton.states[1:]:
            script = [f"{self._entry(automaton.term, 'entered')} := now"]
            if form.is_automaton:
                script.append(self._begun(form.performs))
            elif form.performs is None:
                script.append(f"{self._entry(automaton.term, form.label)} := 1.0")
            stays = f"{following} == {state} || !({_is(following, form.label)})"
            _script(body, stays, *script, name=f"enter {form.label}")
        _script(body, "", f"{state} := {following}", name="change")

    def _perform(self, body: Element, states: Iterable[StateForm], state: str) -> None:
        for form in states:
            if form.performs is None:
                continue
            body = SubElement(body, "WhileDoElse")
            SubElement(body, "ScriptCondition", code=_is(state, form.label))
            name = self.names[str(form.performs)]
            if form.is_automaton:
                SubElement(body, "SubTree", ID=name, _autoremap="true")
            else:
                SubElement(body, name)
        SubElement(body, "AlwaysSuccess")


_SEEN = {flag: f"saw_{flag}" for flag in FLAGS}


def _script(body: Element, skip_if: str, *statements: str, name: str = "") -> None:
    """Add a script with the name that Groot shows."""
    shown = {"name": name} if name else {}
    conditions = {"_skipIf": skip_if} if skip_if else {}
    SubElement(body, "Script", {**shown, "code": "; ".join(statements), **conditions})


def _draw(body: Element, skip_if: str) -> None:
    """Add a node that draws a random number, unless one was drawn already."""
    SubElement(body, "Draw", _skipIf=f"{skip_if} || drawn >= 0")


def _is(state: str, label: str) -> str:
    return f"{state} == '{label}'"


def _any(state: str, labels: Iterable[str]) -> str:
    return " || ".join(_is(state, label) for label in labels)


def _number(value: float) -> str:
    return repr(value) if value >= 0 else f"(0 - {-value!r})"
