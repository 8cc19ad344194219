"""Texts that hold numbers say them in plain English."""

from hitab_core.wording import quantity

"""Verbs, and what is counted only where it is too much."""


def test_one_thing_is_in_the_singular():
    assert quantity(1, "example") == "1 example"
    assert quantity(0, "example") == "0 examples"
    assert quantity(2, "process", "processes") == "2 processes"
    assert quantity(1, "process", "processes") == "1 process"
