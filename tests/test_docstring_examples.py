"""The examples in docstrings, run as they stand."""

import doctest
import importlib
from pathlib import Path

import pytest

SOURCES = Path(__file__).parents[1] / "ros2_ws" / "src"
WITH_EXAMPLES = sorted(
    path.relative_to(SOURCES)
    for path in SOURCES.glob("*/*/**/*.py")
    if path.parts[-2] != "test" and ">>> " in path.read_text()
)


@pytest.mark.parametrize("path", WITH_EXAMPLES, ids=str)
def test_the_examples_of_a_module_give_what_they_show(path):
    module = importlib.import_module(".".join(path.with_suffix("").parts[1:]))
    results = doctest.testmod(module, optionflags=doctest.NORMALIZE_WHITESPACE)
    assert results.attempted
    assert not results.failed
