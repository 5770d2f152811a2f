"""The page of a study of several scenes through the whole chain."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports import downstream, figures_map, headline, provenance
from reports.cases import Case
from reports.comparison import left_out_text
from reports.kind import Kind
from reports.light_levels import levels_told
from reports.page import Page, Picture, Section, Table
from reports.page_rendered import MAP_CAPTION, effects
from reports.run import Run
from reports.statistics import MIN_UNITS
from reports.tables import COLUMNS, MARK_NOTE, failures
from reports.terminal import of_table, paragraphs
from reports.verdict import verdict
from reports.wording import plural

if TYPE_CHECKING:
    from rich.console import RenderableType

MEANINGS = (
    "Landmark recall: discs found of those visible. Landmark precision: discs found of all detections. RMSE: "
    "of position, without alignment. Nav success: of random start–goal pairs, the share whose plan on the "
    "robot's own map touches nothing in the true one.",
)


def compose(run: Run) -> Page:
    """Score, draw and lay out the page."""
    maps = _maps(run)  # first: they read files that may be damaged
    pooled, each = downstream.pooled(run), downstream.each(run)
    sections = (
        Section(
            "numbers",
            "Scene, light and filter",
            levels_told(run) + MEANINGS,
            tables=tables(run, pooled, each),
        ),
        Section("effect", "What the filters changed", pictures=effects(run, (*pooled, *each))),
        Section("map", "Where the robot thought it was", pictures=maps),
        Section("failures", "What failed", bullets=tuple(f.text for f in failures(run))),
        Section("reading", "How to read this", bullets=_caveats(run, pooled[0])),
    )
    return Page(
        run.title,
        provenance.subtitle(run),
        run.description,
        verdict(run, pooled[0].comparison),
        (),
        tuple(s for s in sections if s.tables or s.pictures or s.bullets),
        provenance.lines(run),
    )


def tables(run: Run, pooled: tuple[Case, ...], each: tuple[Case, ...]) -> tuple[Table, Table]:
    """All scenes together, and each scene under each light; every number into ``figures/headline.csv``."""
    of_all, of_each = headline.blocks(run, pooled), headline.blocks(run, each)
    headline.save(run, [*of_all, *of_each])
    columns = [column for column in COLUMNS if column.key in downstream.KEYS]
    return (
        headline.filter_lines("All scenes together", of_all, columns),
        headline.filter_lines("Each scene under each light", of_each, columns, (MARK_NOTE,)),
    )


def _maps(run: Run) -> tuple[Picture, ...]:
    drawn = (
        (scene, figures_map.draw_rendered(run.in_scene(scene), scene)) for scene in downstream.scenes(run)
    )
    return tuple(Picture(path, f"Map of the scene {scene}", MAP_CAPTION) for scene, path in drawn if path)


def _caveats(run: Run, pooled: Case) -> tuple[str, ...]:
    frames, seeds = pooled.comparison.frames, plural(run.runs["seed"].nunique(), "odometry seed")
    texts = [
        "An interval covers 95 %: a bootstrap percentile interval, widened for small samples as Student's t "
        f"is (Hesterberg 2015); with fewer than {MIN_UNITS} units, or where fewer changed, none is given. "
        "Each stands for itself: of many, about one in twenty misses by chance.",
        f"Recall and precision resample {frames.unit} ({frames.blocks} in all scenes), all lights and "
        "filters of a place staying together. RMSE and nav success of one scene under one light resample "
        f"{seeds}; where scenes or lights are pooled they resample those as well (Owen 2007). Differences "
        "are between runs of the same scene, light and seed.",
        "Light spoils a plan only through the pose: depth, and so the map's walls, is not touched by light.",
        "The intervals speak for these scenes, this camera and these tours.",
    ]
    if frames.left_out:
        texts.append(left_out_text(pooled.comparison))
    return tuple(texts)


def summary(run: Run) -> RenderableType:
    """The verdict, and all scenes together under each light."""
    from rich.console import Group

    pooled = downstream.pooled(run)
    columns = [column for column in COLUMNS if column.key in downstream.KEYS]
    told = headline.filter_lines("All scenes together", headline.blocks(run, pooled), columns)
    notes = ["▲ better, ▼ worse than doing nothing, by a paired 95 % interval; the page has each scene."]
    notes += [f"failed: {f.text}" for f in failures(run)]
    sentences = [verdict(run, pooled[0].comparison)]
    return Group(*paragraphs(sentences, "bold"), of_table(told), *paragraphs(notes, "dim"))


KIND = Kind(compose, summary, failures, rendered=True)
