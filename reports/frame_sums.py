"""The frame table, summed over blocks of neighbouring frames: what every frame statistic starts from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from reports import blocks
from reports.run import BASELINE, Run

if TYPE_CHECKING:
    from pandas import DataFrame

FloatArray = NDArray[np.float64]

KEYS = ["scene", "illumination", "frame"]


@dataclass(frozen=True, eq=False)
class FrameSums:
    """Sums per filter, illumination and block.

    Attributes
    ----------
    table : DataFrame
        Indexed by (filter, illumination, block); columns as :func:`addends` makes them.
    block_length : int
        Frames per block.
    blocks : int
        How many blocks there are.
    left_out : int
        Frames that not every filter has, which no comparison uses.
    """

    table: DataFrame
    block_length: int
    blocks: int
    left_out: int

    @property
    def unit(self) -> str:
        """What is resampled, in the plural."""
        return f"blocks of {self.block_length} frames" if self.block_length > 1 else "frames"

    def of(self, name: str, illumination: str | None, *columns: str) -> FloatArray:
        """(k, n) float64: the sums of k columns in each of n blocks, for one illumination or (None) all."""
        rows = self.table.loc[name]
        if illumination is not None:
            per_block = rows.xs(illumination, level="illumination")
        else:
            per_block = rows.groupby(level="block").sum()
        return per_block.reindex(range(self.blocks), fill_value=0.0)[list(columns)].to_numpy(np.float64).T


def frame_sums(run: Run) -> FrameSums:
    """Cut the run's frames into blocks and sum each filter's scores over them."""
    shared, left_out = _shared_frames(run.frames)
    length = _block_length(shared)
    assigned = blocks.assign(shared, length)
    table = addends(shared).merge(assigned, on=["scene", "frame"])
    values = [c for c in table.columns if c not in {*KEYS, "filter", "block"}]
    sums = table.groupby(["filter", "illumination", "block"], sort=True)[values].sum()
    return FrameSums(sums, length, int(assigned["block"].max()) + 1, left_out)


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
    """The longest block that any filter's change in landmarks found asks for, in any scene."""
    hits = frames.groupby(["filter", "scene", "frame"])["detections_true"].sum()
    names = hits.index.get_level_values("filter").unique()
    if BASELINE not in names:
        return 1
    lengths = [1]
    for name in names.drop(BASELINE):
        change = (hits[name] - hits[BASELINE]).dropna()
        lengths += [blocks.optimal_length(g.to_numpy(np.float64)) for _, g in change.groupby(level="scene")]
    return max(lengths)
