"""Whether the domains and behaviors that a swarm description names exist."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import entry_points
from pathlib import Path

from hitab_bringup.suggest import did_you_mean
from hitab_bringup.yaml_fields import Fields
from hitab_core.behavior_schema import SUFFIX
from hitab_core.domain import ENTRY_POINT_GROUP, load_domain
from hitab_core.errors import HitabError, has
from hitab_core.use import Use


class Words:
    """Checks words; what is said once for all agents is complained about once.

    Args:
        top: the description's own fields.
    """

    def __init__(self, top: Fields) -> None:
        self._top = top
        self._domains = [point.name for point in entry_points(group=ENTRY_POINT_GROUP)]
        self._said: set[str] = set()

    def _complain(self, fields: Fields, key: str, text: str) -> None:
        """Complain where the word stands: at the agent, or above."""
        if key in fields:
            fields.complain(text, key)
        elif text not in self._said:
            self._said.add(text)
            self._top.complain(text, *([key] if key in self._top else []))

    def check_domain(self, fields: Fields, name: str) -> None:
        """Complain if there is no such domain."""
        if not name:
            self._complain(fields, "domain", f"`domain:` is missing {has(self._domains)}")
        elif name not in self._domains:
            self._complain(
                fields,
                "domain",
                f'no domain "{name}" is installed {has(self._domains)}'
                f"{did_you_mean(name, self._domains)}",
            )

    def check_behavior(
        self, fields: Fields, domain: str, behavior: str, libraries: Sequence[Path]
    ) -> None:
        """Complain if an agent cannot perform a behavior.

        A library in the run folder is not known yet: it is taken to have what is missing, and the
        agent itself complains if it has not.
        """
        try:
            use = Use.parse(behavior)
            if domain not in self._domains or not libraries:
                return
            known = load_domain(domain)
        except HitabError as error:
            self._complain(fields, "behavior", str(error))
            return
        names = {*known.behaviors, *known.automata}
        for folder in libraries:
            names |= {path.name.removesuffix(SUFFIX) for path in folder.glob(f"*{SUFFIX}")}
        if use.name not in names:
            self._complain(
                fields,
                "behavior",
                f'unknown behavior "{use.name}" {has(names)}{did_you_mean(use.name, names)}',
            )
