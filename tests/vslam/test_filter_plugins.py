"""Filters from elsewhere: classes of the working directory, entry points of packages, ONNX files."""

import sys
from importlib.metadata import EntryPoint

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper

from vslam.errors import VslamError
from vslam.filters import PictureForm, create, describe, discovery, names, registry
from vslam.filters.apply import FilterFailureError, apply

PLUGIN = '''
import numpy as np
from vslam.filters import Filtered

class Dark:
    """Masks what is darker than a level.

    Parameters
    ----------
    level : int
        Of the darkest channel.
    """

    name = "dark"

    def __init__(self, level=100):
        if level == 13:
            raise RuntimeError("bad luck")
        self.level = level

    def __call__(self, image):
        mask = image.min(axis=2) < self.level
        return Filtered(image.copy(), mask, mask.astype(np.float32))

class Deaf:
    """Cannot be called."""
'''


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A working directory with a plug-in, which is forgotten afterwards."""
    (tmp_path / "my_plugin.py").write_text(PLUGIN)
    (tmp_path / "my_broken.py").write_text("raise KeyError('torch')")
    monkeypatch.chdir(tmp_path)
    yield tmp_path
    for name in ("my_plugin", "my_broken"):
        sys.modules.pop(name, None)


def test_a_class_of_the_working_directory_is_a_filter(folder):
    path = list(sys.path)
    light_filter = create("my_plugin:Dark", level=50)
    assert sys.path == path
    image = np.array([[[40, 90, 90], [60, 90, 90]]], np.uint8)
    np.testing.assert_array_equal(apply(light_filter, image).mask, [[True, False]])
    (level,) = registry.parameters("my_plugin:Dark")
    assert (level.name, level.default, level.meaning) == ("level", 100, "Of the darkest channel.")


@pytest.mark.parametrize(
    ("name", "parameters", "said"),
    [
        ("my_nothing:Dark", {}, "there is no module 'my_nothing'"),
        ("my_plugin:Dork", {}, "no class 'Dork'; did you mean 'Dark'"),
        ("my_broken:Dark", {}, "cannot be imported: KeyError: 'torch'"),
        ("my_plugin:Dark", {"levle": 3}, "levle"),
        ("my_plugin:Dark", {"level": 13}, "cannot be built: RuntimeError: bad luck"),
        ("my_plugin:Deaf", {}, "cannot be called"),
    ],
)
def test_what_is_wrong_with_a_class_is_one_line(folder, name, parameters, said):
    with pytest.raises(VslamError, match=said) as caught:
        create(name, **parameters)
    assert "\n" not in str(caught.value) and name in str(caught.value)


@pytest.fixture
def installed(folder, monkeypatch):
    """Two installed filters, one of which cannot be loaded."""
    points = [
        EntryPoint(n, f"{m}:Dark", discovery.GROUP) for n, m in (("dk", "my_plugin"), ("br", "my_broken"))
    ]
    monkeypatch.setattr(registry, "_entries", dict(registry._found()))
    monkeypatch.setattr(discovery, "installed", lambda: {point.name: point for point in points})


@pytest.mark.usefixtures("installed")
def test_an_entry_point_is_known_by_its_name():
    assert {"dk", "br", "seed"} <= set(names())
    described = {d.name: d for d in describe()}
    assert described["dk"].summary == "Masks what is darker than a level"
    assert described["dk"].parameters[0].default == 100
    assert "cannot be loaded" in described["br"].summary and "KeyError" in described["br"].summary
    assert create("dk", level=7).level == 7
    with pytest.raises(VslamError, match="cannot be imported"):
        create("br")


def onnx_file(path, nodes, outputs, constants=(), metadata=None, shape=(1, 3, "h", "w")):
    """A model of float32 nodes from ``x``; ``outputs`` maps names to channels."""
    inputs = [helper.make_tensor_value_info("x", TensorProto.FLOAT, shape)]
    results = [
        helper.make_tensor_value_info(name, TensorProto.FLOAT, (1, channels, None, None))
        for name, channels in outputs.items()
    ]
    initial = [helper.make_tensor(n, TensorProto.FLOAT, (), [v]) for n, v in constants]
    graph = helper.make_graph(nodes, "filter", inputs, results, initial)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    helper.set_model_props(model, metadata or {})
    onnx.save(model, str(path))
    return str(path)


HALVE = helper.make_node("Mul", ["x", "half"], ["image"])
SCORE = helper.make_node("ReduceMax", ["x"], ["score"], axes=[1], keepdims=1)
HALF = (("half", 0.5),)
PICTURE = np.random.default_rng(0).integers(0, 256, (6, 9, 3), dtype=np.uint8)


def test_an_onnx_file_is_a_filter_in_linear_light(tmp_path):
    light_filter = create(onnx_file(tmp_path / "m.onnx", [HALVE, SCORE], {"image": 3, "score": 1}, HALF))
    assert light_filter.wants is PictureForm.LINEAR
    linear = np.where(PICTURE <= 10.31475, PICTURE / 255 / 12.92, ((PICTURE / 255 + 0.055) / 1.055) ** 2.4)
    result = apply(light_filter, PICTURE)
    np.testing.assert_allclose(result.score, linear.max(axis=2), atol=1e-6)
    np.testing.assert_array_equal(result.mask, linear.max(axis=2) >= 0.5)
    half = 0.5 * linear[result.mask]
    encoded = np.where(half <= 0.0031308, 12.92 * half, 1.055 * half ** (1 / 2.4) - 0.055)
    np.testing.assert_allclose(result.image[result.mask], 255 * encoded, atol=0.501)  # the nearest code


def test_its_metadata_name_encoding_threshold_and_multiple(tmp_path):
    metadata = {"glarebench.encoding": "srgb", "glarebench.threshold": "0.75", "glarebench.multiple": "4"}
    # pooling over 4 × 4 and back: sides that are no multiples of 4 would not come back whole
    nodes = [
        SCORE,
        helper.make_node("AveragePool", ["x"], ["small"], kernel_shape=[4, 4], strides=[4, 4]),
        helper.make_node("Resize", ["small", "", "scales"], ["image"], mode="nearest"),
    ]
    path = onnx_file(tmp_path / "m.onnx", nodes, {"image": 3, "score": 1}, (), metadata)
    model = onnx.load(path)
    model.graph.initializer.append(helper.make_tensor("scales", TensorProto.FLOAT, (4,), [1, 1, 4, 4]))
    onnx.save(model, path)
    light_filter = create(path)
    assert light_filter.wants is PictureForm.SRGB8
    result = apply(light_filter, PICTURE)
    np.testing.assert_array_equal(result.mask, PICTURE.max(axis=2) / np.float32(255) >= 0.75)
    mean = PICTURE[:4, :4].mean(axis=(0, 1))
    inside = result.mask[:4, :4]
    np.testing.assert_allclose(result.image[:4, :4][inside], np.tile(mean, (inside.sum(), 1)), atol=0.51)


def test_a_model_without_a_score_is_scored_by_what_it_changes(tmp_path):
    light_filter = create(onnx_file(tmp_path / "m.onnx", [HALVE], {"image": 3}, HALF))
    grey = np.array([[0.0, 0.004, 0.5]], np.float32)[:, :, None].repeat(3, axis=2)
    result = light_filter(grey)
    np.testing.assert_allclose(result.score, [[0, 0.002, 0.25]], atol=1e-6)
    np.testing.assert_array_equal(result.mask, [[False, False, True]])


def test_a_model_without_a_picture_detects_only(tmp_path):
    result = apply(create(onnx_file(tmp_path / "m.onnx", [SCORE], {"score": 1})), PICTURE)
    np.testing.assert_array_equal(result.image, PICTURE)
    assert result.mask.any()


def test_a_model_that_answers_nonsense_is_a_failure(tmp_path):
    nodes = [helper.make_node("Div", ["x", "half"], ["image"])]
    path = onnx_file(tmp_path / "m.onnx", nodes, {"image": 3}, (("half", 0.0),))
    with pytest.raises(FilterFailureError, match="holds NaN"):
        apply(create(path), np.zeros((3, 3, 3), np.uint8))
    path = onnx_file(tmp_path / "m.onnx", [HALVE], {"image": 3}, HALF, shape=(1, 3, 8, 8))
    with pytest.raises(FilterFailureError, match="Got invalid dimensions"):
        apply(create(path), PICTURE)


def test_a_file_that_is_no_filter_is_refused_in_one_line(tmp_path):
    (tmp_path / "text.onnx").write_text("no model")
    two = [helper.make_node("Identity", ["x"], ["y"])]
    for path, said in (
        (str(tmp_path / "none.onnx"), "no such file"),
        (str(tmp_path / "text.onnx"), "cannot load it"),
        (onnx_file(tmp_path / "y.onnx", two, {"y": 3}), "a filter has image, score or both"),
        (
            onnx_file(tmp_path / "d.onnx", [SCORE], {"score": 1}, (), {"glarebench.threshold": "x"}),
            "no number",
        ),
        (onnx_file(tmp_path / "e.onnx", [SCORE], {"score": 1}, (), {"glarebench.encoding": "hsv"}), "'srgb'"),
    ):
        with pytest.raises(VslamError, match=said) as caught:
            create(path)
        assert "\n" not in str(caught.value) and path in str(caught.value)


def test_without_onnxruntime_the_error_says_what_to_install(tmp_path, monkeypatch):
    path = onnx_file(tmp_path / "m.onnx", [SCORE], {"score": 1})
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    with pytest.raises(VslamError, match=r"pip install glarebench\[onnx\]"):
        create(path)
