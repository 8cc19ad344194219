"""The program `hitab`: says what to install where a part of it is missing."""

from __future__ import annotations

import sys

EXTRAS = {"nicegui": "studio", "PIL": "studio"}
"""Which extra of the distribution brings a module; all others come with ``ros``."""


def main() -> None:
    """Run the command."""
    try:
        from hitab_bringup.main import main as run

        run()
    except ModuleNotFoundError as missing:
        module = (missing.name or "").partition(".")[0]
        if module.startswith("hitab_") and module != "hitab_msgs":
            raise
        from hitab_core import way_to_install

        print(
            f"hitab: the Python module {module} is not installed; "
            f"{way_to_install(EXTRAS.get(module, 'ros'))}",
            file=sys.stderr,
        )
        sys.exit(1)


if __name__ == "__main__":
    main()
