"""A light filter out of an ONNX file, run by onnxruntime on one CPU thread.

The model's contract:

- One input, float32 (N, 3, H, W), RGB in 0…1; N = 1. Linear light, unless the model's metadata property
  ``glarebench.encoding`` is ``srgb`` (codes / 255).
- Outputs by name, at least one of them, float32: ``image`` (N, 3, H, W), the repaired picture in the input's
  encoding; ``score`` (N, 1, H, W) or (N, H, W), evidence of a highlight in 0…1. Both are clipped to 0…1.
- The mask is where the score reaches ``glarebench.threshold`` (a metadata property; 0.5 without it).
- A model without ``score`` is scored by what it changes: the largest change of a channel; its mask is, for
  want of another threshold, where that reaches one of 255 levels. One without ``image`` detects only.
- ``glarebench.multiple``: the model's sides must be multiples of this; the picture is padded at its right and
  lower border with its own edge, and the answer cut back.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vslam.errors import VslamError
from vslam.filters.base import Filtered, PictureForm

THRESHOLD = 0.5
ONE_LEVEL = 1.0 / 255.0

_OUTPUTS = ("image", "score")
_FORMS = {"linear": PictureForm.LINEAR, "srgb": PictureForm.SRGB8}


@dataclass(frozen=True)
class _Contract:
    """What a model's metadata says."""

    form: PictureForm
    threshold: float
    multiple: int


class OnnxFilter:
    """A light filter that is a neural network.

    Parameters
    ----------
    path : str
        Of the ``.onnx`` file.

    Raises
    ------
    VslamError
        When onnxruntime is not installed, the file is missing or no model, or the model is not as this
        module says.
    """

    def __init__(self, path: str) -> None:
        self.name = path
        self._session = _session(path)
        self._outputs = _checked_outputs(self._session, path)
        metadata = self._session.get_modelmeta().custom_metadata_map
        self._contract = _contract(metadata, THRESHOLD if "score" in self._outputs else ONE_LEVEL, path)
        self.wants = self._contract.form

    def __call__(self, image: NDArray[Any]) -> Filtered:
        """Run the model on one picture in the form it wants."""
        full = np.float32(255.0 if self.wants is PictureForm.SRGB8 else 1.0)
        picture = image.astype(np.float32) / full
        tensor = _padded(picture.transpose(2, 0, 1)[None], self._contract.multiple)
        answers = self._session.run(list(self._outputs), {self._session.get_inputs()[0].name: tensor})
        parts = {
            name: _part(answer, name, *image.shape[:2])
            for name, answer in zip(self._outputs, answers, strict=True)
        }
        repaired = parts.get("image", picture)
        score = parts.get("score", np.abs(repaired - picture))
        strongest = score.max(axis=2)
        mask = strongest >= np.float32(self._contract.threshold)
        return Filtered(_as(image.dtype, repaired, full), mask, strongest)


def _session(path: str) -> Any:
    try:
        import onnxruntime
    except ImportError:
        raise VslamError(
            f"light filter {path!r}: onnxruntime is not installed; pip install glarebench[onnx]"
        ) from None
    if not Path(path).is_file():
        raise VslamError(f"light filter {path!r}: there is no such file")
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1  # as every other filter; and repeatable
    options.log_severity_level = 4  # what goes wrong is raised
    try:
        return onnxruntime.InferenceSession(path, options, providers=["CPUExecutionProvider"])
    except Exception as error:  # onnxruntime's own types are not public
        reason = str(error).strip().splitlines()[0]
        raise VslamError(f"light filter {path!r}: onnxruntime cannot load it: {reason}") from None


def _checked_outputs(session: Any, path: str) -> tuple[str, ...]:
    inputs = session.get_inputs()
    if len(inputs) != 1 or inputs[0].type != "tensor(float)" or len(inputs[0].shape) != 4:
        given = ", ".join(f"{i.name} {i.type} {i.shape}" for i in inputs) or "none"
        raise VslamError(
            f"light filter {path!r}: its inputs are {given}; a filter has one, float32 (N, 3, H, W)"
        )
    found = tuple(o.name for o in session.get_outputs())
    known = tuple(name for name in _OUTPUTS if name in found)
    if not known:
        raise VslamError(
            f"light filter {path!r}: its outputs are {', '.join(found)}; a filter has image, score or both"
        )
    return known


def _contract(metadata: dict[str, str], default_threshold: float, path: str) -> _Contract:
    encoding = metadata.get("glarebench.encoding", "linear").lower()
    if encoding not in _FORMS:
        raise VslamError(
            f"light filter {path!r}: glarebench.encoding is {encoding!r}; give 'linear' or 'srgb'"
        )
    try:
        threshold = float(metadata.get("glarebench.threshold", default_threshold))
        multiple = int(metadata.get("glarebench.multiple", "1"))
    except ValueError as error:
        raise VslamError(f"light filter {path!r}: its metadata holds no number: {error}") from None
    if not 0.0 <= threshold <= 1.0 or multiple < 1:
        raise VslamError(
            f"light filter {path!r}: glarebench.threshold {threshold:g} must lie in 0…1 and "
            f"glarebench.multiple {multiple} be at least 1"
        )
    return _Contract(_FORMS[encoding], threshold, multiple)


def _padded(tensor: NDArray[np.float32], multiple: int) -> NDArray[np.float32]:
    """(1, 3, H, W) with sides that are multiples, contiguous."""
    below, right = (-side % multiple for side in tensor.shape[2:])
    if below or right:
        return np.pad(tensor, ((0, 0), (0, 0), (0, below), (0, right)), mode="edge")
    return np.ascontiguousarray(tensor)


def _part(answer: NDArray[Any], name: str, height: int, width: int) -> NDArray[np.float32]:
    """An output as (H, W, 3) or (H, W, 1) float32 in 0…1."""
    channels = 3 if name == "image" else 1
    if np.isnan(answer).any():
        raise VslamError(f"its output {name!r} holds NaN")
    if name == "score" and answer.ndim == 3:
        answer = answer[:, None]
    if answer.ndim != 4 or answer.shape[:2] != (1, channels) or answer.dtype != np.float32:
        raise VslamError(
            f"its output {name!r} is {answer.dtype} {answer.shape}, not float32 (1, {channels}, H, W)"
        )
    if answer.shape[2] < height or answer.shape[3] < width:
        raise VslamError(f"its output {name!r} is {answer.shape[2:]}, smaller than ({height}, {width})")
    return np.ascontiguousarray(np.clip(answer[0, :, :height, :width], 0.0, 1.0).transpose(1, 2, 0))


def _as(dtype: np.dtype[Any], values: NDArray[np.float32], full: np.float32) -> NDArray[Any]:
    """0…1 in the picture's type."""
    return values if dtype == np.float32 else np.rint(values * full).astype(dtype)
