"""Every command and option that an error, a help text or a page names is there."""

import importlib.util
import re
from collections.abc import Iterator
from typing import Any

import pytest
import typer
from mentions import ROOT, Mention, mentions, strings

from hitab_bringup.main import make_app

COMMAND = typer.main.get_command(make_app())
FOUND = list(dict.fromkeys(mentions()))
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


@pytest.mark.parametrize("mention", list(filter(of_hitab, FOUND)), ids=str)
def test_every_command_that_is_mentioned_is_there(mention):
    # Without it an error may send its reader to a command that does not exist.
    assert not complaint(list(mention.words[1:]), in_passing=mention.in_passing)


def test_what_is_not_there_is_found_out():
    assert complaint(["library", "check", "--accept", "A.hfa.yaml"], in_passing=False)
    assert complaint(["downn"], in_passing=True)
    assert complaint(["--versoin"], in_passing=False)
    assert complaint(["save"], in_passing=False)
    assert complaint(["save", "keeper_1", "two"], in_passing=False)
    assert not complaint(["save", "keeper_1"], in_passing=False)
    assert len([m for m in FOUND if of_hitab(m)]) > 100


@pytest.mark.parametrize(("path", "command"), list(leaves()), ids=lambda value: str(value)[:40])
def test_every_command_that_talks_to_a_swarm_can_be_told_which(path, command):
    # "Several swarms are up; choose one with --swarm NAME" must hold for each of them.
    names = set(command.callback.__code__.co_names) | set(command.callback.__code__.co_consts)
    if names & {"connection", "_control", "_open", "to_take_down", "Finder"}:
        assert "--swarm" in options_of(command)


def test_options_that_errors_name_are_those_of_a_command():
    wrong = []
    for path in sorted((ROOT / "ros2_ws/src").glob("hitab_*/hitab_*/**/*.py")):
        for place, text in strings(path):
            for option in re.findall(r"(?<![\w/-])--[a-z][a-z-]+", text):
                if option not in ALL_OPTIONS | OF_OTHERS:
                    wrong.append(f"{place}: {option}")
    assert wrong == []


def of_scripts(mention: Mention) -> bool:
    return mention.words[0].startswith("scripts/") and not of_hitab(mention)


@pytest.mark.parametrize("mention", list(filter(of_scripts, FOUND)), ids=str)
def test_every_script_that_is_mentioned_takes_its_options(mention):
    script, *words = mention.words
    assert (ROOT / script).is_file()
    if script == "scripts/test":  # what follows is for pytest
        assert all((ROOT / word).exists() for word in words if "/" in word)
        return
    if script == "scripts/python":
        script, *words = words
        if not script.endswith(".py"):
            return
        if not script.startswith(("research/", "examples/")):
            return  # one of the reader's own
    text = (ROOT / script).read_text(encoding="utf-8")
    for option in (word.partition("=")[0] for word in words if word.startswith("--")):
        declared = f"{option[2:].replace('-', '_')}:" in text  # by typer, from a parameter's name
        assert declared or option in text or option == "--help"


def of_python(mention: Mention) -> bool:
    return mention.words[:2] == ("python", "-m")


@pytest.mark.parametrize("mention", list(filter(of_python, FOUND)), ids=str)
def test_every_module_that_is_mentioned_can_be_run(mention):
    from hitab_agent.settings import DESCRIPTIONS as OF_AGENTS
    from hitab_robots.settings import DESCRIPTIONS as OF_ROBOTS
    from hitab_world.settings import DESCRIPTIONS as OF_WORLDS

    module = mention.words[2]
    if module.startswith("my_"):
        return  # the reader's own
    if (example := ROOT / "examples" / module.split(".")[0]).is_dir():
        assert (example / f"{module.replace('.', '/')}.py").is_file()
        return
    spec = importlib.util.find_spec(module)
    assert spec is not None
    assert spec.origin is not None
    if not module.startswith(("hitab_", "keepaway_", "foraging_")):
        return
    with open(spec.origin, encoding="utf-8") as file:
        assert '__name__ == "__main__"' in file.read()
    known = {*OF_AGENTS, *OF_WORLDS, *OF_ROBOTS}
    known |= {"agents", "roster", "subordinates", "roles", "asks_position"}
    for flag, word in zip(mention.words, mention.words[1:], strict=False):
        if flag == "-p" and (match := re.match(r"(\w+)(\.\w+)?:=", word)):
            assert match[2] or match[1] in known
