"""The fit of a disc's image: least squares over the pixels around it, in linear light.

Model
-----
I(pixel) = (a + b·Δu + c·Δv) · (1 + k · coverage(pixel; x, y, r)): light that slopes evenly and shades floor
and paint alike, and paint of contrast k where the disc of radius r around (x, y) covers the pixel's spread.
Coverage is the mean over 5 × 5 samples of the spread (a box of one pixel convolved with the lens's Gaussian),
each with a soft edge of the width that the samples leave out; so it holds for a disc one pixel thick, too.
A disc of 3 pixels or more in radius takes one sample.

Levenberg-Marquardt (Moré 1978). The covariance is the heteroscedasticity-consistent HC3 of MacKinnon & White
(1985): the residuals at the disc's edge, not those of the flat floor, say how well the edge is known.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

PARAMETERS = 7  # x, y, r, k, a, b, c
_ITERATIONS = 15


def spread_samples(blur_px: float, resolved: bool) -> tuple[FloatArray, float]:
    """Sample offsets of the point spread along one axis and the half width of the soft edge, pixels.

    A resolved disc's edge is straight within a pixel, so that one sample with a wider edge does.
    """
    variance = 1.0 / 12.0 + blur_px**2
    quantiles = np.array([0.0] if resolved else [-1.2816, -0.5244, 0.0, 0.5244, 1.2816])  # normal, 0.1 … 0.9
    offsets = quantiles * np.sqrt(variance)
    rest = variance - float(np.mean(offsets**2))
    return offsets, float(np.sqrt(5.0 * rest))  # the smooth step's slope has the variance w²/5


@njit(cache=True)
def fit_disc(linear, floor, jacobian, row, col, ring, offsets, soft, noise, max_misfit):  # type: ignore[no-untyped-def]
    """Fit one disc near a pixel.

    Parameters
    ----------
    linear : (H, W) float32
        Linear luminance.
    floor, jacobian : (H, W, 2), (H, W, 2, 2) float64
        Floor point of each pixel and its derivative by column and row, metres.
    row, col : int
        The seed.
    ring : float
        Upper bound of the radius, metres.
    offsets, soft
        From `spread_samples`.
    noise : float
        Of the encoded picture, full scale 1.
    max_misfit : float
        What the caller believes; a fit that is far above it is given up on the way (`_patience`).

    Returns
    -------
    ok : bool
    q : (7,) float64
        x, y, r (metres), k, and a, b, c (linear light; b and c per pixel from the seed).
    cov : (4, 4) float64
        Of x, y, r, k.
    misfit : float
        Root mean square residual (the degrees of freedom taken off) beyond noise, over the contrast.
    """
    q = np.zeros(PARAMETERS)
    cov = np.full((4, 4), np.inf)
    box = _box(linear, jacobian, row, col, 1.25 * ring)
    if not _start(linear, floor, jacobian, row, col, ring, box, q):
        return False, q, cov, np.inf
    rows, cols = _window(floor, jacobian, box, q)
    n = len(rows)
    if n < 3 * PARAMETERS:
        return False, q, cov, np.inf
    values = np.empty(n)
    for i in range(n):
        values[i] = linear[rows[i], cols[i]]
    design = np.empty((n, PARAMETERS))
    residual = np.empty(n)
    loss = _evaluate(values, floor, jacobian, rows, cols, row, col, q, offsets, soft, design, residual)
    damping = 1e-3
    trial_design, trial_residual = np.empty_like(design), np.empty_like(residual)
    for iteration in range(_ITERATIONS):
        if _misfit(loss / (n - PARAMETERS), q, noise) > _patience(iteration) * max_misfit:
            return False, q, cov, np.inf
        normal = design.T @ design
        gradient = design.T @ residual
        for k in range(PARAMETERS):
            normal[k, k] *= 1.0 + damping
            normal[k, k] += 1e-15
        step = np.linalg.solve(normal, gradient)
        trial = q + step
        if trial[2] <= 0.02 or trial[2] > 3.0 * ring:
            trial[2] = 0.5 * q[2] if trial[2] <= 0.02 else 1.5 * q[2]
        trial_loss = _evaluate(
            values,
            floor,
            jacobian,
            rows,
            cols,
            row,
            col,
            trial,
            offsets,
            soft,
            trial_design,
            trial_residual,
        )
        if trial_loss < loss:
            settled = trial_loss > (1.0 - 1e-4) * loss
            q, loss = trial, trial_loss
            design, trial_design = trial_design, design
            residual, trial_residual = trial_residual, residual
            damping = max(damping * 0.1, 1e-9)
            # Metres; the next step of a quadratic convergence is far smaller.
            if settled or abs(step[0]) + abs(step[1]) + abs(step[2]) < 5e-4:
                break
        else:
            damping *= 10.0
            if damping > 1e2:
                break
    normal = design.T @ design
    for k in range(PARAMETERS):
        normal[k, k] += 1e-15
    inverse = np.linalg.inv(normal)
    cov[:, :] = _hc3(design, residual, inverse)[:4, :4]
    return True, q, cov, _misfit(loss / (n - PARAMETERS), q, noise)


@njit(cache=True)
def _patience(iteration):  # type: ignore[no-untyped-def]
    """Misfit over the believed one that a fit may still have: 5.5 at the start, 2.5 after four steps.

    Chosen on the DLR pictures 0, 40, 80 …: fits that are believed in the end have at most 2.5 at the start
    and 1.4 (99 in 100) after three steps; of the others, which are four in five, half have more than 3.
    """
    return 1.0 + 9.0 / (2.0 + iteration)


@njit(cache=True)
def _misfit(variance, q, noise):  # type: ignore[no-untyped-def]
    contrast = q[3] * q[4]
    brighter = max(q[4], q[4] + contrast, 0.0)
    # sRGB's slope turns the noise of encoded levels into that of linear light at the brighter level.
    linear_noise = noise * 2.4 / 1.055 * brighter ** (1.4 / 2.4)
    return np.sqrt(max(variance - linear_noise**2, 0.0)) / max(abs(contrast), 1e-12)


@njit(cache=True)
def _box(linear, jacobian, row, col, radius):  # type: ignore[no-untyped-def]
    """Rows and columns (first, past the last) of a box around a floor circle, with slack for perspective."""
    a, b = jacobian[row, col, 0, 0], jacobian[row, col, 0, 1]
    c, d = jacobian[row, col, 1, 0], jacobian[row, col, 1, 1]
    det = abs(a * d - b * c)
    width = int(1.3 * radius * np.hypot(d, b) / det + 4.0)
    height = int(1.3 * radius * np.hypot(c, a) / det + 4.0)
    return (
        max(row - height, 0),
        min(row + height + 1, linear.shape[0]),
        max(col - width, 0),
        min(col + width + 1, linear.shape[1]),
    )


@njit(cache=True)
def _start(linear, floor, jacobian, row, col, ring, box, q):  # type: ignore[no-untyped-def]
    """Levels, area and centroid by moments; writes the first guess into q."""
    x0, y0 = floor[row, col, 0], floor[row, col, 1]
    outside, count = 0.0, 0
    for v in range(box[0], box[1]):
        for u in range(box[2], box[3]):
            distance = np.hypot(floor[v, u, 0] - x0, floor[v, u, 1] - y0)
            if ring <= distance <= 1.5 * ring:
                outside += linear[v, u]
                count += 1
    if count < 4:
        return False
    outside /= count
    contrast = linear[row, col] - outside
    if contrast == 0.0:
        return False
    area = x = y = 0.0
    for v in range(box[0], box[1]):
        for u in range(box[2], box[3]):
            distance = np.hypot(floor[v, u, 0] - x0, floor[v, u, 1] - y0)
            if distance <= ring:
                share = min(max((linear[v, u] - outside) / contrast, 0.0), 1.0)
                J = jacobian[v, u]
                share *= abs(J[0, 0] * J[1, 1] - J[0, 1] * J[1, 0])
                area += share
                x += share * floor[v, u, 0]
                y += share * floor[v, u, 1]
    if area <= 0.0:
        return False
    q[0], q[1], q[2] = x / area, y / area, min(max(np.sqrt(area / np.pi), 0.25 * ring), ring)
    q[3], q[4] = contrast / max(outside, 1e-6), outside
    return True


@njit(cache=True, fastmath=True)
def _gap(dx, dy, J, radius):  # type: ignore[no-untyped-def]
    """Pixels from (dx, dy) to the disc's edge (positive inside), their slope per metre, and the way out."""
    distance = np.sqrt(dx * dx + dy * dy)
    if distance < 1e-9:
        return 1e3, 1.0, 0.0, 0.0
    ex, ey = dx / distance, dy / distance
    along_u, along_v = ex * J[0, 0] + ey * J[1, 0], ex * J[0, 1] + ey * J[1, 1]
    metres_per_pixel = np.sqrt(along_u * along_u + along_v * along_v)
    return (radius - distance) / metres_per_pixel, 1.0 / metres_per_pixel, ex, ey


