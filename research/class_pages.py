"""Measures a studio at which a class trains: one page and one robot for each person.

One world with as many agents as people runs in real time. Each person has a page in Chromium,
trains an agent and presses a key every two seconds, taking turns. Measured is the time from the
key until the page shows the example, inside the page, and the CPU of the studio and of all else.

Browsers on the studio's machine draw twenty fields, which a class does elsewhere: with ``--still``
they draw twice a second, which leaves the time to the studio.

    scripts/python research/class_pages.py --pages 1,5,10,20 --still

Measured on 2026-11-26 on two cores, browser and studio together, for 40 s:

    pages  keys  answered  ms, median  ms, 95 %  studio: cores, MB  browser: cores
    1        21        21         146       234        0.09, 121             0.15
    5       101       101         284       368        0.30, 128             0.77
    10      201       178         954      1864        0.30, 140             1.38
    20      225        42        2378      9538        0.21, 158             1.63

With twenty, the browser has no time left to send keys and to show answers, and the studio waits
for it. With a browser for each person on another machine the studio was not measured.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from statistics import median, quantiles
from typing import Annotated, Any

import psutil  # type: ignore[import-untyped]
import typer
from playwright.sync_api import Page
from rich.console import Console
from rich.table import Table

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

from browsing import browser, studio

HITAB = (sys.executable, "-m", "hitab_cli.main")
ALL_IN_FRONT = ("--disable-backgrounding-occluded-windows", "--disable-renderer-backgrounding")
"""Pages behind others would be slowed down."""

STILL = "window.requestAnimationFrame = draw => setTimeout(() => draw(performance.now()), 500)"
TIMED = """
() => {
  const shown = () => document.querySelector('[data-test="counts"]')?.innerText;
  let pressed, before;
  window.answered = [];
  document.addEventListener("keydown", () => { pressed = performance.now(); before = shown(); },
                            true);
  new MutationObserver(() => {
    if (pressed === undefined || shown() === before) return;
    window.answered.push(performance.now() - pressed);
    pressed = undefined;
  }).observe(document.body, { childList: true, characterData: true, subtree: true });
}
"""


@dataclass(frozen=True)
class Used:
    """CPU, s, and memory, MB, that processes have used."""

    cpu: float
    memory: float

    @staticmethod
    def by(*parents: psutil.Process) -> Used:
        """Return it of processes and their children; memory that they share counts once."""
        found = {p for parent in parents for p in [parent, *parent.children(recursive=True)]}
        cpu = sum(sum(process.cpu_times()[:2]) for process in found)
        return Used(cpu, sum(process.memory_full_info().pss for process in found) / 1e6)


@dataclass(frozen=True)
class Figures:
    """CPU is in cores, memory in MB."""

    pages: int
    keys: int
    answered: int
    ms_median: float
    ms_95: float
    studio_cpu: float
    studio_memory: float
    swarm_cpu: float
    browser_cpu: float


SWARM = """\
swarm: hall
domain: foraging
world:
  kind: foraging
  pace: realtime
  parameters: {{foragers: {0}, obstacles: 0, width: 40.0, height: 40.0, duration: 100000.0}}
agents:
  forager: {{count: {0}, per_process: 10}}
