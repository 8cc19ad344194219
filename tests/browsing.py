"""A person at the studio: a real browser, and what a person finds on the page."""

from __future__ import annotations

import contextlib
import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

ONE, TWO, THREE = "keeper_1", "keeper_2", "keeper_3"
CHROMIUM_NAMES = ("chromium", "chromium-browser", "google-chrome")
QUIET = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)


def chromium() -> str | None:
    """Return the browser that this machine has, if it has one."""
    return next((path for name in CHROMIUM_NAMES if (path := shutil.which(name))), None)


needs_browser = pytest.mark.skipif(
    chromium() is None, reason="there is no Chromium here: apt-get install chromium"
)


@contextlib.contextmanager
def visitor(chrome: Any, url: str, **options: Any) -> Iterator[Person]:
    """Somebody with a browser of their own, of which nothing may complain.

    Args:
        chrome: the browser.
        url: of the page.
        options: of the browser's context, such as ``has_touch=True``.
    """
    context = chrome.new_context(**options)
    someone = Person(context.new_page(), url)
    someone.sees_field()
    yield someone
    context.close()
    assert someone.complaints == []


def away_from_everybody(swarm: Any, distance: float) -> None:
    """Put a keeper on the left of the ball, m, and all others out of the way."""
    keeper = {"x": -distance, "y": 0.0, "heading": 0.0, "vx": 0.0, "vy": 0.0}
    ball = {"x": 0.0, "y": 0.0, "vx": 0.0, "vy": 0.0}
    others = {
        name: {"x": 8.0, "y": y, "vx": 0.0, "vy": 0.0}
        for name, y in ((TWO, 8.0), (THREE, -8.0), ("taker_1", 9.0), ("taker_2", -9.0))
    }
    swarm.world.shown(swarm.world.place({ONE: keeper, "ball": ball, **others}))


def begin(person: Person, name: str, *features: str) -> None:
    """Begin a training of the first keeper, with these features or one.

    Args:
        person: at the page.
        name: of the automaton.
        features: for its decisions to depend on.
    """
    person.click(f"agent-{ONE}")
    person.click("new")
    person.type("new-name", name)
    for feature in features or ("DistanceTo(ball)",):
        person.tick(f"feature-{feature}")
    person.click("begin")
    person.sees("mode", "Training")


def entity(swarm: Any, name: str) -> Any:
    """Return a thing as the world shows it now."""
    swarm.link.spin(0.02)
    return next(e for e in swarm.world.state.entities if e.name == name)


def present_training(swarm: Any, **options: Any) -> Any:
    """Return the training of the first keeper, with what a page has changed meanwhile."""
    swarm.link.spin_until(lambda: False, 0.1)
    return swarm.agents.training(ONE, **options)


