"""The generations of behavior bootstrapping, as kept on disk.

    <run folder>/generations/keeper_1/
      Keepaway.yaml                     all generations of Keepaway: where they come from, scores
      Keepaway/0001.bundle.yaml         the behavior and all that it is made of, word for word

A generation's behaviors are written first and the list last, atomically, so that the list names
nothing that is not there. `hitab library import` reads a bundle as well.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml
from pydantic import Field

from hitab_client.bootstrapping.configuration import Configuration
from hitab_client.bootstrapping.evaluating import LENGTH, Score
from hitab_client.errors import SwarmError
from hitab_core import Fix, FolderInUseError, has
from hitab_core.library import bundle_file_text, content_of, read_bundle_file
from hitab_core.library.durable_files import file_errors, locked, make_folder, write_durably
from hitab_core.library.yaml_models import Format, Names, Record, Texts, open_record
from hitab_core.library.yaml_places import Complaints, open_yaml

FORMAT = 1
"""The format version that is written, and the newest that is read."""

FOLDER = "generations"


class Generation(Record):
    """One stage of a behavior: saved, given to the team, evaluated.

    Attributes:
        number: from 1.
        parent: number of the generation with which the training went on before; 0: none.
        version: of the behavior in the library of the trained agent.
        digest: checksum of the behavior's file.
        at: when, ISO 8601.
        by: who.
        examples: that it was learned from, default ones included.
        arguments: what its parameters were bound to.
        note: free text.
        team: those who have taken it in.
        missing: those who have not, with the reasons.
        score: of its evaluation.
        unscored: why there is no score; empty if there is one.
        restart: how the training went on.
        restored: the versions of the library in which it was brought back.
    """

    number: int = Field(ge=1)
    parent: int = Field(ge=0)
    version: int = Field(ge=0)
    digest: str
    at: str
    by: str
    examples: int = Field(ge=0)
    arguments: Texts = ()
    note: str = ""
    team: Texts = ()
    missing: Names = Field(default_factory=dict)
    score: Score | None = None
    unscored: str = ""
    restart: Configuration = Configuration()
    restored: tuple[int, ...] = Field(default=(), strict=False)


class Generations(Record):
    """All generations of one behavior of one agent.

    Attributes:
        folder: of the agent's generations.
        agent: that is trained.
        behavior: that is trained.
        current: number of the generation with which the training goes on; 0: none yet.
        all: the generations, by ascending number.
    """

    folder: Path = Field(default=Path(), alias=":folder", exclude=True)
    format: Format = FORMAT
    agent: str
    behavior: str
    current: int = Field(default=0, ge=0)
    all: tuple[Generation, ...] = Field(default=(), alias="generations", strict=False)

    # -- looking ----------------------------------------------------------------------------

    def get(self, number: int) -> Generation:
        """Return a generation.

        Raises:
            SwarmError: if there is none of this number; naming those that there are.
        """
        for generation in self.all:
            if generation.number == number:
                return generation
        if not self.all:
            raise SwarmError(
                f"{self.behavior} of {self.agent} has no generations yet",
                Fix.NEXT_GENERATION(agent=self.agent),
            )
        numbers = [str(generation.number) for generation in self.all]
        raise SwarmError(
            f"{self.behavior} of {self.agent} has no generation {number} "
            f"{has(numbers, str(number))}",
            Fix.GENERATIONS(agent=self.agent, behavior=self.behavior),
        )

    def best(self, figure: str = LENGTH, *, least: bool = False) -> Generation | None:
        """Return the generation with the best score, among those that can be compared.

        Those can be compared that were evaluated with as many episodes and the same seed as the
        one evaluated last.
        """
        scored = [g for g in self.all if g.score is not None and figure in g.score.figures]
        if not scored:
            return None
        last = scored[-1].score
        assert last is not None
        alike = {
            g.score.figures[figure].mean: g
            for g in reversed(scored)
            if g.score is not None
            and (g.score.episodes, g.score.seed) == (last.episodes, last.seed)
        }
        return alike[min(alike) if least else max(alike)]

    def texts(self, number: int) -> Mapping[str, str]:
        """Return the files of a generation's behaviors by name, each after those that it uses.

        Raises:
            SwarmError: if somebody has removed them.
            LibraryError: if they are damaged.
        """
        path = self._bundle(number)
        if not path.exists():
            raise SwarmError(
                f"the behaviors of generation {number} of {self.behavior} are not kept ({path})",
                Fix.RESTORE_OF(
                    behavior=self.behavior, version=self.get(number).version, agent=self.agent
                ),
            )
        return read_bundle_file(path).texts

    # -- keeping ----------------------------------------------------------------------------

    def with_(self, generation: Generation, *, current: int | None = None) -> Generations:
        """Return them with one more, or with a changed one."""
        others = [g for g in self.all if g.number != generation.number]
        ordered = tuple(sorted((*others, generation), key=lambda g: g.number))
        return self.but(all=ordered, current=self.current if current is None else current)

    def keep(self) -> Generations:
        """Write the list.

        Raises:
            LibraryError: if it cannot be written.
        """
        content = self.model_dump(mode="json", by_alias=True)
        content["generations"] = [record_of(generation) for generation in self.all]
        text = f"# See `hitab bootstrap list {self.agent} {self.behavior}`.\n"
        text += yaml.safe_dump(content, sort_keys=False, allow_unicode=True, width=100)
        path = file_of(self.folder, self.behavior)
        with file_errors(path, "write"):
            write_durably(path, text.encode())
        return self

    def keep_texts(self, number: int, texts: Mapping[str, str]) -> None:
        """Write a generation's behaviors.

        Raises:
            LibraryError: if they cannot be written.
        """
        domain = content_of(texts[self.behavior], self.behavior)["domain"]["name"]
        path = self._bundle(number)
        with file_errors(path, "write"):
            write_durably(path, bundle_file_text(texts, domain).encode())

    def _bundle(self, number: int) -> Path:
        return self.folder / self.behavior / f"{number:04}.bundle.yaml"


def folder_of(run_folder: Path, agent: str) -> Path:
    """Return the folder of an agent's generations."""
    return run_folder / FOLDER / agent


