"""The map and the pictures of cameras, as pages ask for them.

A page asks for the next picture once it shows the last one, so that it gets no more than it can
show. What it asks for is listened to; what nobody asks for any more is not.
"""

from __future__ import annotations

import asyncio
import io
import json

import numpy as np
from fastapi import FastAPI, Response
from PIL import Image

from hitab_studio.robots.messages import Grid
from hitab_studio.robots.state import Robots
from hitab_studio.studio import Studio
from hitab_studio.viewing import CAMERA, MAP

NOTHING_NEW = 204
FAST = 1
"""How much a map is compressed: it goes over a fast connection, and others wait."""

OCCUPIED = 255
UNKNOWN = 36
"""Opacities of cells; free ones have none."""


def add_routes(app: FastAPI, studio: Studio) -> None:
    """Add what pages ask for.

    Args:
        app: the server.
        studio: knows the robots.
    """
    made: dict[Grid, bytes] = {}

    @app.get("/robots/camera")
    async def camera(agent: str, after: int = 0) -> Response:
        robots = _robots(studio)
        if agent in robots.robots:
            studio.link.viewing.lease(CAMERA, agent)
        state = robots.of(agent).camera
        if state.picture is None or state.number == after:
            return Response(status_code=NOTHING_NEW)
        return _picture(state.picture.data, state.picture.media_type, state.number)

    @app.get("/robots/map")
    async def grid_map(after: int = 0) -> Response:
        studio.link.viewing.lease(MAP)
        state = _robots(studio).map
        if state.grid is None or state.number == after:
            return Response(status_code=NOTHING_NEW)
        if (png := made.get(state.grid)) is None:
            png = await asyncio.to_thread(png_of, state.grid)
            made.clear()
            made[state.grid] = png
        x, y, yaw = state.grid.place
        place = {"x": x, "y": y, "yaw": yaw, "resolution": state.grid.resolution}
        answer = _picture(png, "image/png", state.number)
        answer.headers["X-Place"] = json.dumps(place)
        return answer


def _robots(studio: Studio) -> Robots:
    return studio.store.known.robots or Robots()


def _picture(data: bytes, media_type: str, number: int) -> Response:
    headers = {
        "X-Number": str(number),
        "Cache-Control": "no-store",
        "X-Content-Type-Options": "nosniff",
    }
    return Response(data, media_type=media_type, headers=headers)


def png_of(grid: Grid) -> bytes:
    """Return a map as a PNG whose pixels are the more opaque the more surely a cell is occupied.

    Its first row is the farthest in y. The page gives it the color of its theme.
    """
    # A palette of opacities alone: what is read of the map need not be calculated with.
    opacity = np.full(256, UNKNOWN, np.uint8)
    opacity[:101] = np.round(np.linspace(0, OCCUPIED, 101))
    image = Image.fromarray(np.ascontiguousarray(grid.cells[::-1]).view(np.uint8))
    image.putpalette(bytes(3 * 256))
    png = io.BytesIO()
    image.save(png, "PNG", transparency=opacity.tobytes(), compress_level=FAST)
    return png.getvalue()
