"""Studies as pydantic models: what is rendered or replayed, filtered, mapped and scored.

Unknown keys are refused. Units are in the names: ``_m`` metres, ``_deg`` degrees, ``_s`` seconds, ``_e``
electrons.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, get_args

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from bench.backend_choice import BackendChoice, Backends
from bench.camera_choice import CameraChoice, OpticsChoice
from bench.drive_choice import AnyDrive, distinct_drives
from bench.file_scene import FileScene, name_of
from bench.filter_choice import FilterChoice, Filters
from bench.illumination_grid import Illumination, IlluminationGrid
from bench.sensor_choice import SensorChoice
from bench.study_parts import Illuminant, Name, NotNegative, Part, Positive

__all__ = [
    "SEQUENCES",
    "BackendChoice",
    "BackendsStudy",
    "CameraChoice",
    "ClosedLoopStudy",
    "ClosedLoopTask",
    "DepthNoise",
    "DiscChoice",
    "DlrLightStudy",
    "DlrPicturesStudy",
    "DlrStudy",
    "FileScene",
    "FilterChoice",
    "FiltersStudy",
    "Illumination",
    "IlluminationGrid",
    "LampChoice",
    "LightLevel",
    "NavigationTask",
    "OdometryNoise",
    "OpticsChoice",
    "Part",
    "RenderedStudy",
    "SceneChoice",
    "SensorChoice",
    "SlamChoice",
    "SpotChoice",
    "Study",
    "TourChoice",
]


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
    is chosen on ``train`` can be judged on ``test``.
    """

    name: Name = "corridor"
    split: Literal["train", "test", "validation"] | None = None
    seed: int = Field(0, ge=0)
    parameters: dict[str, Any] = Field(default_factory=dict)
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


class TourChoice(Part):
    """How the robot drives its tour; the speed is Table 4-1's."""

    speed_mps: Positive = 0.93
    frame_interval_s: Positive = 0.4


class OdometryNoise(Part):
    """Standard deviations of one motion increment, in proportion to its length and to its turn.

    Forward and lateral: the medians that the DLR log states for its own steps (σ per metre, steps over
    0.05 m). Heading: a turn is as uncertain as a metre, and straight driving adds 0.1° per step of 0.372 m,
    the upper end of the mild regime (0.05–0.1° per step) in which an EKF is still consistent; the DLR log
    itself states twenty times that, 0.098 rad/m.
    """

    sigma_forward_m_per_m: NotNegative = 0.023
    sigma_lateral_m_per_m: NotNegative = 0.024
    sigma_heading_rad_per_rad: NotNegative = 0.023
    sigma_heading_rad_per_m: NotNegative = 0.0047


class DepthNoise(Part):
    """σ_z = ``sigma_m_at_1m`` · z², the structured-light law of Khoshelham & Elberink (2012, eq. 10), which
    gives 1.4 mm at 1 m; no reading beyond ``max_m`` (Table 4-1's sensor range).
    """

    sigma_m_at_1m: NotNegative = 0.0014
    max_m: Positive = 12.0


class DiscChoice(Part):
    """What the detector looks for and how far it believes it (`vslam.detect.DetectorSettings`)."""

    min_radius_m: float = Field(0.10, ge=0.02, le=1)
    max_radius_m: float = Field(0.20, ge=0.02, le=1)
    max_misfit: float = Field(0.15, gt=0, le=1)
    max_sigma_m: Positive = 0.05
    tilt_sigma_deg: NotNegative = 0.0
    position_sigma_m: NotNegative = 0.0

    @model_validator(mode="after")
    def _in_order(self) -> DiscChoice:
        if not self.min_radius_m < self.max_radius_m:
            raise ValueError(
                f"min_radius_m {self.min_radius_m:g} must be below max_radius_m {self.max_radius_m:g}"
            )
        return self


class SlamChoice(Part):
    """The estimator by its registered names; ``gate`` is the probability of the χ² gate."""

    backend: Name = "ekf"
    association: Name = "icnn"
    observation: Name = "range_bearing"
    gate: Annotated[float, Field(gt=0, lt=1)] = 0.99


class NavigationTask(Part):
    """Random start–goal pairs that are planned on the estimated grid and judged on the true one."""

    pairs: int = Field(20, ge=1)
    resolution_m: Positive = 0.1
    robot_radius_m: Positive = 0.25


