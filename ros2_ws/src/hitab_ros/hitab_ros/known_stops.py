"""Known emergency stops, and which of them are released. No ROS here.

A stop is an event with an identity. It counts once, whenever it arrives, so clocks do not matter.
A release names the stops to end. Stops and releases are only ever added, so receivers
of the same ones agree, in any order of arrival and with any repetition.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Self

from hitab_ros.plain_text import plain

KEPT_MAX = 100
"""Maximum number of stops, and of releases, kept. An older stop that is delivered again after its
release was forgotten stops the robots again."""

WORDS_MAX = 200
"""Maximum characters of who stopped or released the robots, and why."""

STOPS_NAMED_MAX = 3
"""Maximum number of stops named in the text for people."""


@dataclass(frozen=True)
class KnownStops:
    """Stops known to one participant; true if the robots have to stand still.

    Attributes:
        stops: who stopped the robots and why, for each stop that is not released, by identity.
        released: who released the other stops, by identity; the last one last.
    """

    stops: Mapping[str, str] = field(default_factory=dict)
    released: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of_texts(cls, stops: Iterable[str], released: Iterable[str]) -> Self:
        """Return what has these `texts`."""
        return cls(_of_texts(stops), _of_texts(released))

    def texts(self) -> dict[str, list[str]]:
        """Return both fields, by name, as texts: an identity, a blank, and words."""
        return {
            name: [f"{i} {words}" for i, words in of.items()] for name, of in vars(self).items()
        }

    def __bool__(self) -> bool:
        return bool(self.stops)

    @property
    def who(self) -> str:
        """Senders and reasons of the stops in force; empty if there are none."""
        return ", ".join([*dict.fromkeys(self.stops.values())][-STOPS_NAMED_MAX:])

    def joined(self, other: KnownStops) -> KnownStops:
        """Return the union of both."""
        # What is new comes last, and words stay as they were first heard.
        released = {**self.released, **other.released, **self.released}
        stops = {**self.stops, **other.stops, **self.stops}
        left = {identity: stops[identity] for identity in stops if identity not in released}
        return KnownStops(_newest(left), _newest(released))

    def stopped(self, identity: str, by: str, reason: str = "") -> KnownStops:
        """Return what is known after a stop; one that is known already makes no difference."""
        words = f"{by or 'somebody'} ({reason})" if reason else by or "somebody"
        return self.joined(KnownStops({identity: plain(words, WORDS_MAX, lines=False)}))

    def released_by(self, by: str) -> KnownStops:
        """Return what is known after a release of all stops that are known."""
        who = plain(by or "somebody", WORDS_MAX, lines=False)
        return self.joined(KnownStops({}, dict.fromkeys(self.stops, who)))


def must_tell(before: KnownStops, known: KnownStops, heard: KnownStops) -> bool:
    """Whether a receiver of news has to rebroadcast its own knowledge.

    True if the news stops or releases the receiver, and if the sender does not know the
    receiver's stops or releases.
    """
    return not bool(before) == bool(known) == bool(heard)


def _of_texts(texts: Iterable[str]) -> dict[str, str]:
    return {identity: words for identity, _, words in (text.partition(" ") for text in texts)}


def _newest(known: Mapping[str, str]) -> dict[str, str]:
    return dict([*known.items()][-KEPT_MAX:])
