"""From the user's file to a `Scene`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from bench.file_scene import FileScene
from bench.kinds.rendered import RenderedStudy
from bench.own_scene.ground import Ground, bounds_of, ground_of
from bench.own_scene.marks import beside, marked, placed
from bench.own_scene.way import Way, planned, through
from bench.rng import generator
from scenes.errors import SceneError
from scenes.floor import laid
from scenes.geometry import MAX_EDGE_M
from scenes.gltf.importer import Mark, load
from scenes.materials import DISC_BLACK, DISC_WHITE
from scenes.model import Bulb, FloatArray, Landmark, Scene, Sky, Sun, Surface
from scenes.tessellate import tessellate
from scenes.waypoints import follow

MORE_VERTICES = 12_000
"""What splitting large triangles may add; more cost baking time and show little."""

COARSER = 1.3
FAR_EDGE = 0.5
"""Longest edge away from the floor, as a share of the distance to it: what is far away looks small."""

SIGHT_M = 12.0
"""The robot's range (Table 4-1): the plan reaches so far around its way."""

USUAL_SUN = Sun(azimuth_deg=180.0, elevation_deg=40.0, lux=20_000.0)
USUAL_SKY = Sky(2_500.0)


@dataclass(frozen=True)
class Drive:
    """How the robot drives its tour: m/s, seconds between frames, and its radius in metres."""

    speed_mps: float
    interval_s: float
    radius_m: float


def build(study: RenderedStudy) -> Scene:
    """The scene of a study that names a file; read again only if file or study change.

    Raises
    ------
    SceneError
        In one line, for whatever is wrong with the file, its floor, its tour or its landmarks.
    """
    choice, tour = study.scene.file, study.tour
    assert choice is not None
    path = Path(choice.path).expanduser()
    stamp = path.stat().st_mtime_ns if path.is_file() else 0
    drive = Drive(tour.speed_mps, tour.frame_interval_s, study.navigation.robot_radius_m)
    return _build(path, stamp, choice, study.scene.name, study.scene.seed, drive)


@lru_cache(maxsize=2)  # of the process: a large file takes a while to read
def _build(path: Path, stamp: int, choice: FileScene, name: str, seed: int, drive: Drive) -> Scene:
    found = load(path)
    floored = laid(found.surfaces, choice.floor)
    surfaces = tessellated(floored.surfaces, floored.floor)
    ground = ground_of(surfaces, floored.floor)
    way = _way(choice, found.marks, ground, drive.radius_m, name)
    return Scene(
        name=name,
        surfaces=surfaces,
        landmarks=_landmarks(choice, found.marks, ground, way, seed, name),
        suns=(_sun(choice, found.suns),),
        sky=USUAL_SKY,
        bulbs=tuple(_lowered(bulb, floored.level_m) for bulb in found.bulbs),
        tour=follow(way.points, way.closed, choice.laps, drive.speed_mps, drive.interval_s),
        floor=floored.floor[0],
        inlays=floored.floor[1:],
        paint_white=DISC_WHITE,
        paint_black=DISC_BLACK,
        bounds=_bounds(surfaces, floored.floor, way),
        notices=found.notices + _about_lamps(found.bulbs),
    )


def tessellated(surfaces: Sequence[Surface], floor: Sequence[str]) -> tuple[Surface, ...]:
    """All surfaces in triangles small enough for baked light, coarser away from the floor.

    Where that would add more than `MORE_VERTICES`, all are coarser.
    """
    x0, y0, x1, y1 = bounds_of([s for s in surfaces if s.name in floor])
    low, high = np.array([x0, y0]), np.array([x1, y1])
    most = sum(len(s.vertices) for s in surfaces) + MORE_VERTICES
    shortest = MAX_EDGE_M
    while True:

        def limit(middle: FloatArray, edge: float = shortest) -> FloatArray:
            away = np.linalg.norm(
                np.maximum(np.maximum(low - middle[:, :2], middle[:, :2] - high), 0), axis=1
            )
            return np.asarray(np.maximum(edge, FAR_EDGE * away))

        split: list[Surface] = []
        left = most
        for surface in surfaces:
            fine = tessellate(surface, limit, left)
            if fine is None:
                break
            split.append(fine)
            left -= len(fine.vertices)
        else:
            return tuple(split)
        shortest *= COARSER


def _way(choice: FileScene, marks: Sequence[Mark], ground: Ground, radius_m: float, name: str) -> Way:
    points = list(choice.tour)
    if not points:
        stops = sorted((m for m in marks if m.name.lower().startswith("tour")), key=lambda m: _number(m.name))
        points = [m.position[:2] for m in stops]
    if not points:
        return planned(ground, radius_m, choice.longest_m, name)
    if len(points) < 2:
        raise SceneError(f"scene {name!r}: a tour needs at least two way-points")
    return through(np.array(points, dtype=np.float64), choice.closed, ground, radius_m, name)


def _number(name: str) -> tuple[int, str]:
    """The first number in a name, and the name: tour2 comes before tour10."""
    digits = re.search(r"\d+", name)
    return int(digits.group()) if digits else -1, name


def _landmarks(
    choice: FileScene, marks: Sequence[Mark], ground: Ground, way: Way, seed: int, name: str
) -> tuple[Landmark, ...]:
    listed = [(x, y, r, colour == "white") for x, y, r, colour in choice.landmarks or ()] or marked(marks)
    if listed or choice.landmarks is not None:
        return placed(listed, ground, name)
    return beside(way, ground, generator(seed, "landmarks"))


def _sun(choice: FileScene, suns: Sequence[Sun]) -> Sun:
    """The file's brightest directional light from above, or the usual sun, turned as the study says."""
    sun = next((s for s in suns if s.elevation_deg > 0), USUAL_SUN)
    azimuth, elevation = choice.sun_azimuth_deg, choice.sun_elevation_deg
    return replace(
        sun,
        azimuth_deg=sun.azimuth_deg if azimuth is None else azimuth,
        elevation_deg=sun.elevation_deg if elevation is None else elevation,
    )


def _lowered(bulb: Bulb, level_m: float) -> Bulb:
    x, y, z = bulb.position
    return replace(bulb, position=(x, y, z - level_m))


def _bounds(surfaces: Sequence[Surface], floor: Sequence[str], way: Way) -> tuple[float, float, float, float]:
    """The floor's, no farther from the way than the robot sees."""
    x0, y0, x1, y1 = bounds_of([s for s in surfaces if s.name in floor])
    (a, b), (c, d) = way.points.min(axis=0) - SIGHT_M, way.points.max(axis=0) + SIGHT_M
    return max(x0, float(a)), max(y0, float(b)), min(x1, float(c)), min(y1, float(d))


def _about_lamps(bulbs: Sequence[Bulb]) -> tuple[str, ...]:
    if not bulbs:
        return (
            "the file has no lamps (KHR_lights_punctual), so bulb_lm changes nothing: sun and sky light it",
        )
    lumen = [bulb.lumen for bulb in bulbs]
    return (
        f"the file's {len(lumen)} lamps give {min(lumen):.0f} to {max(lumen):.0f} lm; the study's bulb_lm "
        "stands for each of them",
    )
