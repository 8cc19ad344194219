"""The sample of situations that an agent in training met."""

from __future__ import annotations

from hitab_core.assistant.situation_sample import SITUATIONS_MAX, SituationSample
from hitab_core.training.percepts import PerceptRecord


def test_a_sample_of_situations_is_bounded_and_keeps_what_is_rare() -> None:
    met = SituationSample()
    for i in range(20_000):
        met.add(
            "rare" if i % 4_000 == 0 else "common", PerceptRecord(i, i * 0.1, "Right", (float(i),))
        )
    kept = list(met)
    assert len(kept) == SITUATIONS_MAX
    assert sum(moment.cycle % 4_000 == 0 for moment in kept) == 5
    later = sum(moment.cycle > 10_000 for moment in kept)
    assert SITUATIONS_MAX / 3 < later < SITUATIONS_MAX * 2 / 3, (
        "as many of the second half as of the first"
    )
    met.forget_from(1_000.0)
    assert all(moment.time < 1_000.0 for moment in met)
