"""The `hitab` command: verbs for training robots, teams and swarms while they run.

Every verb uses only the public topics and services, so any other ROS 2 tool can do the same. Verbs
are declared in `hitab_cli.verbs`; other packages add verbs under the entry-point group
``hitab.verbs`` (a module with ``register(app)``).
"""

from __future__ import annotations

import os
import sys
from importlib import import_module
from importlib.metadata import entry_points
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from hitab_cli.help_pages import make_helpful
from hitab_client import console, interruptions
from hitab_client.connecting.ros_environment import refuse_problems
from hitab_client.terminal.cli_remedies import called
from hitab_core import HitabError, installed_version

VERBS = "hitab.verbs"


class HitabGroup(TyperGroup):
    """Prints errors that a user can fix in one line, and exits with code 130 on Ctrl-C."""

    def invoke(self, ctx: Any) -> Any:
        """Run the user's verb."""
        try:
            return super().invoke(ctx)
        except HitabError as error:
            console.error(error)
            raise typer.Exit(1) from None
        except KeyboardInterrupt:
            console.note("interrupted")
            raise typer.Exit(130) from None
        except BrokenPipeError:
            # The reader of the output, such as `head`, has closed it.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise typer.Exit(0) from None
        except OSError as error:
            if error.filename is None:
                raise
            console.error(f"{error.filename}: {error.strerror}; choose another place for it")
            raise typer.Exit(1) from None

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the user's verb; for a verb of a group, the error names the group."""
        try:
            return super().resolve_command(ctx, args)
        except Exception as error:
            ways = " or ".join(
                f"`{called()} {name} {args[0]}`"
                for name, group in self.commands.items()
                if args[0] in getattr(group, "commands", ())
            )
            if ways:
                error.message = f'No such command "{args[0]}". Did you mean {ways}?'  # type: ignore
            raise


HELP_PANELS = {
    "Begin here": "begin.demo.demo begin.new.new",
    "Swarm": "swarm.swarm.up swarm.swarm.down swarm.status.status swarm.attention.attention "
    "swarm.logs.logs swarm.move.move swarm.recording.record swarm.doctor.doctor swarm.size.size "
    "swarm.policy.policy",
    "Train": "perform.commanding.demonstrate train.driving.drive train.training.train "
    "train.training.start_testing train.training.undo train.training.redo train.training.save "
    "train.training.discard train.questions.questions train.breakpoint.set_breakpoints "
    "swarm.world.back",
    "Perform": "perform.commanding.perform perform.commanding.distribute "
    "perform.commanding.vocabulary perform.perceiving.perceive perform.perceiving.why "
    "perform.evaluate.evaluate perform.evaluate.film "
    "perform.emergency.stop perform.emergency.go perform.emergency.arm",
    "Command": "perform.hierarchy.tree perform.hierarchy.order",
}
"""The verbs by panel of the help, as folder, module and function of `hitab_cli.verbs`.

Verbs without a panel would come before "Begin here"."""

RENAMED = {"start_testing": "test", "set_breakpoints": "break"}
"""Verbs whose functions cannot have their names."""

GROUPS = {
    "swarm.world": "Swarm",
    "train.examples": "Train",
    "train.bootstrap": "Train",
    "train.lesson": "Train",
    "libraries.library": "Perform",
}
"""Panel of each module whose ``app`` is a group of verbs."""

HELP = "Train robots, teams and swarms by demonstration, while they run."


def _say_version(wanted: bool) -> None:
    if wanted:
        console.say(f"hitab {installed_version()}")
        raise typer.Exit


def _hitab(
    context: typer.Context,
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_say_version, is_eager=True, help="Show the version and exit."
        ),
    ] = False,
) -> None:
    """Refuse an environment in which ROS would end the process; `hitab doctor` lists faults."""
    if context.invoked_subcommand != "doctor":
        refuse_problems()


def make_app(wanted: str = "") -> typer.Typer:
    """Return the command with its verbs, including those of other packages.

    Args:
        wanted: if a verb in `HELP_PANELS`, load only that verb, which is faster: a stop is
            urgent.
    """
    app = typer.Typer(
        name="hitab",
        cls=HitabGroup,
        no_args_is_help=True,
        epilog="Begin with `hitab demo`. `hitab VERB --help` describes a verb.",
        rich_markup_mode="rich",
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback(help=HELP)(_hitab)
    alone = f".{wanted} " in f"{' '.join(HELP_PANELS.values())} "
    for panel, places in HELP_PANELS.items():
        for place in places.split():
            module, _, function = place.rpartition(".")
            if alone and function != wanted:
                continue
            name = RENAMED.get(function, function)
            # The command takes no names of robots, and the error explains why.
            names = {"allow_extra_args": name in ("stop", "go")}
            app.command(name, rich_help_panel=panel, context_settings=names)(
                _verb(module, function)
            )
    if not alone:
        _add_groups_and_others(app)
    make_helpful(app)
    return app


def _verb(module: str, name: str) -> Any:
    return getattr(import_module(f"hitab_cli.verbs.{module}_verbs"), name)


def _add_groups_and_others(app: typer.Typer) -> None:
    app.command("begin", hidden=True)(_verb("train.training", "train"))
    for name, panel in GROUPS.items():
        word = name.rpartition(".")[2]
        app.add_typer(_verb(name, "app"), name=word, rich_help_panel=panel, no_args_is_help=True)
    for point in sorted(entry_points(group=VERBS), key=lambda point: point.name):
        point.load().register(app)


def main() -> None:
    """Run the command; on SIGTERM, clean up as on Ctrl-C."""
    interruptions.handle_interruptions()
    try:
        make_app(*sys.argv[1:2])()
    finally:
        interruptions.forget_handled()


if __name__ == "__main__":
    main()
