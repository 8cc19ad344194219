"""What the command says when it is called wrongly: names the argument and what it may be."""

from __future__ import annotations

import difflib
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

from hitab_client import called_as
from hitab_core import HitabError, has, some

NEAR = 0.7
"""Similarity from which on another option is suggested, as `difflib` measures it."""

NOT_WHOLE = ("int_parsing", "int_from_float", "int_type", "int_parsing_size")
NOT_NUMBER = ("float_parsing", "float_type", "finite_number")
OUT_OF_RANGE = ("greater_than_equal", "less_than_equal", "greater_than", "less_than")


def reword(error: Exception) -> None:
    """Give an error of Typer's about a wrong call a message that helps; leave other errors."""
    if (option := getattr(error, "option_name", None)) and hasattr(error, "possibilities"):
        error.message = _no_option(option, error)  # type: ignore[attr-defined]
        error.possibilities = None
    elif getattr(error, "param", None) is not None:
        parameter, value = error.param, _wrong_number(error)  # type: ignore[attr-defined]
        if value is None:
            _name_candidates(error, parameter)
        else:
            error.message = f'it must be {_numbers(parameter)}, not "{value}"'  # type: ignore


def _no_option(option: str, error: Any) -> str:
    """Return an error text for an option that a command does not have."""
    parameters = error.ctx.command.params if error.ctx is not None else []
    if option[1:2].isdigit():  # a negative number is read as an option
        for parameter in parameters:
            if parameter.param_type_name == "argument" and _least(parameter) is not None:
                return f"{parameter.name} must be {_numbers(parameter)}, not a negative number"
            if "FIELD=VALUE" in (parameter.metavar or ""):
                return f"{option}: say what it is, for example x={option}"
        return f"{option} is no option, and no negative number is expected here"
    known = [name for p in parameters if p.param_type_name == "option" for name in p.opts]
    near = difflib.get_close_matches(option, known, n=1, cutoff=NEAR)
    if near:
        return f"No such option: {option}. Did you mean {near[0]}?"
    return f"No such option: {option} {has(name for name in known if name.startswith('--'))}"


def _name_candidates(error: Any, parameter: Any) -> None:
    """Add which agents are up to an error about an agent that is not named."""
    if parameter.name != "agent" or error.message:
        return
    from hitab_client.swarm_choice import find_running

    with suppress(HitabError):
        found = find_running(None)
        agents = found[1].agents if found is not None else ()
        if agents:
            error.message = f"These are up: {some(agents)}"


def _wrong_number(error: Exception) -> Any:
    """Return the text that is no number, or none in the range; None: something else is wrong."""
    cause: Any = error.__cause__
    for detail in cause.errors() if hasattr(cause, "errors") else ():
        if detail["type"] in (*NOT_WHOLE, *NOT_NUMBER, *OUT_OF_RANGE):
            return detail["input"]
    return None


def _least(parameter: Any) -> float | None:
    least: float | None = getattr(parameter, "min", None)
    return least


def _numbers(parameter: Any) -> str:
    """Return which numbers a parameter takes."""
    annotation = str(parameter.type_descriptor.annotation)
    kind = "a number" if "float" in annotation else "a whole number"
    least, most = _least(parameter), getattr(parameter, "max", None)
    if least is not None and most is not None:
        return f"{kind} from {least:g} to {most:g}"
    if least is not None:
        return f"{kind} of at least {least:g}"
    return f"{kind} of at most {most:g}" if most is not None else kind


def with_way(message: str, name: str, groups: Any) -> str:
    """Return an error about an unknown verb; a group of verbs may have it.

    Args:
        message: the error.
        name: of the verb.
        groups: all commands, by name.
    """
    ways = list(_ways(name, groups))
    if not ways:
        return message
    wrong = message.partition(" Did you mean")[0].rstrip(".")  # its own guess is less sure
    return called_as.as_called(f"{wrong}. Did you mean {' or '.join(ways)}?")


def _ways(name: str, groups: Any) -> Iterator[str]:
    for group, command in groups.items():
        if name in getattr(command, "commands", {}):
            yield f"`{' '.join(('hitab', group, name))}`"
