"""Commands for the remedies that errors and statuses propose."""

from __future__ import annotations

import os
import shlex
from collections.abc import Iterable

from hitab_core import Fix, Remedy

CALLED_AS = "HITAB_CALLED_AS"
"""Environment variable in which ``scripts/hitab`` passes its own name as called."""

REMEDY_COMMANDS = {
    Fix.TRAIN: "train {agent} {behavior} -f {feature}",
    Fix.TRAIN_FURTHER: "train {agent} {behavior} --resume",
    Fix.RESUME: "train {agent}",
    Fix.DEMONSTRATE: "demonstrate {agent} {behavior}",
    Fix.CORRECT: "train {agent}, then demonstrate {agent} {behavior}",
    Fix.CHOOSE_FEATURES: "examples features {agent} -f {feature}",
    Fix.VOCABULARY: "vocabulary {agent}",
    Fix.QUESTIONS: "questions {agent}",
    Fix.EXAMPLES: "examples list {agent}",
    Fix.RELABEL: "examples relabel {agent} {number} --to {behavior}",
    Fix.EXAMPLES_OF: "examples list {agent} {behavior}",
    Fix.TEST: "test {agent}",
    Fix.CAUTION: "test {agent} --when-unsure {when_unsure} --distance 3",
    Fix.SAVE: "save {agent}",
    Fix.DISCARD: "discard {agent}",
    Fix.PERFORM: "perform {agent} {behavior}",
    Fix.IDLE: "perform {agent}",
    Fix.CHECK_LIBRARY: "library check",
    Fix.RESTORE: "library restore {behavior} {version} -l {folder}",
    Fix.DELETE: "library delete {behavior} -l {folder}",
    Fix.SEND: "distribute {agent} {behavior}",
    Fix.GIVE: "distribute {agent} {behavior} --to {receiver}",
    Fix.RELOAD: "library reload --swarm {swarm}",
    Fix.NEXT_GENERATION: "bootstrap next {agent}",
    Fix.GO: "go",
    Fix.ARM: "arm {robot}",
    Fix.PACE: "world pace realtime",
    Fix.RESUME_WORLD: "world resume",
    Fix.SAVE_SNAPSHOT: "world snapshot save {snapshot}",
    Fix.DELETE_SNAPSHOT: "world snapshot delete {snapshot}",
    Fix.UP: "up {swarm}",
    Fix.DOWN: "down {swarm}",
    Fix.DOWN_FOLDER: "down --run-dir {folder}",
    Fix.STATUS: "status",
    Fix.TREE: "tree {commander}",
    Fix.LOGS: "logs {node}",
    Fix.DOCTOR: "doctor",
    Fix.RECORD: "record",
}
"""Arguments of the command, by remedy. Some remedies have no command."""

THEN = ", then "
"""Separator of the commands of one remedy."""


def called() -> str:
    """Return the name of the command, as the user calls it."""
    return os.environ.get(CALLED_AS) or "hitab"


def as_command(remedy: Remedy) -> str:
    """Return a remedy with the command for it, named as the user calls it."""
    if remedy.code not in REMEDY_COMMANDS:
        return str(remedy)
    code = remedy.code
    quoted = Remedy(code, tuple((name, shlex.quote(value)) for name, value in remedy.arguments))
    commands = [quoted.worded({code: words}) for words in REMEDY_COMMANDS[code].split(THEN)]
    return f"{remedy}: {THEN.join(f'`{called()} {command}`' for command in commands)}"


def with_commands(problem: str, remedies: Iterable[Remedy]) -> str:
    """Return a problem and, below it, the commands that may solve it, one per line."""
    return "\n  ".join((problem, *map(as_command, dict.fromkeys(remedies))))
