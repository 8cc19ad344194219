"""The page of topics and services names what there is."""

import re

import pytest
from hitab_msgs import msg, srv
from mentions import ROOT

from hitab_core.operations import OPERATIONS

PAGE = (ROOT / "docs/topics.md").read_text()
ROWS = [[cell.strip() for cell in line.split("|")[1:-1]] for line in PAGE.splitlines() if line]


def quoted(cell: str) -> list[str]:
    return re.findall("`([^`]+)`", cell)


@pytest.mark.parametrize("name", OPERATIONS)
def test_it_has_each_operation_with_its_fields(name: str) -> None:
    (row,) = [row for row in ROWS if len(row) == 4 and name in quoted(row[0])]
    assert OPERATIONS[name].__name__ in row[1].split(", ")
    assert quoted(row[2]) == list(OPERATIONS[name].own_fields())


def test_it_has_each_field_of_an_agents_status() -> None:
    section = PAGE[PAGE.index("### The status") : PAGE.index("### Commands that come late")]
    kinds = msg.AgentStatus, msg.TrainingStatus, msg.Caution, msg.OrderStatus
    known = {name for kind in kinds for name in kind.get_fields_and_field_types()}
    assert known <= set(quoted(section))


def test_the_types_in_its_examples_have_the_names_of_their_services() -> None:
    asked = re.findall(r"ros2 service call \S*?/(\w+) hitab_msgs/srv/(\w+)", PAGE)
    assert len(asked) > 8
    for name, kind in asked:
        assert hasattr(srv, kind)
        if name in OPERATIONS:
            assert OPERATIONS[name].__name__ == kind
