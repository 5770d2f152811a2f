"""Phase 3, the light filter: a picture in; the repaired picture and the mask of what light spoiled out.

One file per filter or family of them; what they compute lies in `stages`, one idea a file.
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
