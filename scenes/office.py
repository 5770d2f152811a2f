"""The scene ``office``: desks with screens and paper between white walls, under a row of windows."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from scenes import discs
from scenes.geometry import box, rectangle, surface
from scenes.library import scene
from scenes.materials import (
    BLACK_GLOSS,
    BRICK,
    CEILING,
    DISC_BLACK,
    DISC_WHITE,
    GROUND,
    LIGHT_WOOD,
    PAPER,
    PLANT,
    RUBBER,
    STEEL,
    WHITE_WALL,
    WOOD,
)
from scenes.model import Bulb, Material, Scene, Sky, Sun, Surface
from scenes.room import Opening, Room, ground, panes, windows
from scenes.shapes import Piece, curved_surface, cylinder, lathe, place, sphere
from scenes.splits import stream
from scenes.tour import drive, loop_length, rounded_loop, starting_at

DESK_M, DESK_HEIGHT_M, DESKS = (1.5, 0.75), 0.73, 3
INSET_M, TURN_M = 1.5, 0.9
BULB_LM, BULB_RADIUS_M = 3000.0, 0.10

LINOLEUM = Material((0.26, 0.27, 0.28), roughness=0.28)
ENAMEL = Material((0.72, 0.71, 0.69), roughness=0.38)
WHITEBOARD = Material((0.82, 0.83, 0.83), roughness=0.12)
GREY_CABINET = Material((0.42, 0.43, 0.44), roughness=0.30)
CHAIR = Material((0.03, 0.05, 0.14), roughness=0.9, specular=0.4)
RED_GLAZE = Material((0.45, 0.05, 0.04), roughness=0.15)
POSTERS = (
    Material((0.10, 0.25, 0.45), roughness=0.25),
    Material((0.55, 0.35, 0.05), roughness=0.25),
    Material((0.08, 0.30, 0.14), roughness=0.25),
)


@scene("office")
def build(seed: int = 0, speed_mps: float = 0.93, frame_interval_s: float = 0.5, laps: float = 1.25) -> Scene:
    """An office of about 10.5 m × 8.5 m: an island of desks with screens and paper, white walls, windows.

    Parameters
    ----------
    seed : int
        Sizes the room and places what stands and lies in it.
    speed_mps, frame_interval_s, laps : float
        The tour round the desks: 0.93 m/s is Table 4-1's speed.
    """
    size = stream(seed, "office", "room").uniform((10.0, 8.2, 2.7), (11.0, 9.0, 3.0))
    room = Room(*size.tolist())
    furniture = [
        *_island(room, stream(seed, "office", "desks")),
        *_along_the_walls(room, stream(seed, "office", "cabinets")),
    ]
    m = INSET_M
    corners = np.array([[room.width - m, m], [room.width - m, room.depth - m], [m, room.depth - m], [m, m]])
    way = starting_at(rounded_loop(corners, TURN_M), (room.width / 2, m))
    marks = stream(seed, "office", "landmarks")
    return Scene(
        name="office",
        surfaces=(*_shell(room, stream(seed, "office", "walls")), *furniture),
        landmarks=discs.beside(way, marks, furniture, spacing_m=1.2, offset_m=(0.45, 0.85)),
        suns=(Sun(azimuth_deg=150.0, elevation_deg=32.0, lux=30_000.0),),
        sky=Sky(lux=4_000.0),
        bulbs=_bulbs(room),
        tour=drive(way, 0.0, laps * loop_length(way), speed_mps, frame_interval_s),
        floor="floor",
        paint_white=DISC_WHITE,
        paint_black=DISC_BLACK,
        bounds=(0.0, 0.0, room.width, room.depth),
    )


def _shell(room: Room, rng: np.random.Generator) -> list[Surface]:
    """The room; posters, whiteboard and door are let into its walls."""
    w, d = room.width, room.depth
    glazing = [p for o in _windows(w) for p in panes(o, 2, 1, 0.08)]
    posters = [
        Opening(y, y + 0.6, 1.1, 1.95, 0.0)
        for y in (d * rng.uniform((0.15, 0.4, 0.65), (0.25, 0.5, 0.75))).tolist()
    ]
    board_left, door_left = rng.uniform((4.2, 0.3 * d), (4.6, 0.4 * d)).tolist()
    board, door = (
        Opening(board_left, board_left + 2.0, 0.9, 2.0, 0.0),
        Opening(door_left, door_left + 0.95, 0, 2.05, 0.0),
    )
    openings = {"south": glazing, "west": posters, "north": [board], "east": [door]}
    return [
        surface("floor", LINOLEUM, room.floor()),
        surface("ceiling", CEILING, *room.wall("ceiling")),
        surface("wall", WHITE_WALL, *room.walls(openings)),
        surface("whiteboard", WHITEBOARD, room.panel("north", board)),
        surface("door", WOOD, room.panel("east", door)),
        *(
            surface(f"poster {k}", material, room.panel("west", poster))
            for k, (material, poster) in enumerate(zip(POSTERS, posters, strict=True))
        ),
        surface("ground", GROUND, ground()),
        surface("house opposite", BRICK, box((-6, -26, -0.3), (w - 2, -20, 6), max_edge_m=4.0)),
    ]


def _windows(width: float) -> list[Opening]:
    return windows(width, 4, 1.9, 0.85, 2.3)


def _island(room: Room, rng: np.random.Generator) -> list[Surface]:
    """Two rows of desks face to face, a screen between each pair of seats."""
    parts: dict[str, list[Piece]] = defaultdict(list)
    for k in range(DESKS):
        for side in (-1.0, 1.0):
            left = room.width / 2 + (k - DESKS / 2) * DESK_M[0]
            _desk(parts, left, room.depth / 2, side, rng)
    return [
        surface("desk top", LIGHT_WOOD, *parts["top"]),
        surface("desk leg", GREY_CABINET, *parts["leg"]),
        surface("screen", BLACK_GLOSS, *parts["screen"]),
        surface("screen foot", STEEL, *parts["screen foot"]),
        surface("keyboard", RUBBER, *parts["keyboard"]),
        surface("paper", PAPER, *parts["paper"]),
        curved_surface("mug", RED_GLAZE, *parts["mug"]),
        surface("chair", CHAIR, *parts["chair"]),
        curved_surface("chair foot", STEEL, *parts["chair foot"]),
    ]


def _desk(
    parts: dict[str, list[Piece]], left: float, back: float, side: float, rng: np.random.Generator
) -> None:
    """One place to work: a desk from ``left`` on whose back edge lies at y = ``back``, and what is on it."""
    (long, deep), high = DESK_M, DESK_HEIGHT_M

    def y(share: float) -> float:
        """So far from the back edge towards the seat, metres."""
        return back + side * share

    near, far = sorted((y(0), y(deep)))
    parts["top"].append(_block((left, near, high - 0.03), (left + long, far, high)))
    for a in (left + 0.04, left + long - 0.07):
        parts["leg"].append(_block((a, near + 0.05, 0), (a + 0.03, far - 0.05, high - 0.03)))
    x = left + long / 2 + float(rng.uniform(-0.15, 0.15))
    turn = float(rng.uniform(-12, 12)) + (180.0 if side > 0 else 0.0)
    panel = _block((-0.30, -0.02, 0.0), (0.30, 0.02, 0.36))  # 27 inch, leaning back
    parts["screen"].append(place(panel, (x, y(0.16), high + 0.14), turn, -6.0))
    foot, post = (
        _block((-0.12, -0.08, 0), (0.12, 0.08, 0.015)),
        _block((-0.03, -0.015, 0.015), (0.03, 0.015, 0.15)),
    )
    parts["screen foot"] += [place(piece, (x, y(0.16), high)) for piece in (foot, post)]
    keys = _block((-0.22, -0.07, 0), (0.22, 0.07, 0.025))
    parts["keyboard"].append(place(keys, (x, y(0.5), high)))
    parts["paper"] += _sheets(rng, (left + 0.25, y(0.45)), (left + long - 0.25, y(0.55)), high)
    mug = left + float(rng.uniform(0.1, 0.2)), y(float(rng.uniform(0.25, 0.6))), high
    parts["mug"].append(place(cylinder(0.04, 0.1, sectors=12), mug))
    seat, stem = _chair((x, y(deep + float(rng.uniform(0.05, 0.2))), 0.0), side, rng)
    parts["chair"] += seat
    parts["chair foot"] += stem


def _block(low: tuple[float, float, float], high: tuple[float, float, float]) -> Piece:
    """A closed box of single cells of up to a metre."""
    return box(low, high, max_edge_m=1.0, bottom=True)


def _sheets(
    rng: np.random.Generator, low: tuple[float, float], high: tuple[float, float], desk: float
) -> list[Piece]:
    """One to three sheets of A4, 3 mm proud and more, so that none lies in another's plane."""
    pieces = []
    for k in range(int(rng.integers(1, 4))):
        sheet = rectangle((-0.105, -0.148, 0), (0.21, 0, 0), (0, 0.297, 0))
        x, y = rng.uniform(np.minimum(low, high), np.maximum(low, high)).tolist()
        pieces.append(place(sheet, (x, y, desk + 0.003 + 0.003 * k), float(rng.uniform(-30, 30))))
    return pieces