@njit(cache=True)
def _window(floor, jacobian, box, q):  # type: ignore[no-untyped-def]
    """Pixels of the fit: the disc and a rim of 3 pixels or 0.35 radii around it."""
    size = (box[1] - box[0]) * (box[3] - box[2])
    rows, cols = np.empty(size, dtype=np.int64), np.empty(size, dtype=np.int64)
    n = 0
    for v in range(box[0], box[1]):
        for u in range(box[2], box[3]):
            dx, dy = floor[v, u, 0] - q[0], floor[v, u, 1] - q[1]
            if not np.isfinite(dx):
                continue
            gap, _, _, _ = _gap(dx, dy, jacobian[v, u], q[2])
            if gap >= -3.0 or dx * dx + dy * dy <= (1.35 * q[2]) ** 2:
                rows[n], cols[n] = v, u
                n += 1
    return rows[:n], cols[:n]


@njit(cache=True, fastmath=True)
def _evaluate(values, floor, jacobian, rows, cols, row, col, q, offsets, soft, design, residual):  # type: ignore[no-untyped-def]
    """Residuals and derivatives of the model; returns the sum of squares."""
    loss = 0.0
    count = len(offsets)
    reach = offsets[count - 1] * 1.5 + soft
    share = 1.0 / (count * count)
    for i in range(len(rows)):
        v, u = rows[i], cols[i]
        J = jacobian[v, u]
        px, py = floor[v, u, 0] - q[0], floor[v, u, 1] - q[1]
        gap, _, _, _ = _gap(px, py, J, q[2])
        cover = by_x = by_y = by_r = 0.0
        thin = px * px + py * py < q[2] * q[2] and _thinness(J, px, py, q[2]) < reach
        if gap < -reach:
            cover = 0.0
        elif gap > reach and not thin:
            cover = 1.0
        else:
            for s in range(count):
                for t in range(count):
                    dx = px + J[0, 0] * offsets[s] + J[0, 1] * offsets[t]
                    dy = py + J[1, 0] * offsets[s] + J[1, 1] * offsets[t]
                    g, per_metre, ex, ey = _gap(dx, dy, J, q[2])
                    if g >= soft:
                        cover += 1.0
                    elif g > -soft:
                        z = 0.5 * (g / soft + 1.0)
                        cover += z * z * (3.0 - 2.0 * z)
                        slope = 3.0 * z * (1.0 - z) / soft * per_metre
                        by_r += slope
                        by_x += slope * ex
                        by_y += slope * ey
            cover *= share
        light = q[4] + q[5] * (u - col) + q[6] * (v - row)
        paint = 1.0 + q[3] * cover
        design[i, 0] = light * q[3] * by_x * share
        design[i, 1] = light * q[3] * by_y * share
        design[i, 2] = light * q[3] * by_r * share
        design[i, 3] = light * cover
        design[i, 4] = paint
        design[i, 5] = paint * (u - col)
        design[i, 6] = paint * (v - row)
        residual[i] = values[i] - light * paint
        loss += residual[i] * residual[i]
    return loss


@njit(cache=True, fastmath=True)
def _thinness(J, dx, dy, radius):  # type: ignore[no-untyped-def]
    """Pixels to the disc's edge along the column or the row, whichever is nearer, from a point inside."""
    nearest = np.inf
    for k in range(2):
        a = J[0, k] * J[0, k] + J[1, k] * J[1, k]
        b = abs(J[0, k] * dx + J[1, k] * dy)
        c = radius * radius - dx * dx - dy * dy
        nearest = min(nearest, (np.sqrt(b * b + a * c) - b) / a)
    return nearest


@njit(cache=True)
def _hc3(design, residual, inverse):  # type: ignore[no-untyped-def]
    projected = design @ inverse
    for i in range(len(residual)):
        leverage = 0.0
        for a in range(PARAMETERS):
            leverage += projected[i, a] * design[i, a]
        weight = residual[i] / max(1.0 - leverage, 0.05)
        for a in range(PARAMETERS):
            projected[i, a] *= weight
    return projected.T @ projected
