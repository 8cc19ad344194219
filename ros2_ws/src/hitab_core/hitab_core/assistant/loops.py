"""An assistant that looks for loops: situations in which an automaton only changes its state."""

from __future__ import annotations

from contextlib import suppress

from hitab_core.advice.remarks import Remark, loops
from hitab_core.example import Example
from hitab_core.texts.errors import HitabError
from hitab_core.training.trainer import Trainer


class Loops:
    """Looks for loops in the automaton that would be learned from the present examples.

    Args:
        trainer: the trainer.
    """

    def __init__(self, trainer: Trainer) -> None:
        self._trainer = trainer
        self._looks = False
        self._found: list[Remark] = []
        self._about: tuple[Example, ...] = ()

    def subscribe(self) -> None:
        """Enable the search for loops."""
        self._looks = True

    def remarks(self, *, look: bool = False) -> list[Remark]:
        """Return the loops found; none if the examples have changed since.

        Args:
            look: search again if they have changed.
        """
        trainer, examples = self._trainer, self._trainer.examples
        if look and self._looks and self._about is not examples:
            self._about, self._found = examples, []
            with suppress(HitabError):  # testing reports why nothing can be learned
                classifier = trainer.curriculum.classifier
                self._found = loops(trainer.automaton(), trainer.context.repertoire, classifier)
        return self._found if self._about is examples else []
