"""How light reaches a sensor: cameras, G-buffer engines, shading, light basis, sensor, ground truth."""
