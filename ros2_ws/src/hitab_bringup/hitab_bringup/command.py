"""The program `hitab`: says what to install where a part of it is missing."""

from __future__ import annotations

import sys

EXTRAS = {"nicegui": "ros,studio", "PIL": "ros,studio"}
"""Which extras of the distribution bring a module; all others come with ``ros``."""


def main() -> None:
    """Run the command."""
    try:
        from hitab_bringup.main import main as run

        run()
    except ModuleNotFoundError as missing:
        module = (missing.name or "").partition(".")[0]
        if module.startswith("hitab_") and module != "hitab_msgs":
            raise
        print(
            f'hitab: the Python module {module} is not installed; pip install "hitab['
            f'{EXTRAS.get(module, "ros")}]", or set up the ROS 2 workspace that has it',
            file=sys.stderr,
        )
        sys.exit(1)


if __name__ == "__main__":
    main()
