"""Pages share one node and one server: none of them stops, or misleads, another."""

import asyncio
import dataclasses
import errno
import threading
import time
from collections.abc import Awaitable, Callable
from typing import Any

import pytest

from hitab_client.errors import SwarmError
from hitab_client.recording import bag_file
from hitab_studio.actions import REGISTERED_ACTIONS
from hitab_studio.pages.page_view import RequestQueue
from hitab_studio.studio import Studio

SECONDS = 60.0


async def until(true: Callable[[], Any], what: str) -> None:
    deadline = time.monotonic() + SECONDS
    while not true():
        assert time.monotonic() < deadline, what
        await asyncio.sleep(0.005)


def in_the_server(find: Callable[[], Any], term: Callable[[Studio], Awaitable[None]]) -> None:
    """Run a studio, and call `term` with it in the server's loop."""

    async def run() -> None:
        studio = Studio(find)
        await studio.start()
        try:
            await until(lambda: studio.present.frame, "the field is shown")
            await term(studio)
        finally:
            await studio.stop()

    asyncio.run(asyncio.wait_for(run(), 3 * SECONDS))


def waiting(released: threading.Event) -> Callable[[Any], Any]:
    """Return a request that waits for a message, as all do."""

    async def asked(swarm: Any) -> str:
        assert await swarm.link.until(released.is_set, 2 * SECONDS), "it was not released"
        return "done"

    return asked


async def at_once(swarm: Any) -> str:
    return "at once"


# -- questions do not stop each other -------------------------------------------------------


def test_while_one_page_waits_for_an_answer_the_field_moves_and_others_get_theirs(stand_in):
    """A request that spins the node itself would block the stream and all other requests."""

    async def term(studio: Studio) -> None:
        one, two, released = studio.open(), studio.open(), threading.Event()
        waits = asyncio.create_task(one.ask(waiting(released)))
        await until(lambda: one.busy, "it has begun")
        before = studio.present.frames
        await until(lambda: studio.present.frames > before + 10, "the field stands still")
        answer = await asyncio.wait_for(two.ask(at_once), SECONDS)
        assert answer == "at once"
        assert not waits.done()
        released.set()
        assert await asyncio.wait_for(waits, SECONDS) == "done"

    in_the_server(lambda: stand_in.target, term)


def test_what_was_asked_of_a_swarm_that_goes_down_ends_with_the_reason(stand_in):
    """Otherwise the page would be busy until the timeout of the request."""
    target = stand_in.target

    async def term(studio: Studio) -> None:
        nonlocal target
        page, other = studio.open(), studio.open()
        waits = asyncio.create_task(page.ask(waiting(threading.Event()), "keeper_1"))
        too = asyncio.create_task(other.ask(waiting(threading.Event())))
        await until(lambda: page.busy and other.busy, "both were asked for")
        target = dataclasses.replace(target, start=2)
        for asked in (waits, too):
            with pytest.raises(SwarmError, match=r'"stand_in" was stopped, .* check whether'):
                await asyncio.wait_for(asked, SECONDS)
        assert not page.busy
        assert await asyncio.wait_for(page.ask(at_once), SECONDS) == "at once"

    in_the_server(lambda: target, term)


def test_what_blocks_for_minutes_has_a_thread_and_a_node_and_ends_with_its_swarm(stand_in):
    target = stand_in.target

    async def term(studio: Studio) -> None:
        nonlocal target
        begun = threading.Event()

        def job(swarm: Any) -> None:
            assert swarm.agents.await_agent("keeper_1").agent == "keeper_1"
            begun.set()
            swarm.link.spin_until(lambda: False, SECONDS)

        doing = asyncio.create_task(studio.link.do(job))
        await until(begun.is_set, "it has begun")
        before = studio.present.frames
        await until(lambda: studio.present.frames > before + 10, "the field stands still")
        target = dataclasses.replace(target, start=2)
        with pytest.raises(SwarmError, match=r'"stand_in" was stopped, .* check whether'):
            await asyncio.wait_for(doing, SECONDS)

    in_the_server(lambda: target, term)


@pytest.mark.parametrize("error", [ValueError, StopIteration, SystemError])
def test_whatever_a_question_raises_reaches_its_page_and_ends_nothing(stand_in, error):
    async def term(studio: Studio) -> None:
        page, other = studio.open(), studio.open()

        async def mistaken(swarm: Any) -> None:
            raise error("a mistake")

        with pytest.raises(Exception, match=r"a mistake|raised StopIteration"):
            await asyncio.wait_for(page.ask(mistaken), SECONDS)
        before = studio.present.frames
        await until(lambda: studio.present.frames > before, "the field stands still")
        assert await asyncio.wait_for(other.ask(at_once), SECONDS) == "at once"

    in_the_server(lambda: stand_in.target, term)


def test_a_swarm_that_cannot_be_found_out_for_a_moment_is_found_later(stand_in):
    """The search for the swarm reads files: an error would end the link for good."""
    failing, once = threading.Event(), iter([True])

    def find() -> Any:
        if next(once, False) or failing.is_set():
            raise PermissionError("another user's run folder")
        return stand_in.target

    async def term(studio: Studio) -> None:
        page = studio.open()
        failing.set()
        await until(lambda: any("run folder" in m.text for m in page.messages.shown), "no message")
        before = studio.present.frames
        await until(lambda: studio.present.frames > before, "the field stands still")

    in_the_server(find, term)


