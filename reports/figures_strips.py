"""The contact sheet of the strips, for use outside the page; its data is the runner's ``strips.csv``."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from reports import style
from reports.errors import ReportError
from reports.page import Section
from reports.run import Run
from reports.strips import PICTURES, Strip, strips
from reports.wording import number, plural


def draw(run: Run, shown: Sequence[Strip]) -> Path | None:
    """Save ``figures/strips.png``; None without strips."""
    if not shown:
        return None
    from matplotlib import image

    with style.styled():
        figure = style.new_figure(11.0, height := 1.62 * len(shown) + 0.35, None)
        axes = figure.subplots(len(shown), len(PICTURES), squeeze=False)
        edges = {"left": 0.07, "right": 0.995, "top": 1 - 0.3 / height, "bottom": 0.05 / height}
        figure.subplots_adjust(**edges, wspace=0.03, hspace=0.05)
        for row, strip in zip(axes, shown, strict=True):
            for panel, kind in zip(row, PICTURES, strict=True):
                try:
                    panel.imshow(image.imread(strip.files[kind]), cmap="gray", interpolation="nearest")
                except (OSError, SyntaxError) as error:
                    raise ReportError(f"{strip.files[kind]} is damaged: run the study again") from error
                panel.set(xticks=[], yticks=[])
                for spine in panel.spines.values():
                    spine.set_visible(False)
            row[0].set_ylabel(label(strip), fontsize=7)
        for panel, title in zip(axes[0], PICTURES.values(), strict=True):
            panel.set_title(title)
        target = run.folder / "figures" / "strips.png"
        aside = target.with_suffix(".png.part")
        figure.savefig(aside, format="png", dpi=110, metadata={"Software": None})
        os.replace(aside, target)
    return target


def label(strip: Strip) -> str:
    """Which frame it is and how well it went."""
    return f"{strip.filter}, {strip.rank}\nframe {strip.frame}\nIoU {number(strip.iou)}"


def section(run: Run, text: str = "") -> Section:
    """The strips that fit on a page, drawn as a sheet too; ``text`` says which frames they are."""
    shown, stored = strips(run)
    draw(run, shown)
    left = stored - len(shown)
    note = f"{plural(left, 'further strip')} left out to keep the page small." if left else ""
    paragraphs = (text,) if text and shown else ()
    return Section("strips", "What the filters see and make", paragraphs, strips=shown, strips_note=note)
