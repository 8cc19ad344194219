"""Access to the page: refused to other sites, and to other machines without the token."""

from __future__ import annotations

import hmac
import ipaddress
import re
import secrets
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs, urlsplit

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

    For a page of another site, the browser sends that site's ``Origin``. With DNS rebinding,
    ``Host`` has the other site's name.

    Args:
        app: the guarded application.
        host: the address that the server listens on.
        token: required once, in the address; "" if none is needed.
    """

    def __init__(self, app: App, host: str = "127.0.0.1", token: str = "") -> None:
        self._app = app
        self._token = token
        self._names = LOOPBACK_NAMES | {host}
        self._any_name = bool(token) and host in ("0.0.0.0", "::", "")

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on a request, or refuse it."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        headers = {k.decode("latin-1"): v.decode("latin-1") for k, v in scope["headers"]}
        problem = self._foreign(headers)
        if problem:
            await _refuse(scope, send, 403, problem)
            return
        if not self._token:
            await self._app(scope, receive, send)
            return
        given = parse_qs(scope.get("query_string", b"").decode("latin-1")).get("token", [""])[0]
        if self._is_right(given) and scope["type"] == "http":
            await _welcome(scope, send, given)
        elif self._is_right(_cookie(headers)):
            await self._app(scope, receive, send)
        else:
            await _refuse(
                scope, send, 401, "A token is needed: open the address that the studio printed."
            )

    def _foreign(self, headers: MutableMapping[str, str]) -> str:
        host = headers.get("host", "")
        name = urlsplit(f"//{host}").hostname or ""
        if not self._any_name and name not in self._names:
            return f"This page is not called {name}: open it by the address that was printed."
        origin = headers.get("origin")
        if origin is not None and urlsplit(origin).netloc != host:
            return "Requests from other sites are refused."
        return ""

    def _is_right(self, token: str) -> bool:
        return hmac.compare_digest(token.encode(), self._token.encode())


def _cookie(headers: MutableMapping[str, str]) -> str:
    cookies: SimpleCookie = SimpleCookie()
    try:
        cookies.load(headers.get("cookie", ""))
    except CookieError:
        return ""
    return cookies[COOKIE].value if COOKIE in cookies else ""


async def _welcome(scope: Scope, send: Send, token: str) -> None:
    """Keep the token in a cookie and open the page without it in the address."""
    cookie = f"{COOKIE}={token}; Path=/; HttpOnly; SameSite=Strict"
    headers = [(b"location", b"/"), (b"set-cookie", cookie.encode())]
    await send({"type": "http.response.start", "status": 303, "headers": headers})
    await send({"type": "http.response.body", "body": b""})


async def _refuse(scope: Scope, send: Send, status: int, why: str) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1008, "reason": why[:120]})
        return
    headers = [(b"content-type", b"text/plain; charset=utf-8")]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": why.encode()})


def new_token(host: str, given: str = "") -> str:
    """Return the token for an address: the given one, or a new one if one is needed.

    Raises:
        SwarmError: if the given one is not valid in an address.
    """
    if given and re.fullmatch(r"[A-Za-z0-9_-]{8,}", given) is None:
        raise SwarmError("a token needs at least 8 characters, each a letter, a digit, - or _")
    return given or ("" if is_loopback(host) else secrets.token_urlsafe(18))
