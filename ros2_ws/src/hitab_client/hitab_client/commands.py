"""The commands with which a person does what an error or a status proposes."""

from __future__ import annotations

import os
import shlex
from collections.abc import Iterable

from hitab_core import Do, Remedy

CALLED_AS = "HITAB_CALLED_AS"
"""Environment variable that ``scripts/hitab`` sets to how it was called."""

COMMANDS = {
    Do.TRAIN: "train {agent} {behavior} -f {feature}",
    Do.TRAIN_FURTHER: "train {agent} {behavior} --resume",
    Do.RESUME: "train {agent}",
    Do.DEMONSTRATE: "demonstrate {agent} {behavior}",
    Do.CORRECT: "train {agent}, then demonstrate {agent} {behavior}",
    Do.CHOOSE_FEATURES: "examples features {agent} -f {feature}",
    Do.VOCABULARY: "vocabulary {agent}",
    Do.QUESTIONS: "questions {agent}",
    Do.EXAMPLES: "examples list {agent}",
    Do.RELABEL: "examples relabel {agent} {number} --to {behavior}",
    Do.EXAMPLES_OF: "examples list {agent} {behavior}",
    Do.TEST: "test {agent}",
    Do.CAUTION: "test {agent} --when-unsure {when_unsure} --distance 3",
    Do.SAVE: "save {agent}",
    Do.DISCARD: "discard {agent}",
    Do.PERFORM: "perform {agent} {behavior}",
    Do.IDLE: "perform {agent}",
    Do.CHECK_LIBRARY: "library check",
    Do.ACCEPT: "library accept {file}",
    Do.RESTORE: "library restore {behavior} {version} -l {folder}",
    Do.DELETE: "library delete {behavior} -l {folder}",
    Do.SEND: "distribute {agent} {behavior}",
    Do.RELOAD: "library reload --swarm {swarm}",
    Do.NEXT_GENERATION: "bootstrap next {agent}",
    Do.GO: "go",
    Do.ARM: "arm {robot}",
    Do.PACE: "world pace realtime",
    Do.RESUME_WORLD: "world resume",
    Do.SAVE_SNAPSHOT: "world snapshot save {snapshot}",
    Do.DELETE_SNAPSHOT: "world snapshot delete {snapshot}",
    Do.UP: "up {swarm}",
    Do.DOWN: "down {swarm}",
    Do.DOWN_FOLDER: "down --run-dir {folder}",
    Do.STATUS: "status",
    Do.LOGS: "logs {node}",
    Do.DOCTOR: "doctor",
    Do.RECORD: "record",
}
"""What is typed after the name of the command. Some remedies are not done with it."""

THEN = ", then "
"""Between two commands of one remedy."""


def called() -> str:
    """Return the name of the command, as the user calls it."""
    return os.environ.get(CALLED_AS) or "hitab"


def as_command(remedy: Remedy) -> str:
    """Return a remedy with the command for it, named as the user calls it."""
    if remedy.code not in COMMANDS:
        return str(remedy)
    code = remedy.code
    quoted = Remedy(code, tuple((name, shlex.quote(value)) for name, value in remedy.arguments))
    commands = [quoted.worded({code: words}) for words in COMMANDS[code].split(THEN)]
    return f"{remedy}: {THEN.join(f'`{called()} {command}`' for command in commands)}"


def with_commands(problem: str, remedies: Iterable[Remedy]) -> str:
    """Return what is wrong, and below it what a person can do, one command a line."""
    return "\n  ".join((problem, *map(as_command, dict.fromkeys(remedies))))
