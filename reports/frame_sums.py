"""The frame table, summed over blocks of neighbouring frames: what every frame statistic starts from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from reports import blocks
from reports.run import BASELINE, Run
from reports.statistics import MIN_UNITS

if TYPE_CHECKING:
    from pandas import DataFrame

FloatArray = NDArray[np.float64]

KEYS = ["scene", "illumination", "frame"]


@dataclass(frozen=True, eq=False)
class FrameSums:
    """Sums per filter, illumination and block.

    Attributes
    ----------
    sums : (filters, illuminations, blocks, columns) float64
        NaN for a filter that failed on every picture.
    axes : the names along the first, second and last axis
    block_length : int
        Frames per block.
    left_out : int
        Frames that not every filter has, which no comparison uses.
    """

    sums: FloatArray
    axes: tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]
    block_length: int
    left_out: int

    @property
    def blocks(self) -> int:
        """How many blocks there are."""
        return self.sums.shape[2]

    @property
    def unit(self) -> str:
        """What is resampled, in the plural."""
        return f"blocks of {self.block_length} frames" if self.block_length > 1 else "frames"

    def of(self, name: str, illumination: str | None, *columns: str) -> FloatArray:
        """(k, n) float64: the sums of k columns in each of n blocks, for one illumination or (None) all."""
        filters, lights, names = self.axes
        sums = self.sums[filters.index(name)]
        per_block = sums.sum(axis=0) if illumination is None else sums[lights.index(illumination)]
        return per_block[:, [names.index(c) for c in columns]].T


def frame_sums(run: Run) -> FrameSums:
    """Cut the run's frames into blocks and sum each filter's scores over them."""
    shared, left_out = _shared_frames(run.frames)
    length = _block_length(shared)
    assigned = blocks.assign(shared, length)
    table = addends(shared).merge(assigned, on=["scene", "frame"])
    columns = tuple(str(c) for c in table.columns if c not in {*KEYS, "filter", "block"})
    lights = tuple(sorted(set(run.frames["illumination"])))
    sums = np.zeros((len(run.filters), len(lights), int(assigned["block"].max()) + 1, len(columns)))
    at = (
        np.array([run.filters.index(f) for f in table["filter"]]),
        np.array([lights.index(w) for w in table["illumination"]]),
        table["block"].to_numpy(),
    )
    sums[[name not in set(table["filter"]) for name in run.filters]] = np.nan
    np.add.at(sums, at, table[list(columns)].to_numpy(np.float64))
    return FrameSums(sums, (run.filters, lights, columns), length, left_out)


def addends(frames: DataFrame) -> DataFrame:
    """What adds up over frames: counts, scores with the number of frames that have one, squared errors.

    PSNR becomes the relative squared error 10^(−PSNR/10), so that a perfect picture (+∞ dB) counts as zero.
    """
    table = frames[[*KEYS, "filter"]].copy()
    for name in ("detections_true", "landmarks_visible", "landmarks_detected"):
        table[name] = frames[name].astype(float)
    table["frames"] = 1.0
    table["right_pixels"] = right_share(frames)
    error = frames[["psnr_db", "psnr_in_mask_db"]].rpow(10.0**-0.1)
    scores = {name: frames[name] for name in ("iou", "f1", "ap", "ber", "masked_share", "true_share")}
    scores |= {"error": error["psnr_db"], "error_in_mask": error["psnr_in_mask_db"]}
    for name, values in scores.items():
        table[name] = values.fillna(0.0)
        table[f"{name}_frames"] = values.notna().astype(float)
    return table


def right_share(frames: DataFrame) -> FloatArray:
    """(n,) float64: share of pixels on which mask and truth agree.

    With |A∩B| = IoU · (|A| + |B|) / (1 + IoU), it is 1 − |A| − |B| + 2 |A∩B|.
    """
    both = (frames["masked_share"] + frames["true_share"]).to_numpy(np.float64)
    iou = frames["iou"].fillna(0.0).to_numpy(np.float64)
    return 1.0 - both + 2.0 * iou * both / (1.0 + iou)


def _shared_frames(frames: DataFrame) -> tuple[DataFrame, int]:
    """The rows of frames that each filter has, and how many frames were left out."""
    filters = frames.groupby(KEYS)["filter"].transform("nunique")
    complete = filters == frames["filter"].nunique()
    left_out = len(frames[~complete].drop_duplicates(KEYS))
    return (frames[complete] if complete.any() else frames), left_out


def _block_length(frames: DataFrame) -> int:
    """The longest block that any reported series asks for, in any scene; at least two units' worth stay.

    Series: recall's residuals, squared error and masks of each filter, and their changes by the filter.
    """
    columns = ["hits", "masked_share", "right_pixels", "error", "iou"]
    table = addends(frames)
    visible = max(float(table["landmarks_visible"].sum()), 1.0)
    recall = float(table["detections_true"].sum()) / visible
    table["hits"] = table["detections_true"] - recall * table["landmarks_visible"]
    per_frame = table.groupby(["filter", "scene", "frame"])[columns].sum()
    series = [per_frame.loc[name] for name in per_frame.index.get_level_values("filter").unique()]
    if BASELINE in per_frame.index.get_level_values("filter"):
        series += [own - per_frame.loc[BASELINE] for own in series]
    lengths, counts = [1], []
    for own in series:
        for _, scene in own.dropna().groupby(level="scene"):
            counts.append(len(scene))
            lengths += [blocks.optimal_length(scene[c].to_numpy(np.float64)) for c in columns]
    return max(1, min(max(lengths), min(counts, default=1) // (2 * MIN_UNITS) or 1))
