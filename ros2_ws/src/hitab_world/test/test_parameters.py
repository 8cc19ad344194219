"""The figures of a world: what cannot be is refused by name, with what it may be."""

import math
from dataclasses import dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hitab_world.parameters import (
    FRACTION,
    NOT_NEGATIVE,
    ParameterError,
    Parameters,
    at_least,
    between,
    one_of,
)


@dataclass(frozen=True)
class PuddleParameters(Parameters):
    WORLD = "puddle"
    LIMITS = {  # noqa: RUF012
        "width": at_least(2.0, "m"),
        "leaves": NOT_NEGATIVE,
        "damping": FRACTION,
        "ducks": between(0, 9),
        "weather": one_of("sun", "rain"),
    }

    width: float = 5.0
    leaves: int = 3
    frogs: int = 1
    ducks: int = 0
    damping: float = 0.5
    weather: str = "sun"
    name: str = ""
    frozen: bool = False


@given(
    st.builds(
        PuddleParameters,
        width=st.floats(2.0, 1e9) | st.integers(2, 9),
        leaves=st.integers(0),
        ducks=st.integers(0, 9),
        damping=st.floats(0.0, 1.0, exclude_min=True, exclude_max=True),
        weather=st.sampled_from(["sun", "rain"]),
        name=st.text(),
        frozen=st.booleans(),
    )
)
def test_figures_come_back_from_their_dictionary(figures):
    assert PuddleParameters.from_dict(figures.as_dict()) == figures


@pytest.mark.parametrize(
    ("figures", "message"),
    [
        ({"width": 1.5}, "width is 1.5; it must be at least 2 m"),
        ({"width": math.nan}, "width is nan; it must be finite"),
        ({"width": -math.inf}, "width is -inf; it must be finite"),
        ({"width": True}, "width is True; it must be a number"),
        ({"width": "wide"}, "width is 'wide'; it must be a number"),
        ({"leaves": -1}, "leaves is -1; it must be a whole number and not be negative"),
        ({"leaves": 2.0}, "leaves is 2.0; it must be a whole number"),
        ({"leaves": True}, "leaves is True; it must be a whole number"),
        ({"frogs": 0}, "frogs is 0; it must be a whole number and be above 0"),
        ({"ducks": 10}, "ducks is 10; it must be a whole number and lie between 0 and 9"),
        ({"damping": 1.0}, "damping is 1.0; it must lie between 0 and 1"),
        ({"weather": "fog"}, "weather is 'fog'; it must be one of: sun, rain"),
        ({"name": 3}, "name is 3; it must be text"),
        ({"frozen": 1}, "frozen is 1; it must be true or false"),
        ({"depth": 1.0}, 'there is no puddle parameter "depth" (known: damping, ducks, frogs, '),
    ],
)
def test_what_cannot_be_is_refused_by_name(figures, message):
    with pytest.raises(ParameterError) as error:
        PuddleParameters.from_dict(figures)
    assert str(error.value).startswith(message)
