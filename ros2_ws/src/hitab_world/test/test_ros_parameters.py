"""The figures of a world as parameters of its node: declared, read, and refused by name."""

from contextlib import ExitStack
from dataclasses import dataclass

import pytest

from hitab_core.texts.errors import HitabError
from hitab_ros.nodes.spinning import make_node, spinner
from hitab_world.node.ros_parameters import declare_parameters
from hitab_world.parameters import Parameters


@dataclass(frozen=True)
class PuddleParameters(Parameters):
    WORLD = "puddle"

    width: float = 5.0
    leaves: int = 3
    frozen: bool = False


@dataclass(frozen=True)
class Place:
    host: str = "here"


@pytest.fixture
def node_given():
    """Make a node that is given figures on the command line: ``node_given("width:=3.0")``."""
    with ExitStack() as running:

        def make(*figures):
            given = [argument for figure in figures for argument in ("-p", f"parameters.{figure}")]
            spinning = running.enter_context(spinner(["--ros-args", *given]))
            node = make_node("puddle")
            spinning.executor.add_node(node)
            return node

        yield make


def test_several_dataclasses_give_the_figures_of_one_world(node_given):
    node = node_given("host:=there", "leaves:=7")
    assert declare_parameters(node, Place, PuddleParameters) == [
        Place("there"),
        PuddleParameters(leaves=7),
    ]


@pytest.mark.parametrize(
    ("figure", "told"),
    [
        ("width:=-1.0", "width is -1.0; it must be above 0"),
        ("widht:=3.0", r'this world has no parameter "widht" \(known: frozen, leaves, width. Did'),
        (
            "width:=wide",
            'the parameter "parameters.width" is the text "wide"; it must be such as 5.0',
        ),
        ("leaves:=2.5", 'the parameter "parameters.leaves" is 2.5; it must be such as 3'),
    ],
)
def test_what_cannot_be_is_refused_by_name(node_given, figure, told):
    with pytest.raises(HitabError, match=told):
        declare_parameters(node_given(figure), PuddleParameters)