"""


@contextmanager
def swarm(agents: int, folder: Path) -> Iterator[psutil.Process]:
    """Run a world with so many agents; yields the process above all of them."""
    (folder / "hall.yaml").write_text(SWARM.format(agents))
    subprocess.run([*HITAB, "up", "hall.yaml"], cwd=folder, check=True)
    try:
        record = json.loads((folder / "home/hall/run.json").read_text())
        yield psutil.Process(record["supervisor"])
    finally:
        subprocess.run([*HITAB, "down"], cwd=folder, check=True)


@contextmanager
def person(chrome: Any, url: str, number: int, still: bool) -> Iterator[Page]:
    """Open a page and begin to train an agent."""
    context = chrome.new_context(viewport={"width": 1280, "height": 800})
    cookie: Any = {"name": "hitab_demonstrator", "value": f"Student%20{number}", "url": url}
    context.add_cookies([cookie])
    if still:
        context.add_init_script(STILL)
    page = context.new_page()
    page.set_default_timeout(90_000)
    page.goto(url)
    page.click(f'[data-test="agent-forager_{number}"]')
    page.click('[data-test="new"]')
    page.fill('[data-test="new-name"]', "Shuttle")
    page.check('[data-test="feature-HoldsABox"]', force=True)
    page.uncheck('[data-test="new-pause"]', force=True)
    page.click('[data-test="begin"]')
    page.wait_for_selector('[data-test="counts"]')
    page.evaluate(TIMED)
    yield page
    context.close()


def measure(chrome: Any, pages: int, seconds: float, still: bool) -> Figures:
    """Have so many people train."""
    driver = psutil.Process()  # whose children the browser's processes are
    with tempfile.TemporaryDirectory() as temporary, ExitStack() as stack:
        folder = Path(temporary)
        os.environ["HITAB_HOME"] = str(folder / "home")
        runner = stack.enter_context(swarm(pages, folder))
        url = stack.enter_context(studio(folder / "studio.log"))
        (server,) = (child for child in driver.children() if "studio" in child.cmdline())
        people = []
        for number in range(1, pages + 1):
            people.append(stack.enter_context(person(chrome, url, number, still)))
            Console(stderr=True).print(f"page {number} is open")
        time.sleep(3.0)

        def used() -> list[Used]:
            all_of_us = Used.by(driver)
            ours = Used.by(server)
            return [ours, Used.by(runner), Used(all_of_us.cpu - ours.cpu, 0.0)]

        before, begun, keys = used(), time.monotonic(), 0
        while (now := time.monotonic() - begun) < seconds:
            turn, who = divmod(keys, pages)
            due = 2.0 * turn + 2.0 * who / pages
            if due > now:
                people[who].wait_for_timeout(1000 * (due - now))
            people[who].keyboard.press("3" if turn % 2 else "1")
            keys += 1
        took, after = time.monotonic() - begun, used()
        people[0].wait_for_timeout(3000)
        answers = [ms for page in people for ms in page.evaluate("window.answered")]
    studio_cpu, swarm_cpu, browser_cpu = (
        (a.cpu - b.cpu) / took for a, b in zip(after, before, strict=True)
    )
    return Figures(
        pages=pages,
        keys=keys,
        answered=len(answers),
        ms_median=median(answers),
        ms_95=quantiles(answers, n=20)[-1],
        studio_cpu=studio_cpu,
        studio_memory=after[0].memory,
        swarm_cpu=swarm_cpu,
        browser_cpu=browser_cpu,
    )


def main(
    pages: Annotated[str, typer.Option(help="How many, separated by commas.")] = "1,5,10,20",
    seconds: Annotated[float, typer.Option(help="How long keys are pressed.")] = 60.0,
    still: Annotated[bool, typer.Option("--still", help="Draw the fields rarely.")] = False,
) -> None:
    """Measure a studio at which a class trains."""
    os.environ.setdefault("ROS_DOMAIN_ID", "63")
    columns = (
        "pages",
        "keys",
        "answered",
        "ms, median",
        "ms, 95 %",
        "studio, cores",
        "studio, MB",
        "swarm, cores",
        "browser, cores",
    )
    table = Table(*columns)
    for number in map(int, pages.split(",")):
        with browser(*ALL_IN_FRONT) as chrome:
            figures = measure(chrome, number, seconds, still)
        table.add_row(
            *(
                f"{v:.2f}" if isinstance(v, float) and v < 10 else f"{v:.0f}"
                for v in vars(figures).values()
            )
        )
        Console().print(figures)
    Console().print(table)


if __name__ == "__main__":
    typer.run(main)
