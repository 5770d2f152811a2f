"""The top view: the scene seen straight from above, cut below its ceiling, with lights and tour."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from renderers.appearance import materials_at
from renderers.develop import encode
from renderers.mesh import NOTHING, RayCaster, build_mesh
from scenes.model import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CUT_M = 1.9
"""Height of the cut: below lintels, above furniture."""

LONG_SIDE = 1000
"""Pixels along the longer side of the plan."""

SUN, BULB, TOUR, VIEW = "#e69f00", "#f0c808", "#0072b2", "#d55e00"


def draw(scene: Scene, views: NDArray[np.float64]) -> Figure:
    """The plan with landmarks, lights, tour and numbered views.

    Parameters
    ----------
    views : (n, 3) float64
        Poses of the contact sheet's views.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    x0, y0, x1, y1 = scene.bounds
    scale = 9.0 / max(x1 - x0, y1 - y0)
    figure = Figure(figsize=((x1 - x0) * scale + 1.6, (y1 - y0) * scale + 1.6), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.imshow(from_above(scene), extent=(x0, x1, y0, y1), origin="lower", interpolation="nearest")
    _landmarks(axes, scene)
    _lights(axes, scene)
    _tour(axes, scene, views)
    axes.set(xlabel="x, east (m)", ylabel="y, north (m)", title=_title(scene))
    axes.set_aspect("equal")
    axes.legend(loc="upper left", bbox_to_anchor=(0, -0.07), ncols=6, frameon=False, fontsize=8)
    return figure


def from_above(scene: Scene) -> NDArray[np.uint8]:
    """(H, W, 3) uint8: base colours seen from `CUT_M` downwards, row 0 at the smallest y; white where cut.

    What rises above the cut shows as its cross-section, dark.
    """
    mesh = build_mesh(scene)
    caster = RayCaster(mesh.vertices, mesh.triangles)
    x0, y0, x1, y1 = scene.bounds
    step = max(x1 - x0, y1 - y0) / LONG_SIDE
    x, y = np.meshgrid(np.arange(x0 + step / 2, x1, step), np.arange(y0 + step / 2, y1, step))
    origins = np.stack([x, y, np.full_like(x, CUT_M)], axis=-1).astype(np.float32)
    down = np.broadcast_to(np.array([0, 0, -1], dtype=np.float32), origins.shape)
    triangle, _, bary = caster.nearest(origins, np.ascontiguousarray(down))
    colour = np.ones((*triangle.shape, 3), dtype=np.float32)
    hit = triangle != NOTHING
    weights = np.column_stack([1 - bary[hit].sum(axis=1), bary[hit]])
    colour[hit] = materials_at(mesh, triangle[hit], weights, step).base_color
    colour[hit & (mesh.normals[triangle, 2] < 0)] = 0.1  # from within something: its cross-section
    return encode(np.asarray(colour, dtype=np.float64))


def _landmarks(axes: Axes, scene: Scene) -> None:
    from matplotlib.collections import EllipseCollection

    for white, colour in ((True, "white"), (False, "black")):
        discs = [mark for mark in scene.landmarks if mark.white == white]
        if discs:
            diameter = [2 * mark.radius for mark in discs]
            axes.add_collection(
                EllipseCollection(
                    diameter,
                    diameter,
                    np.zeros(len(discs)),
                    units="xy",
                    offsets=[mark.position for mark in discs],
                    offset_transform=axes.transData,
                    facecolors=colour,
                    edgecolors="0.4",
                    linewidths=0.4,
                )
            )
            label = f"{len(discs)} {colour} landmarks"
            axes.scatter([], [], c=colour, edgecolors="0.4", linewidths=0.4, label=label)  # for the legend


def _lights(axes: Axes, scene: Scene) -> None:
    if scene.bulbs:
        x, y, _ = np.array([bulb.position for bulb in scene.bulbs]).T
        label = f"{len(scene.bulbs)} bulbs"
        axes.scatter(
            x, y, s=36, marker="*", c=BULB, edgecolors="black", linewidths=0.5, zorder=4, label=label
        )
    suns = [sun.direction[:2] for sun in scene.suns if sun.elevation_deg > 0 and sun.elevation_deg < 90]
    x0, y0, x1, y1 = scene.bounds
    centre, reach = np.array([x0 + x1, y0 + y1]) / 2, 0.5 * np.hypot(x1 - x0, y1 - y0)
    for towards in suns:
        unit = towards / np.linalg.norm(towards)
        arrow = {"arrowstyle": "-|>", "color": SUN, "linewidth": 2.0}
        axes.annotate("", centre + 0.2 * reach * unit, centre + 0.45 * reach * unit, arrowprops=arrow)
    if suns:
        axes.plot([], [], color=SUN, linewidth=2, label="direction of sunlight")


def _tour(axes: Axes, scene: Scene, views: NDArray[np.float64]) -> None:
    x, y, _ = scene.tour.poses.T
    axes.plot(x, y, color=TOUR, linewidth=1.0, zorder=3, label="tour")
    ahead = np.stack([np.cos(views[:, 2]), np.sin(views[:, 2])])
    axes.quiver(*views[:, :2].T, *ahead, color=VIEW, scale=28, width=0.004, zorder=5, label="views")
    for number, (vx, vy, _) in enumerate(views, start=1):
        axes.annotate(
            str(number), (vx, vy), (5, 5), textcoords="offset points", color=VIEW, fontweight="bold", zorder=6
        )


def _title(scene: Scene) -> str:
    x0, y0, x1, y1 = scene.bounds
    triangles = sum(len(surface.triangles) for surface in scene.surfaces)
    length = float(np.hypot(*np.diff(scene.tour.poses[:, :2], axis=0).T).sum())
    return f"{scene.name}: {x1 - x0:.0f} × {y1 - y0:.0f} m, {triangles:,} triangles, tour {length:.0f} m"
