"""The export of a behavior to one file of Python 3.8 or later that needs nothing else."""

from __future__ import annotations

import ast
import keyword
from importlib.resources import files

from hitab_export.hierarchy_form import Hierarchy, LeafForm, NumbersForm, StateForm, TestForm
from hitab_export.names import identifiers

USE = """\
    import random, time
    robot = {name}()
    action = robot.tick(percept, time.monotonic(), random.random)  # once per cycle

`percept` maps the names in FEATURES to numbers, each in its unit there: booleans to 0 or 1, a
category to its index, and a value that is missing to None. Without a value that is required, the
third item in FEATURES, `tick` raises a ValueError and decides nothing."""


def as_python(hierarchy: Hierarchy, origin: str) -> str:
    """Return the file's text; ``origin`` describes where the behavior comes from."""
    runtime = files(__package__).joinpath("python_runtime.py").read_text(encoding="utf-8")
    parsed = ast.parse(runtime)
    there = {node.name for node in parsed.body if isinstance(node, (ast.ClassDef))}
    own = ["AUTOMATA", "FEATURES", "FLAGS", "REQUIRED", "inf", "math"]
    reserved = {*keyword.kwlist, *there, *own}
    top = str(hierarchy.top.term)
    name = identifiers([top], reserved)[top]
    lines = [f'"""{origin}\n', USE.format(name=name), '"""']
    lines += runtime.splitlines()[parsed.body[0].end_lineno :]
    lines += ["", "", "FEATURES += ["]
    lines += [
        f"    ({feature.label!r}, {feature.categories}, {feature.required}),"
        + (f"  # {feature.unit}" if feature.unit else "")
        for feature in hierarchy.features
    ]
    lines.append("]")
    for automaton in hierarchy.automata:
        lines.append(f"AUTOMATA[{str(automaton.term)!r}] = (")
        for state in automaton.states:
            lines += _state(state)
        lines.append(")")
        if automaton.required:
            lines.append(f"REQUIRED[{str(automaton.term)!r}] = {automaton.required!r}")
    lines += ["", "", f"class {name}(Behavior):", f'    """Performs {top}."""', ""]
    return "\n".join([*lines, f"    NAME = {top!r}", ""])


def _state(state: StateForm) -> list[str]:
    performs = "None"
    if state.is_automaton:
        performs = repr(str(state.performs))
    elif state.performs is not None:
        performs = f"Action({state.performs.name!r}, {state.performs.arguments}, {state.one_shot})"
    numbers = _numbers(state.numbers)
    if state.tree is None:
        return [f"    State({state.label!r}, {performs}, None{numbers}),"]
    nodes = [f"            {_node(node)}," for node in state.tree]
    return [f"    State({state.label!r}, {performs}, (", *nodes, f"    ){numbers}),"]


def _numbers(form: NumbersForm | None) -> str:
    """Return the last argument of a state."""
    if form is None:
        return ""
    axes = tuple((i, *axis) for i, axis in zip(form.features, form.table.axes, strict=True))
    wanted = tuple((n.name, n.low, n.high, n.circular) for n in form.wanted)
    moments = "".join(f"            {moment},\n" for moment in form.table.moments)
    return f", Numbers(\n        {axes},\n        {wanted},\n        (\n{moments}        ),\n    )"


def _node(node: TestForm | LeafForm) -> str:
    if isinstance(node, LeafForm):
        return repr(tuple(zip(*node.chances, strict=True)))
    limits = (node.feature, node.period, node.low, node.high, node.yes, node.no, node.share)
    return f"({', '.join(map(repr, limits))})"
