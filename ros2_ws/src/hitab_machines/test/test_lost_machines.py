"""Of the machines of a divided network, never two take over from each other."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from hitab_machines.node.lost_machines import to_take_over

Links = set[tuple[str, str]]


def taken(rescuers: dict[str, set[str]], hearing: Links) -> set[tuple[str, str]]:
    """Return who takes over from whom, if each hears the others as given, and nobody else."""
    hears = {a: {b for x, b in hearing if x == a} for a in rescuers}
    found = set()
    for own in rescuers:
        silent = {name: math.inf for name in rescuers if name not in {own, *hears[own]}}
        heard = {name: hears[name] for name in hears[own]}
        found |= {(own, lost) for lost in to_take_over(own, rescuers, silent, heard)}
    return found


def parts(*groups: str) -> Links:
    return {(a, b) for group in groups for a in group for b in group if a != b}


ALL = {"a": {"b", "c"}, "b": {"a", "c"}, "c": {"a", "b"}}


def test_of_three_machines_the_two_that_hear_each_other_take_over_and_the_third_does_not():
    assert taken(ALL, parts("ab", "c")) == {("a", "c")}
    assert taken(ALL, parts("a", "bc")) == {("b", "a")}
    assert taken(ALL, parts("a", "b", "c")) == set()


def test_a_connection_between_two_that_a_third_one_hears_loses_nobody():
    assert taken(ALL, parts("ac", "bc")) == set()
    assert taken(ALL, parts("ab", "bc", "ac") - {("a", "b")}) == set()


def test_of_two_machines_only_the_one_that_the_file_names_takes_over():
    assert taken({"a": set(), "b": {"a"}}, parts("a", "b")) == {("a", "b")}
    assert taken({"a": {"b"}, "b": set()}, parts("a", "b")) == {("b", "a")}
    assert taken({"a": {"b"}, "b": {"a"}}, parts("a", "b")) == set()


def test_halves_take_over_only_if_the_file_names_one_direction():
    one_way = {"a": set(), "b": set(), "c": {"a"}, "d": {"b"}}
    assert taken(one_way, parts("ab", "cd")) == {("a", "c"), ("b", "d")}
    assert taken({**one_way, "a": {"d"}}, parts("ab", "cd")) == set()


NAMES = st.lists(st.sampled_from("abcde"), min_size=2, unique=True)


@given(data=st.data(), names=NAMES)
def test_never_two_take_over_from_each_other_whoever_hears_whom(data, names):
    rescuers = {n: data.draw(st.sets(st.sampled_from(names))) - {n} for n in names}
    pairs = [(a, b) for a in names for b in names if a != b]
    found = taken(rescuers, data.draw(st.sets(st.sampled_from(pairs))))
    losers = {lost for _, lost in found}
    assert len(losers) == len(found), "one takes over"
    assert losers.isdisjoint(taker for taker, _ in found)
