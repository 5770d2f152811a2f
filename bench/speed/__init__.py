"""Benchmarks of speed, one file each: ours and a baseline, measured alternately in one run."""
