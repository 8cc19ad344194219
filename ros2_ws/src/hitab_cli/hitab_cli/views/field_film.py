"""Films of episodes: the field cycle by cycle, as a moving picture."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hitab_cli.views.field_picture import BALL_SHAPE, draw_moment, shape_of
from hitab_cli.views.plots import check_folder, figure
from hitab_core import HitabError
from hitab_core.library.durable_files import write_durably

if TYPE_CHECKING:
    from hitab_bringup import GameSetup
    from hitab_client import Thing
    from hitab_client.terminal.console import Advance
    from hitab_world import World

SUFFIXES = (".gif", ".png", ".webp")
INCHES = 3.6  # width of the drawing, for the size of text and lines
TITLE_INCHES = 0.25  # inches, above the field
TRAIL = 10  # number of moments of the ball's path


@dataclass(frozen=True)
class Filmed:
    """A part of an episode.

    Attributes:
        world: the filmed world.
        moments: everything in the world, cycle by cycle.
        begin: time of the first moment, s.
        ended: outcome of the episode if it ended within the film; empty if it continued.
    """

    world: World
    moments: Sequence[Sequence[Thing]]
    begin: float
    ended: str

    @property
    def seconds(self) -> float:
        """The length of the film, s."""
        return len(self.moments) * self.world.cycle_seconds


def check_film(path: Path) -> None:
    """Check that a film can be saved at a path.

    Raises:
        HitabError: if it cannot; names the reason and a way out.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise HitabError(f"{path} cannot be filmed: its name must end with {', '.join(SUFFIXES)}")
    check_folder(path, "filmed")


def film(game: GameSetup, episode: int, begin: float, seconds: float) -> Filmed:
    """Play an episode and keep a part of it.

    Args:
        game: game whose world is reset and played.
        episode: number of the episode in the run.
        begin: beginning of the part, s.
        seconds: length of the part, s; the film is shorter if the episode ends before.

    Raises:
        HitabError: if the episode ends before the part begins.
    """
    from hitab_world.inprocess import play

    world, players, confer = game
    moments: list[Sequence[Any]] = []
    first = round(begin / world.cycle_seconds)
    last = first + round(seconds / world.cycle_seconds)

    def look() -> None:
        if confer is not None:
            confer()
        if world.episode_cycle >= first:
            moments.append(world.entities())

    (result,) = play(world, players, between=look, cycles_max=last, first=episode)
    if not moments:
        raise HitabError(
            f"episode {episode} ended after {result.seconds:.1f} s; begin the film before that, "
            "or choose another episode"
        )
    return Filmed(world, moments, first * world.cycle_seconds, result.ended)


def draw_film(
    filmed: Filmed, path: Path, advance: Advance, *, pixels: int = 360, speed: float = 1.0
) -> None:
    """Draw a film; the file is written when it is complete.

    Args:
        filmed: the filmed episode.
        path: path of the film; the suffix selects the format.
        advance: called with the number of pictures drawn.
        pixels: width of the pictures.
        speed: speed of the film, as a factor of real time.

    Raises:
        HitabError: if the film cannot be saved.
    """
    from matplotlib.animation import PillowWriter

    check_film(path)
    (width, height), looks = filmed.world.size, filmed.world.looks
    cycle_seconds = filmed.world.cycle_seconds
    drawing, axes = figure(INCHES, INCHES * height / width + TITLE_INCHES)
    drawing.set_layout_engine("none")  # equal in all pictures
    axes.set_position((0.0, 0.0, 1.0, 1.0 - TITLE_INCHES / drawing.get_figheight()))
    rate: Any = speed / cycle_seconds  # pictures per second, not always whole
    writer = PillowWriter(fps=rate)
    try:
        with tempfile.TemporaryDirectory() as folder:
            drawn = Path(folder) / path.name  # the suffix selects the format
            # Not `saving`, which writes an incomplete film when interrupted.
            writer.setup(drawing, str(drawn), dpi=pixels / INCHES)
            for number, moment in enumerate(filmed.moments):
                advance(number, len(filmed.moments), "drawing pictures")
                axes.clear()
                recent = filmed.moments[max(0, number - TRAIL) : number + 1]
                paths = {t.name: recent for t in moment if shape_of(t, looks) == BALL_SHAPE}
                draw_moment(axes, moment, width, height, looks, paths)
                axes.set_axis_off()
                at = filmed.begin + number * cycle_seconds
                axes.set_title(f" {at:.1f} s", fontsize=9, loc="left", y=1.0)
                writer.grab_frame(facecolor="white")
            writer.finish()
            write_durably(path, drawn.read_bytes())
    except OSError as error:
        raise HitabError(f"{path} cannot be filmed: {error}") from None
    advance(len(filmed.moments), len(filmed.moments), "")