def test_an_agent_that_answers_nonsense_is_told_to_the_pages_that_look_at_it(stand_in):
    """Otherwise the pages would show old values for ever, without a reason."""
    stand_in.nonsense = True

    async def term(studio: Studio) -> None:
        looks, other = studio.open(), studio.open()
        await until(lambda: studio.known.answers("keeper_2"), "it is there")
        other.look_at("keeper_1")
        looks.look_at("keeper_2")
        await until(lambda: other.watched.vocabulary.features, "the other agent answers")
        await until(lambda: looks.messages.shown, "no message")
        assert (
            "The answer of keeper_2 about vocabulary cannot be read"
            in looks.messages.shown[0].text
        )
        assert not other.messages.shown
        before = studio.present.frames
        await until(lambda: studio.present.frames > before, "the field stands still")

    in_the_server(lambda: stand_in.target, term)


def test_a_recording_for_which_there_is_no_room_ends_and_its_page_is_told(
    stand_in, monkeypatch, tmp_path
):
    """Otherwise the error would end the callback and the node, without a reason."""

    class Full(bag_file.Writer):
        def add_message(self, *_: Any, **__: Any) -> None:
            raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(bag_file, "Writer", Full)

    async def term(studio: Studio) -> None:
        page, other = studio.open(), studio.open()
        path = str(tmp_path / "run.mcap")
        studio.link.observer.start_recording(path, page.id)
        await until(lambda: studio.known.recording == path, "it has begun")
        await until(lambda: page.messages.shown, "no message")
        assert "run.mcap ends here: No space left" in page.messages.shown[0].text
        await until(lambda: not studio.known.recording, "it has ended")
        assert not other.messages.shown
        before = studio.present.frames
        await until(lambda: studio.present.frames > before, "the field stands still")

    in_the_server(lambda: stand_in.target, term)


# -- requests of a page ---------------------------------------------------------------------


def test_what_was_begun_when_a_page_goes_is_done_to_its_end_and_what_waits_is_not(monkeypatch):
    """Otherwise others could take the agent in the middle of a request."""
    begun, released, done = asyncio.Event(), asyncio.Event(), []

    async def first(page: Any, data: Any) -> None:
        page.hold("keeper_1")
        begun.set()
        await released.wait()
        done.append("first")

    async def second(page: Any, data: Any) -> None:
        done.append("second")

    monkeypatch.setitem(REGISTERED_ACTIONS, "first", first)
    monkeypatch.setitem(REGISTERED_ACTIONS, "second", second)

    async def run() -> None:
        studio, requests = Studio(lambda: None), RequestQueue()  # type: ignore[arg-type,return-value]
        page = studio.open()
        performing = asyncio.create_task(requests.perform(page, lambda: None))
        requests.add({"do": "first"})
        requests.add({"do": "second"})
        await begun.wait()
        requests.close()
        released.set()
        await asyncio.wait_for(performing, SECONDS)
        assert done == ["first"]
        assert studio.held == {"keeper_1": page}
        studio.close(page)
        assert not studio.held

    asyncio.run(run())


def asked_twice(monkeypatch: Any, name: str, *wanted: Any) -> list[Any]:
    """Return the handled requests of a page that sends several during the first one."""
    done: list[Any] = []

    async def run() -> None:
        begun = asyncio.Event()

        async def do(page: Any, data: Any) -> None:
            begun.set()
            done.append(data)
            await asyncio.sleep(0)

        monkeypatch.setitem(REGISTERED_ACTIONS, name, do)
        studio, requests = Studio(lambda: None), RequestQueue()  # type: ignore[arg-type,return-value]
        performing = asyncio.create_task(requests.perform(studio.open(), lambda: None))
        requests.add(wanted[0])
        await begun.wait()
        for data in wanted[1:]:
            requests.add(data)
        await until(lambda: not requests.waiting, "all is done")
        requests.close()
        await performing

    asyncio.run(run())
    return done


def test_what_is_asked_again_before_its_answer_is_done_once(monkeypatch):
    save, other = {"do": "save", "values": {"name": "A"}}, {"do": "save", "values": {"name": "B"}}
    assert asked_twice(monkeypatch, "save", save, save, other, other) == [save, other]
    assert asked_twice(monkeypatch, "save", save, {**other, "again": True}) == [save]
    stop = {"do": "command", "behavior": "Stop", "seen": 7}
    later = {**stop, "seen": 8}
    assert asked_twice(monkeypatch, "command", stop, later) == [stop], (
        "the world went on meanwhile"
    )


def test_what_is_asked_again_after_something_else_is_done_again(monkeypatch):
    """Otherwise a hurried demonstrator's commands would be lost during the first one."""
    go, stop = ({"do": "command", "behavior": name} for name in ("GoFast", "Stop"))
    assert asked_twice(monkeypatch, "command", go, stop, go, stop) == [go, stop, go, stop]


def test_what_did_nothing_when_the_page_was_drawn_is_tried_after_what_it_does_not_show(
    monkeypatch,
):
    """Otherwise Undo right after the first command would find nothing to undo."""
    go, off = {"do": "it"}, {"do": "it", "more": 1, "off": "There is nothing to undo."}
    assert asked_twice(monkeypatch, "it", go, off) == [go, {"do": "it", "more": 1}]
    requests = RequestQueue()
    requests.add(off)
    assert requests.waiting == [{"do": "why", "reason": "There is nothing to undo."}]


def test_a_step_is_done_as_often_as_it_is_clicked(monkeypatch):
    step = {"do": "step", "cycles": "1"}
    assert asked_twice(monkeypatch, "step", step, step, {**step, "again": True}) == [step] * 3


def test_what_is_no_wish_at_all_is_dropped(monkeypatch):
    """A page may send anything over its socket, which must not end the handling of requests."""
    step = {"do": "step"}
    assert asked_twice(monkeypatch, "step", step, None, 7, ["do"], "step", step) == [step] * 2
