"""How sure a number is: bootstrap intervals over whatever a run really repeats.

Sources
-------
Bootstrap: Efron & Tibshirani 1993, through ``scipy.stats.bootstrap``. The percentile interval is too narrow
for few units; the level is widened so that it is as wide as Student's t asks for a mean:
α'/2 = Φ(−√(n/(n−1)) · t_{α/2, n−1}), the "expanded percentile interval" of Hesterberg 2015, *What teachers
should know about the bootstrap*, The American Statistician 69(4).

Conventions
-----------
- A *unit* is what is resampled: a seed, or a block of neighbouring frames. Everything measured on one unit
  (each filter, each illumination) stays together, so a difference between filters is a paired one.
- Each statistic is a function of sums over units: a recall is Σ hits / Σ visible, not a mean of recalls.
- Below ``MIN_UNITS`` units no interval is given. With n units a two-sided sign test cannot reach a p value
  below 2/2ⁿ; at n = 5 that is 0.0625, so a 95 % statement needs n ≥ 6.
- What is pooled over illuminations resamples illuminations and seeds, each by itself (the pigeonhole
  bootstrap of Owen 2007, *The pigeonhole bootstrap*, Annals of Applied Statistics 1(2)): all seeds of one
  illumination share its pictures, and with them one realisation of the sensor's noise, which resampling seeds
  alone would take for certain. It is conservative. With fewer than ``MIN_UNITS`` illuminations, seeds alone.
- In a paired comparison only units that changed count as n, as a sign test drops ties: the bootstrap alone
  would call five changed blocks among forty unchanged ones certain, because few resamples miss all five.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Statistic = Callable[..., FloatArray]

CONFIDENCE = 0.95
MIN_UNITS = math.ceil(1 + math.log2(1 / (1 - CONFIDENCE)))
RESAMPLES = 4999
SEED = 20090831
"""Any fixed number will do: the same run folder gives the same page."""


@dataclass(frozen=True)
class Estimate:
    """A number, and how sure it is.

    Attributes
    ----------
    value : float
        The estimate from all units; NaN where there is nothing to measure.
    low, high : float
        Ends of the 95 % interval; NaN where none can be given.
    units : int
        How many units were resampled.
    unit : str
        What they are, in the plural ("seeds").
    note : str
        Why there is no interval, otherwise empty.
    """

    value: float
    low: float = math.nan
    high: float = math.nan
    units: int = 0
    unit: str = ""
    note: str = ""

    @property
    def has_interval(self) -> bool:
        """Whether both ends are known."""
        return not (math.isnan(self.low) or math.isnan(self.high))

    @property
    def excludes_zero(self) -> bool:
        """Whether the interval lies wholly on one side of zero."""
        return self.has_interval and (self.low > 0.0 or self.high < 0.0)


def plain(value: float) -> Estimate:
    """A number that this run measures once, so that it has no interval."""
    return Estimate(float(value))


def estimate(
    statistic: Statistic, sums: FloatArray, unit: str, changed: NDArray[np.bool_] | None = None
) -> Estimate:
    """A statistic of sums over units, with its interval.

    Parameters
    ----------
    statistic : callable
        Takes k arrays of sums (one per row of ``sums``) and returns one array of the same shape.
    sums : (k, n) float64
        k measured sums of each of n units. Units without anything measured (all zero) do not count.
    unit : str
        What a unit is, in the plural.
    changed : (n,) bool, optional
        In a paired comparison, which units differ from the baseline at all.
    """
    sums = np.atleast_2d(np.asarray(sums, dtype=np.float64))
    measured = sums.any(axis=0)
    informative = int(measured.sum() if changed is None else (measured & changed).sum())
    sums = sums[:, measured]
    n = sums.shape[1]
    with np.errstate(divide="ignore", invalid="ignore"):
        value = float(statistic(*sums.sum(axis=1)))
        if math.isnan(value):
            return Estimate(value, units=n, unit=unit, note="nothing to measure")
        if n < MIN_UNITS:
            return Estimate(
                value, units=n, unit=unit, note=f"too few {unit} for an interval ({n} < {MIN_UNITS})"
            )
        if changed is not None and informative == 0:
            return Estimate(value, value, value, n, unit)
        if informative < MIN_UNITS:
            note = f"only {informative} of {n} {unit} changed, too few for an interval"
            return Estimate(value, units=n, unit=unit, note=note)
        low, high = _interval(statistic, sums.shape, sums.tobytes(), informative)
    if math.isnan(low) or math.isnan(high):
        return Estimate(value, units=n, unit=unit, note="undefined in some resamples")
    return Estimate(value, low, high, n, unit)


def crossed(values: FloatArray, rows: str, columns: str, paired: bool = False) -> Estimate:
    """The mean of a table whose rows and columns both are random factors, with its interval.

    Parameters
    ----------
    values : (r, n) float64
        NaN where nothing was measured. In a paired comparison, the differences.
    rows, columns : str
        What they are, in the plural.
    paired : bool
        Whether only rows and columns that changed count as units.
    """
    measured = np.isfinite(values)
    filled = np.where(measured, values, 0.0)
    if len(values) < MIN_UNITS or filled.shape[1] < MIN_UNITS or not measured.any():
        sums = np.stack([filled.sum(axis=0), measured.sum(axis=0).astype(np.float64)])
        return estimate(ratio, sums, columns, sums[0] != 0.0 if paired else None)
    value = float(filled.sum() / measured.sum())
    counted = filled != 0.0 if paired else measured
    informative = int(min(counted.any(axis=0).sum(), counted.any(axis=1).sum()))
    unit, units = f"{rows} and {columns}", int(min(values.shape))
    if paired and informative == 0:
        return Estimate(value, value, value, units, unit)
    if informative < MIN_UNITS:
        note = f"only {informative} of {units} {unit} changed, too few for an interval"
        return Estimate(value, units=units, unit=unit, note=note)
    rng = np.random.default_rng(SEED)
    draws = [rng.multinomial(k, np.full(k, 1 / k), RESAMPLES).astype(np.float64) for k in values.shape]
    total, count = (np.einsum("br,rn,bn->b", draws[0], t, draws[1]) for t in (filled, measured.astype(float)))
    tail = (1 - expanded_level(informative)) / 2
    low, high = np.quantile(total[count > 0] / count[count > 0], [tail, 1 - tail])
    return Estimate(value, float(low), float(high), units, unit)


@lru_cache(maxsize=4096)
def _interval(
    statistic: Statistic, shape: tuple[int, int], raw: bytes, informative: int
) -> tuple[float, float]:
    """The interval; kept, because table, sentence and figure ask for the same ones."""
    from scipy.stats import bootstrap

    sums = np.frombuffer(raw, dtype=np.float64).reshape(shape)

    def of_resample(*samples: FloatArray, axis: int = -1) -> FloatArray:
        return statistic(*(sample.sum(axis=axis) for sample in samples))

    result = bootstrap(
        tuple(sums),
        of_resample,
        paired=True,
        vectorized=True,
        method="percentile",
        confidence_level=expanded_level(informative),
        n_resamples=RESAMPLES,
        rng=np.random.default_rng(SEED),
    )
    return float(result.confidence_interval.low), float(result.confidence_interval.high)


def expanded_level(n: int) -> float:
    """The percentile level that makes the bootstrap of n units as wide as Student's t (Hesterberg 2015)."""
    from scipy.stats import norm, t

    tail = norm.cdf(math.sqrt(n / (n - 1)) * t.ppf((1 - CONFIDENCE) / 2, n - 1))
    return float(1 - 2 * tail)


def ratio(part: FloatArray, whole: FloatArray) -> FloatArray:
    """Σ part / Σ whole: a recall, a precision, or a mean when ``whole`` counts."""
    return part / whole


def ratio_change(part: FloatArray, whole: FloatArray, base: FloatArray, base_whole: FloatArray) -> FloatArray:
    """A ratio minus that of the baseline."""
    return part / whole - base / base_whole


def decibel(error: FloatArray, count: FloatArray) -> FloatArray:
    """PSNR of the mean of relative squared errors, dB: pictures seen as one, never a mean of decibels."""
    return -10.0 * np.log10(error / count)


def decibel_change(error: FloatArray, base: FloatArray) -> FloatArray:
    """PSNR minus that of the baseline on the same pictures, dB."""
    return -10.0 * np.log10(error / base)
