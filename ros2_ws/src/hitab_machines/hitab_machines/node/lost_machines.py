"""The rule by which a machine takes the processes of lost ones over, so that never two do."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Set

from hitab_ros.timing import FOUND_S, PROMPT_S

TAKE_OVER_AFTER_S = PROMPT_S + FOUND_S
"""Silence of a machine, s, after which others take its processes over, if the file says so."""


def to_take_over(
    own: str,
    rescuers: Mapping[str, Set[str]],
    silent: Mapping[str, float],
    hears: Mapping[str, Set[str]],
) -> Iterator[str]:
    """Yield the silent machines whose processes a machine has to start.

    Of a network that is divided, one part at most takes over from another: that with more than
    half of the machines. Of two halves, it is the one for whose machines the other does not stand
    in. Machines count as reached if both hear each other, and as lost if none of these hears them:
    so a single broken connection loses none.

    Args:
        own: the machine that asks.
        rescuers: the machines that take over from each machine of the swarm file, by its name.
        silent: time of silence of each machine that was heard and is silent, s.
        hears: the machines that each machine hears now, of those that are heard.
    """
    machines = rescuers.keys()
    reached = {own} | {n for n in machines & hears.keys() - silent.keys() if own in hears[n]}
    away = machines - reached
    surplus = len(reached) - len(away)
    if surplus < 0 or (surplus == 0 and any(rescuers[name] & away for name in reached)):
        return
    for lost in sorted(away & silent.keys()):
        if silent[lost] < TAKE_OVER_AFTER_S or any(lost in hears[n] for n in reached - {own}):
            continue
        if own == min(reached & rescuers[lost], default=""):
            yield lost
