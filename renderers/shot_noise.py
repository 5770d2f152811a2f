"""Counting noise: Poisson electrons, normal read noise, and the read-out to digital numbers.

Where read noise hides the steps between whole electrons, the sum is the ziggurat's normal number bent to the
sum's first five cumulants: its distribution function is off by less than 1e-6, for a quarter of the time.
Elsewhere electrons are counted exactly. The random bits are SplitMix64's, started from the caller's
generator, as a call into NumPy costs more than the arithmetic around it. The kernels share one file because
numba's cache does not see a change in another.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from renderers.gbuffer import F32

FEW = 10.0
"""Below this mean, multiplying uniforms until e^−mean is passed is faster than rejection."""

BENT_FROM = ((4.0, 0.0), (1.0, 50.0))
"""With at least this read noise, the cumulants serve from this mean on; all in electrons."""

LAYERS = 256
GAMMA = 0x9E3779B97F4A7C15
"""SplitMix64's step (Steele, Lea & Flood 2014)."""

TAIL = 3.6541528853610088
"""Where the ziggurat's base layer ends, for 256 layers (Marsaglia & Tsang 2000)."""


def _ziggurat() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Right edges of the layers, widest first, and the density exp(−x²/2) there; all of one area."""
    area = TAIL * math.exp(-(TAIL**2) / 2) + math.sqrt(math.pi / 2) * math.erfc(TAIL / math.sqrt(2))
    x = [area / math.exp(-(TAIL**2) / 2), TAIL]
    while len(x) < LAYERS:
        x.append(math.sqrt(-2 * math.log(area / x[-1] + math.exp(-(x[-1] ** 2) / 2))))
    edges = np.array([*x, 0.0])
    return edges, np.exp(-(edges**2) / 2)


EDGES, DENSITY = _ziggurat()
LOG_FACTORIAL = np.array([math.lgamma(k + 1.0) for k in range(16)])
NONE = np.empty(0, dtype=np.float32)


def _bent_from(read_noise: float) -> float:
    """The least mean at which the cumulants serve."""
    return next((mean for noise, mean in BENT_FROM if read_noise >= noise), math.inf)


def start(rng: np.random.Generator) -> NDArray[np.uint64]:
    """(1,) uint64: the state of a new SplitMix64 stream."""
    return rng.integers(0, 2**64, size=1, dtype=np.uint64)


def count_electrons(mean: F32, read_noise: float, rng: np.random.Generator) -> F32:
    """Draw Poisson counts and add normal noise.

    Parameters
    ----------
    mean : float32, any shape
        Expected electrons, finite and ≥ 0.
    read_noise : float
        Standard deviation, electrons.

    Returns
    -------
    counted : float32, the same shape
    """
    counted = np.empty(mean.shape, dtype=np.float32)
    flat = np.ascontiguousarray(mean).reshape(-1)
    _count(flat, NONE, NONE, 0.0, np.inf, read_noise, _bent_from(read_noise), start(rng), counted.reshape(-1))
    return counted


def read_out(
    electrons: F32,
    response: F32,
    offset: F32,
    dark: float,
    read_noise: float,
    full_well: float,
    gain: float,
    black: float,
    largest: float,
    rng: np.random.Generator,
) -> NDArray[np.uint16]:
    """One exposure of flat (n,) pixels in the order of EMVA 1288.

    Parameters
    ----------
    electrons : float32, any shape
        Expected photo-electrons, ≥ 0.
    response, offset : float32, as many or none
        Fixed patterns: factor on the expectation, electrons added to the count; empty for none.
    dark, read_noise, full_well : float
        Expected thermal electrons, standard deviation, electrons.
    gain, black, largest : float
        DN per electron, DN, DN.

    Returns
    -------
    raw : uint16, the shape of ``electrons``
    """
    counted, raw = np.empty(electrons.size, np.float32), np.empty(electrons.shape, np.uint16)
    flat = np.ascontiguousarray(electrons, dtype=np.float32).reshape(-1)
    bound = 2.0 * full_well  # far above full well the count clips whatever its noise
    many = _bent_from(read_noise)
    _count(flat, response.reshape(-1), offset.reshape(-1), dark, bound, read_noise, many, start(rng), counted)
    _convert(counted, full_well, gain, black, largest, raw.reshape(-1))
    return raw


def convert(
    electrons: F32, full_well: float, gain: float, black: float, largest: float
) -> NDArray[np.uint16]:
    """Electrons of any shape to digital numbers: clip at full well, amplify, round, clip to 0…largest."""
    raw = np.empty(electrons.shape, np.uint16)
    flat = np.ascontiguousarray(electrons, dtype=np.float32).reshape(-1)
    _convert(flat, full_well, gain, black, largest, raw.reshape(-1))
    return raw


@njit(cache=True)
def _convert(
    counted: F32, full_well: float, gain: float, black: float, largest: float, out: NDArray[np.uint16]
) -> None:
    well, k = np.float32(full_well), np.float32(gain)
    zero, top = np.float32(0.0), np.float32(largest)
    rounded = np.float32(black + 0.5)  # truncation then rounds to nearest
    for i in range(len(counted)):
        count = counted[i] if counted[i] < well else well
        dn = count * k + rounded
        dn = dn if dn > zero else zero
        out[i] = np.uint16(np.int32(dn if dn < top else top))


@njit(cache=True)
def _count(
    electrons: F32,
    response: F32,
    offset: F32,
    dark: float,
    bound: float,
    read_noise: float,
    many: float,
    state: NDArray[np.uint64],
    out: F32,
) -> None:
    """Counted electrons with read noise and fixed patterns."""
    thermal, most = np.float32(dark), np.float32(bound)
    mean, noise = np.empty_like(electrons), np.zeros_like(electrons)
    for i in range(len(mean)):
        expected = (electrons[i] * response[i] if len(response) > 0 else electrons[i]) + thermal
        mean[i] = expected if expected < most else most
    if read_noise > 0.0:
        _normals(state, noise)
    if many < np.inf:
        _bend(mean, noise, read_noise, out)
    for i in range(len(mean)):
        if mean[i] < many:
            out[i] = _poisson(float(mean[i]), state) + read_noise * noise[i]
    if len(offset) > 0:
        for i in range(len(out)):
            out[i] += offset[i]


@njit(cache=True, error_model="numpy")
def _bend(mean: F32, noise: F32, read_noise: float, out: F32) -> None:
    """Standard normal numbers to Poisson plus normal ones (Cornish & Fisher 1938, to the third order).

    The sum's second cumulant is mean + σ², every higher one the mean. All in float32, so that it runs on
    eight pixels at once.
    """
    variance = np.float32(read_noise * read_noise)
    one, two, three, five, six = np.float32(1), np.float32(2), np.float32(3), np.float32(5), np.float32(6)
    c1, c2, c11 = np.float32(1 / 6), np.float32(1 / 24), np.float32(-1 / 36)
    c3, c12, c111 = np.float32(1 / 120), np.float32(-1 / 24), np.float32(1 / 324)
    twelve, k53, k17 = np.float32(12), np.float32(53), np.float32(17)
    for i in range(len(mean)):
        z = noise[i]
        z2 = z * z
        sigma = np.sqrt(mean[i] + variance)
        per_sigma = one / sigma
        g = mean[i] * per_sigma * per_sigma * per_sigma  # skewness; times 1/σ the excess, 1/σ² the next
        first = c1 * (z2 - one)
        second = z * (c2 * per_sigma * (z2 - three) + c11 * g * (two * z2 - five))
        third = (
            c3 * per_sigma * per_sigma * ((z2 - six) * z2 + three)
            + c12 * per_sigma * g * ((z2 - five) * z2 + two)
            + c111 * g * g * ((twelve * z2 - k53) * z2 + k17)
        )
        out[i] = mean[i] + sigma * (z + g * (first + second + third))


@njit(cache=True)
def _mixed(counter: np.uint64) -> np.uint64:
    """SplitMix64's output for one value of its counter (Steele, Lea & Flood 2014)."""
    z = (counter ^ (counter >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


@njit(cache=True)
def _bits(state: NDArray[np.uint64]) -> np.uint64:
    """64 random bits."""
    state[0] += np.uint64(GAMMA)
    return _mixed(state[0])


@njit(cache=True)
def _uniform(state: NDArray[np.uint64]) -> float:
    """In the open interval 0…1, on the middles of 2⁵² steps."""
    return (float(np.int64(_bits(state) >> np.uint64(12))) + 0.5) * 2.0**-52


@njit(cache=True)
def _normals(state: NDArray[np.uint64], out: F32) -> None:
    """Standard normal numbers by the ziggurat (Marsaglia & Tsang 2000).

    Of 64 numbers 63 take the short way, on which the counter stays in a register: a third of the time.
    """
    counter = state[0]
    for i in range(len(out)):
        counter += np.uint64(GAMMA)
        bits = _mixed(counter)
        layer, x = _candidate(bits)
        if abs(x) >= EDGES[layer + 1]:
            state[0] = counter
            x = _outside(bits, state)
            counter = state[0]
        out[i] = x
    state[0] = counter


@njit(cache=True)
def _candidate(bits: np.uint64) -> tuple[int, float]:
    """Layer and abscissa, of separate bits; the sign is the bits' own."""
    layer = int(bits & np.uint64(255))
    return layer, float(np.int64(bits) >> 11) * 2.0**-52 * EDGES[layer]


@njit(cache=True)
def _outside(bits: np.uint64, state: NDArray[np.uint64]) -> float:
    """The number that follows from bits whose candidate may lie outside of the density."""
    while True:
        layer, x = _candidate(bits)
        if abs(x) < EDGES[layer + 1]:
            return x
        if layer == 0:
            while True:
                beyond = -math.log(_uniform(state)) / TAIL
                if -2.0 * math.log(_uniform(state)) > beyond * beyond:
                    return math.copysign(TAIL + beyond, x)
        low, high = DENSITY[layer], DENSITY[layer + 1]
        if low + _uniform(state) * (high - low) < math.exp(-0.5 * x * x):
            return x
        bits = _bits(state)


@njit(cache=True)
def _poisson(mean: float, state: NDArray[np.uint64]) -> float:
    return _by_products(mean, state) if mean < FEW else _by_rejection(mean, state)


@njit(cache=True)
def _by_products(mean: float, state: NDArray[np.uint64]) -> float:
    """Poisson count (Knuth, The Art of Computer Programming, vol. 2, 3.4.1)."""
    limit, product, count = math.exp(-mean), _uniform(state), 0.0
    while product > limit:
        product *= _uniform(state)
        count += 1.0
    return count


@njit(cache=True)
def _by_rejection(mean: float, state: NDArray[np.uint64]) -> float:
    """Poisson count by transformed rejection with squeeze (Hörmann 1993, algorithm PTRS); mean ≥ 10."""
    b = 0.931 + 2.53 * math.sqrt(mean)
    a = -0.059 + 0.02483 * b
    inner = 0.9277 - 3.6224 / (b - 2.0)
    while True:
        u, v = _uniform(state) - 0.5, _uniform(state)
        us = 0.5 - abs(u)
        count = math.floor((2.0 * a / us + b) * u + mean + 0.43)
        if us >= 0.07 and v <= inner:
            return count
        if count < 0.0 or (us < 0.013 and v > us):
            continue
        ratio = v * (1.1239 + 1.1328 / (b - 3.4)) / (a / (us * us) + b)
        if math.log(ratio) <= _log_probability(float(count), mean):
            return count


@njit(cache=True)
def _log_probability(count: float, mean: float) -> float:
    """Logarithm of P(count), for large counts by Stirling's series (error below 1e-10)."""
    if count < 16.0:
        return count * math.log(mean) - mean - LOG_FACTORIAL[int(count)]
    inverse = 1.0 / count
    square = inverse * inverse
    series = inverse * (1.0 / 12.0 - square * (1.0 / 360.0 - square / 1260.0))
    return count * math.log(mean * inverse) + count - mean - 0.5 * math.log(2.0 * math.pi * count) - series
