"""The keys of a file with several behaviors."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, Field

from hitab_core.library.yaml_models import NONE_IS_EMPTY, Format, Record


def _some(files: dict[str, str]) -> dict[str, str]:
    if not files:
        raise ValueError("holds no behavior; export it again")
    return files


class BundleFile(Record):
    """Behavior files from one file.

    Attributes:
        domain: name of the domain in which they were trained.
        digest: digest of the texts.
        texts: texts of the files, by behavior name, each after its parts.
    """

    format: Format = 1
    domain: str
    digest: str
    texts: Annotated[dict[str, str], NONE_IS_EMPTY, AfterValidator(_some)] = Field(alias="files")
