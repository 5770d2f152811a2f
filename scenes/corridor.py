"""The scene ``corridor``: a closed ring of corridors with a glossy floor and windows to the south."""

from __future__ import annotations

import numpy as np

from scenes.geometry import box, rectangle, surface
from scenes.library import scene
from scenes.materials import DISC_BLACK, DISC_WHITE
from scenes.model import Bulb, Landmark, Material, Scene, Sky, Sun, Surface
from scenes.tour import drive, loop_length, rounded_loop

LENGTH_M, DEPTH_M, WIDTH_M, HEIGHT_M = 20.0, 14.0, 2.5, 2.6
SILL_M, LINTEL_M, WINDOW_M, WINDOW_SPACING_M = 0.9, 2.3, 1.4, 2.4
BULB_SPACING_M, PENDANT_M = 4.1, 0.35
LANDMARK_SPACING_M, LANDMARK_OFFSET_M = 1.5, 0.6

FLOOR = Material((0.24, 0.20, 0.155), roughness=0.22)
WHITE_WALL = Material((0.80, 0.79, 0.76), roughness=0.9, specular=0.3)
BLUE_WALL = Material((0.16, 0.28, 0.42), roughness=0.8, specular=0.3)
CEILING = Material((0.85, 0.85, 0.84), roughness=0.95, specular=0.2)
DOOR = Material((0.36, 0.20, 0.10), roughness=0.35)
GREY_CABINET = Material((0.42, 0.43, 0.44), roughness=0.30)
RED_CABINET = Material((0.45, 0.06, 0.05), roughness=0.25)
STEEL = Material((0.56, 0.57, 0.58), roughness=0.30, metallic=1.0)
GROUND = Material((0.18, 0.19, 0.15), roughness=1.0, specular=0.0)


@scene("corridor")
def build(seed: int = 0, speed_mps: float = 0.93, frame_interval_s: float = 0.5, laps: float = 1.25) -> Scene:
    """A ring of glossy corridors, 20 m × 14 m, with windows to the south and ceiling bulbs.

    Parameters
    ----------
    seed : int
        Places discs, doors and cabinets.
    speed_mps, frame_interval_s, laps : float
        The tour: 0.93 m/s is Table 4-1's speed.
    """
    way = _centre_line()
    return Scene(
        name="corridor",
        surfaces=(*_shell(), *_doors(_stream(seed, "doors")), *_cabinets(_stream(seed, "cabinets"))),
        landmarks=_landmarks(_stream(seed, "landmarks"), way),
        suns=(Sun(azimuth_deg=140.0, elevation_deg=35.0, lux=20_000.0),),
        sky=Sky(lux=2_500.0),
        bulbs=_bulbs(way),
        tour=drive(way, 0.0, laps * loop_length(way), speed_mps, frame_interval_s),
        floor="floor",
        paint_white=DISC_WHITE,
        paint_black=DISC_BLACK,
        bounds=(0.0, 0.0, LENGTH_M, DEPTH_M),
    )


def _stream(seed: int, component: str) -> np.random.Generator:
    """A component's own random numbers: another draw of one moves nothing of the others."""
    return np.random.default_rng([seed, *component.encode()])


def _centre_line() -> np.ndarray:
    m = WIDTH_M / 2
    corners = np.array([[LENGTH_M - m, m], [LENGTH_M - m, DEPTH_M - m], [m, DEPTH_M - m], [m, m]])
    way = rounded_loop(corners, radius=0.8)
    middle_of_south = np.argmin(np.hypot(way[:, 0] - LENGTH_M / 2, way[:, 1] - m))
    return np.roll(way, -int(middle_of_south), axis=0)


def _shell() -> list[Surface]:
    w, d, h, c = LENGTH_M, DEPTH_M, HEIGHT_M, WIDTH_M
    strips = [(0.0, 0.0, w, c), (0.0, d - c, w, c), (0.0, c, c, d - 2 * c), (w - c, c, c, d - 2 * c)]
    floor = [rectangle((x, y, 0), (dx, 0, 0), (0, dy, 0)) for x, y, dx, dy in strips]
    ceiling = [rectangle((x, y, h), (0, dy, 0), (dx, 0, 0)) for x, y, dx, dy in strips]
    inner_w, inner_d = w - 2 * c, d - 2 * c
    inner = [  # these face the corridor, away from the core
        rectangle((c, c, 0), (inner_w, 0, 0), (0, 0, h)),
        rectangle((w - c, c, 0), (0, inner_d, 0), (0, 0, h)),
        rectangle((c, d - c, 0), (0, -inner_d, 0), (0, 0, h)),
    ]
    blue = rectangle((w - c, d - c, 0), (-inner_w, 0, 0), (0, 0, h))
    outer = [
        *_window_wall(),
        rectangle((w, 0, 0), (0, 0, h), (0, d, 0)),
        rectangle((w, d, 0), (0, 0, h), (-w, 0, 0)),
        rectangle((0, d, 0), (0, 0, h), (0, -d, 0)),
    ]
    roof = rectangle((-0.3, -0.3, h + 0.05), (w + 0.6, 0, 0), (0, d + 0.6, 0), max_edge_m=4.0)
    ground = rectangle((-240, -250, -0.3), (500, 0, 0), (0, 500, 0), max_edge_m=60.0)
    return [
        surface("floor", FLOOR, *floor),
        surface("ceiling", CEILING, *ceiling),
        surface("wall", WHITE_WALL, *inner, *outer),
        surface("blue wall", BLUE_WALL, blue),
        surface("roof", GROUND, roof),
        surface("ground", GROUND, ground),
    ]


