"""The nouns of a scene. World frame: x east, y north, z up, metres; colours are linear sRGB."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from scenes.errors import SceneError
from scenes.photometry import ISOTROPIC, Photometry
from scenes.textures import Textures

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Rgb = tuple[float, float, float]


@dataclass(frozen=True)
class Material:
    """A glTF metallic-roughness material (with KHR_materials_specular's strength).

    Attributes
    ----------
    base_color : (r, g, b)
        Linear reflectance, 0…1 each.
    roughness : float
        Perceptual roughness 0…1; GGX α is its square.
    metallic : float
        0 dielectric … 1 metal.
    specular : float
        Strength of the dielectric's specular layer, 0…1; 0 leaves pure Lambert.
    """

    base_color: Rgb
    roughness: float
    metallic: float = 0.0
    specular: float = 1.0

    def __post_init__(self) -> None:
        values = (*self.base_color, self.roughness, self.metallic, self.specular)
        if len(self.base_color) != 3 or not all(0.0 <= v <= 1.0 for v in values):
            raise SceneError(f"material {self}: every value must lie in 0…1")


@dataclass(frozen=True, eq=False)
class Surface:
    """A named triangle mesh of one material. Triangles are one-sided: counter-clockwise seen from
    the side that reflects light.

    Attributes
    ----------
    vertices : (n, 3) float64, metres
    triangles : (m, 3) int64, indices into ``vertices``
    normals : (n, 3) float64, optional
        Unit normals at the vertices of a curved surface, which is shaded with the normals between them.
        Without them each triangle is flat.
    uv : (n, 2) float64, optional
        Texture coordinates at the vertices: u to the right, v down.
    textures : Textures, optional
        What varies the material over ``uv``.

    Raises
    ------
    SceneError
        If the normals are not one unit vector for each vertex, or textures have no coordinates.
    """

    name: str
    vertices: FloatArray
    triangles: IntArray
    material: Material
    normals: FloatArray | None = None
    uv: FloatArray | None = None
    textures: Textures | None = None

    def __post_init__(self) -> None:
        if self.textures is not None and (self.uv is None or self.uv.shape != (len(self.vertices), 2)):
            raise SceneError(f"surface {self.name!r}: textures need (u, v) at each vertex")
        if self.normals is None:
            return
        if self.normals.shape != self.vertices.shape:
            raise SceneError(
                f"surface {self.name!r}: normals are {self.normals.shape}, vertices {self.vertices.shape}"
            )
        length = np.linalg.norm(self.normals, axis=1)
        if not np.allclose(length, 1.0, atol=1e-3):
            raise SceneError(f"surface {self.name!r}: its normals must have unit length")


@dataclass(frozen=True)
class Sun:
    """Light from the sun's disc of half a degree.

    Attributes
    ----------
    azimuth_deg : float
        Where the sun stands, from north over east (compass bearing), degrees.
    elevation_deg : float
        Above the horizon, degrees. A sun below it is dark.
    lux : float
        Illuminance on a plane that faces the sun.
    illuminant : str
        CIE illuminant name, or a colour temperature such as "5200K".
    """

    azimuth_deg: float
    elevation_deg: float
    lux: float
    illuminant: str = "D55"
    name: str = "sun"

    def __post_init__(self) -> None:
        _intensity("sun", "lux", self.lux)
        if not np.isfinite([self.azimuth_deg, self.elevation_deg]).all():
            raise SceneError(
                f"sun: azimuth {self.azimuth_deg}, elevation {self.elevation_deg}; both must be finite"
            )

    @staticmethod
    def at(latitude_deg: float, longitude_deg: float, time: datetime, altitude_m: float = 0.0) -> Sun:
        """The sun at a place and time under a clear sky (`scenes.sun_position.clear_sky`)."""
        from scenes.sun_position import clear_sky

        return clear_sky(latitude_deg, longitude_deg, time, altitude_m)[0]

    @property
    def direction(self) -> FloatArray:
        """(3,) unit vector from the scene towards the sun."""
        a, e = np.radians([self.azimuth_deg, self.elevation_deg])
        return np.array([np.sin(a) * np.cos(e), np.cos(a) * np.cos(e), np.sin(e)])


@dataclass(frozen=True)
class Sky:
    """A uniform sky dome; ``lux`` is what it gives on open horizontal ground (luminance lux/π)."""

    lux: float
    illuminant: str = "D75"
    name: str = "sky"

    def __post_init__(self) -> None:
        _intensity("sky", "lux", self.lux)

    @staticmethod
    def at(latitude_deg: float, longitude_deg: float, time: datetime, altitude_m: float = 0.0) -> Sky:
        """The clear sky's diffuse light at a place and time (`scenes.sun_position.clear_sky`)."""
        from scenes.sun_position import clear_sky

        return clear_sky(latitude_deg, longitude_deg, time, altitude_m)[1]


@dataclass(frozen=True)
class Bulb:
    """A luminous sphere. Bulbs of one ``group`` share one layer of the light basis.

    Attributes
    ----------
    position : (x, y, z) metres
    lumen : float
        Total flux, whatever its distribution.
    radius : float
        Of the luminous sphere, metres: it sets how soft shadows are and how large the lamp's images.
    illuminant : str
        CIE illuminant name, or a colour temperature such as "2700K".
    aim : (x, y, z)
        Where the axis of ``photometry`` points; straight down unless given.
    photometry : Photometry
        Isotropic (``lumen``/4π candela), `Photometry.spot`, or `scenes.photometry_ies.read_ies`.
    """

    position: tuple[float, float, float]
    lumen: float
    radius: float = 0.05
    illuminant: str = "LED-B3"
    group: str = "bulbs"
    aim: tuple[float, float, float] = (0.0, 0.0, -1.0)
    photometry: Photometry = ISOTROPIC

    def __post_init__(self) -> None:
        _intensity(f"bulb at {self.position}", "lumen", self.lumen)
        if not (np.isfinite(self.radius) and self.radius > 0):
            raise SceneError(f"bulb at {self.position}: radius {self.radius} must be above 0 m")
        if not np.isfinite([*self.position, *self.aim]).all() or not any(self.aim):
            raise SceneError(f"bulb at {self.position}: position or aim {self.aim} not finite, or aim 0")


def _intensity(light: str, unit: str, value: float) -> None:
    if not (np.isfinite(value) and value >= 0):
        raise SceneError(f"{light}: {value} {unit}; must be finite and ≥ 0")


@dataclass(frozen=True)
class Landmark:
    """A painted disc on the floor.

    Attributes
    ----------
    position : (x, y) metres on the floor
    radius : float, metres
    white : bool
        White paint if true, black otherwise.
    """

    id: int
    position: tuple[float, float]
    radius: float
    white: bool


@dataclass(frozen=True, eq=False)
class Tour:
    """The robot's true track.

    Attributes
    ----------
    poses : (n, 3) float64
        x, y (metres) and heading (rad, counter-clockwise from +x) of each frame.
    stamps : (n,) float64
        Seconds from the first frame.
    """

    poses: FloatArray
    stamps: FloatArray


@dataclass(frozen=True, eq=False)
class Scene:
    """A place: geometry, floor landmarks, lights at their default intensity, and a tour through it.

    Attributes
    ----------
    suns : tuple of Sun
        Each has a layer of the light basis of its own, under its name: a place has one sun, or none
        indoors, a day as many as it is looked at. An illumination weights at most one.
    floor : str
        Name of the surface (z = 0) that carries the landmarks.
    inlays : tuple of str
        Surfaces let into the floor (z = 0) that carry them as well, such as a second colour of tile.
    paint_white, paint_black : (r, g, b)
        Linear reflectance of the landmark discs. Paint lies under the floor's polish: a disc changes the
        floor's base colour and keeps its gloss.
    bounds : (x_min, y_min, x_max, y_max)
        Of the floor plan, metres.
    notices : tuple of str
        What the user should know about how the scene was made, a line each.
    """

    name: str
    surfaces: tuple[Surface, ...]
    landmarks: tuple[Landmark, ...]
    suns: tuple[Sun, ...]
    sky: Sky
    bulbs: tuple[Bulb, ...]
    tour: Tour
    floor: str
    paint_white: Rgb
    paint_black: Rgb
    bounds: tuple[float, float, float, float]
    inlays: tuple[str, ...] = ()
    notices: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if [m.id for m in self.landmarks] != list(range(len(self.landmarks))):
            raise SceneError(f"scene {self.name!r}: its landmarks' ids must be 0, 1, 2 … in their order")
        missing = {self.floor, *self.inlays} - {s.name for s in self.surfaces}
        if missing:
            raise SceneError(f"scene {self.name!r}: its floor {sorted(missing)[0]!r} is none of its surfaces")
        named = [self.sky.name, *(sun.name for sun in self.suns), *{bulb.group for bulb in self.bulbs}]
        for name in named:
            if named.count(name) > 1:
                raise SceneError(f"scene {self.name!r}: two lights are named {name!r}; rename one of them")

    @cached_property
    def landmark_positions(self) -> FloatArray:
        """(n, 2) float64: the discs' centres on the floor, metres."""
        return np.array([m.position for m in self.landmarks], dtype=np.float64).reshape(-1, 2)
