"""The parts of a study that choose a scene and what its lamps are."""

from __future__ import annotations

from typing import Any

from pydantic import Field, model_validator

from bench.file_scene import FileScene, name_of
from bench.study_parts import Illuminant, Name, Part, Split

LOG = "log"
"""Name of the parameter by which a scene's builder asks for the log."""


class SpotChoice(Part):
    """Half angles of a spot's cone (`scenes.photometry.Photometry.spot`): full light within ``inner_deg``."""

    inner_deg: float = Field(ge=0, lt=180)
    outer_deg: float = Field(gt=0, le=180)


class LampChoice(Part):
    """What a study changes about all lamps of its scene; their lumen are `IlluminationGrid.bulb_lm`.

    ``ies`` is the path of an IES LM-63 file, from the folder that the program is started in; of the file its
    shape counts, not its lumen.
    """

    ies: str | None = None
    spot: SpotChoice | None = None
    illuminant: Illuminant | None = None
    radius_m: float | None = Field(None, gt=0, le=1)

    @model_validator(mode="after")
    def _one_shape(self) -> LampChoice:
        if self.ies is not None and self.spot is not None:
            raise ValueError("ies and spot both shape the light; leave one out")
        return self


class SceneChoice(Part):
    """A scene of the library (`scenes.library`) with the parameters of its builder, or one out of a ``file``;
    and what its lamps are. A file's scene is named after the file unless it has a ``name``.

    ``seed`` is the builder's; with a ``split`` it counts that split's scenes (`scenes.splits`), so that what
    is chosen on ``train`` can be judged on ``test``. ``disc_share`` of its discs are left, drawn by the
    study's seed; those of a smaller share are among those of a larger one.
    """

    name: Name = "corridor"
    split: Split | None = None
    seed: int = Field(0, ge=0)
    parameters: dict[str, Any] = Field(default_factory=dict)
    disc_share: float = Field(1.0, gt=0, le=1)
    file: FileScene | None = None
    lamps: LampChoice = LampChoice()

    @model_validator(mode="before")
    @classmethod
    def _named_after_file(cls, value: Any) -> Any:
        if not isinstance(value, dict) or "name" in value or value.get("file") is None:
            return value
        file = value["file"]
        path = file.get("path") if isinstance(file, dict) else file
        return {**value, "name": name_of(path)} if isinstance(path, str) else value

    @model_validator(mode="after")
    def _parameters_of_library(self) -> SceneChoice:
        for key in ("parameters", "split"):
            if self.file is not None and getattr(self, key):
                raise ValueError(f"{key} is for scenes of the library; a file has its own keys under file")
        return self

    def reads_log(self) -> bool:
        """Whether its builder asks for the DLR log, by a parameter of the name `LOG`."""
        from scenes import library

        return any(info.name == self.name and LOG in info.parameters for info in library.describe())
