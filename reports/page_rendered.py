"""The page of a rendered study."""

from __future__ import annotations

from collections.abc import Sequence

from reports import (
    figures_effects,
    figures_heat,
    figures_map,
    figures_strips,
    headline,
    provenance,
    terminal_rendered,
)
from reports.cases import Case, by_illumination
from reports.comparison import Comparison, compare, left_out_text
from reports.illuminations import illuminations
from reports.kind import Kind
from reports.page import Page, Picture, Section
from reports.run import Run
from reports.statistics import MIN_UNITS
from reports.tables import failures
from reports.verdict import mask_verdict, verdict
from reports.wording import plural

SHOWN = (
    "For each filter the frames in which it brought the picture closest to the true diffuse one, took it "
    "furthest away, and the one in between, by change of PSNR. White in a mask is what light affects."
)
MAP_CAPTION = (
    "Rings are the true landmarks, dots those the robot mapped. Shown are the weakest and the strongest "
    "light with the lowest seed: chosen by rule, not by result. Estimates far outside the place are cut off."
)


def compose(run: Run) -> Page:
    """Score, draw and lay out the page."""
    # first: they read files that may be damaged
    maps, strip_section = _maps(run), figures_strips.section(run, SHOWN)
    comparison = compare(run)
    cases = by_illumination(run, comparison)
    further = tuple(s for s in (mask_verdict(run, comparison),) if s)
    sections = (
        Section("effect", "What the filters changed", pictures=effects(run, cases)),
        Section("numbers", "All numbers", tables=headline.tables(run, cases)),
        Section("light", "Under which light", pictures=_heat_maps(run, comparison)),
        strip_section,
        Section("map", "Where the robot thought it was", pictures=maps),
        Section("failures", "What failed", bullets=_failures(run)),
        Section("reading", "How to read this", bullets=_caveats(run, comparison)),
    )
    filled = tuple(s for s in sections if s.tables or s.pictures or s.strips or s.bullets)
    return Page(
        run.title,
        provenance.subtitle(run),
        run.description,
        verdict(run, comparison),
        further,
        filled,
        provenance.lines(run),
    )


def effects(run: Run, cases: Sequence[Case]) -> tuple[Picture, ...]:
    """What the filters changed in each case; nothing where there is no filter."""
    path = figures_effects.draw(run, cases)
    if path is None:
        return ()
    caption = (
        "Paired differences to doing nothing, with 95 % intervals; a hollow dot has too few repetitions for "
        "one. What crosses the line at zero cannot be told apart from no effect."
    )
    return (Picture(path, "Change against doing nothing", caption),)


def _heat_maps(run: Run, comparison: Comparison) -> tuple[Picture, ...]:
    drawn = ((metric, figures_heat.draw(run, comparison, metric)) for metric in figures_heat.METRICS)
    timed = any(light.time for light in illuminations(run))
    return tuple(Picture(path, metric.title, _heat_caption(metric, timed)) for metric, path in drawn if path)


def _heat_caption(metric: figures_heat.HeatMetric, timed: bool) -> str:
    sun = "time of day with its sun" if timed else "sun"
    better = "Higher" if metric.higher_is_better else "Lower"
    unit = f"In {metric.unit}. " if metric.unit else ""
    if metric.of_light:
        return (
            f"{unit}The true mask's share of the picture, before any filter: {sun} (on a surface facing it) "
            "against the light of each bulb. Automatic exposure follows the brighter of the two."
        )
    return (
        f"{unit}{sun.capitalize()} (on a surface facing it) against the light of each bulb; all panels share "
        f"one colour scale. {better} is better, and brighter."
    )


def _maps(run: Run) -> tuple[Picture, ...]:
    drawn = ((scene, figures_map.draw_rendered(run, scene)) for scene in run.scenes)
    return tuple(Picture(path, f"Map of the scene {scene}", MAP_CAPTION) for scene, path in drawn if path)


def _failures(run: Run) -> tuple[str, ...]:
    return tuple(f.text for f in failures(run))


def _caveats(run: Run, comparison: Comparison) -> tuple[str, ...]:
    frames = comparison.frames
    seeds = run.runs["seed"].nunique()
    texts = [
        "An interval covers 95 %: a bootstrap percentile interval, widened for small samples as Student's t "
        f"is (Hesterberg 2015). With fewer than {MIN_UNITS} units none is given, because none could reach "
        "95 %. Each interval stands for itself: of many, about one in twenty misses by chance.",
        f"Picture and landmark scores resample {frames.unit}, {frames.blocks} in all, since a frame hardly "
        "differs from the one before it; the block length is the longest that any reported series asks for "
        "(Politis & White 2004). The same blocks serve each filter and each illumination; these intervals "
        "speak for the study's own illuminations alone.",
        f"RMSE, landmarks mapped and navigation resample {plural(seeds, 'odometry seed')} and, where lights "
        "are pooled, the illuminations too (Owen 2007), because the seeds of one illumination share its "
        "pictures. A difference is between two runs of the same illumination and seed.",
        "The sensor's noise was drawn once for each picture, the same for each filter: intervals of picture "
        "scores hold the scatter between places on the tour, not between exposures.",
        "Recall is landmarks found over landmarks visible, summed over all frames; precision is landmarks "
        "found over detections. PSNR averages squared errors, not decibels. Mask IoU, F1 and AP leave out "
        "pictures without any truly affected pixel. Filter time is the median for one picture.",
        "The intervals speak for this scene, this camera and this tour; they cannot speak for others.",
    ]
    if len(run.failed_frames):
        texts.append(
            "A picture that a filter failed on has no scores, is left out of the comparison for every "
            "filter, and gives that filter's SLAM no observation. A filter that failed on all pictures has "
            "no scores, and leaves none out."
        )
    if frames.left_out:
        texts.append(left_out_text(comparison))
    return tuple(texts)


KIND = Kind(compose, terminal_rendered.summary, failures, rendered=True)
