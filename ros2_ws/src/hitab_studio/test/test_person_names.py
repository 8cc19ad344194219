"""People at the pages have names, which their commands carry."""

import asyncio
import json
from pathlib import Path

from hitab_client.runs.run_folder import state_home
from hitab_client.runs.users import user_name
from hitab_studio.pages.page_view import perform
from hitab_studio.studio import Studio


def test_people_of_one_name_are_told_apart_and_what_is_no_name_is_refused(tmp_path, monkeypatch):
    monkeypatch.setenv("HITAB_HOME", str(tmp_path))

    async def run() -> None:
        studio = Studio(lambda: None)  # type: ignore[arg-type,return-value]
        one, two, three = studio.open("Anna"), studio.open("Anna"), studio.open("An\u202ena")
        assert [one.name, two.name, three.name] == ["Anna", "Anna (2)", user_name()]
        assert two.demonstrator == "Anna", "commands carry the name that was entered"
        for name, why in (("", "Enter"), ("A" * 61, "at most 60"), ("A\0", "control characters")):
            await perform(three, {"do": "name-set", "values": {"demonstrator": name}})
            assert why in three.messages.shown[-1].text
        await perform(three, {"do": "name-set", "values": {"demonstrator": " Anna (2) "}})
        assert three.name == "Anna (2) (2)"

    asyncio.run(run())


def test_a_user_without_a_name_as_in_a_container_gets_one_from_the_id(monkeypatch):
    def nameless() -> str:
        raise KeyError("getpwuid(): uid not found: 12345")

    monkeypatch.setattr("getpass.getuser", nameless)
    monkeypatch.setattr("os.getuid", lambda: 12345)
    monkeypatch.setattr("pwd.getpwuid", lambda _: nameless())
    for name in ("HITAB_HOME", "XDG_STATE_HOME", "HOME"):
        monkeypatch.delenv(name, raising=False)
    assert user_name() == "user_12345"
    assert state_home() == Path("/.local/state/hitab"), "it is looked for, though not there"


def test_the_browser_remembers_the_name_of_its_person(tmp_path, monkeypatch):
    monkeypatch.setenv("HITAB_HOME", str(tmp_path))

    async def run() -> None:
        page = Studio(lambda: None).open()  # type: ignore[arg-type,return-value]
        await perform(page, {"do": "ask", "kind": "name"})
        assert page.dialog["kind"] == "name"
        await perform(page, {"do": "name-set", "values": {"demonstrator": "Änne"}})
        assert (page.demonstrator, page.dialog) == ("Änne", {})
        sent = [json.loads(message) for message in page.outgoing]
        assert {"t": "remember", "name": "demonstrator", "value": "Änne"} in sent

    asyncio.run(run())
