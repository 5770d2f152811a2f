"""KHR_lights_punctual: points and spots become bulbs, the brightest directional light the sun."""

from __future__ import annotations

import numpy as np

from scenes.gltf.document import Document
from scenes.gltf.nodes import Node
from scenes.model import Bulb, FloatArray, Sun
from scenes.photometry import ISOTROPIC, Photometry

EXTENSION = "KHR_lights_punctual"
MIN_CONE_DEG = 1e-3
"""Inner and outer cone are at least this far apart: an edge of no width has no slope."""


def lights(document: Document, nodes: list[Node]) -> tuple[tuple[Bulb, ...], tuple[Sun, ...]]:
    """Bulbs in the order of their nodes, and the suns, the brightest first.

    A point's or spot's intensity is in candela: lumen = candela / (candela per lumen on the axis), 4π for a
    point. A directional light's is in lux. Colours and ranges are left out: bulbs have the illuminant that
    the study gives them, and light falls off by distance alone.
    """
    listed = document.content.get("extensions", {}).get(EXTENSION, {}).get("lights", [])
    bulbs: list[Bulb] = []
    suns: list[Sun] = []
    for node in nodes:
        index = node.content.get("extensions", {}).get(EXTENSION, {}).get("light")
        if index is None:
            continue
        if not (isinstance(index, int) and 0 <= index < len(listed)):
            raise document.error(
                f"node {node.name!r} refers to light {index!r}, of which there are {len(listed)}"
            )
        light = listed[index]
        ahead = -node.T_world_node[:3, 2]  # a light shines along its node's −z
        length = float(np.linalg.norm(ahead))
        if length == 0:
            raise document.error(f"light {node.name!r}: its node is scaled to nothing")
        intensity = float(light.get("intensity", 1.0))
        if light.get("type") == "directional":
            suns.append(_sun(ahead / length, intensity))
        elif light.get("type") in ("point", "spot"):
            bulbs.append(_bulb(node, light, ahead / length, intensity))
        else:
            raise document.error(f"light {node.name!r}: unknown type {light.get('type')!r}")
    return tuple(bulbs), tuple(sorted(suns, key=lambda sun: -sun.lux))


def _bulb(node: Node, light: dict, ahead: FloatArray, candela: float) -> Bulb:  # type: ignore[type-arg]
    x, y, z = (float(v) for v in node.position)
    if light["type"] == "point":
        return Bulb((x, y, z), lumen=candela * 4 * np.pi)
    cone = light.get("spot", {})
    outer = np.degrees(cone.get("outerConeAngle", np.pi / 4))
    inner = min(np.degrees(cone.get("innerConeAngle", 0.0)), outer - MIN_CONE_DEG)
    web = Photometry.spot(max(inner, 0.0), outer) if outer < 180 else ISOTROPIC
    aim = (float(ahead[0]), float(ahead[1]), float(ahead[2]))
    return Bulb((x, y, z), candela / float(web.candela_per_lumen[0, 0]), aim=aim, photometry=web)


def _sun(ahead: FloatArray, lux: float) -> Sun:
    x, y, z = -ahead
    azimuth = np.degrees(np.arctan2(x, y)) % 360
    return Sun(float(azimuth), float(np.degrees(np.arcsin(np.clip(z, -1.0, 1.0)))), lux)
