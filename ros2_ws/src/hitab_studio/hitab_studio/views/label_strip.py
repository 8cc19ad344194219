"""The strip of an agent's labeled behaviors under the time bar of a recording."""

from __future__ import annotations

from typing import Any

from hitab_core import Domain, Term
from hitab_core.labeling import UNSURE
from hitab_studio.pages.page import Page
from hitab_studio.swarm.received_vocabulary import terms


def strip(page: Page) -> dict[str, Any] | None:
    """Return the strip of the agent; None if there is none."""
    player = page.player
    labels = player.labels if player is not None else None
    if player is None or labels is None or labels.strip.agent != page.agent:
        return None
    palette, whole = page.studio.palette, player.recording.seconds or 1.0
    colors = {b: palette.color(b) for b in labels.strip.behaviors}
    spans = [
        {
            "left": 100 * (span.begin + labels.offset) / whole,
            "width": 100 * (span.end - span.begin) / whole,
            "color": colors[span.behavior],
            "unsure": span.sure < UNSURE and not span.corrected,
            "odd": span.unexplained > 0,
            "said": _span_text(span, labels.offset),
            "behavior": span.behavior,
        }
        for span in labels.strip.spans
    ]
    chosen = spans[labels.chosen] if 0 <= labels.chosen < len(spans) else None
    return {"spans": spans, "colors": colors, "chosen": chosen, "number": labels.chosen}


def _span_text(span: Any, offset: float) -> str:
    sure = "as you said" if span.corrected else f"{100 * span.sure:.0f} % sure"
    odd = f", {span.unexplained} of {span.moments} moments unexplained" if span.unexplained else ""
    begin, end = span.begin + offset, span.end + offset
    return f"{begin:.1f} to {end:.1f} s: {span.behavior}, {sure}{odd}"


def words(domain: Domain) -> dict[str, Any]:
    """Return the features and behaviors of a domain to choose from."""
    behaviors = {name: b for name, b in domain.behaviors.items() if not b.numbers}
    return {"features": _bound(domain, domain.features), "states": _bound(domain, behaviors)}


def _bound(domain: Domain, there: Any) -> list[tuple[str, str, str, str]]:
    labels = [str(Term(word.name, word.parameters)) for word in there.values()]
    return [
        (str(term), there[term.name].description, "", "")
        for _, term in terms(labels, sorted(domain.targets))
    ]
