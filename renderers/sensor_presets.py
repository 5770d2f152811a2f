"""Sensors by name, from published numbers. Plain data, so that study files are checked without numba.

EMVA 1288 numbers follow from what a sheet states: full well from the largest signal-to-noise ratio
(SNR_max = √μ_e.sat), dark noise from the dynamic range (DR = μ_e.sat / (σ_d + ½)). Quantum efficiencies are
means over 400–700 nm behind a colour filter: peak × 0.35, a bell of 100 nm width at half height. Thermal
electrons from mV/s take 1 V as the full well's swing; a dark current doubles every 8 K unless stated. Where a
sheet is silent the value is marked as assumed.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

STANDARD = {
    # no product: a machine vision CMOS camera with large pixels and no flaws but shot and read noise
    "pixel_pitch_um": 6.0,
    "f_number": 2.0,
    "lens_transmission": 0.9,
    "quantum_efficiency": (0.35, 0.45, 0.35),
    "full_well_e": 20_000.0,
    "read_noise_e": 8.0,
    "bit_depth": 10,
    "black_level_dn": 16,
    "dark_current_e_per_s": 0.0,
    "reference_temperature_c": 25.0,
    "doubling_temperature_k": 8.0,
    "temperature_c": 25.0,
    "dsnu_e": 0.0,
    "prnu": 0.0,
}

MACHINE_VISION = STANDARD | {
    # Sony Pregius, 3.45 µm (IMX250, IMX255): SNR 40.3 dB, dynamic range 71.3 dB, 12 bit (Matrix Vision
    # mvBlueFOX3 manual, A.1, IMX255). Peak QE 0.70 mono × 0.93 IR filter (Basler, EMVA reports for colour
    # sensors); red and blue at 0.85 and 0.80 of it, dark current, DSNU and PRNU assumed, of the size that
    # EMVA reports of this family show.
    "pixel_pitch_um": 3.45,
    "quantum_efficiency": (0.19, 0.23, 0.18),
    "full_well_e": 10_700.0,
    "read_noise_e": 2.4,
    "bit_depth": 12,
    "black_level_dn": 64,
    "dark_current_e_per_s": 5.0,
    "temperature_c": 40.0,
    "dsnu_e": 1.0,
    "prnu": 0.005,
}

WEBCAM = STANDARD | {
    # OmniVision OV5647 (OptArc AF51 user guide, ch. 3): 1.4 µm, well 4.3 ke⁻, dynamic range 68 dB, dark
    # current 16 mV/s at 60 °C, fixed pattern < 1 % of the swing (taken as ± 3σ), 680 mV/(lux s), hence
    # QE 0.14; f/2.9 (its Raspberry Pi lens); 10 bit. PRNU, and red and blue at 0.85 of green, assumed.
    "pixel_pitch_um": 1.4,
    "f_number": 2.9,
    "quantum_efficiency": (0.12, 0.14, 0.12),
    "full_well_e": 4_300.0,
    "read_noise_e": 1.2,
    "bit_depth": 10,
    "black_level_dn": 16,
    "dark_current_e_per_s": 69.0,
    "reference_temperature_c": 60.0,
    "temperature_c": 40.0,
    "dsnu_e": 7.0,
    "prnu": 0.01,
}

OLD_ROBOT = STANDARD | {
    # OmniVision OV7950 (data sheet 2.5, 2006), an analogue NTSC camera behind an 8-bit frame grabber, one
    # field of 320 × 240: 6 µm, SNR 48 dB, dynamic range 49 dB, dark current 10 mV/s at 60 °C, fixed pattern
    # 0.22 % of the swing (taken as ± 3σ). QE (peak 0.4) and PRNU assumed.
    "quantum_efficiency": (0.12, 0.14, 0.10),
    "full_well_e": 63_000.0,
    "read_noise_e": 223.0,
    "bit_depth": 8,
    "black_level_dn": 8,
    "dark_current_e_per_s": 630.0,
    "reference_temperature_c": 60.0,
    "temperature_c": 40.0,
    "dsnu_e": 23.0,
    "prnu": 0.01,
}

PRESETS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "standard": STANDARD,
        "machine-vision": MACHINE_VISION,
        "webcam": WEBCAM,
        "old-robot": OLD_ROBOT,
    }
)
"""The parameters of `renderers.sensor.Sensor` that belong to the camera itself, by the preset's name."""