def free_port() -> int:
    """Return a port that nobody uses at the moment."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextlib.contextmanager
def studio(log: Path, *arguments: str) -> Iterator[str]:
    """Run `hitab studio` and yield its address."""
    port = free_port()
    command = [sys.executable, "-m", "hitab_cli.main", "studio", "--no-browser"]
    with log.open("w") as output:
        process = subprocess.Popen(
            [*command, "--port", str(port), *arguments],
            stdout=output,
            stderr=output,
            env={k: v for k, v in os.environ.items() if not k.startswith("PYTEST_")},
        )
    try:
        url = f"http://127.0.0.1:{port}/"
        deadline = time.monotonic() + 100
        while not _answers(url):
            if process.poll() is not None or time.monotonic() > deadline:
                raise AssertionError(f"the studio did not start:\n{log.read_text()}")
            time.sleep(0.05)
        yield url
    finally:
        process.terminate()
        process.wait(15)


def _answers(url: str) -> bool:
    try:
        urllib.request.urlopen(url, timeout=5).close()
    except urllib.error.HTTPError:
        return True
    except OSError:
        return False
    return True


class Person:
    """Somebody at the page, who clicks and looks.

    Attributes:
        page: of the browser.
        complaints: errors on the browser's console.
    """

    def __init__(self, page: Any, url: str) -> None:
        self.page = page
        self.complaints: list[str] = []
        page.set_default_timeout(60_000)
        page.on("console", self._hear)
        page.on("pageerror", self._hear_error)
        page.goto(url)
        page.wait_for_selector("#panel-top header")

    def _hear(self, message: Any) -> None:
        if message.type == "error":
            self.complaints.append(message.text)

    def _hear_error(self, error: Any) -> None:
        self.complaints.append(str(error))

    def leave(self) -> None:
        """Leave the page, and nothing in its window for who comes next."""
        self.page.evaluate("localStorage.clear(); sessionStorage.clear()")
        self.page.context.clear_cookies()
        self.page.unroute_all()
        self.page.goto("about:blank")
        self.page.remove_listener("console", self._hear)
        self.page.remove_listener("pageerror", self._hear_error)

    @contextlib.contextmanager
    def _telling(self) -> Iterator[None]:
        """Tell what the page shows instead, if what is expected does not come."""
        from playwright.sync_api import TimeoutError as Late

        try:
            yield
        except Late as late:
            shown = self.page.inner_text("body", timeout=5_000)
            complaints = "\n".join(self.complaints)
            raise AssertionError(f"{late}\nthe page shows:\n{shown}\n{complaints}") from None

    def click(self, name: str) -> None:
        """Click what has this name."""
        with self._telling():
            self.page.click(f'[data-test="{name}"]')

    def type(self, name: str, text: str) -> None:
        """Type into what has this name."""
        with self._telling():
            self.page.fill(f'[data-test="{name}"]', text)

    def tick(self, name: str) -> None:
        """Tick a box."""
        with self._telling():
            self.page.check(f'[data-test="{name}"]', force=True)

    def sees(self, name: str, text: str = "") -> Any:
        """Wait for something to be shown, and for a text in it."""
        suffix = f":has-text('{text}')" if text else ""
        with self._telling():
            return self.page.wait_for_selector(f'[data-test="{name}"]{suffix}')

    def does_not_see(self, name: str) -> None:
        """Wait for something not to be shown any more."""
        with self._telling():
            self.page.wait_for_selector(f'[data-test="{name}"]', state="detached")

    def text(self, name: str) -> str:
        """Return what stands there."""
        return str(self.page.inner_text(f'[data-test="{name}"]'))

    def waits_until(self, true: Callable[[], Any], what: str, seconds: float = 15.0) -> None:
        """Wait for a condition."""
        deadline = time.monotonic() + seconds
        while not true():
            assert time.monotonic() < deadline, what
            self.page.wait_for_timeout(20)

    def on_screen(self, x: float, y: float) -> tuple[float, float]:
        """Return where a place of the field is on the page."""
        box = self.page.locator("canvas#field").bounding_box()
        px, py = self.page.evaluate("([x, y]) => window.studioField.toScreen(x, y)", [x, y])
        return box["x"] + px, box["y"] + py

    def place_of(self, name: str) -> tuple[float, float]:
        """Return where the page shows a thing, m."""
        x, y = self.page.evaluate(
            "name => { const f = window.studioField, i = f.index.get(name);"
            " return [f.now.places[3 * i], f.now.places[3 * i + 1]]; }",
            name,
        )
        return x, y

    def sees_field(self) -> None:
        """Wait for the field to be drawn."""
        self.page.wait_for_function("window.studioField?.now")

    def drags(self, name: str, x: float, y: float) -> None:
        """Drag a thing to a place of the field, once no dialog covers it any more."""
        self.page.wait_for_selector("[data-modal]", state="detached")
        mouse = self.page.mouse
        mouse.move(*self.on_screen(*self.place_of(name)))
        mouse.down()
        mouse.move(*self.on_screen(x, y), steps=4)
        mouse.up()


@contextlib.contextmanager
def browser(*more: str) -> Iterator[Any]:
    """Start the browser, with more arguments."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=chromium(), args=[*QUIET, *more])
        yield started
        started.close()