def _window_wall() -> list[tuple[np.ndarray, np.ndarray]]:
    """Inner face of the south wall with its window openings, and its outer face against the sun."""
    h = HEIGHT_M
    count = int((LENGTH_M - 0.8) // WINDOW_SPACING_M)
    first = (LENGTH_M - (count - 1) * WINDOW_SPACING_M) / 2 - WINDOW_M / 2
    edges = [0.0]
    for i in range(count):
        left = first + i * WINDOW_SPACING_M
        edges += [left, left + WINDOW_M]
    edges.append(LENGTH_M)
    panels = [(0.0, LENGTH_M, 0.0, SILL_M), (0.0, LENGTH_M, LINTEL_M, h)]
    panels += [(a, b, SILL_M, LINTEL_M) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    inside = [rectangle((a, 0, low), (0, 0, high - low), (b - a, 0, 0)) for a, b, low, high in panels]
    thickness = -0.12
    outside = [
        rectangle((a, thickness, low), (b - a, 0, 0), (0, 0, high - low)) for a, b, low, high in panels
    ]
    reveals = []
    for left, right in zip(edges[1:-1:2], edges[2:-1:2], strict=True):
        up, across = LINTEL_M - SILL_M, right - left
        reveals += [
            rectangle((left, thickness, SILL_M), (across, 0, 0), (0, -thickness, 0)),
            rectangle((left, thickness, LINTEL_M), (0, -thickness, 0), (across, 0, 0)),
            rectangle((left, thickness, SILL_M), (0, -thickness, 0), (0, 0, up)),
            rectangle((right, thickness, SILL_M), (0, 0, up), (0, -thickness, 0)),
        ]
    return inside + outside + reveals


def _doors(rng: np.random.Generator) -> list[Surface]:
    """Thin door leaves, flush on the inner walls so that none reaches into the core; one is a steel lift."""
    c, thick, wide, tall = WIDTH_M, 0.04, 0.9, 2.05
    south = [c + 2.0 + 5.0 * i + rng.uniform(-0.5, 0.5) for i in range(3)]
    north = [c + 1.5 + 5.0 * i + rng.uniform(-0.5, 0.5) for i in range(3)]
    leaves = [box((x, c - thick, 0), (x + wide, c, tall)) for x in south]
    leaves += [box((x, DEPTH_M - c, 0), (x + wide, DEPTH_M - c + thick, tall)) for x in north]
    lift_y = DEPTH_M / 2 + rng.uniform(-1, 1)
    lift = box((LENGTH_M - c, lift_y, 0), (LENGTH_M - c + thick, lift_y + 1.4, 2.1))
    return [surface("door", DOOR, *leaves), surface("lift", STEEL, lift)]


def _cabinets(rng: np.random.Generator) -> list[Surface]:
    """Cabinets along the east, north and west outer walls, out of the robot's way."""
    deep, grey, red = 0.32, [], []
    for i in range(4):
        x = 3.5 + 4.0 * i + rng.uniform(-0.6, 0.6)
        grey.append(box((x, DEPTH_M - deep, 0), (x + rng.uniform(0.8, 1.4), DEPTH_M, rng.uniform(0.9, 1.9))))
    for x_low, x_high in ((LENGTH_M - deep, LENGTH_M), (0.0, deep)):
        for i in range(2):
            y = 3.6 + 4.0 * i + rng.uniform(-0.6, 0.6)
            red.append(box((x_low, y, 0), (x_high, y + rng.uniform(0.7, 1.2), rng.uniform(0.8, 1.6))))
    return [surface("grey cabinet", GREY_CABINET, *grey), surface("red cabinet", RED_CABINET, *red)]


def _bulbs(way: np.ndarray) -> tuple[Bulb, ...]:
    count = round(loop_length(way) / BULB_SPACING_M)
    places = way[np.linspace(0, len(way), count, endpoint=False).astype(int)]
    return tuple(
        Bulb((float(x), float(y), HEIGHT_M - PENDANT_M), lumen=800.0, radius=0.06) for x, y in places
    )


def _landmarks(rng: np.random.Generator, way: np.ndarray) -> tuple[Landmark, ...]:
    count = int(loop_length(way) / LANDMARK_SPACING_M)
    marks: list[Landmark] = []
    for side in (-1.0, 1.0):
        at = (np.arange(count) + rng.uniform(-0.25, 0.25, count)) / count * len(way)
        for k in at.astype(int) % len(way):
            ahead = way[(k + 5) % len(way)] - way[k]
            left = np.array([-ahead[1], ahead[0]]) / np.linalg.norm(ahead)
            centre = way[k] + side * (LANDMARK_OFFSET_M + rng.uniform(-0.08, 0.08)) * left
            radius, white = float(rng.uniform(0.10, 0.20)), bool(rng.random() < 0.6)
            if all(np.hypot(*(centre - m.position)) > radius + m.radius + 0.15 for m in marks):
                marks.append(Landmark(len(marks), (float(centre[0]), float(centre[1])), radius, white))
    return tuple(marks)
