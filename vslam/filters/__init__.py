"""Phase 3, the light filter: a picture in; the repaired picture and the mask of what light spoiled out.

One file per stage of the dissertation's filter (eqs. 3-2 … 3-5), one class per registered filter.
A module put into this folder that uses :func:`register` is found by name without further ado.
"""

from vslam.filters.base import (
    Encoding,
    Filtered,
    LightFilter,
    PictureCalibration,
    PictureForm,
    check_picture,
)
from vslam.filters.parameters import FilterParameter
from vslam.filters.registry import (
    FilterDescription,
    FilterParameterError,
    UnknownFilterError,
    create,
    describe,
    names,
    register,
)

__all__ = [
    "Encoding",
    "FilterDescription",
    "FilterParameter",
    "FilterParameterError",
    "Filtered",
    "LightFilter",
    "PictureCalibration",
    "PictureForm",
    "UnknownFilterError",
    "check_picture",
    "create",
    "describe",
    "names",
    "register",
]