class RenderedStudy(Part):
    """A scene of the library, rendered, filtered, mapped and navigated."""

    sequence: Literal["rendered"]
    name: Name
    title: str = ""
    description: str = ""
    seed: int = Field(0, ge=0)
    scene: SceneChoice = SceneChoice()
    camera: CameraChoice = CameraChoice.model_validate({})
    engine: Literal["auto", "rasterise", "raycast"] = "auto"
    sensor: SensorChoice = SensorChoice.model_validate({})
    illuminations: IlluminationGrid = IlluminationGrid.model_validate({})
    tour: TourChoice = TourChoice()
    odometry: OdometryNoise = OdometryNoise()
    depth: DepthNoise = DepthNoise()
    filters: Filters = (FilterChoice(name="none"),)
    discs: DiscChoice = DiscChoice()
    slam: SlamChoice = SlamChoice()
    seeds: int = Field(10, ge=1)
    navigation: NavigationTask = NavigationTask()


class ClosedLoopTask(Part):
    """What is driven in closed loop, and when the true world calls it a success.

    ``goal``: from a start to a goal at least ``min_distance_m`` away and home again, `NavigationTask.pairs`
    such pairs with `RenderedStudy.seeds` repetitions each. ``explore``: see all free space, from
    ``explorations`` starts. ``lights`` are names of illuminations out of the grid, all where it is empty.
    ``arrival_m``: as near the robot has to be in truth where it believes to have arrived. It gets
    ``patience`` times the time that the shortest way takes at full speed, and ``explore_s`` for exploring.
    """

    tasks: tuple[Literal["goal", "explore"], ...] = Field(("goal", "explore"), min_length=1)
    home: bool = True
    lights: tuple[Name, ...] = ()
    min_distance_m: Positive = 8.0
    explorations: int = Field(2, ge=1)
    arrival_m: Positive = 0.3
    patience: float = Field(4.0, ge=1)
    explore_s: Positive = 180.0
    commands_per_frame: int = Field(4, ge=1, le=100)


class ClosedLoopStudy(RenderedStudy):
    """A robot that drives itself through a rendered scene, its own SLAM pose its only feedback.

    The tour gives its speed and the time between two pictures, nothing else.
    """

    sequence: Literal["drive"]  # type: ignore[assignment]  # another value of the key that tells kinds apart
    drive: ClosedLoopTask = ClosedLoopTask()

    @model_validator(mode="after")
    def _can_be_driven(self) -> ClosedLoopStudy:
        if self.camera.optics.motion_blur:
            raise ValueError("camera.optics.motion_blur: is for tours; leave it out of a drive")
        known = [cell.name for cell in self.illuminations.grid()]
        for name in self.drive.lights:
            if name not in known:
                raise ValueError(f"drive.lights: {name!r} is not in the grid; it has {', '.join(known)}")
        return self

    def lights(self) -> tuple[Illumination, ...]:
        """The illuminations that are driven in."""
        cells, chosen = self.illuminations.grid(), self.drive.lights
        return tuple(cell for cell in cells if not chosen or cell.name in chosen)


class DlrStudy(Part):
    """The real DLR building log, replayed with every back-end, association and observation form."""

    sequence: Literal["dlr"]
    name: Name
    title: str = ""
    description: str = ""
    seed: int = Field(0, ge=0)
    backends: Backends = (BackendChoice(name="ekf"),)
    associations: tuple[Name, ...] = Field(("annotated", "icnn"), min_length=1)
    observations: tuple[Name, ...] = Field(("cartesian", "range_bearing"), min_length=1)
    gate: Annotated[float, Field(gt=0, lt=1)] = 0.99


class LightLevel(Part):
    """A level of light in proportion to a scene's own: its sun with its sky, and its lamps.

    A warehouse's high bays are no corridor's bulbs: what is common to places is the ratio to what they are
    built with.
    """

    name: Name
    sun: NotNegative = 0.0
    lamps: NotNegative = 0.0

    @model_validator(mode="after")
    def _lit(self) -> LightLevel:
        if not self.sun and not self.lamps:
            raise ValueError("sun or lamps must be above 0; nothing is seen in the dark")
        return self


def _named(scenes: Any) -> Any:
    """A scene of the library by its name alone."""
    if not isinstance(scenes, list | tuple):
        return scenes
    return [{"name": scene} if isinstance(scene, str) else scene for scene in scenes]


def _names_differ(parts: tuple[Any, ...]) -> tuple[Any, ...]:
    names = [part.name for part in parts]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"the name {name!r} stands twice")
    return parts


