"""The rasterising engine: pyrender on OSMesa finds the triangles, each pixel's own ray finds the point."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from renderers.camera import Camera, Intrinsics, Pinhole, pixel_grid
from renderers.gbuffer import F32, I32, View
from renderers.mesh import NOTHING, SceneMesh
from renderers.osmesa import FloatTarget, import_pyrender

NEAR_M, FAR_M = 0.03, 500.0
FACE_DENSITY = 1.5
"""Cube-face pixels per radian at a face's centre, where they are fewest, over the camera's own."""

LARGEST_FACE = 4096
"""Columns or rows of a face at most: a pinhole that looks so far aside that it needs more takes a cube."""

EDGE_SLACK, NEIGHBOUR_SLACK = 1e-4, 1.0
"""How far beside a triangle, as a share of its size, a ray still hits it: float32's error on an edge; one
triangle further on the same plane."""

_CUBE = {  # rotation from a face's camera axes to the camera's, for front, right, left, down, up, back
    (2, 1): ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    (0, 1): ((0, 0, 1), (0, 1, 0), (-1, 0, 0)),
    (0, -1): ((0, 0, -1), (0, 1, 0), (1, 0, 0)),
    (1, 1): ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    (1, -1): ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
    (2, -1): ((-1, 0, 0), (0, 1, 0), (0, 0, -1)),
}


@dataclass(frozen=True, eq=False)
class Face:
    """One pinhole picture that covers part of a camera's view.

    Attributes
    ----------
    R_camera_face : (3, 3) float64
    pixels : (n, 2) int64
        Row and column of the camera's pixels that look it up.
    coordinates : (n, 2) float32
        Where on the face's picture (u, v) each of them lies.
    """

    pinhole: Pinhole
    R_camera_face: NDArray[np.float64]
    pixels: NDArray[np.int64]
    coordinates: F32


def faces_of(camera: Camera) -> list[Face]:
    """Split a camera's view into pinhole pictures.

    A simple pinhole is its own; a distorted or off-centre one looks its pixels up in a simple one that
    sees as much; a fisheye in the sides of a cube that it sees.
    """
    rays = camera.unproject(pixel_grid(camera))
    if not isinstance(camera, Pinhole):
        return _cube_faces(camera, rays)
    own = camera
    if camera.distortion or isinstance(camera.view, Intrinsics):
        own = _surrounding(rays)
        if max(own.width, own.height) > LARGEST_FACE:
            return _cube_faces(camera, rays)
    everything = np.argwhere(np.ones(rays.shape[:2], dtype=bool))
    coordinates = own.project(rays.reshape(-1, 3))[0].astype(np.float32)
    return [Face(own, np.eye(3), everything, coordinates)]


def _surrounding(rays: NDArray[np.float64]) -> Pinhole:
    """A simple pinhole that sees all of a pinhole's (H, W, 3) rays, `FACE_DENSITY` times as densely."""
    plane = rays[..., :2] / rays[..., 2:]
    steps = [np.linalg.norm(np.diff(plane, axis=axis), axis=-1) for axis in (0, 1)]
    finest = min(float(step.min()) for step in steps if step.size)
    widest, tallest = np.abs(plane).reshape(-1, 2).max(axis=0) + finest
    focal = FACE_DENSITY / finest
    width, height = (int(np.ceil(2 * focal * half)) for half in (widest, tallest))
    return Pinhole(width, height, 2 * float(np.degrees(np.arctan(width / 2 / focal))))


def _cube_faces(camera: Camera, rays: NDArray[np.float64]) -> list[Face]:
    side = int(np.ceil(2 * FACE_DENSITY * _rate(camera, rays)))
    pinhole = Pinhole(side, side, 90.0)
    axis = np.argmax(np.abs(rays), axis=-1)
    sign = np.sign(np.take_along_axis(rays, axis[..., None], axis=-1)[..., 0])
    faces = []
    for (face_axis, face_sign), columns in _CUBE.items():
        pixels = np.argwhere((axis == face_axis) & (sign == face_sign))
        if len(pixels):
            R = np.array(columns, dtype=np.float64)
            coordinates, _ = pinhole.project(rays[pixels[:, 0], pixels[:, 1]] @ R)
            faces.append(Face(pinhole, R, pixels, coordinates.astype(np.float32)))
    return faces


def _rate(camera: Camera, rays: NDArray[np.float64]) -> float:
    """The camera's most pixels per radian away from its axis, along x and y."""
    theta = np.linspace(0.0, float(np.arccos(rays[..., 2].min())), 200)
    out = np.stack([np.sin(theta), np.zeros_like(theta), np.cos(theta)], axis=-1)
    rates = [
        np.linalg.norm(np.diff(camera.project(way)[0], axis=0), axis=-1).max() / theta[1]
        for way in (out, out[:, [1, 0, 2]])
    ]
    return float(max(rates))