def file_of(folder: Path, behavior: str) -> Path:
    """Return the file that lists the generations of a behavior."""
    return folder / f"{behavior}.yaml"


def behaviors_in(folder: Path) -> list[str]:
    """Return the behaviors that have generations."""
    return sorted(path.stem for path in folder.glob("*.yaml"))


def read_generations(folder: Path, agent: str, behavior: str) -> Generations:
    """Return the generations of a behavior; none if there is no file.

    Raises:
        SwarmError: naming all that is wrong with the file, by line.
    """
    path = file_of(folder, behavior)
    if not path.exists():
        return Generations(agent=agent, behavior=behavior).but(folder=folder)
    document = open_yaml(path, error=SwarmError)
    read = open_record(Generations, document, FORMAT)
    complaints = Complaints(document)
    for key, found, own in (("agent", read.agent, agent), ("behavior", read.behavior, behavior)):
        if found != own:
            complaints.add((key,), f"`{key}: {found}` is not known {has([own], found)}")
    numbers = [generation.number for generation in read.all]
    if len(set(numbers)) < len(numbers) or read.current not in (0, *numbers):
        complaints.add((), "each generation needs a number of its own, and `current:` one of them")
    complaints.raise_any()
    return read.but(
        folder=folder, all=tuple(g.but(restart=g.restart.about(agent)) for g in read.all)
    )


@contextlib.contextmanager
def held(run_folder: Path) -> Iterator[None]:
    """Have a swarm's generations alone: two steps at once would spoil each other.

    Raises:
        SwarmError: if somebody else has them.
    """
    folder = run_folder / FOLDER
    with file_errors(folder, "make", error=SwarmError):
        make_folder(folder)
    with contextlib.ExitStack() as stack:
        try:
            stack.enter_context(locked(folder, alone=True, patience=0.0))
        except FolderInUseError:
            raise SwarmError(
                f"another generation of this swarm is being made (which holds {folder}); wait "
                "until that has ended, or end it with Ctrl-C"
            ) from None
        yield


def record_of(generation: Generation) -> dict[str, Any]:
    """Return a generation as plain data."""
    return generation.model_dump(mode="json") | {"restart": generation.restart.record()}
