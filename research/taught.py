"""What lessons have taught, for comparison."""

from pathlib import Path

from hitab_bringup.libraries.opened_library import open_library


def examples_of(library: Path) -> dict[str, list[tuple]]:
    """Return what was taught, but for the numbers of the world's cycles."""
    return {
        name: [(e.state, e.features, e.next_state, e.kind) for e in automaton.examples]
        for name, automaton in open_library(library).load().items()
    }
