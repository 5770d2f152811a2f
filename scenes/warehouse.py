"""The scene ``warehouse``: metal racks on sealed concrete under high-bay lamps and roof lights."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from scenes import discs
from scenes.geometry import box, rectangle, surface
from scenes.library import scene
from scenes.materials import CEILING, DISC_BLACK, DISC_WHITE, GROUND, LIGHT_WOOD, RUBBER, WOOD, ZINC
from scenes.model import Bulb, Material, Scene, Sky, Sun, Surface
from scenes.photometry import Photometry
from scenes.room import Opening, Room, ground, panes, windows
from scenes.shapes import Piece, curved_surface, cylinder, place
from scenes.splits import stream
from scenes.tour import drive, loop_length, rounded_loop, starting_at

RACK_DEPTH_M, BAY_M, LEVELS_M = 1.1, 2.7, (0.15, 1.9, 3.65)
RACK_HEIGHT_M, MIDDLE_END_M, TURN_M = 5.2, 4.8, 1.5
HIGH_BAY_LM, HIGH_BAY_RADIUS_M, HIGH_BAY_M = 20_000.0, 0.2, 8.2
"""A 150 W LED high bay gives about 20,000 lm, at 8 to 10 m, through a 120° reflector."""

CONCRETE = Material((0.36, 0.355, 0.34), roughness=0.18)
CLADDING = Material((0.60, 0.61, 0.62), roughness=0.45)
UPRIGHT = Material((0.02, 0.06, 0.28), roughness=0.35)
BEAM = Material((0.62, 0.16, 0.02), roughness=0.35)
CARTON = Material((0.36, 0.235, 0.125), roughness=0.85, specular=0.4)
FILM = Material((0.62, 0.64, 0.66), roughness=0.18)
DRUM = Material((0.02, 0.10, 0.32), roughness=0.22)
CRATE = Material((0.05, 0.17, 0.09), roughness=0.45)
GATE = Material((0.20, 0.26, 0.32), roughness=0.45)
YELLOW = Material((0.62, 0.42, 0.02), roughness=0.32)


@scene("warehouse")
def build(seed: int = 0, speed_mps: float = 0.93, frame_interval_s: float = 0.5, laps: float = 1.25) -> Scene:
    """A warehouse of about 25 m × 16 m × 9 m: metal racks, sealed concrete, high-bay lamps, roof lights.

    Parameters
    ----------
    seed : int
        Sizes the hall and places goods and discs.
    speed_mps, frame_interval_s, laps : float
        The tour round the middle rack: 0.93 m/s is Table 4-1's speed.
    """
    size = stream(seed, "warehouse", "room").uniform((23.5, 15.2, 8.8), (26.5, 16.8, 9.4))
    room = Room(*size.tolist())
    rows = _rows(room)
    furniture = [
        *_racks(rows),
        *_goods(rows, stream(seed, "warehouse", "goods")),
        *_floor_things(room, stream(seed, "warehouse", "floor")),
    ]
    aisle = (rows[0][3] + rows[1][2]) / 2
    corners = np.array(
        [
            [room.width - 2.6, aisle],
            [room.width - 2.6, room.depth - aisle],
            [2.6, room.depth - aisle],
            [2.6, aisle],
        ]
    )
    way = starting_at(rounded_loop(corners, TURN_M), (room.width / 2, aisle))
    marks = stream(seed, "warehouse", "landmarks")
    return Scene(
        name="warehouse",
        surfaces=(*_shell(room), *furniture),
        landmarks=discs.beside(way, marks, furniture, offset_m=(0.5, 1.2)),
        suns=(Sun(azimuth_deg=195.0, elevation_deg=52.0, lux=60_000.0),),
        sky=Sky(lux=8_000.0),
        bulbs=_bulbs(room, aisle),
        tour=drive(way, 0.0, laps * loop_length(way), speed_mps, frame_interval_s),
        floor="floor",
        paint_white=DISC_WHITE,
        paint_black=DISC_BLACK,
        bounds=(0.0, 0.0, room.width, room.depth),
    )


def _shell(room: Room) -> list[Surface]:
    w, d = room.width, room.depth
    roof = [
        pane
        for y in (0.24 * d, 0.66 * d)
        for pane in panes(Opening(y, y + 1.2, 3.0, w - 3.0, 0.3), 1, 5, 1.6)
    ]
    high = windows(w, 6, 2.4, 6.4, 7.8)
    gate = Opening(d / 2 - 2.0, d / 2 + 2.0, 0.0, 4.2, 0.0)
    return [
        surface("floor", CONCRETE, room.floor(0.8)),
        surface("ceiling", CEILING, *room.wall("ceiling", roof, 1.0)),
        surface("wall", CLADDING, *room.walls({"south": high, "west": [gate]}, 1.1)),
        surface("gate", GATE, room.panel("west", gate, 1.0)),
        surface("ground", GROUND, ground()),
    ]


def _rows(room: Room) -> list[tuple[float, float, float, float]]:
    """Racks as (x low, x high, y low, y high): along the south wall, two back to back, along the north."""
    w, d, deep = room.width, room.depth, RACK_DEPTH_M
    outer = int((w - 3.0) / BAY_M) * BAY_M
    inner = int((w - 2 * MIDDLE_END_M) / BAY_M) * BAY_M

    def row(long: float, low: float) -> tuple[float, float, float, float]:
        return (w / 2 - long / 2, w / 2 + long / 2, low, low + deep)

    return [
        row(outer, 0.2),
        row(inner, d / 2 - deep - 0.05),
        row(inner, d / 2 + 0.05),
        row(outer, d - 0.2 - deep),
    ]


def _racks(rows: list[tuple[float, float, float, float]]) -> list[Surface]:
    posts, beams, decks = [], [], []
    for x0, x1, y0, y1 in rows:
        for x in np.linspace(x0, x1, round((x1 - x0) / BAY_M) + 1).tolist():
            for y in (y0, y1 - 0.08):
                posts.append(
                    box((x - 0.05, y, 0), (x + 0.05, y + 0.08, RACK_HEIGHT_M), max_edge_m=RACK_HEIGHT_M)
                )
        for z in LEVELS_M:
            for y in (y0 - 0.01, y1 - 0.04):
                beams.append(box((x0, y, z - 0.12), (x1, y + 0.05, z), max_edge_m=3 * BAY_M, bottom=True))
            decks.append(box((x0, y0 + 0.05, z - 0.03), (x1, y1 - 0.05, z), max_edge_m=2.0, bottom=True))
    return [
        surface("rack post", UPRIGHT, *posts),
        surface("rack beam", BEAM, *beams),
        surface("rack deck", ZINC, *decks),
    ]


def _goods(rows: list[tuple[float, float, float, float]], rng: np.random.Generator) -> list[Surface]:
    """Cartons, wrapped goods, drums and crates in most places of the racks, on pallets where a truck goes."""
    goods: dict[str, list[Piece]] = defaultdict(list)
    for x0, x1, y0, y1 in rows:
        places = np.arange(x0 + BAY_M / 4, x1, BAY_M / 2).tolist()
        for z in LEVELS_M:
            for x in places:
                kind, wide, tall = rng.random(), rng.uniform(0.7, 1.1), rng.uniform(0.6, 1.2)
                deep, yaw = rng.uniform(0.7, 0.9), float(rng.uniform(-4, 4))
                if kind < 0.25:
                    continue
                y, base = (y0 + y1) / 2, z + (0.13 if z == LEVELS_M[0] else 0.002)
                if z == LEVELS_M[0]:
                    low, high = (x - 0.58, y - 0.4, z + 0.002), (x + 0.58, y + 0.4, base)
                    goods["pallet"].append(box(low, high, max_edge_m=2.0))
                block = box((-wide / 2, -deep / 2, 0), (wide / 2, deep / 2, tall), max_edge_m=2.0)
                if kind < 0.62:
                    goods["carton"].append(place(block, (x, y, base), yaw))
                elif kind < 0.82:
                    goods["wrapped"].append(place(block, (x, y, base), yaw))
                elif kind < 0.92:
                    drum = cylinder(0.28, 0.88, sectors=12)
                    goods["drum"] += [place(drum, (x + aside, y, base)) for aside in (-0.29, 0.29)]
                else:
                    goods["crate"].append(place(block, (x, y, base), yaw))
    return [
        surface("carton", CARTON, *goods["carton"]),
        surface("wrapped pallet", FILM, *goods["wrapped"]),
        curved_surface("drum", DRUM, *goods["drum"]),
        surface("crate", CRATE, *goods["crate"]),
        surface("pallet", LIGHT_WOOD, *goods["pallet"]),
    ]


def _floor_things(room: Room, rng: np.random.Generator) -> list[Surface]:
    """Painted lines along the racks, a truck in a corner, and pallets that wait at the gate's side."""
    w, d, aside = room.width, room.depth, 0.2 + RACK_DEPTH_M + 0.35
    lines = [
        rectangle((3.2, y, 0.003), (w - 6.4, 0, 0), (0, 0.08, 0), max_edge_m=1.2)
        for y in (aside, d - aside - 0.08)
    ]
    x = w - 0.9 + float(rng.uniform(-0.1, 0.0))
    y = d / 2 + float(rng.uniform(-1.2, 1.2))
    pile = [
        box((x - 0.6, y - 0.4, 0.14 * k), (x + 0.6, y + 0.4, 0.14 * k + 0.12), max_edge_m=2.0, bottom=True)
        for k in range(7)
    ]
    body, dark, wheels = _truck((0.75, d / 2 + float(rng.uniform(-1.0, 1.0))))
    return [
        surface("line", YELLOW, *lines),
        surface("waiting pallet", WOOD, *pile),
        surface("truck", YELLOW, *body),
        surface("truck mast", RUBBER, *dark),
        curved_surface("truck wheel", RUBBER, *wheels),
    ]


