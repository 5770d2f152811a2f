"""What all tests share: one thread per process for numeric libraries, steady hypothesis, the DLR log."""

from __future__ import annotations

import os
from pathlib import Path

# set before NumPy loads: two BLAS threads per test process slow each other down
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import hypothesis
import pytest

# a loaded machine is no failure, and a failure must come again
hypothesis.settings.register_profile("steady", deadline=None, derandomize=True)
hypothesis.settings.load_profile("steady")


@pytest.fixture(scope="session")
def dlr_folder() -> Path:
    """The folder of the real DLR log, or skip."""
    folder = Path(os.environ.get("BENCH_DATA", "")) / "dlr"
    if "BENCH_DATA" not in os.environ or not (folder / "map.circles").is_file():
        pytest.skip("needs the DLR log in $BENCH_DATA/dlr")
    return folder
