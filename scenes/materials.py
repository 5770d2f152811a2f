"""Materials that several scenes share; each is what is common of its kind, none is a measured sample.

Metals: F0 of Adobe's Standard Material reference table (linear). Wood, brick and rubber: the base colours of
Filament's material properties sheet, made linear. Painted rooms: the reflectances that EN 12464-1 recommends
(ceiling 0.7…0.9, walls 0.5…0.8, floor 0.2…0.4). Roughness is chosen by gloss class: mirror 0.05, polished
0.1…0.15, glossy 0.2…0.3, satin 0.35…0.5, matt 0.8 and more.
"""

from __future__ import annotations

from scenes.model import Material

DISC_WHITE, DISC_BLACK = (0.85, 0.85, 0.83), (0.03, 0.03, 0.03)
"""Paint of landmark discs (`scenes.model.Scene.paint_white`)."""

WHITE_WALL = Material((0.80, 0.79, 0.77), roughness=0.9, specular=0.3)
CEILING = Material((0.85, 0.85, 0.84), roughness=0.95, specular=0.2)
PAPER = Material((0.82, 0.82, 0.80), roughness=0.95, specular=0.3)
WOOD = Material((0.242, 0.107, 0.045), roughness=0.45)
LIGHT_WOOD = Material((0.46, 0.31, 0.17), roughness=0.40)
PLANT = Material((0.070, 0.140, 0.035), roughness=0.55)
BRICK = Material((0.296, 0.205, 0.178), roughness=0.95, specular=0.3)
RUBBER = Material((0.036, 0.036, 0.036), roughness=0.8)
BLACK_GLOSS = Material((0.012, 0.012, 0.013), roughness=0.15)
GROUND = Material((0.18, 0.19, 0.15), roughness=1.0, specular=0.0)

CHROME = Material((0.550, 0.556, 0.553), roughness=0.05, metallic=1.0)
STEEL = Material((0.550, 0.556, 0.553), roughness=0.30, metallic=1.0)
ZINC = Material((0.876, 0.869, 0.854), roughness=0.45, metallic=1.0)
GOLD = Material((1.0, 0.710, 0.315), roughness=0.15, metallic=1.0)
