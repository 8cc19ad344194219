"""The program `hitab`, which reports missing parts and how to install them."""

from __future__ import annotations

import os
import shlex
import shutil
import sys

PROGRAM = "hitab"
EXTRAS = {"nicegui": "studio", "PIL": "studio"}
"""Extra of the distribution that contains a module; all others are in ``ros``."""


def main() -> None:
    """Run the command."""
    # Arrays are small: numpy's threads would only prolong the start.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Printed commands can be copied even if the environment is not activated.
    if os.path.basename(sys.argv[0]) == PROGRAM and shutil.which(PROGRAM) is None:
        os.environ.setdefault("HITAB_CALLED_AS", shlex.quote(sys.argv[0]))
    try:
        from hitab_cli.main import main as run

        run()
    except KeyboardInterrupt:  # while importing; later, the command handles it
        exec("")  # see hitab_client.terminal.interruptions.forget_handled
        print("interrupted", file=sys.stderr)
        sys.exit(130)
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
