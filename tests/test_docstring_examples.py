"""The examples in docstrings, run as they stand."""

import doctest
import importlib
from pathlib import Path

SOURCES = Path(__file__).parents[1] / "ros2_ws" / "src"
WITH_EXAMPLES = sorted(
    path.relative_to(SOURCES)
    for path in SOURCES.glob("*/*/**/*.py")
    if path.parts[-2] != "test" and ">>> " in path.read_text()
)


def test_the_examples_of_modules_give_what_they_show():
    failed = {}
    for path in WITH_EXAMPLES:
        module = importlib.import_module(".".join(path.with_suffix("").parts[1:]))
        results = doctest.testmod(module, optionflags=doctest.NORMALIZE_WHITESPACE)
        assert results.attempted, path
        failed[path] = results.failed
    assert [path for path in WITH_EXAMPLES if failed[path]] == []  # shown above
