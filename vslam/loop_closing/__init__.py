"""SLAM that closes large loops: a local map that tracks discs, constellations that are recognised, a factor graph."""
