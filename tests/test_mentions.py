"""Every command and option that an error, a help text or a page names is there."""

import re
from collections.abc import Iterator
from typing import Any

import typer
from mentions import ROOT, Mention, mentions

from hitab_cli.main import make_app

COMMAND = typer.main.get_command(make_app())
WRITTEN_SO = {"...", "[", "VERB", "command"}
"""First words that stand for a command, or tell that no command is meant."""

OF_OTHERS = {
    *("--ros-args", "--remap", "--disable-external-lib-logs", "--params-file", "--once"),
    "--network",
}
"""Options that are not ours: those of ROS and of Docker."""


def is_group(command: Any) -> bool:
    return hasattr(command, "commands")


def leaves(command: Any = COMMAND, path: tuple[str, ...] = ()) -> Iterator[tuple]:
    """Go through all commands that do something."""
    if is_group(command):
        for name, inner in command.commands.items():
            yield from leaves(inner, (*path, name))
    else:
        yield path, command


def options_of(command: Any) -> set[str]:
    return {o for p in command.params for o in (*p.opts, *p.secondary_opts)} | {"--help", "-h"}


ALL_OPTIONS = options_of(COMMAND).union(*(options_of(command) for _, command in leaves()))


def complaint(words: list[str], *, in_passing: bool) -> str:
    """Return what is wrong with the words of a `hitab` command, or ""."""
    command: Any = COMMAND
    context = command.context_class(command, info_name="hitab")
    while is_group(command):
        if not words:
            return ""
        if words[0] in options_of(command):
            return ""
        if in_passing and words[0] in WRITTEN_SO:
            return ""
        try:
            _, command, words = command.resolve_command(context, list(words))
        except Exception as error:  # typer brings a click of its own
            return str(error)
        context = command.context_class(command, parent=context)
    if not words and in_passing:
        return ""
    if {"-h", "--help"} & set(words):
        return ""
    optional = "..." in words or any(word.startswith("[") for word in words)
    optional = optional or (in_passing and words[0].startswith("-"))
    words = [w.strip("[]") for w in words if w != "..."]
    try:
        parsed, extra, _ = command.make_parser(context).parse_args(list(words))
    except Exception as error:
        return str(error)
    if extra:
        return f"{len(extra)} arguments too many: {extra}"
    missing = [
        p.name
        for p in command.params
        if p.param_type_name == "argument" and p.required and not parsed.get(p.name)
    ]
    return f"lacks {missing}" if missing and not optional else ""


def of_hitab(mention: Mention) -> bool:
    return mention.words[0].rpartition("/")[2] == "hitab"


def test_every_command_that_is_mentioned_is_there():
    # Without it an error may send its reader to a command that does not exist.
    wrong = {
        str(mention): complaint(list(mention.words[1:]), in_passing=mention.in_passing)
        for mention in filter(of_hitab, mentions())
    }
    assert {mention: what for mention, what in wrong.items() if what} == {}


def test_every_command_that_talks_to_a_swarm_can_be_told_which():
    # "Several swarms are up; choose one with --swarm NAME" must hold for each of them.
    talking = {"connection", "_control", "_open", "to_take_down", "Finder"}
    wrong = []
    for path, command in leaves():
        code = command.callback.__code__
        if talking & {*code.co_names, *code.co_consts} and "--swarm" not in options_of(command):
            wrong.append(path)
    assert wrong == []


def test_every_module_that_a_page_names_is_there():
    there = [f"/{path.relative_to(ROOT)}" for path in (ROOT / "ros2_ws/src").rglob("*.*")]
    gone = {
        f"{page.name}: {name}"
        for page in (ROOT / "CONTRIBUTING.md", *(ROOT / "docs").glob("*.md"))
        for name in re.findall(r"`((?:hitab|keepaway)_\w+/[\w/]+\.\w+)`", page.read_text())
        if not any(path.endswith(f"/{name}") for path in there)
    }
    assert gone == set()


def test_a_command_and_a_percept_pass_twenty_files_at_most():
    design = (ROOT / "docs/design.md").read_text()
    for way in ("command", "percept"):
        section = design.partition(f"## The way of a {way}\n")[2].partition("\n## ")[0]
        assert 0 < len(re.findall(r"^\d+\. `\w+/", section, re.MULTILINE)) <= 20
