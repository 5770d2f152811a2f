"""Random streams by name: adding a component changes no other one's numbers."""

from __future__ import annotations

from hashlib import blake2b

import numpy as np


def generator(seed: int, *names: str | int) -> np.random.Generator:
    """Create the generator that belongs to a component of a study.

    Parameters
    ----------
    seed : int
        The study's seed, ≥ 0.
    *names : str or int
        The component's path, for example ``"sensor", "sun20000-bulb800", 17``. Text and number differ:
        ``"1"`` and ``1`` name two streams.

    Returns
    -------
    numpy.random.Generator
        PCG64, the same for the same arguments on every machine and in every process.

    Raises
    ------
    ValueError
        If ``seed`` is negative.
    """
    if seed < 0:
        raise ValueError(f"seed {seed}: must not be negative")
    # the length before each name keeps ("ab", "c") and ("a", "bc") apart
    digest = blake2b(digest_size=16)
    for name in names:
        text = f"{type(name).__name__}:{name}".encode()
        digest.update(len(text).to_bytes(8, "little") + text)
    words = np.frombuffer(digest.digest(), dtype="<u4")
    return np.random.default_rng(np.random.SeedSequence([seed, *(int(w) for w in words)]))