def _truck(at: tuple[float, float]) -> tuple[list[Piece], list[Piece], list[Piece]]:
    """A pedestrian stacker that faces north: body, mast and forks, wheels."""
    x, y = at
    body = [box((-0.4, -0.5, 0.08), (0.4, 0.1, 0.95), bottom=True)]
    dark = [box((a, 0.1, 0.05), (a + 0.08, 0.2, 2.1), bottom=True) for a in (-0.35, 0.27)]
    dark += [box((a, 0.2, 0.06), (a + 0.14, 1.3, 0.12), bottom=True) for a in (-0.3, 0.16)]
    wheel = cylinder(0.1, 0.08, sectors=14)
    wheels = [place(wheel, (s * 0.34, -0.35, 0.1), s * 90.0, 90.0) for s in (-1, 1)]
    at3 = (x, y, 0.0)
    return [place(p, at3) for p in body], [place(p, at3) for p in dark], [place(p, at3) for p in wheels]


def _bulbs(room: Room, aisle: float) -> tuple[Bulb, ...]:
    beam = Photometry.spot(25.0, 65.0)
    return tuple(
        Bulb((room.width * x, y, HIGH_BAY_M), HIGH_BAY_LM, HIGH_BAY_RADIUS_M, photometry=beam)
        for x in (0.12, 0.37, 0.63, 0.88)
        for y in (aisle, room.depth - aisle)
    )
