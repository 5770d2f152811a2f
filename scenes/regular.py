"""The scene ``regular``: patterns that repeat and walls that are bare, where association fails."""

from __future__ import annotations

import numpy as np

from scenes import discs
from scenes.geometry import box, checker, surface
from scenes.library import scene
from scenes.materials import CEILING, DISC_BLACK, DISC_WHITE, GROUND, STEEL, WHITE_WALL
from scenes.model import Bulb, FloatArray, Landmark, Material, Scene, Sky, Sun, Surface
from scenes.room import Room, ground, windows
from scenes.splits import stream
from scenes.tour import drive, loop_length, rounded_loop, starting_at

RING_M, TURN_M = 3.0, 1.1
BULB_LM, BULB_RADIUS_M = 1500.0, 0.08

LIGHT_TILE = Material((0.38, 0.38, 0.37), roughness=0.20)
DARK_TILE = Material((0.22, 0.22, 0.225), roughness=0.20)
BLUE_STRIPE = Material((0.10, 0.20, 0.40), roughness=0.7, specular=0.3)
DOOR = Material((0.30, 0.31, 0.33), roughness=0.30)


@scene("regular")
def build(seed: int = 0, speed_mps: float = 0.93, frame_interval_s: float = 0.5, laps: float = 1.25) -> Scene:
    """A ring of 3 m wide halls of bare white walls, where tiles, doors, stripes, windows and discs repeat.

    Parameters
    ----------
    seed : int
        Sizes the hall and its patterns; within a scene they are strictly regular.
    speed_mps, frame_interval_s, laps : float
        The tour: 0.93 m/s is Table 4-1's speed.
    """
    size = stream(seed, "regular", "room").uniform((14.0, 11.0, 2.9), (16.0, 12.5, 3.3))
    room = Room(*size.tolist())
    core = _core(room)
    m = RING_M / 2
    corners = np.array([[room.width - m, m], [room.width - m, room.depth - m], [m, room.depth - m], [m, m]])
    way = starting_at(rounded_loop(corners, TURN_M), (room.width / 2, m))
    return Scene(
        name="regular",
        surfaces=(*_shell(room, stream(seed, "regular", "patterns")), *core),
        landmarks=_landmarks(way, stream(seed, "regular", "landmarks"), core),
        suns=(Sun(azimuth_deg=165.0, elevation_deg=36.0, lux=30_000.0),),
        sky=Sky(lux=4_000.0),
        bulbs=_bulbs(way, room),
        tour=drive(way, 0.0, laps * loop_length(way), speed_mps, frame_interval_s),
        floor="light tile",
        inlays=("dark tile",),
        paint_white=DISC_WHITE,
        paint_black=DISC_BLACK,
        bounds=(0.0, 0.0, room.width, room.depth),
    )


def _shell(room: Room, rng: np.random.Generator) -> list[Surface]:
    """Equal windows to the south, doors to the north, stripes to the east; the west wall is bare."""
    w, d = room.width, room.depth
    tile = float(rng.uniform(0.45, 0.62))
    light, dark = checker((0, 0, 0), (w, 0, 0), (0, d, 0), (round(w / tile), round(d / tile)))
    lights, doors, stripes = rng.integers((6, 5, 8), (9, 8, 13)).tolist()
    leaves = windows(w, doors, 0.9, 0.0, 2.05, 0.0)
    bars = windows(d, stripes, d / stripes / 2, 0.0, room.height, 0.0)
    openings = {"south": windows(w, lights, 1.1, 0.9, 2.4), "north": leaves, "east": bars}
    handles = [
        box((o.left + 0.06, d - 0.06, 1.0), (o.left + 0.2, d - 0.03, 1.03), bottom=True) for o in leaves
    ]
    return [
        surface("light tile", LIGHT_TILE, light),
        surface("dark tile", DARK_TILE, dark),
        surface("ceiling", CEILING, *room.wall("ceiling", (), 0.6)),
        surface("wall", WHITE_WALL, *room.walls(openings, 0.5)),
        surface("door", DOOR, *(room.panel("north", leaf) for leaf in leaves)),
        surface("handle", STEEL, *handles),
        surface("stripe", BLUE_STRIPE, *(room.panel("east", bar, 0.6) for bar in bars)),
        surface("ground", GROUND, ground()),
    ]


def _core(room: Room) -> list[Surface]:
    """The block inside the ring: bare and white."""
    low, high = (RING_M, RING_M, 0.0), (room.width - RING_M, room.depth - RING_M, room.height)
    return [surface("core", WHITE_WALL, box(low, high, 0.5))]


def _landmarks(way: FloatArray, rng: np.random.Generator, core: list[Surface]) -> tuple[Landmark, ...]:
    """Equal discs in pairs at equal distances, black and white in turn: nothing tells pairs apart."""
    spacing, offset = float(rng.uniform(1.1, 1.5)), float(rng.uniform(0.6, 0.8))
    radius, pairs = float(rng.uniform(0.12, 0.18)), int(loop_length(way) / spacing)
    centres, white = [], []
    for k in range(pairs):
        at = round((k + 0.5) / pairs * len(way))
        ahead = way[(at + 5) % len(way)] - way[at % len(way)]
        left = np.array([-ahead[1], ahead[0]]) / np.linalg.norm(ahead)
        centres += [way[at % len(way)] + side * offset * left for side in (-1.0, 1.0)]
        white += [k % 2 == 0] * 2
    return discs.accepted(np.array(centres), np.full(len(centres), radius), white, core)


def _bulbs(way: FloatArray, room: Room) -> tuple[Bulb, ...]:
    count = round(loop_length(way) / 3.5)
    places = way[np.linspace(0, len(way), count, endpoint=False).astype(int)]
    return tuple(Bulb((x, y, room.height - 0.3), BULB_LM, BULB_RADIUS_M) for x, y in places.tolist())