class FiltersStudy(Part):
    """Light filters compared in several scenes at the same levels of light, picture by picture.

    ``split`` is that of every library scene without one of its own; ``frames`` are taken evenly from each
    tour; ``neutral_objects`` names white and grey surfaces, which a filter should leave alone. Filters are
    timed on pictures of ``timed_sizes``, width and height.
    """

    sequence: Literal["filters"]
    name: Name
    title: str = ""
    description: str = ""
    seed: int = Field(0, ge=0)
    scenes: Annotated[tuple[SceneChoice, ...], BeforeValidator(_named), AfterValidator(_names_differ)] = (
        Field((SceneChoice(),), min_length=1)
    )
    split: Literal["train", "test", "validation"] = "test"
    levels: Annotated[tuple[LightLevel, ...], AfterValidator(_names_differ)] = Field(
        (LightLevel(name="lamps", lamps=1.0),), min_length=1
    )
    frames: int = Field(6, ge=1)
    camera: CameraChoice = CameraChoice.model_validate({})
    engine: Literal["auto", "rasterise", "raycast"] = "auto"
    sensor: SensorChoice = SensorChoice.model_validate({})
    filters: Filters = (FilterChoice(name="none"),)
    discs: DiscChoice = DiscChoice()
    neutral_objects: tuple[str, ...] = ()
    timed_sizes: tuple[tuple[Annotated[int, Field(ge=16)], Annotated[int, Field(ge=16)]], ...] = Field(
        ((320, 240), (640, 480), (1280, 720)), min_length=1
    )


class DlrPicturesStudy(Part):
    """The DLR robot's recorded pictures through the light filters and our detector, then SLAM.

    ``stride`` takes every so many of the log's steps. The camera's mount is calibrated on the pictures 0,
    ``calibrate_every``, 2 · ``calibrate_every`` … (`bench.sequences.dlr_mount`), which no score counts; with
    0, ``camera.json`` stays as it is.
    """

    sequence: Literal["dlr_pictures"]
    name: Name
    title: str = ""
    description: str = ""
    seed: int = Field(0, ge=0)
    stride: int = Field(1, ge=1)
    calibrate_every: int = Field(20, ge=0)
    filters: Filters = (FilterChoice(name="none"),)
    discs: DiscChoice = DiscChoice()
    slam: tuple[SlamChoice, ...] = Field((SlamChoice(association="annotated"),), min_length=1)

    @model_validator(mode="after")
    def _pictures_left(self) -> DlrPicturesStudy:
        if self.calibrate_every and self.stride % self.calibrate_every == 0:
            raise ValueError(
                f"stride {self.stride} takes only pictures that calibrate_every {self.calibrate_every} keeps "
                "from being scored; choose another stride"
            )
        return self


class DlrLightStudy(Part):
    """The DLR robot's recorded pictures with light composited onto them (`bench.sequences.dlr_light`).

    ``stride`` takes every so many of the log's steps; ``own_lamps_lm`` is what each of the building's lamps
    had when the pictures were taken, by assumption, and ties the added light to the recorded one.
    """

    sequence: Literal["dlr_light"]
    name: Name
    title: str = ""
    description: str = ""
    seed: int = Field(0, ge=0)
    stride: int = Field(30, ge=1)
    floor_roughness: float = Field(0.25, ge=0.02, le=1)
    own_lamps_lm: Positive = 3000.0
    illuminations: IlluminationGrid = IlluminationGrid.model_validate({})
    highlight_threshold: int = Field(16, ge=1, le=255)
    filters: Filters = (FilterChoice(name="none"),)
    discs: DiscChoice = DiscChoice()


class PairsStudy(Part):
    """A folder of picture pairs (`bench.sequences.pairs`), named by ``--data``, that filters are scored on.

    ``linear`` says that the files hold linear light; otherwise they are sRGB. ``thresholds`` are the grey
    levels of 255 by which a picture has to exceed its diffuse one to count as affected.
    """

    sequence: Literal["pairs"]
    name: Name
    title: str = ""
    description: str = ""
    seed: int = Field(0, ge=0)
    filters: Filters = (FilterChoice(name="none"),)
    linear: bool = False
    thresholds: tuple[Annotated[int, Field(ge=0, le=254)], ...] = Field((8, 16, 32), min_length=1)


class BackendsStudy(Part):
    """Back-ends compared on the same observations of known landmarks, simulated or recorded; no pictures.

    ``seeds`` repeats what is random: a simulated drive, never a recorded one.
    """

    sequence: Literal["backends"]
    name: Name
    title: str = ""
    description: str = ""
    seed: int = Field(0, ge=0)
    drives: Annotated[
        tuple[Annotated[AnyDrive, Field(discriminator="source")], ...],
        Field(min_length=1),
        AfterValidator(distinct_drives),
    ]
    backends: Backends
    observation: Name = "cartesian"
    seeds: int = Field(10, ge=1)


Study = Annotated[
    RenderedStudy
    | DlrStudy
    | DlrPicturesStudy
    | DlrLightStudy
    | BackendsStudy
    | PairsStudy
    | FiltersStudy
    | ClosedLoopStudy,
    Field(discriminator="sequence"),
]
"""A study of any kind; the key ``sequence`` chooses the model, and with it ``bench/<sequence>_run.py``, which
runs it, and ``reports/page_<sequence>.py``, which tells of it."""

SEQUENCES: tuple[type[Study], ...] = get_args(get_args(Study)[0])
