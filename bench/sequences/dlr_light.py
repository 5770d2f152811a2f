"""Light composited onto the DLR robot's own pictures: a real picture, an exact mask, a known original.

The building rebuilt around the drive (`scenes.dlr_building`) gets a polished floor. What that floor would
throw at the robot's camera at a recorded pose, lobes of lamps and sun and mirror images of walls and windows,
is rendered by itself and added to the picture of that pose in linear light:

1. the picture is decoded as sRGB, which is an assumption: the camera's own curve is not known;
2. one factor ties the renderer's cd/m² to the picture: the ratio of medians on the floor, of the recorded
   picture over the rendered diffuse light under the building's own lamps. So light of any strength stands in
   its true proportion to theirs;
3. the specular light on the floor is added, clipped where the sensor would clip, and encoded.

What is not there: the diffuse light of the added lamps, the exposure that would follow them, and their shot
noise. Where furniture stood on the floor, light lies over it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.illumination_grid import Illumination
from bench.kinds.rendered import RenderedStudy
from bench.scene_choice import SceneChoice
from bench.sequences.rendered import RenderedSequence
from renderers.basis import LightBasis

FLOORS = ("floor", "tiles")
"""Surfaces of the scene that are polished."""

LUMINANCE = np.array([0.2126, 0.7152, 0.0722], dtype=np.float32)
"""Of linear sRGB (IEC 61966-2-1): the camera sees no colour."""


@dataclass(frozen=True, eq=False)
class Composite:
    """One picture with light.

    Attributes
    ----------
    image, original : (H, W, 3) uint8
        With light, and as recorded.
    highlight : (H, W) bool
        Where light exceeds the original by at least the threshold.
    """

    image: NDArray[np.uint8]
    original: NDArray[np.uint8]
    highlight: NDArray[np.bool_]


class FloorLight:
    """The specular light of the rebuilt building's floor at the poses of a sequence.

    Parameters
    ----------
    sequence : RenderedSequence
        Of `study_of`: its frames are those of the pictures.
    lumen : float
        Of each of the building's own lamps.
    """

    def __init__(self, sequence: RenderedSequence, lumen: float) -> None:
        self._sequence = sequence
        self._own = Illumination(name="own lamps", sun_lux=0.0, sky_lux=0.0, bulb_lm=lumen)
        names = [surface.name for surface in sequence.scene.surfaces]
        self._floors = [k for k, name in enumerate(names) if name in FLOORS]

    def basis(self, frame: int) -> LightBasis:
        """The light basis at a frame's pose; one serves all illuminations."""
        return self._sequence.basis(frame)

    def composite(
        self,
        picture: NDArray[np.uint8],
        basis: LightBasis,
        illumination: Illumination,
        frame: int,
        threshold: int,
    ) -> Composite:
        """Add an illumination's light to a frame's recorded picture; a view without floor stays as it is."""
        floor = np.isin(basis.surface, self._floors)
        diffuse, _ = self._sequence.relight(basis, self._own, frame)
        _, specular = self._sequence.relight(basis, illumination, frame)
        return composite(picture, diffuse @ LUMINANCE, specular @ LUMINANCE, floor, threshold)


def composite(
    picture: NDArray[np.uint8],
    diffuse: NDArray[np.float32],
    specular: NDArray[np.float32],
    floor: NDArray[np.bool_],
    threshold: int = 16,
) -> Composite:
    """Add specular light to a picture.

    Parameters
    ----------
    picture : (H, W, 3) uint8
        Grey, sRGB-encoded.
    diffuse, specular : (H, W) float32
        cd/m²: of the scene under its own lamps, and what is added.
    floor : (H, W) bool
        Where light is added.
    threshold : int
        Grey levels of 255 that count as a highlight.
    """
    from vslam.filters.stages.srgb import decode, encode

    linear = decode(picture)
    rendered = np.median(diffuse[floor]) if floor.any() else 0.0
    if not rendered > 0.0:
        return Composite(picture.copy(), picture, np.zeros(floor.shape, dtype=np.bool_))
    scale = np.median(linear[floor][:, 0]) / rendered
    added = np.where(floor, np.float32(scale) * specular, np.float32(0.0))[..., None]
    lit = np.where(added > 0.0, encode(np.minimum(linear + added, np.float32(1.0))), picture)
    exceeds = (lit.astype(np.int16) - picture).max(axis=2)
    return Composite(lit, picture, exceeds >= threshold)


def study_of(base: RenderedStudy, folder: Path, stride: int, floor_roughness: float) -> RenderedStudy:
    """The rebuilt building along every so many steps of the drive, under a study's illuminations.

    Parameters
    ----------
    base : RenderedStudy
        Says illuminations, engine and camera.
    folder : Path
        Of the log.
    """
    parameters = {"log": str(folder), "stride": stride, "floor_roughness": floor_roughness}
    return base.model_copy(update={"scene": SceneChoice(name="dlr_building", parameters=parameters)})
