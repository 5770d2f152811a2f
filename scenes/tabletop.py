"""The scene ``tabletop``: single objects on a table, from matt to mirror, for the light filter alone."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from scenes import discs
from scenes.errors import SceneError
from scenes.geometry import box, join, surface
from scenes.library import scene
from scenes.materials import (
    BLACK_GLOSS,
    BRICK,
    CEILING,
    CHROME,
    DISC_BLACK,
    DISC_WHITE,
    GOLD,
    GROUND,
    LIGHT_WOOD,
    WHITE_WALL,
    WOOD,
)
from scenes.model import Bulb, Landmark, Material, Scene, Sky, Sun, Surface
from scenes.room import Opening, Room, ground, panes
from scenes.shapes import Piece, cone, curved_surface, cylinder, lathe, place, sphere
from scenes.splits import stream
from scenes.tour import orbit

TABLE_RADIUS_M, TABLE_HEIGHT_M, ORBIT_M = 0.85, 0.72, 1.5
RINGS_M = ((0.30, 4), (0.64, 8))
"""Where objects stand: radius of a ring on the table, and how many places it has."""

BULB_LM, BULB_RADIUS_M = 800.0, 0.06

PICTURE = Material((0.03, 0.10, 0.42), roughness=0.25)
FLOOR = Material((0.30, 0.28, 0.25), roughness=0.30)
OBJECTS = {
    "white matt": Material((0.82, 0.82, 0.81), roughness=0.9, specular=0.3),
    "white glaze": Material((0.80, 0.80, 0.78), roughness=0.12),
    "grey matt": Material((0.30, 0.30, 0.30), roughness=0.9, specular=0.3),
    "grey gloss": Material((0.30, 0.30, 0.30), roughness=0.15),
    "red gloss": Material((0.50, 0.04, 0.03), roughness=0.12),
    "green satin": Material((0.06, 0.26, 0.08), roughness=0.40),
    "blue gloss": Material((0.03, 0.10, 0.42), roughness=0.22),
    "yellow matt": Material((0.66, 0.46, 0.04), roughness=0.85, specular=0.4),
    "black gloss": BLACK_GLOSS,
    "chrome": CHROME,
    "gold": GOLD,
    "orange satin": Material((0.60, 0.18, 0.02), roughness=0.35),
}
"""Coloured, white and grey; matt to mirror. The first ``objects`` of a shuffled order are shown."""


@scene("tabletop")
def build(
    seed: int = 0,
    speed_mps: float = 0.93,
    frame_interval_s: float = 0.5,
    laps: float = 1.25,
    objects: int = 12,
) -> Scene:
    """Single objects on a round table by a window: coloured, white and grey, matt to mirror, curved and flat.

    Parameters
    ----------
    seed : int
        Sizes the room; gives each object its shape, size and place.
    speed_mps, frame_interval_s, laps : float
        The tour: round the table with the camera towards it.
    objects : int
        How many of the twelve stand on the table.

    Raises
    ------
    SceneError
        If there are not so many objects.
    """
    if not 1 <= objects <= len(OBJECTS):
        raise SceneError(f"scene 'tabletop': objects {objects}; there are 1 to {len(OBJECTS)}")
    size = stream(seed, "tabletop", "room").uniform((5.6, 5.8, 2.6), (6.6, 6.6, 2.9))
    room = Room(*size.tolist())
    x, y = room.width / 2, room.depth / 2
    furniture = [
        *_table(x, y),
        *_objects(x, y, objects, stream(seed, "tabletop", "objects")),
        _sideboard(room, stream(seed, "tabletop", "sideboard")),
    ]
    return Scene(
        name="tabletop",
        surfaces=(*_shell(room, stream(seed, "tabletop", "walls")), *furniture),
        landmarks=_landmarks(x, y, stream(seed, "tabletop", "landmarks"), furniture),
        suns=(Sun(azimuth_deg=172.0, elevation_deg=24.0, lux=30_000.0),),
        sky=Sky(lux=4_000.0),
        bulbs=_bulbs(room),
        tour=orbit((x, y), ORBIT_M, laps, speed_mps, frame_interval_s),
        floor="floor",
        paint_white=DISC_WHITE,
        paint_black=DISC_BLACK,
        bounds=(0.0, 0.0, room.width, room.depth),
    )


def _shell(room: Room, rng: np.random.Generator) -> list[Surface]:
    """The room: a window to the south, a picture on the west wall and a door in the east one."""
    w, d = room.width, room.depth
    picture_left, door_left = (d * rng.uniform((0.35, 0.3), (0.5, 0.4))).tolist()
    picture = Opening(picture_left, picture_left + 0.9, 1.1, 1.8, 0.0)
    door = Opening(door_left, door_left + 0.9, 0.0, 2.05, 0.0)
    glazing = panes(Opening(w / 2 - 1.5, w / 2 + 1.5, 0.8, 2.4), 2, 1, 0.1)
    return [
        surface("floor", FLOOR, room.floor(0.35)),
        surface("ceiling", CEILING, *room.wall("ceiling")),
        surface("wall", WHITE_WALL, *room.walls({"south": glazing, "west": [picture], "east": [door]})),
        surface("picture", PICTURE, room.panel("west", picture)),
        surface("door", LIGHT_WOOD, room.panel("east", door)),
        surface("ground", GROUND, ground()),
        surface("house opposite", BRICK, box((-8, -34, -0.3), (w + 8, -30, 5), max_edge_m=4.0)),
    ]


def _table(x: float, y: float) -> list[Surface]:
    r, h = TABLE_RADIUS_M, TABLE_HEIGHT_M
    top = [
        lathe([(r, h - 0.04), (r, h)], 40),
        lathe([(r, h), (0.8 * r, h), (0.6 * r, h), (0.4 * r, h), (0.2 * r, h), (0.0, h)], 40),
        lathe([(0.0, h - 0.04), (r, h - 0.04)], 40),
    ]
    return [
        curved_surface("table", LIGHT_WOOD, *(place(p, (x, y, 0)) for p in top)),
        curved_surface(
            "table foot",
            WOOD,
            place(cylinder(0.08, h - 0.04), (x, y, 0)),
            place(lathe([(0.35, 0.0), (0.33, 0.03), (0.08, 0.06)]), (x, y, 0)),
        ),
    ]


def _can(size: float) -> Piece:
    return cylinder(0.8 * size, 2.2 * size, size)


def _cone(size: float) -> Piece:
    return cone(size, 2.4 * size)


def _vase(size: float) -> Piece:
    """Foot, belly, neck and lip; the inside is closed by a lid below the lip."""
    outline = [(0.55, 0.0), (0.85, 0.5), (0.95, 1.0), (0.8, 1.5), (0.5, 1.9), (0.42, 2.2), (0.55, 2.5)]
    inside = [(0.55, 2.5), (0.38, 2.2), (0.0, 2.15)]
    return join([lathe([(size * r, size * z) for r, z in part]) for part in (outline, inside)])


def _block(size: float) -> Piece:
    return box((-0.8 * size, -0.8 * size, 0), (0.8 * size, 0.8 * size, 1.6 * size))


def _board(size: float) -> Piece:
    """A flat panel that leans back."""
    panel = box((-size, -0.008, 0), (size, 0.008, 2.4 * size), bottom=True)
    return place(panel, (0, 0, 0.003), 0.0, -25.0)


CURVED: tuple[Callable[[float], Piece], ...] = (sphere, _can, _vase, _cone)
FLAT: tuple[Callable[[float], Piece], ...] = (_block, _board)


def _objects(x: float, y: float, count: int, rng: np.random.Generator) -> list[Surface]:
    places = [
        (radius * np.cos(angle), radius * np.sin(angle))
        for radius, number in RINGS_M
        for angle in rng.uniform(0, 2 * np.pi) + 2 * np.pi * np.arange(number) / number
    ]
    places = [places[k] for k in rng.permutation(len(places))]
    shapes = [*CURVED, *CURVED, *FLAT, *FLAT]
    shapes = [shapes[k] for k in rng.permutation(len(shapes))]
    named = [list(OBJECTS)[k] for k in rng.permutation(len(OBJECTS))]
    surfaces = []
    for name, shape, (dx, dy) in list(zip(named, shapes, places, strict=True))[:count]:
        size, yaw = float(rng.uniform(0.085, 0.125)), float(rng.uniform(0, 360))
        piece = place(shape(size), (x + dx, y + dy, TABLE_HEIGHT_M), yaw)
        make = curved_surface if shape in CURVED else surface
        surfaces.append(make(name, OBJECTS[name], piece))
    return surfaces


def _sideboard(room: Room, rng: np.random.Generator) -> Surface:
    left, deep = float(rng.uniform(0.5, 1.2)), room.depth
    return surface("sideboard", WOOD, box((left, deep - 0.4, 0), (left + 1.8, deep, 0.8)))


def _landmarks(
    x: float, y: float, rng: np.random.Generator, furniture: list[Surface]
) -> tuple[Landmark, ...]:
    """Two rings of discs about the table: before the robot, and behind the table."""
    centres, white = [], []
    for radius, count in ((1.14, 8), (2.15, 11)):
        turn = rng.uniform(0, 2 * np.pi)
        for k in range(count):
            angle = turn + 2 * np.pi * (k + rng.uniform(-0.2, 0.2)) / count
            reach = radius + rng.uniform(-0.04, 0.04)
            centres.append((x + reach * np.cos(angle), y + reach * np.sin(angle)))
            white.append(bool(rng.random() < discs.WHITE_SHARE))
    radii = rng.uniform(0.10, 0.16, len(centres))
    return discs.accepted(np.array(centres), radii, white, furniture)


def _bulbs(room: Room) -> tuple[Bulb, ...]:
    return tuple(
        Bulb((room.width * a, room.depth * b, room.height - 0.35), BULB_LM, BULB_RADIUS_M)
        for a, b in ((0.3, 0.4), (0.7, 0.4), (0.5, 0.75))
    )
