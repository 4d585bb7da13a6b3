"""Models in files: those that Relume 0.1.0 saved stay what they were, and no JSON breaks the reader."""

import gzip
import json
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from relume.core import FactorModel
from relume.core.errors import ModelError
from relume.core.model import bases
from relume.core.spectra import library

# {name: {"model": what `to_dict` gave in 0.1.0, "relight": {illuminant: matrix}}}
SAVED = json.loads(gzip.decompress((Path(__file__).parent / "data" / "models_0_1_0.json.gz").read_bytes()))
# Only fits pass through a solver, and their training set through colour-science, whose data differ between versions.
TOLERANCE = {"fitted": 1e-9, "scene": 1e-9}
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner, max_size=4),
)


@pytest.mark.parametrize("name", SAVED)
def test_a_model_saved_by_0_1_0_keeps_its_description_and_its_matrices(name):
    saved = SAVED[name]
    model = FactorModel.from_dict(saved["model"])
    assert json.dumps(model.to_dict()) == json.dumps(saved["model"])
    assert isinstance(model, FactorModel)
    for light, expected in saved["relight"].items():
        expected = np.array(expected)
        found = model.relight(library.illuminant(light))
        tolerance = TOLERANCE.get(name, 1e-12)
        np.testing.assert_allclose(found, expected, rtol=tolerance, atol=tolerance * np.abs(expected).max())


def test_labels_are_those_that_people_use():
    assert [bases.fitted(9).label, bases.bands().label] == ["9 channels", "the reference, 36 bands"]
    assert bases.prefiltered(library.illuminant("A")).label == "one light, prefiltered sharp RGB"
    saved = FactorModel.from_dict(SAVED["bands"]["model"])
    assert saved.is_reference and saved.reordered(list(range(33))[::-1]).is_reference
    assert not any(model.is_reference for model in (bases.block(36), bases.fitted(40), bases.fitted(9), bases.rgb()))


def parts(path=()):
    """Every place in the description of a small model."""
    described = SAVED["prefiltered"]["model"]
    return st.sampled_from([(), *((key,) for key in described), ("filters", 0), ("filters", 0, 1), ("wavelengths", 3)])


@given(parts(), JSON, st.sampled_from(["prefiltered", "block", "scene"]))
@settings(max_examples=300, deadline=None)
def test_any_json_in_any_place_makes_a_model_or_a_model_error(place, value, name):
    described = json.loads(json.dumps(SAVED[name]["model"]))
    if not place:
        described = value
    elif place[0] in described:
        owner = described
        for key in place[:-1]:
            owner = owner[key]
        owner[place[-1]] = value
    with suppress(ModelError):
        assert isinstance(FactorModel.from_dict(described), FactorModel)


def nested(depth):
    inner = []
    for _ in range(depth):
        inner = [inner]
    return inner


@pytest.mark.parametrize("field", ["wavelengths", "filters", "primaries", "rule"])
@pytest.mark.parametrize(
    "value",
    [
        *[None, True, "380", 5.0, 10**400, [], [[]], {}, [None], ["380"], [float("nan")], [[1.0], [1.0, 2.0]]],
        *[nested(50), nested(500), [[1e308, 1e308, 1e308]] * 81, [0.5] * 6000, [[[0.0]] * 81] * 3, [0.0, 0.0]],
        *[[[0.0] * 3] * 3, [1e308 * (-1) ** k for k in range(81)], list(range(780, 375, -5))],
    ],
    ids=lambda value: str(value)[:20],
)
def test_hostile_fields_are_refused_in_words(field, value):
    with pytest.raises(ModelError, match=r"model|description"):
        FactorModel.from_dict({**SAVED["prefiltered"]["model"], field: value})


@pytest.mark.parametrize("name", [None, 5, [], {}, nested(500)])
def test_a_name_is_text(name):
    with pytest.raises(ModelError, match="name"):
        FactorModel.from_dict({**SAVED["prefiltered"]["model"], "name": name})


def test_an_array_of_another_rule_is_refused():
    with pytest.raises(ModelError, match="reconstruction"):
        FactorModel.from_dict({**SAVED["fitted"]["model"], "reconstruction": SAVED["fitted"]["model"]["filters"]})
