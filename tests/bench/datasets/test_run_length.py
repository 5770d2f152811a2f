"""COCO's run lengths: equal to pycocotools' on any mask."""

import hypothesis.extra.numpy as arrays
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pycocotools import mask as coco

from bench.datasets.run_length import box, compress, runs

SHAPES = st.tuples(st.integers(1, 40), st.integers(1, 40))


@given(arrays.arrays(np.bool_, SHAPES))
def test_any_mask_is_encoded_as_pycocotools_does(mask):
    reference = coco.encode(np.asfortranarray(mask.astype(np.uint8)))
    assert compress(runs(mask)).encode() == reference["counts"]
    assert box(mask) == coco.toBbox(reference).tolist() or not mask.any()


@pytest.mark.parametrize("sparse", [0.5, 0.01, 0.0001])
def test_long_runs_take_several_digits(sparse):
    mask = np.random.default_rng(1).random((700, 900)) < sparse
    reference = coco.encode(np.asfortranarray(mask.astype(np.uint8)))
    assert compress(runs(mask)).encode() == reference["counts"]


@pytest.mark.parametrize("value", [False, True])
def test_masks_of_one_value(value):
    mask = np.full((3, 5), value)
    assert runs(mask).tolist() == ([0, 15] if value else [15])
    assert box(mask) == ([0, 0, 5, 3] if value else [0, 0, 0, 0])
