"""Sensors by name, from published numbers. Plain data.

EMVA 1288 numbers follow from what a sheet states: full well from the largest signal-to-noise ratio
(SNR_max = √μ_e.sat), dark noise from the dynamic range (DR = μ_e.sat / (σ_d + ½)). Quantum efficiencies are
means over 400–700 nm behind a colour filter: peak × 0.35, a bell of 100 nm width at half height. Thermal
electrons from mV/s take 1 V as the full well's swing; a dark current doubles every 8 K unless stated. Where a
sheet is silent the value is marked as assumed. No published spectral sensitivities of these sensors are at
hand, so all keep the sRGB primaries.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from renderers.sensor_sheet import Sheet

MACHINE_VISION = Sheet(
    # Sony Pregius, 3.45 µm (IMX250, IMX255): SNR 40.3 dB, dynamic range 71.3 dB, 12 bit (Matrix Vision
    # mvBlueFOX3 manual, A.1, IMX255). Peak QE 0.70 mono × 0.93 IR filter (Basler, EMVA reports for colour
    # sensors); red and blue at 0.85 and 0.80 of it, dark current, DSNU and PRNU assumed, of the size that
    # EMVA reports of this family show. Their colour models have a Bayer array; its order assumed.
    colour_filter_array="RGGB",
    pixel_pitch_um=3.45,
    quantum_efficiency=(0.19, 0.23, 0.18),
    full_well_e=10_700.0,
    read_noise_e=2.4,
    bit_depth=12,
    black_level_dn=64,
    dark_current_e_per_s=5.0,
    temperature_c=40.0,
    dsnu_e=1.0,
    prnu=0.005,
)

WEBCAM = Sheet(
    # OmniVision OV5647 (OptArc AF51 user guide, ch. 3): 1.4 µm, well 4.3 ke⁻, dynamic range 68 dB, dark
    # current 16 mV/s at 60 °C, fixed pattern < 1 % of the swing (taken as ± 3σ), 680 mV/(lux s), hence
    # QE 0.14; f/2.9 (its Raspberry Pi lens); 10 bit. PRNU, and red and blue at 0.85 of green, assumed. BGGR
    # unless it mirrors its picture (Linux, drivers/media/i2c/ov5647.c).
    colour_filter_array="BGGR",
    pixel_pitch_um=1.4,
    f_number=2.9,
    quantum_efficiency=(0.12, 0.14, 0.12),
    full_well_e=4_300.0,
    read_noise_e=1.2,
    bit_depth=10,
    black_level_dn=16,
    dark_current_e_per_s=69.0,
    reference_temperature_c=60.0,
    temperature_c=40.0,
    dsnu_e=7.0,
    prnu=0.01,
)

OLD_ROBOT = Sheet(
    # OmniVision OV7950 (data sheet 2.5, 2006), an analogue NTSC camera behind an 8-bit frame grabber, one
    # field of 320 × 240: 6 µm, SNR 48 dB, dynamic range 49 dB, dark current 10 mV/s at 60 °C, fixed pattern
    # 0.22 % of the swing (taken as ± 3σ). QE (peak 0.4) and PRNU assumed. Its 656 × 492 photosites are
    # demosaiced on the chip and reduced to the grabber's 320 × 240, so no mosaic is left to see.
    quantum_efficiency=(0.12, 0.14, 0.10),
    full_well_e=63_000.0,
    read_noise_e=223.0,
    bit_depth=8,
    black_level_dn=8,
    dark_current_e_per_s=630.0,
    reference_temperature_c=60.0,
    temperature_c=40.0,
    dsnu_e=23.0,
    prnu=0.01,
)

PRESETS: Mapping[str, Sheet] = MappingProxyType(
    {
        "standard": Sheet(),
        "machine-vision": MACHINE_VISION,
        "webcam": WEBCAM,
        "old-robot": OLD_ROBOT,
    }
)
"""Cameras by the preset's name."""
