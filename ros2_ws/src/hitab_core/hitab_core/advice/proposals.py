"""What advice consists of: corrections that were given, and proposals that answer them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class ProposalKind(StrEnum):
    """Why a robot did the wrong thing, and so what to do about it."""

    MISTAKE = "mistake"  # an example says what the person did not mean: remove it
    SPARSE = "sparse"  # too little was shown there: add an example


@dataclass(frozen=True, slots=True)
class Correction:
    """A command against what the automaton did by itself.

    Attributes:
        state: label of the state in which it decided.
        features: the values that it saw, in the order of the automaton's features; NaN: missing.
        wrong: label of the state that it went to, or stayed in.
        right: label of the state that the person commanded.
        number: of the example that the command recorded, 0 if it recorded none. The example with
            this number is not taken for evidence a second time.
        since: number of the last example then; what has a higher one was shown later. 0: unknown.
    """

    state: str
    features: tuple[float, ...]
    wrong: str
    right: str
    number: int = 0
    since: int = 0


@dataclass(frozen=True, slots=True)
class Proposal:
    """Something that the person can accept or decline.

    Attributes:
        kind: remove (`MISTAKE`) or add (`SPARSE`).
        state: label of the state whose transition function is concerned.
        examples: their numbers, ascending. For a mistake, all to be removed, so the default
            example of the command as well; for too few examples, the one that decided.
        instead: the next state that was probably meant.
        score: probability that it is right, 0 to 1.
        evidence: sentences that say why, the strongest first.
        corrections: indices of the corrections that it answers.
        change: of a mistake, what removing it changes, in a sentence.
        place: of too few examples, a situation in which one more command tells most: feature
            values.
    """

    kind: ProposalKind
    state: str
    examples: tuple[int, ...]
    instead: str
    score: float
    evidence: tuple[str, ...]
    corrections: tuple[int, ...] = ()
    change: str = ""
    place: tuple[float, ...] | None = None