class RasteriseEngine:
    """Draws each face with pyrender, then intersects each pixel's ray with the triangle drawn there."""

    name = "rasterise"

    def __init__(self, mesh: SceneMesh, camera: Camera) -> None:
        pyrender = import_pyrender()
        self._mesh, self._camera, self._faces = mesh, camera, faces_of(camera)
        shape = self._faces[0].pinhole
        self._target = FloatTarget(shape.width, shape.height)
        fov_y = 2 * np.arctan(shape.height / 2 / shape.focal)
        self._scene = pyrender.Scene(bg_color=[0.0, 0.0, 0.0, 0.0])
        primitive = pyrender.Primitive(positions=mesh.vertices, indices=mesh.triangles)
        self._scene.add(pyrender.Mesh([primitive]))
        eye = pyrender.PerspectiveCamera(yfov=fov_y, znear=NEAR_M, zfar=FAR_M)
        self._eye = self._scene.add(eye, pose=np.eye(4))

    def visible(self, view: View) -> tuple[I32, F32]:
        """See `Engine.visible`."""
        triangle = np.full(view.directions.shape[:2], NOTHING, dtype=np.int32)
        distance = np.full(view.directions.shape[:2], np.inf, dtype=np.float32)
        for face in self._faces:
            drawn = self._draw(view, face)
            rows, columns = face.pixels[:, 0], face.pixels[:, 1]
            triangle[rows, columns], distance[rows, columns] = _resolve(
                drawn,
                face.coordinates,
                view.origin,
                view.directions[rows, columns],
                self._mesh.vertices,
                self._mesh.triangles,
            )
        return triangle, distance

    def _draw(self, view: View, face: Face) -> F32:
        pose = view.T_world_camera.copy()
        pose[:3, :3] = (
            pose[:3, :3] @ face.R_camera_face @ np.diag([1.0, -1.0, -1.0])
        )  # to OpenGL's camera axes
        self._scene.set_pose(self._eye, pose)
        return np.ascontiguousarray(self._target.draw(self._scene))

    def close(self) -> None:
        """Free the OSMesa context."""
        self._target.close()


@njit(cache=True)
def _resolve(
    drawn: F32, coordinates: F32, origin: F32, directions: F32, vertices: F32, triangles: I32
) -> tuple[I32, F32]:
    """The triangle under each ray among those drawn at the four nearest face pixels.

    A face pixel's centre is not the ray's, so near an edge the nearest pixel may show the neighbour. The
    ray decides: of the candidates it pierces, the nearest wins. If it pierces none, as where the tips of
    several triangles meet, the nearest pixel's triangle stands, with the distance to its plane; where the ray
    misses that by far (a silhouette thinner than a pixel), with the distance drawn.
    """
    height, width = drawn.shape[:2]
    n = len(coordinates)
    triangle, distance = np.full(n, -1, dtype=np.int32), np.full(n, np.inf, dtype=np.float32)
    for i in range(n):
        u, v = coordinates[i, 0], coordinates[i, 1]
        nearest_row = min(max(int(np.round(v)), 0), height - 1)
        nearest_column = min(max(int(np.round(u)), 0), width - 1)
        sky = False
        for k in range(4):
            row = min(max(int(np.floor(v)) + k // 2, 0), height - 1)
            column = min(max(int(np.floor(u)) + k % 2, 0), width - 1)
            candidate = int(drawn[row, column, 0] + 0.5) - 1
            if candidate < 0:
                sky = True
                continue
            t = _pierce(origin, directions[i], vertices, triangles[candidate], EDGE_SLACK)
            if t < distance[i]:
                triangle[i], distance[i] = candidate, t
        if triangle[i] < 0 and not sky:
            triangle[i] = int(drawn[nearest_row, nearest_column, 0] + 0.5) - 1
            t = _pierce(origin, directions[i], vertices, triangles[triangle[i]], NEIGHBOUR_SLACK)
            distance[i] = t if t < np.inf else drawn[nearest_row, nearest_column, 1]
    return triangle, distance


@njit(cache=True)
def _pierce(origin: F32, direction: F32, vertices: F32, corners: I32, slack: float) -> float:
    """Distance along the ray to a triangle (Möller & Trumbore 1997), inf if it passes by.

    ``slack`` is how far outside the barycentric coordinates may lie.
    """
    ax, ay, az = vertices[corners[0], 0], vertices[corners[0], 1], vertices[corners[0], 2]
    bx, by, bz = vertices[corners[1], 0] - ax, vertices[corners[1], 1] - ay, vertices[corners[1], 2] - az
    cx, cy, cz = vertices[corners[2], 0] - ax, vertices[corners[2], 1] - ay, vertices[corners[2], 2] - az
    dx, dy, dz = float(direction[0]), float(direction[1]), float(direction[2])
    px, py, pz = dy * cz - dz * cy, dz * cx - dx * cz, dx * cy - dy * cx
    determinant = bx * px + by * py + bz * pz
    if abs(determinant) < 1e-12:
        return np.inf
    sx, sy, sz = origin[0] - ax, origin[1] - ay, origin[2] - az
    b = (sx * px + sy * py + sz * pz) / determinant
    qx, qy, qz = sy * bz - sz * by, sz * bx - sx * bz, sx * by - sy * bx
    c = (dx * qx + dy * qy + dz * qz) / determinant
    t = (cx * qx + cy * qy + cz * qz) / determinant
    if b < -slack or c < -slack or b + c > 1 + slack or t <= 0:
        return np.inf
    return t
