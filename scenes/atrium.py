"""The scene ``atrium``: a tall hall with a glazed front, direct sun on polished tiles, and a mirror ball."""

from __future__ import annotations

import numpy as np

from scenes import discs
from scenes.geometry import box, checker, surface
from scenes.library import scene
from scenes.materials import (
    BRICK,
    CEILING,
    CHROME,
    DISC_BLACK,
    DISC_WHITE,
    GROUND,
    LIGHT_WOOD,
    PLANT,
    WHITE_WALL,
    WOOD,
)
from scenes.model import Bulb, FloatArray, Material, Scene, Sky, Sun, Surface
from scenes.room import Opening, Room, ground, panes, windows
from scenes.shapes import Piece, curved_surface, cylinder, place, sphere
from scenes.splits import stream
from scenes.tour import drive, loop_length, rounded_loop, starting_at

TILE_M, INSET_M, TURN_M = 0.6, 3.3, 1.6
BULB_LM, BULB_RADIUS_M, PENDANT_M = 3000.0, 0.15, 1.2

LIGHT_TILE = Material((0.42, 0.385, 0.33), roughness=0.12)
DARK_TILE = Material((0.29, 0.265, 0.23), roughness=0.12)
TERRACOTTA_WALL = Material((0.46, 0.20, 0.12), roughness=0.85, specular=0.3)
GRANITE = Material((0.05, 0.05, 0.055), roughness=0.10)
WHITE_LACQUER = Material((0.80, 0.80, 0.79), roughness=0.20)
COLUMN = Material((0.70, 0.69, 0.66), roughness=0.45)


@scene("atrium")
def build(seed: int = 0, speed_mps: float = 0.93, frame_interval_s: float = 0.5, laps: float = 1.25) -> Scene:
    """A tall hall, about 18 m × 14 m × 6 m, whose glazed front lets the sun onto polished tiles.

    Parameters
    ----------
    seed : int
        Sizes the hall and places furniture and discs.
    speed_mps, frame_interval_s, laps : float
        The tour round the hall's middle: 0.93 m/s is Table 4-1's speed.
    """
    size = stream(seed, "atrium", "room").uniform((17.0, 13.2, 5.6), (19.0, 14.8, 6.4))
    room = Room(*size.tolist())
    furniture = _furniture(room, stream(seed, "atrium", "furniture"))
    m = INSET_M
    corners = np.array([[room.width - m, m], [room.width - m, room.depth - m], [m, room.depth - m], [m, m]])
    way = starting_at(rounded_loop(corners, TURN_M), (room.width / 2, m))
    return Scene(
        name="atrium",
        surfaces=(*_shell(room), *furniture),
        landmarks=discs.beside(way, stream(seed, "atrium", "landmarks"), furniture, offset_m=(0.5, 1.2)),
        suns=(Sun(azimuth_deg=160.0, elevation_deg=38.0, lux=40_000.0),),
        sky=Sky(lux=5_000.0),
        bulbs=_bulbs(room),
        tour=drive(way, 0.0, laps * loop_length(way), speed_mps, frame_interval_s),
        floor="light tile",
        inlays=("dark tile",),
        paint_white=DISC_WHITE,
        paint_black=DISC_BLACK,
        bounds=(0.0, 0.0, room.width, room.depth),
    )


def _shell(room: Room) -> list[Surface]:
    w, d, h = room.width, room.depth, room.height
    light, dark = checker((0, 0, 0), (w, 0, 0), (0, d, 0), (round(w / TILE_M), round(d / TILE_M)))
    front = [p for o in windows(w, 5, w / 5 - 0.5, 0.3, h - 0.9, 0.15) for p in panes(o, 2, 2, 0.08)]
    skylight = panes(Opening(d / 2 - 1.6, d / 2 + 1.6, w / 2 - 3.0, w / 2 + 3.0, 0.4), 2, 3, 0.12)
    doors = [Opening(left, left + 0.98, 0.0, 2.4, 0.0) for left in (0.4 * w, 0.4 * w + 1.0)]
    edge = 0.8
    return [
        surface("light tile", LIGHT_TILE, light),
        surface("dark tile", DARK_TILE, dark),
        surface("ceiling", CEILING, *room.wall("ceiling", skylight, edge)),
        surface("front", WHITE_WALL, *room.wall("south", front, edge)),
        surface("wall", WHITE_WALL, *room.wall("east", (), edge), *room.wall("west", (), edge)),
        surface("terracotta wall", TERRACOTTA_WALL, *room.wall("north", doors, edge)),
        surface("door", LIGHT_WOOD, *(room.panel("north", door, edge) for door in doors)),
        surface("ground", GROUND, ground()),
        surface("house opposite", BRICK, box((-8, -34, -0.3), (w + 12, -28, 7), max_edge_m=4.0)),
    ]