def _chair(
    at: tuple[float, float, float], side: float, rng: np.random.Generator
) -> tuple[list[Piece], list[Piece]]:
    """A swivel chair: seat and back, stem and round foot."""
    yaw = (0.0 if side > 0 else 180.0) + float(rng.uniform(-35, 35))
    seat = [_block((-0.23, -0.23, 0.42), (0.23, 0.23, 0.48)), _block((-0.21, 0.20, 0.55), (0.21, 0.24, 0.95))]
    foot = [cylinder(0.03, 0.42, sectors=8), lathe([(0.28, 0.0), (0.27, 0.04), (0.0, 0.07)], sectors=12)]
    return [place(p, at, yaw) for p in seat], [place(p, at, yaw) for p in foot]


def _along_the_walls(room: Room, rng: np.random.Generator) -> list[Surface]:
    """Cabinets, a bookcase, radiators, and a plant in the corner."""
    w, d = room.width, room.depth
    x, case = rng.uniform((0.6, 0.12 * d), (1.1, 0.2 * d)).tolist()
    cabinets = [box((x + 0.82 * k, d - 0.42, 0), (x + 0.82 * k + 0.8, d, 1.25)) for k in range(3)]
    radiators = [
        box((o.left + 0.2, 0.02, 0.12), (o.right - 0.2, 0.1, 0.72), bottom=True) for o in _windows(w)
    ]
    return [
        surface("cabinet", GREY_CABINET, *cabinets),
        surface("bookcase", LIGHT_WOOD, box((w - 0.35, case, 0), (w, case + 1.0, 1.8))),
        surface("radiator", ENAMEL, *radiators),
        curved_surface("pot", RED_GLAZE, place(cylinder(0.2, 0.4, sectors=20), (w - 0.5, d - 0.5, 0))),
        curved_surface("leaves", PLANT, place(sphere(0.36, 16), (w - 0.5, d - 0.5, 0.38))),
    ]


def _bulbs(room: Room) -> tuple[Bulb, ...]:
    return tuple(
        Bulb((room.width * x, room.depth * y, room.height - 0.25), BULB_LM, BULB_RADIUS_M)
        for x in (0.14, 0.38, 0.62, 0.86)
        for y in (0.25, 0.75)
    )
