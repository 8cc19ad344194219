"""Operations on what an agent performs, and on its library."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from hitab_core.term import Term
from hitab_core.texts.errors import LibraryError, VocabularyError
from hitab_core.texts.remedies import Fix
from hitab_core.texts.wording import quantity, some
from hitab_core.training.operation import Operation, Outcome, Shipment

if TYPE_CHECKING:
    from hitab_core.agent import Agent


@dataclass(frozen=True)
class Perform(Operation):
    """Perform a behavior as the top-level one, from Start; a training is kept.

    Attributes:
        behavior: the behavior; empty to perform nothing.
        targets: targets for its parameters, such as ball; its numbers, such as direction=40.
    """

    behavior: str = ""
    targets: Sequence[str] = ()

    def apply(self, agent: Agent) -> Outcome:
        """Perform the behavior."""
        term = Term.parse(self.behavior, self.targets) if self.behavior else None
        agent.perform(term)
        done = f"{agent.name} performs {term or 'nothing'}"
        if agent.session is None:
            return Outcome(done)
        examples = quantity(agent.unsaved, "example")
        done += f'; the training of "{agent.training}" ({examples}) is kept'
        return Outcome(done, [Fix.RESUME(agent=agent.name)])


@dataclass(frozen=True)
class SetCaution(Operation):
    """Set what the agent does when it is unsure of a decision.

    Attributes:
        when_unsure: ``go_on``, ``halt`` or ``hand_back``.
        distance: it is unsure farther from any example, in spreads of the examples; 0 for any
            distance.
    """

    when_unsure: str
    distance: float = 0.0

    def apply(self, agent: Agent) -> Outcome:
        """Set it."""
        from hitab_core.assistant.caution import Caution

        caution = Caution.parse(self.when_unsure, self.distance)
        agent.monitor.set(caution)
        return Outcome(f"{agent.name}: {caution}")


@dataclass(frozen=True)
class SetBreakpoints(Operation):
    """Set where an agent holds its world, before it acts; a robot's agent only says so.

    Breakpoints are gone when the agent's process ends, as its caution is.

    Attributes:
        breakpoints: states, transitions such as ``ControlBall -> Pass``, or ``unsure``; these
            replace earlier ones.
    """

    breakpoints: Sequence[str] = ()

    def apply(self, agent: Agent) -> Outcome:
        """Set them."""
        agent.break_at(self.breakpoints)
        there = some([str(one) for one in agent.breakpoints.set])
        if agent.domain.link and there:
            return Outcome(f"{agent.name} reports {there}; a robot does not wait there")
        return Outcome(
            f"{agent.name} holds at {there}" if there else f"{agent.name} holds nowhere"
        )


@dataclass(frozen=True)
class LoadLibrary(Operation):
    """Read the library again, or another one.

    Attributes:
        path: its folder; empty for the same again.
    """

    path: str = ""

    def apply(self, agent: Agent) -> Outcome:
        """Read the library."""
        from hitab_core.library.behavior_file import BEHAVIOR_SUFFIX

        other = None
        if self.path:
            folder = Path(os.path.expanduser(self.path))
            if not folder.is_absolute() or not folder.is_dir():
                raise LibraryError(
                    f'"{self.path}" is not a folder here; give the absolute path of a library'
                )
            if any(folder.iterdir()) and not any(folder.glob(f"*{BEHAVIOR_SUFFIX}")):
                raise LibraryError(
                    f"{folder} contains files but no behaviors (*{BEHAVIOR_SUFFIX}); give "
                    "the path of a library, or of an empty folder for a new one"
                )
            other = agent.open_library(folder, agent.domain)
        behaviors, loaded = agent.reload(other), agent.loaded
        broken = [text for file in loaded.files.values() for text in file.broken]
        done = "; but ".join([quantity(len(behaviors), "trained behavior"), *broken])
        return Outcome(done, behaviors=behaviors, digest=loaded.digest)


@dataclass(frozen=True)
class Distribute(Operation):
    """Send a behavior of the library, with all its parts, to other agents.

    Attributes:
        behavior: the behavior.
        targets: targets for its parameters, such as ball; its numbers, such as direction=40.
        receivers: names of the receivers; empty for all.
        start: have them begin performing it, at Start.
    """

    behavior: str
    targets: Sequence[str] = ()
    receivers: Sequence[str] = ()
    start: bool = False

    def apply(self, agent: Agent) -> Outcome:
        """Send the behavior."""
        from hitab_core.library.bundle import make_bundle

        term = Term.parse(self.behavior, self.targets)
        agent.check_saved(term.name)
        if self.start:
            agent.repertoire.check_state(term)
        agent.repertoire.get(term.name)  # unless it is unknown or lost
        if term.name not in agent.loaded.files:
            raise VocabularyError(
                f'"{term.name}" does not need to be sent: it comes with domain '
                f'"{agent.domain.name}", which its agents have'
            )
        bundle = make_bundle(agent.loaded.texts, agent.repertoire, term.name)
        number = agent.send(Shipment(bundle, term, self.receivers, self.start))
        broken = [text for name, _ in bundle.files for text in agent.loaded.files[name].broken]
        done = "; but ".join([f"sent {quantity(len(bundle.files), 'behavior')}", *broken])
        return Outcome(done, digest=bundle.digest, sequence=number)
