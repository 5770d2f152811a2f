"""``croissant.json``: what the data set is, for machines (MLCommons Croissant 1.0, JSON-LD)."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from bench.datasets.layout import layouts
from bench.datasets.model import NO_SPLIT, TABLE, Request, StoredFile

_CROISSANT = "http://mlcommons.org/croissant/"
_TERMS = (
    *("citeAs", "column", "extract", "field", "fileProperty", "fileObject", "fileSet", "format", "includes"),
    *("isLiveDataset", "jsonPath", "key", "md5", "parentField", "path", "recordSet", "references", "regex"),
    *("repeated", "replace", "samplingRate", "separator", "source", "subField", "transform"),
    "equivalentProperty",
)
CONTEXT: dict[str, Any] = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "cr": _CROISSANT,
    "rai": f"{_CROISSANT}RAI/",
    "sc": "https://schema.org/",
    "dct": "http://purl.org/dc/terms/",
    "conformsTo": "dct:conformsTo",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "examples": {"@id": "cr:examples", "@type": "@json"},
    **{term: f"cr:{term}" for term in _TERMS},
}
_TYPES = {
    **dict.fromkeys(("sequence", "split", "scene", "illumination"), "sc:Text"),
    "frame": "sc:Integer",
    **dict.fromkeys(("stamp_s", "x_m", "y_m", "heading_rad", "exposure_ev", "exposure_s"), "sc:Float"),
    **dict.fromkeys(
        ("gain_db", "white_r", "white_g", "white_b", "highlight_share", "saturated_share"), "sc:Float"
    ),
}
_MEDIA = {".png": "image/png", ".exr": "image/x-exr"}


def croissant(request: Request, closing: Iterable[StoredFile]) -> dict[str, Any]:
    """The metadata of a data set.

    Parameters
    ----------
    closing : iterable of StoredFile
        The files that are no pictures; the table of all pictures is among them.
    """
    table = next(file for file in closing if file.path == TABLE)
    study = request.places[0].study
    scenes = ", ".join(dict.fromkeys(place.study.scene.name for place in request.places))
    description = (
        f"{request.pictures} rendered pictures of {scenes}, each place under {len(request.places[0].lights)} "
        "conditions of light and exposure, with the exact diffuse and specular light, masks of highlights, "
        "depth and poses."
    )
    columns = {**_TYPES, **dict.fromkeys(request.layouts, "sc:Text")}
    splits = list(dict.fromkeys(place.split for place in request.places))
    return {
        "@context": CONTEXT,
        "@type": "sc:Dataset",
        "name": study.name,
        "description": description,
        "conformsTo": f"{_CROISSANT}1.0",
        "version": request.glarebench,
        "distribution": [_table_file(table), *(_pictures(layout) for layout in request.layouts)],
        "recordSet": [
            *([] if splits == [NO_SPLIT] else [_splits(splits)]),
            {
                "@type": "cr:RecordSet",
                "@id": "pictures",
                "name": "pictures",
                "description": "One record per picture; the layouts' fields are paths from here.",
                "field": [_field(name, kind, splits) for name, kind in columns.items()],
            },
        ],
    }


def _table_file(table: StoredFile) -> dict[str, Any]:
    return {
        "@type": "cr:FileObject",
        "@id": TABLE,
        "name": TABLE,
        "contentUrl": TABLE,
        "contentSize": f"{table.bytes} B",
        "encodingFormat": "text/csv",
        "sha256": table.sha256,
    }


def _pictures(layout: str) -> dict[str, Any]:
    suffix = layouts()[layout].suffix
    return {
        "@type": "cr:FileSet",
        "@id": f"{layout}-pictures",
        "name": f"{layout}-pictures",
        "encodingFormat": _MEDIA[suffix],
        "includes": f"{layout}/**/*{suffix}",
    }


def _splits(names: list[str]) -> dict[str, Any]:
    field = {"@type": "cr:Field", "@id": "splits/name", "name": "name", "dataType": "sc:Text"}
    return {
        "@type": "cr:RecordSet",
        "@id": "splits",
        "name": "splits",
        "dataType": "cr:Split",
        "key": {"@id": "splits/name"},
        "field": [field],
        "data": [{"splits/name": name} for name in names],
    }


def _field(name: str, kind: str, splits: list[str]) -> dict[str, Any]:
    field: dict[str, Any] = {
        "@type": "cr:Field",
        "@id": f"pictures/{name}",
        "name": name,
        "dataType": kind,
        "source": {"fileObject": {"@id": TABLE}, "extract": {"column": name}},
    }
    if name == "split" and splits != [NO_SPLIT]:
        field["references"] = {"field": {"@id": "splits/name"}}
    return field
