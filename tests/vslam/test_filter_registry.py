"""The registry: names, descriptions, parameters."""

import subprocess
import sys

import pytest

from vslam.errors import VslamError
from vslam.filters import FilterParameterError, UnknownFilterError, create, describe, names, register


def test_names_are_sorted_and_described() -> None:
    assert set(names()) >= {"none", "seed", "seed_per_pixel"}
    assert list(names()) == sorted(names())
    assert tuple(d.name for d in describe()) == names()
    assert all(d.summary and d.source for d in describe())


def test_a_description_holds_each_parameter_with_its_default_and_meaning() -> None:
    (seed,) = (d for d in describe() if d.name == "seed")
    patch = seed.parameters[0]
    assert (patch.name, patch.type, patch.default) == ("patch", "int", 15)
    assert patch.meaning.startswith("Side of the dark channel's patch")
    for description in describe():
        for parameter in description.parameters:
            assert parameter.meaning, f"{description.name}: {parameter.name} is not explained"


def test_an_unknown_name_carries_the_known_ones() -> None:
    with pytest.raises(UnknownFilterError) as caught:
        create("sed")
    assert caught.value.known == names()
    assert caught.value.name == "sed"
    assert isinstance(caught.value, VslamError)


def test_unknown_parameters_and_senseless_values_are_refused() -> None:
    with pytest.raises(FilterParameterError, match="pach"):
        create("seed", pach=3)
    with pytest.raises(VslamError, match="odd"):
        create("seed_per_pixel", patch=4)
    with pytest.raises(VslamError, match="outside 0…255"):
        create("seed", threshold=300)
    assert create("seed", patch=3) == create("seed", patch=3)


def test_a_name_is_given_once() -> None:
    with pytest.raises(VslamError, match="twice"):
        register("seed", summary="another", source="test")(lambda: create("none"))


def test_listing_does_not_import_numba() -> None:
    code = "import sys; from vslam.filters import describe; describe(); sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
