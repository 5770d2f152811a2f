"""The network of `guarded`, run by OpenCV: how likely a highlight is at each pixel, how much of it is light.

The weights are an ONNX file, made by ``python -m tools.guarded.train_guarded`` from scenes of `train`. It
takes (1, 3, H, W) standardised codes, H and W multiples of 32, and gives (1, 16, H/2, W/2) logits: of each
cell of 2 × 2 pixels four numbers in rows (sub-pixel convolution, Shi et al. 2016), for the mask, then for
each channel's share.
"""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from vslam.errors import VslamError

MULTIPLE = 32
"""Five halvings."""

USUAL_PIXELS = 160 * 120
"""The size of picture that the network learned on; larger ones are shrunk by a whole number to about it."""


LEAST_SPREAD = 0.02
"""Added to the standard deviation, in codes 0…1, so that noise of an empty picture stays small."""


class LightNetwork:
    """Runs the network; not for two threads at once.

    Parameters
    ----------
    model : bytes
        ONNX.

    Raises
    ------
    VslamError
        If OpenCV cannot read it.
    """

    def __init__(self, model: bytes) -> None:
        buffer = np.frombuffer(model, dtype=np.uint8)
        # OpenCV 5's new engine is half as fast on this network; OpenCV 4 has the classic one alone
        engine = (cv2.dnn.ENGINE_CLASSIC,) if hasattr(cv2.dnn, "ENGINE_CLASSIC") else ()
        try:
            self._net = cv2.dnn.readNetFromONNX(buffer, *engine)
        except cv2.error as error:
            raise VslamError(
                f"light filter 'guarded': its weights cannot be read by OpenCV ({error.err})"
            ) from None

    def __call__(self, image: NDArray[np.uint8]) -> NDArray[np.float32]:
        """Logits of a picture.

        Parameters
        ----------
        image : (H, W, 3) uint8
            sRGB.

        Returns
        -------
        (16, ⌈H/2⌉ or more, ⌈W/2⌉ or more) float32
            By cell of 2 × 2 pixels.
        """
        below, right = (-side % MULTIPLE for side in image.shape[:2])
        padded = cv2.copyMakeBorder(image, 0, below, 0, right, cv2.BORDER_REPLICATE)
        self._net.setInput(standardised(np.asarray(padded, dtype=np.uint8)))
        logits: NDArray[np.float32] = self._net.forward()[0]
        return logits


def standardised(image: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Less the picture's mean, over its standard deviation: exposure and contrast then matter little.

    Parameters
    ----------
    image : (H, W, 3) uint8

    Returns
    -------
    (1, 3, H, W) float32
    """
    means, spreads = cv2.meanStdDev(image)
    mean = float(means.mean())
    spread = float(np.sqrt(np.mean(spreads**2 + (means - mean) ** 2)))
    scale = 1.0 / (spread + 255.0 * LEAST_SPREAD)
    return np.asarray(cv2.dnn.blobFromImage(image, scale, mean=(mean, mean, mean)), dtype=np.float32)


def load(name: str) -> tuple[LightNetwork, dict[str, Any]]:
    """A packaged network with the numbers chosen for it.

    Raises
    ------
    VslamError
        If it is missing or damaged.
    """
    folder = files("vslam.filters") / "weights"
    try:
        model = (folder / f"{name}.onnx").read_bytes()
        chosen = json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))["chosen"]
    except (OSError, ValueError, KeyError) as error:
        raise VslamError(
            f"light filter {name!r}: its weights are missing or damaged ({error}); install the package again"
        ) from None
    return LightNetwork(model), chosen


def shrink_factor(height: int, width: int) -> int:
    """By how much a picture is shrunk before the network sees it: 1 up to about 1.5 times the usual size."""
    return max(1, round(float(np.sqrt(height * width / USUAL_PIXELS))))
