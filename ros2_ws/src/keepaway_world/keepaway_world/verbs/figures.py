"""Figures of an evaluation."""

from __future__ import annotations

from pathlib import Path
from statistics import fmean

from hitab_bringup.plots import figure, save
from hitab_core import quantity
from keepaway_world.verbs import paper
from keepaway_world.verbs.evaluation import Evaluation


def draw_episode_lengths(evaluation: Evaluation, path: Path) -> None:
    """Draw the lengths of the episodes, with the paper's mean and ours."""
    seconds = [played.seconds for played in evaluation.played]
    drawing, axes = figure(7.0, 4.0)
    out = [p.seconds for p in evaluation.played if p.ended == "out"]
    others = [p.seconds for p in evaluation.played if p.ended != "out"]
    bins = [i * max(seconds) / 30 for i in range(31)]
    axes.hist(
        [out, others],
        bins=bins,
        stacked=True,
        label=["ended out", "ended taken"],
        color=["#7fa6d6", "#d98c7f"],
    )
    ours = fmean(seconds)
    axes.axvline(ours, color="#1f5fb4", linewidth=2, label=f"mean {ours:.1f} s")
    axes.axvline(
        paper.HOLD_TIME_S,
        color="black",
        linewidth=1.5,
        linestyle="--",
        label=f"the paper's mean {paper.HOLD_TIME_S} ± {paper.HOLD_TIME_SE_S} s",
    )
    axes.set_xlabel("length of the episode, s")
    axes.set_ylabel("episodes")
    axes.set_title(
        f"{evaluation.behavior}: {quantity(len(seconds), 'episode')}, seed {evaluation.seed}, "
        f"takers at {evaluation.parameters.get('taker_speed', 0.25):g} of full speed",
        fontsize=10,
    )
    axes.legend()
    save(drawing, path)
