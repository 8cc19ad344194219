"""Texts that hold numbers say them in plain English."""

from hitab_core.wording import LONG, gist, quantity

"""Verbs, and what is counted only where it is too much."""


def test_one_thing_is_in_the_singular():
    assert quantity(1, "example") == "1 example"
    assert quantity(0, "example") == "0 examples"
    assert quantity(2, "process", "processes") == "2 processes"
    assert quantity(1, "process", "processes") == "1 process"


def test_the_gist_of_a_long_text_says_where_the_rest_is():
    what = "a" * LONG
    text = f"{what}; bring it back with `hitab library restore A 1 -l lib`"
    assert gist(text) == f"{what}; see `hitab library check`"
    assert gist(f"{what}; call the doctor") == f"{what}; call the doctor"
    taken_out = f"{what}; train it with `hitab train AGENT A`, or use `hitab library import`"
    assert gist(taken_out) == taken_out, "`hitab library check` does not tell of it"
    assert gist("short; see `hitab library list`") == "short; see `hitab library list`"
