"""A rendered sequence: what the robot's sensors deliver along a scene's tour, and what is true about it."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench import camera_choice
from bench.camera_choice import camera, mount
from bench.illumination_grid import Illumination
from bench.kinds.rendered import RenderedStudy
from bench.rng import generator
from bench.robot_choice import OdometryNoise
from bench.sequences.lighting import Colours, Lighting, as_built, load_scene
from renderers.basis import LightBasis, SceneRenderer, mean_white, relight
from renderers.irradiance import FULL_QUALITY, BakeQuality
from renderers.metering import Exposure, meter, shifted
from renderers.motion_blur import image_velocity, motion_blurred
from renderers.optics import Optics, basis_through_lens
from renderers.sensor import Sensor
from renderers.sensor_sheet import Sheet
from renderers.truth import Recording, record
from scenes.tour import body_twist
from vslam.camera import Calibration
from vslam.frame import Odometry

FloatArray = NDArray[np.float64]
Velocities = tuple[NDArray[np.float32], NDArray[np.float32]]


@dataclass(frozen=True)
class SequenceSetup:
    """All that a worker process needs to make its own `RenderedSequence`.

    Attributes
    ----------
    engine : str
        "rasterise" or "raycast", already resolved.
    colours : dict of illuminant to (3,) float64
        Linear sRGB of each illuminant of the study (`bench.sequences.lighting.light_colours`).
    threads : int
        Of the renderer in this process, 0 for all cores.
    cache : Path, optional
        Where baked light is kept.
    quality : BakeQuality
        How much work goes into baked light.
    cached_shadows : bool
        Whether what lights reach is told once and kept (`renderers.shadow_cache`).
    """

    study: RenderedStudy
    engine: str
    colours: Colours
    threads: int
    cache: Path | None
    quality: BakeQuality = FULL_QUALITY
    cached_shadows: bool = False


class RenderedSequence:
    """The tour of a study's scene, frame by frame, under any of its illuminations.

    Every picture, depth image and odometry increment comes from a random stream of its own, so it is the
    same in whatever order and process it is made.
    """

    def __init__(self, setup: SequenceSetup) -> None:
        self._setup, self.study = setup, setup.study
        self.scene = load_scene(setup.study)
        self._lighting = Lighting(setup.study, self.scene, as_built(setup.study), setup.colours)
        self._mount = mount(setup.study.camera)
        self.sensor, self._optics = sensor(setup.study), _optics(setup.study)
        self._moving: tuple[LightBasis, Velocities] | None = None

    def __len__(self) -> int:
        return len(self.scene.tour.stamps)

    @cached_property
    def renderer(self) -> SceneRenderer:
        """The renderer of the scene; its baked light is made, or read from the cache, at first use."""
        return SceneRenderer(
            self.scene,
            camera(self.study.camera),
            self._mount,
            self._setup.engine,
            self.study.camera.supersampling,
            self._setup.threads,
            self._setup.cache,
            self._setup.quality,
            mirrored=self.study.camera.optics.motion_blur,
            cached_shadows=self._setup.cached_shadows,
        )

    def basis(self, frame: int) -> LightBasis:
        """The light basis at a frame's true pose, behind the camera's lens."""
        return self.basis_at(self.scene.tour.poses[frame])

    def basis_at(self, pose: FloatArray) -> LightBasis:
        """The same at any pose, (3,) x, y in metres and heading in rad."""
        basis = self.renderer.render(pose)
        return basis_through_lens(self._optics, camera(self.study.camera), basis)

    def relight(
        self, basis: LightBasis, illumination: Illumination, frame: int = 0
    ) -> tuple[NDArray, NDArray]:
        """Diffuse and specular luminance of a basis under an illumination, (H, W, 3) float32, cd/m².

        The frame matters where lamps flicker, and where motion blurs.
        """
        return self._exposed(basis, illumination, frame)[:2]

    def record(
        self, basis: LightBasis, illumination: Illumination, frame: int, highlights: bool = True
    ) -> Recording:
        """Take the picture of a frame under an illumination.

        Without ``highlights`` all specular light is removed; exposure and noise are drawn as with it.
        """
        rng = generator(self.study.seed, "sensor", illumination.name, frame)
        diffuse, specular, white, exposure = self._exposed(basis, illumination, frame)
        specular = specular if highlights else np.zeros_like(specular)
        return self._recorded((diffuse, specular, white, exposure), rng)

    def record_at(
        self, basis: LightBasis, illumination: Illumination, seconds: float, rng: np.random.Generator
    ) -> Recording:
        """Take a picture off the tour, at a moment of the lamps' flicker; nothing moves while it is taken."""
        return self._recorded(self._still(basis, illumination, seconds), rng)

    def _recorded(
        self, light: tuple[NDArray, NDArray, FloatArray, Exposure], rng: np.random.Generator
    ) -> Recording:
        diffuse, specular, white, exposure = light
        threshold = self.study.sensor.highlight_threshold
        return record(self.sensor, diffuse, specular, white, rng, threshold, exposure)

    def _still(
        self, basis: LightBasis, illumination: Illumination, seconds: float
    ) -> tuple[NDArray, NDArray, FloatArray, Exposure]:
        """Diffuse and specular light, its colour, and the metered exposure."""
        colours = self._lighting.colour(illumination)
        intensity = self._lighting.intensity(illumination, seconds)
        diffuse, specular = relight(basis, intensity, colours)
        white = mean_white(basis, intensity, colours)
        metered = meter(self.sensor, diffuse + specular, white)
        return diffuse, specular, white, shifted(self.sensor, metered, illumination.exposure_ev)

    def _exposed(
        self, basis: LightBasis, illumination: Illumination, frame: int
    ) -> tuple[NDArray, NDArray, FloatArray, Exposure]:
        """Diffuse and specular light while the shutter is open, its colour, and the metered exposure."""
        seconds = float(self.scene.tour.stamps[frame])
        diffuse, specular, white, exposure = self._still(basis, illumination, seconds)
        if self.study.camera.optics.motion_blur:
            diffuse, specular = (
                motion_blurred(light, velocity, exposure.seconds)
                for light, velocity in zip(
                    (diffuse, specular), self._image_velocities(basis, frame), strict=True
                )
            )
        return diffuse, specular, white, exposure

    def _image_velocities(self, basis: LightBasis, frame: int) -> Velocities:
        """Of diffuse and of specular light; kept for the frame's other illuminations."""
        if self._moving is None or self._moving[0] is not basis:
            eye, twist = camera(self.study.camera), body_twist(self.scene.tour, frame)
            of_surface = image_velocity(eye, self._mount, twist, basis.depth)
            of_mirrored = image_velocity(eye, self._mount, twist, basis.mirror_depth)
            self._moving = basis, (of_surface, of_mirrored)
        return self._moving[1]

    def measured_depth(self, basis: LightBasis, frame: int) -> NDArray[np.float32]:
        """The depth camera's reading: σ grows with z²; nothing beyond its range, (H, W) float32 metres."""
        return self.noisy_depth(basis, generator(self.study.seed, "depth", frame))

    def noisy_depth(self, basis: LightBasis, rng: np.random.Generator) -> NDArray[np.float32]:
        """The same with random numbers of the caller's."""
        noise, depth = self.study.depth, basis.depth
        sigma = np.float32(noise.sigma_m_at_1m) * depth * depth
        reading = depth + sigma * rng.standard_normal(depth.shape, dtype=np.float32)
        return np.where((depth > 0) & (depth <= noise.max_m), np.maximum(reading, 0), 0).astype(np.float32)


