"""Data sets on disk: layouts that other tools open as they are, one index for all of them, and a reader."""

from bench.datasets.reader import PictureSet

__all__ = ["PictureSet"]
