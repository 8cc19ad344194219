"""Known emergency stops and their releases, independent of ROS.

A stop is an event with an identity, which counts once, whenever it arrives, so clocks do not
matter. A release names the stops to end. Stops and releases are only ever added, so receivers of
the same messages agree, in any order of arrival and with any repetition.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Self

from hitab_ros.messages.plain_text import plain

KEPT_MAX = 100
"""Maximum number of stops, and of releases, kept. An older stop that is delivered again after its
release was forgotten stops the robots again."""

WORDS_MAX = 200
"""Maximum number of characters of the sender and the reason of a stop or release."""

STOPS_NAMED_MAX = 3
"""Maximum number of stops named in the text for people."""


@dataclass(frozen=True)
class KnownStops:
    """Stops known to one participant; true if the robots have to stand still.

    Attributes:
        stops: sender and reason of each stop that is not released, by identity.
        released: sender of the release of each other stop, by identity; the latest last.
    """

    stops: Mapping[str, str] = field(default_factory=dict)
    released: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of_texts(cls, stops: Iterable[str], released: Iterable[str]) -> Self:
        """Return the known stops with these `texts`."""
        return cls(_of_texts(stops), _of_texts(released))

    def texts(self) -> dict[str, list[str]]:
        """Return stops and releases, by field, as texts of an identity, a blank, and words."""
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
        # New stops come last, and words stay as first received.
        released = {**self.released, **other.released, **self.released}
        stops = {**self.stops, **other.stops, **self.stops}
        left = {identity: stops[identity] for identity in stops if identity not in released}
        return KnownStops(_newest(left), _newest(released))

    def stopped(self, identity: str, by: str, reason: str = "") -> KnownStops:
        """Return the known stops after a stop; a repeated stop makes no difference."""
        words = f"{by or 'somebody'} ({reason})" if reason else by or "somebody"
        return self.joined(KnownStops({identity: plain(words, WORDS_MAX, lines=False)}))

    def released_by(self, by: str) -> KnownStops:
        """Return the known stops after a release of all of them."""
        who = plain(by or "somebody", WORDS_MAX, lines=False)
        return self.joined(KnownStops({}, dict.fromkeys(self.stops, who)))


def must_tell(before: KnownStops, known: KnownStops, heard: KnownStops) -> bool:
    """Whether a receiver of news has to rebroadcast its own knowledge.

    True if the news stops or releases the receiver, or if the sender's stops and releases leave
    it in another state than the receiver.
    """
    return not bool(before) == bool(known) == bool(heard)


def _of_texts(texts: Iterable[str]) -> dict[str, str]:
    return {identity: words for identity, _, words in (text.partition(" ") for text in texts)}


def _newest(known: Mapping[str, str]) -> dict[str, str]:
    return dict([*known.items()][-KEPT_MAX:])
