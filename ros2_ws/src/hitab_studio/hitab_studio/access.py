"""Access to the page: refused to other sites, and to other machines without the token."""

from __future__ import annotations

import hmac
import ipaddress
import re
import secrets
from collections.abc import Awaitable, Callable, Collection, Mapping, MutableMapping
from typing import Any
from urllib.parse import urlsplit

from fastapi.requests import HTTPConnection
from fastapi.responses import PlainTextResponse, RedirectResponse

from hitab_client import SwarmError

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

COOKIE = "hitab_studio_token"
LOOPBACK_NAMES = frozenset({"localhost", "127.0.0.1", "::1"})


def is_loopback(host: str) -> bool:
    """Whether an address can only be reached from this machine."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


class AccessControl:
    """Filters requests and web sockets before any other code sees them.

    A request from a page of another site carries the ``Origin`` of that site; with DNS rebinding,
    ``Host`` carries the name of that site.

    Args:
        app: the guarded application.
        host: the address that the server listens on.
        token: required once, in the address; "" if the page needs no token.
        allowed: further names of this server, such as the name of a proxy.
        root_path: path under which the proxy serves the page.
    """

    def __init__(
        self,
        app: App,
        host: str = "127.0.0.1",
        token: str = "",
        allowed: Collection[str] = (),
        root_path: str = "",
    ) -> None:
        self._app = app
        self._token = token
        self._allowed = frozenset(name.lower() for name in allowed)
        self._root_path = root_path
        self._names = LOOPBACK_NAMES | {host} | self._allowed
        self._any_name = bool(token) and host in ("0.0.0.0", "::", "")

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on a request, or refuse it."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        root = self._root_path
        if root and not scope["path"].startswith(f"{root}/"):  # the proxy has cut it off
            scope["path"] = f"{root}{scope['path']}"
        scope["root_path"] = root
        asked = HTTPConnection(scope)
        answer: App = self._app
        if problem := self._origin_problem(asked.headers):
            answer = _refusal(scope, 403, problem)
        elif scope["type"] == "http" and self._is_valid(asked.query_params.get("token", "")):
            answer = _set_cookie(self._token)
        elif self._token and not self._is_valid(asked.cookies.get(COOKIE, "")):
            why = "A token is needed: open the address that the studio printed."
            answer = _refusal(scope, 401, why)
        await answer(scope, receive, send)

    def _origin_problem(self, headers: Mapping[str, str]) -> str:
        host = headers.get("host", "")
        name = urlsplit(f"//{host}").hostname or ""
        if not self._any_name and name not in self._names:
            way_out = f"start the studio with --allow-host {name}"
            return f"Unknown host name {name}: open the printed address, or {way_out}."
        origin = urlsplit(headers.get("origin", f"//{host}"))
        if origin.netloc != host and origin.hostname not in self._allowed:
            way_out = f"start the studio with --allow-host {origin.hostname}"
            return (
                f"Requests from other sites are refused. If this is a proxy of yours, {way_out}."
            )
        return ""

    def _is_valid(self, token: str) -> bool:
        return bool(self._token) and hmac.compare_digest(token.encode(), self._token.encode())


def _set_cookie(token: str) -> App:
    """Keep the token in a cookie and open the page without it in the address."""
    welcome = RedirectResponse("./", 303)
    welcome.set_cookie(COOKIE, token, httponly=True, samesite="strict")
    return welcome


def _refusal(scope: Scope, status: int, why: str) -> App:
    async def close(scope: Scope, receive: Receive, send: Send) -> None:
        await send({"type": "websocket.close", "code": 1008, "reason": why[:120]})

    return close if scope["type"] == "websocket" else PlainTextResponse(why, status)


def new_token(host: str, given: str = "") -> str:
    """Return the given token, or a new one if other machines can reach the address.

    Raises:
        SwarmError: if the given token is not valid in a URL.
    """
    if given and re.fullmatch(r"[A-Za-z0-9_-]{8,}", given) is None:
        raise SwarmError("a token needs at least 8 characters, each a letter, a digit, - or _")
    return given or ("" if is_loopback(host) else secrets.token_urlsafe(18))
