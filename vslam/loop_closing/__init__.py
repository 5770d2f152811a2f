"""Large loops: a local map that tracks discs, constellations that are recognised, a track that is
smoothed.
"""
