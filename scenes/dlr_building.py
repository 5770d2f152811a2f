"""The scene ``dlr_building``: the building of the DLR log, rebuilt around the drive that recorded it.

Track and discs are the log's own. Walls stand around what the robot swept and saw (`scenes.driven_space`);
doors, windows and lamps, which the log does not tell, are set in customary sizes.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scenes.drive_log import DriveLog
from scenes.driven_space import DrivenSpace, driven_space
from scenes.driven_walls import HEIGHT_M, build_walls
from scenes.errors import SceneError
from scenes.geometry import box, rectangle, surface
from scenes.library import scene
from scenes.materials import DISC_BLACK, DISC_WHITE
from scenes.model import Bulb, FloatArray, IntArray, Landmark, Material, Scene, Sky, Sun, Surface, Tour
from scenes.photometry import Photometry
from scenes.planar_mesh import triangulate

DISC_RADIUS_M = 0.095
"""Median of the discs on the pictures' floor; 0.10 nominal."""

MAX_EDGE_M = 0.8
LUMEN, LAMP_RADIUS_M = 3000.0, 0.08
"""A recessed luminaire of four 18 W tubes (1,350 lm each) that gives off 55 % of their light."""
LAMP_SPACING_M, LAMP_M, POST_SPACING_M, POST_M, POST_ASIDE_M = 3.6, 2.62, 9.0, 3.5, 2.2
RECESSED = Photometry.spot(0.0, 75.0)
"""Set into the ceiling: nothing within 15° of it, so that a lamp lights no more than 10 m of a corridor."""

CARPET = Material((0.085, 0.085, 0.090), roughness=1.0, specular=0.0)
TILES = Material((0.42, 0.41, 0.39), roughness=0.5)
PAVING = Material((0.20, 0.19, 0.18), roughness=0.95, specular=0.3)
WHITE_WALL = Material((0.80, 0.79, 0.77), roughness=0.9, specular=0.3)
CEILING = Material((0.82, 0.82, 0.81), roughness=0.95, specular=0.2)
DOOR = Material((0.15, 0.085, 0.045), roughness=0.45)
FACADE = Material((0.55, 0.53, 0.50), roughness=0.95, specular=0.2)
STEEL = Material((0.56, 0.57, 0.58), roughness=0.40, metallic=1.0)
GROUND = Material((0.07, 0.10, 0.04), roughness=1.0, specular=0.0)
PAVING_Z, GROUND_Z = -0.001, -0.05


@scene("dlr_building")
def build(
    seed: int = 0,
    speed_mps: float = 0.93,
    frame_interval_s: float = 0.4,
    log: DriveLog | None = None,
    first: int = 0,
    frames: int | None = None,
    stride: int = 1,
    floor_roughness: float | None = None,
) -> Scene:
    """The DLR log's building: its discs, walls around its drive, and the drive itself (needs the log).

    Parameters
    ----------
    seed : int
        Says which rooms have windows, and places doors.
    speed_mps : float
        Not used: the recorded steps say how far the robot went in each.
    frame_interval_s : float
        Between two recorded steps, as the log has no clock.
    log : DriveLog
        The recorded drive.
    first, frames, stride : int
        The tour starts at a recorded step and takes every ``stride``-th, so many or all.
    floor_roughness : float, optional
        Of a polish over carpet and tiles, 0…1; without one the carpet is matt, as the real one is.

    Raises
    ------
    SceneError
        Without a log, or for steps that it does not have.
    """
    if not isinstance(log, DriveLog):
        raise SceneError("scene 'dlr_building': needs the DLR log; get it with: python -m bench fetch dlr")
    space = driven_space(log)
    posts = _posts(log, space)
    floors = [_polished(one, floor_roughness) for one in _floors(log, space)]
    surfaces = (*floors, *_shell(log, space, seed), *_outdoors(space, posts))
    return Scene(
        name="dlr_building",
        surfaces=surfaces,
        landmarks=_landmarks(log),
        suns=(Sun(azimuth_deg=215.0, elevation_deg=35.0, lux=20_000.0),),
        sky=Sky(lux=2_500.0),
        bulbs=_lamps(log, posts),
        tour=_tour(log, frame_interval_s, first, frames, stride),
        floor="floor",
        paint_white=DISC_WHITE,
        paint_black=DISC_BLACK,
        bounds=_bounds(space),
        inlays=tuple(s.name for s in surfaces if s.name in ("tiles", "paving")),
    )


def _tour(log: DriveLog, interval_s: float, first: int, frames: int | None, stride: int) -> Tour:
    rows = np.arange(len(log.poses))
    if not (0 <= first < len(rows) and stride >= 1 and (frames is None or frames >= 1)):
        raise SceneError(
            f"scene 'dlr_building': first {first}, frames {frames}, stride {stride}; "
            f"the log has {len(rows)} steps, frames and stride start at 1"
        )
    chosen = rows[first::stride][:frames]
    return Tour(log.poses[chosen], interval_s * (chosen - first).astype(np.float64))


def _landmarks(log: DriveLog) -> tuple[Landmark, ...]:
    return tuple(
        Landmark(k, (x, y), DISC_RADIUS_M, bool(white))
        for k, ((x, y), white) in enumerate(zip(log.discs.tolist(), log.white, strict=True))
    )


