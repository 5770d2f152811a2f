"""`guarded`: finds highlights by what lies around them, repairs them, and leaves everything else alone."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from vslam.filters.base import Filtered, check_picture
from vslam.filters.registry import register

if TYPE_CHECKING:
    from vslam.filters.stages.light_guard import Guard
    from vslam.filters.stages.light_network import LightNetwork

# vslam.filters.stages is imported where a filter is built, not here: see vslam.filters.seed


@register(
    "guarded",
    summary="a small network tells light from paint by its surroundings; repairs certain highlights alone",
    source="this suite, trained on its split `train`; Ronneberger 2015 (U-Net), He 2016, Shi 2016",
)
@dataclass(frozen=True)
class Guarded:
    """Detection and repair by one small network on a single picture.

    1. `stages.light_network`: of each pixel, the chance that light added 16 grey levels or more, and the
       share of its codes that light added. White paint and the mirror image of a lamp have one colour, and a
       grey picture has none: what tells them apart is their surroundings.
    2. `stages.light_guard`: a region of likely pixels counts only if it is certain on average and large
       enough; a picture without any such region is not touched.
    3. Inside, the codes are reduced by their share, less towards the border, so that none is drawn there.
       Nothing else changes.

    It assumes a white-balanced or grey picture of a room like those of the split `train` of this suite's
    scenes. Splits share no scene but do share the six families: what is reported on `test` says how it
    does in new rooms of known kinds, not in new kinds.

    Attributes
    ----------
    likely : float
        Chance above which a pixel may belong to a highlight; 0 for the number chosen on `validation`.
    certain : float
        Chance that a highlight must exceed on average; 0 for the number chosen on `validation`.
    least : int
        Pixels, at the network's resolution, below which a region is no highlight; −1 for the number chosen
        on `validation`.
    strength : float
        How much of the light a repair takes away where it is certain; 0 for the number chosen on
        `validation`.

    Raises
    ------
    VslamError
        When a parameter has no meaning, or the weights cannot be read.
    """

    name: ClassVar[str] = "guarded"
    likely: float = 0.0
    certain: float = 0.0
    least: int = -1
    strength: float = 0.0
    _network: LightNetwork = field(init=False, repr=False, compare=False)
    _guard: Guard = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        from vslam.filters.stages.light_guard import Guard
        from vslam.filters.stages.light_network import load

        network, chosen = load(self.name)
        guard = Guard(
            self.likely or chosen["likely"],
            self.certain or chosen["certain"],
            self.least if self.least >= 0 else int(chosen["least"]),
            self.strength or chosen["strength"],
        )
        object.__setattr__(self, "_network", network)
        object.__setattr__(self, "_guard", guard)

    def __call__(self, image: NDArray[np.uint8]) -> Filtered:
        """Detect and repair."""
        from vslam.filters.stages.light_guard import guarded

        check_picture(image)
        return guarded(image, self._network, self._guard)
