"""A Python file that a user names by its path: a world, and the words of its agents."""

from __future__ import annotations

import sys
import threading
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from traceback import extract_tb
from types import ModuleType

from hitab_core.term import VOCABULARY_NAME, VOCABULARY_NAME_RULE
from hitab_core.texts.errors import VocabularyError

PREFIX = "hitab_file_"


LONG_SECONDS = 5.0
"""Time after which a file is reported as still running, s; definitions alone take less."""


def loaded_file(name: str) -> ModuleType | None:
    """Return the file of this name that this process has loaded, if any."""
    return sys.modules.get(f"{PREFIX}{name}")


def load_file(path: Path) -> ModuleType:
    """Run a file once and return it as a module.

    Raises:
        VocabularyError: if there is no such file, its name is malformed, or it raises.
    """
    path = path.expanduser().resolve()
    if not path.is_file():
        raise VocabularyError(f"{path}: there is no such file; correct the path")
    if VOCABULARY_NAME.match(path.stem) is None:
        raise VocabularyError(
            f'{path}: "{path.stem}" is not a name; {VOCABULARY_NAME_RULE}; rename the file'
        )
    there = loaded_file(path.stem)
    if there is not None and there.__file__ == str(path):
        return there
    spec = spec_from_file_location(f"{PREFIX}{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    sys.modules[spec.name] = module
    warning = (
        f"{path} still runs after {LONG_SECONDS:g} s; what a file does besides defining things "
        'belongs below `if __name__ == "__main__":`. Ctrl-C ends this'
    )
    timer = threading.Timer(LONG_SECONDS, print, [warning], {"file": sys.stderr})
    timer.daemon = True
    timer.start()
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        del sys.modules[spec.name]
        frames = extract_tb(error.__traceback__)
        lines = [frame.lineno for frame in frames if frame.filename == str(path)] or [1]
        line = getattr(error, "lineno", None) or lines[-1]
        place = f"{path}:{line}"
        raise VocabularyError(
            f"{place}: {type(error).__name__}: {error}; correct the file"
        ) from error
    finally:
        timer.cancel()
    return module