def _furniture(room: Room, rng: np.random.Generator) -> list[Surface]:
    w, d = room.width, room.depth
    middle = np.array([w / 2, d / 2]) + rng.uniform(-0.4, 0.4, 2)
    x, y = middle.tolist()
    ball = float(rng.uniform(0.5, 0.7))
    columns = [
        place(cylinder(0.28, room.height, 1.2, sectors=20), (float(w * k), side, 0.0))
        for k in (0.2 + rng.uniform(0, 0.04), 0.8 - rng.uniform(0, 0.04))
        for side in (1.5, d - 1.5)
    ]
    pots, leaves = _planters(rng, [(x - 2.1, y), (x + 2.1, y), (0.9, 0.9), (w - 0.9, 0.9), (0.9, d - 0.9)])
    desk = float(rng.uniform(0.35, 0.6) * d)
    return [
        curved_surface("column", COLUMN, *columns),
        surface("plinth", GRANITE, box((x - 0.8, y - 0.8, 0), (x + 0.8, y + 0.8, 0.45))),
        curved_surface("mirror ball", CHROME, place(sphere(ball), (x, y, 0.45))),
        curved_surface("planter", WHITE_LACQUER, *pots),
        curved_surface("leaves", PLANT, *leaves),
        surface("bench", LIGHT_WOOD, *_benches(room, rng)),
        surface("desk", WHITE_LACQUER, box((w - 1.5, desk - 1.5, 0), (w - 0.7, desk + 1.5, 1.05))),
        surface("desk top", WOOD, box((w - 1.6, desk - 1.6, 1.05), (w - 0.6, desk + 1.6, 1.10), bottom=True)),
    ]


def _planters(rng: np.random.Generator, places: list[tuple[float, float]]) -> tuple[list[Piece], list[Piece]]:
    """Round pots with a ball-shaped shrub each."""
    pots, leaves = [], []
    for x, y in places:
        wide, tall = rng.uniform((0.28, 0.45), (0.40, 0.65)).tolist()
        pots.append(place(cylinder(wide, tall, sectors=20), (x, y, 0.0)))
        leaves.append(place(sphere(wide * float(rng.uniform(1.1, 1.4)), sectors=16), (x, y, tall - 0.05)))
    return pots, leaves


def _benches(room: Room, rng: np.random.Generator) -> list[Piece]:
    """Along the north and west walls."""
    w, d = room.width, room.depth
    pieces = []
    for x in (w * 0.12, w * 0.62, w * 0.8):
        left = float(x + rng.uniform(-0.3, 0.3))
        pieces.append(box((left, d - 0.75, 0), (left + 1.8, d - 0.3, 0.45)))
    for y in (d * 0.3, d * 0.6):
        low = float(y + rng.uniform(-0.3, 0.3))
        pieces.append(box((0.3, low, 0), (0.75, low + 1.8, 0.45)))
    return pieces


def _bulbs(room: Room) -> tuple[Bulb, ...]:
    at: FloatArray = np.array([(x, y) for x in (0.14, 0.38, 0.62, 0.86) for y in (0.18, 0.5, 0.82)])
    return tuple(
        Bulb((x, y, room.height - PENDANT_M), BULB_LM, BULB_RADIUS_M)
        for x, y in (at * (room.width, room.depth)).tolist()
    )