def calibration(study: RenderedStudy) -> Calibration:
    """What the robot knows of its camera."""
    return camera_choice.calibration(study.camera)


def _optics(study: RenderedStudy) -> Optics:
    """The study's lens; motion blur is the sequence's."""
    return Optics(**study.camera.optics.model_dump(exclude={"motion_blur"}))


def sensor(study: RenderedStudy) -> Sensor:
    """The study's sensor."""
    choice = study.sensor
    sheet = {field.name: getattr(choice, field.name) for field in fields(Sheet)}
    return Sensor(
        **sheet,
        min_exposure_s=choice.min_exposure_s,
        max_exposure_s=choice.max_exposure_s,
        exposure_s=None if choice.exposure == "auto" else choice.exposure,
        gain_db=choice.gain_db,
        max_gain_db=choice.max_gain_db,
        metering=choice.metering,
        metering_target=choice.target,
        serial_number=int(generator(study.seed, "fixed patterns").integers(2**63)),
    )


def odometry(study: RenderedStudy, poses: FloatArray, seed: int) -> tuple[Odometry, ...]:
    """Noisy motion increments along the true poses, with the covariance they were drawn from.

    Parameters
    ----------
    poses : (n, 3) float64
        True poses; the first increment is exactly zero, as the robot starts there.
    seed : int
        Number of the repetition.

    Returns
    -------
    n increments
    """
    noise, rng = study.odometry, generator(study.seed, "odometry", seed)
    increments = [Odometry(np.zeros(3), np.zeros((3, 3)))]
    for before, after in pairwise(poses):
        c, s = np.cos(before[2]), np.sin(before[2])
        dx, dy = after[:2] - before[:2]
        delta = np.array([c * dx + s * dy, -s * dx + c * dy, after[2] - before[2]])
        sigma = increment_sigma(noise, float(np.hypot(dx, dy)), abs(float(delta[2])))
        increments.append(Odometry(delta + sigma * rng.standard_normal(3), np.diag(sigma**2)))
    return tuple(increments)


def increment_sigma(noise: OdometryNoise, length: float, turn: float) -> FloatArray:
    """(3,) float64: σ forward, left (metres) and of the heading (rad) of an increment of so many m, rad."""
    heading = np.hypot(noise.sigma_heading_rad_per_m * length, noise.sigma_heading_rad_per_rad * turn)
    return np.array(
        [noise.sigma_forward_m_per_m * length, noise.sigma_lateral_m_per_m * length, float(heading)]
    )
