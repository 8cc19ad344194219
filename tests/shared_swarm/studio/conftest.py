"""One studio and one browser for all files of this folder."""

from collections.abc import Iterator
from typing import Any

import pytest
from browsing import browser, studio

from hitab_bringup.processes.bringing_up import RunningSwarm


@pytest.fixture(scope="package")
def url(three_keepers: RunningSwarm, tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    with studio(tmp_path_factory.mktemp("studio") / "log") as address:
        yield address


@pytest.fixture(scope="package")
def chrome() -> Iterator[Any]:
    with browser() as started:
        yield started


@pytest.fixture(scope="package")
def window(chrome: Any) -> Iterator[Any]:
    page = chrome.new_page()
    yield page
    page.close()