def _bounds(space: DrivenSpace) -> tuple[float, float, float, float]:
    corners = np.concatenate(space.rings(space.indoor | space.outdoor))
    (x0, y0), (x1, y1) = corners.min(axis=0) - 1.0, corners.max(axis=0) + 1.0
    return float(x0), float(y0), float(x1), float(y1)


def _floors(log: DriveLog, space: DrivenSpace) -> list[Surface]:
    """Carpet, and tiles where most of the five nearest discs lie on a light floor."""
    from scipy.spatial import cKDTree

    vertices, triangles = triangulate(space.rings(space.indoor), MAX_EDGE_M)
    cell = np.floor(vertices[triangles].mean(axis=1) / MAX_EDGE_M)  # borders follow the mesh's grid
    _, nearest = cKDTree(log.discs).query((cell + 0.5) * MAX_EDGE_M, k=min(5, len(log.discs)))
    light = log.light_floor[nearest.reshape(len(cell), -1)].mean(axis=1) > 0.5
    kinds = [("floor", CARPET, ~light), ("tiles", TILES, light)]
    return [_level(name, m, vertices, triangles[chosen], 0.0) for name, m, chosen in kinds if chosen.any()]


def _polished(floor: Surface, roughness: float | None) -> Surface:
    """The floor under a dielectric polish, as sealed linoleum has it."""
    if roughness is None:
        return floor
    return replace(floor, material=Material(floor.material.base_color, roughness=roughness))


def _level(name: str, material: Material, vertices: FloatArray, triangles: IntArray, z: float) -> Surface:
    """A plane mesh as a surface at a height."""
    used, compact = np.unique(triangles, return_inverse=True)
    at_height = np.column_stack([vertices[used], np.full(len(used), z)])
    return Surface(name, at_height, compact.reshape(-1, 3).astype(np.int64), material)


def _shell(log: DriveLog, space: DrivenSpace, seed: int) -> list[Surface]:
    """Walls with what is in them, and the ceiling."""
    walls = build_walls(space, log.poses, np.random.default_rng([seed, *b"walls"]))
    pieces = [
        ("wall", WHITE_WALL, [piece for wall in walls for piece in wall.inner_face(MAX_EDGE_M)]),
        ("facade", FACADE, [piece for wall in walls for piece in wall.outer_face()]),
        ("door", DOOR, [piece for wall in walls for piece in wall.leaves()]),
    ]
    vertices, triangles = triangulate(space.rings(space.indoor), MAX_EDGE_M)
    ceiling = _level("ceiling", CEILING, vertices, triangles[:, ::-1], HEIGHT_M)
    return [*(surface(name, material, *parts) for name, material, parts in pieces if parts), ceiling]


def _outdoors(space: DrivenSpace, posts: list[tuple[float, float]]) -> list[Surface]:
    """The way outdoors, the ground around everything, and lamp posts."""
    x0, y0, x1, y1 = _bounds(space)
    far = 200.0
    ground = rectangle(
        (x0 - far, y0 - far, GROUND_Z), (x1 - x0 + 2 * far, 0, 0), (0, y1 - y0 + 2 * far, 0), max_edge_m=15.0
    )
    surfaces = [surface("ground", GROUND, ground)]
    if space.outdoor.any():
        way = triangulate(space.rings(space.beyond_gates()), MAX_EDGE_M)
        surfaces.append(_level("paving", PAVING, *way, PAVING_Z))
    if posts:
        poles = [
            box((x - 0.05, y - 0.05, GROUND_Z), (x + 0.05, y + 0.05, POST_M - 0.15), 2.0) for x, y in posts
        ]
        surfaces.append(surface("post", STEEL, *poles))
    return surfaces


def _lamps(log: DriveLog, posts: list[tuple[float, float]]) -> tuple[Bulb, ...]:
    """Ceiling luminaires along the indoor track, and one on each post."""
    rows = np.arange(len(log.poses))
    indoors = log.poses[(rows < log.outdoors[0]) | (rows >= log.outdoors[1]), :2]
    ceiling = [(x, y, LAMP_M) for x, y in spaced(indoors, LAMP_SPACING_M).tolist()]
    outdoors = [(x, y, POST_M) for x, y in posts]
    return tuple(
        Bulb(place, LUMEN, LAMP_RADIUS_M, illuminant="FL4", photometry=RECESSED)
        for place in [*ceiling, *outdoors]
    )


def spaced(points: FloatArray, apart_m: float) -> FloatArray:
    """Those of (n, 2) points, in their order, that are no nearer than ``apart_m`` to an earlier one taken."""
    taken = np.empty((0, 2))
    for point in points:
        if not len(taken) or np.hypot(*(taken - point).T).min() >= apart_m:
            taken = np.vstack([taken, point])
    return taken


def _posts(log: DriveLog, space: DrivenSpace) -> list[tuple[float, float]]:
    """Beside the outdoor track, off the way, where there is room on its left or its right."""
    outdoors = log.poses[slice(*log.outdoors)]
    posts = []
    for place in spaced(outdoors[:, :2], POST_SPACING_M):
        heading = outdoors[np.hypot(*(outdoors[:, :2] - place).T).argmin(), 2]
        left = POST_ASIDE_M * np.array([-np.sin(heading), np.cos(heading)])
        free = [
            side
            for side in (place + left, place - left)
            if not space.holds(space.indoor | space.outdoor, side)
        ]
        posts += [(float(x), float(y)) for x, y in free[:1]]
    return posts
