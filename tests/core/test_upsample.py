import colour
import numpy as np
import pytest

from relume.core.model import bases, upsample
from relume.core.model.factor_model import ModelError
from relume.core.spectra import library

from .conftest import difference, tristimulus

CUBE = np.stack(np.meshgrid(*[np.linspace(0, 1, 11)] * 3), axis=-1).reshape(-1, 3)


@pytest.mark.parametrize("space", upsample.RGB_SPACES)
def test_spaces_are_those_of_colour_science(space):
    name = {"Linear Rec.709": "sRGB", "Linear Rec.2020": "ITU-R BT.2020", "ACEScg": "ACEScg"}[space]
    theirs = colour.RGB_COLOURSPACES[name]
    adapted = colour.RGB_to_XYZ(np.eye(3), name, colour.CCS_ILLUMINANTS["CIE 1931 2 Degree Standard Observer"]["D65"],
                                "Bradford").T if space == "ACEScg" else theirs.matrix_RGB_to_XYZ  # fmt: skip
    np.testing.assert_allclose(upsample.rgb_to_xyz(space), adapted, atol=5e-4)


@pytest.mark.parametrize("channels", [3, 6, 9, 12, 15])
def test_round_trip_under_daylight_is_exact_and_in_range(channels):
    model = bases.fitted(channels)
    daylight = library.illuminant("D65")
    white = tristimulus(np.ones(81), daylight.sampled())
    matrix = upsample.rgb_matrix(model)
    np.testing.assert_allclose(matrix.sum(axis=1), 1, atol=1e-8)
    coefficients = CUBE @ matrix.T
    assert coefficients.min() >= -1e-6 and coefficients.max() <= 1 + 1e-6
    back = coefficients @ model.relight(daylight).T
    assert difference(back, CUBE @ upsample.rgb_to_xyz().T, white).max() < 1e-3


@pytest.mark.parametrize("space", ["Linear Rec.2020", "ACEScg"])
def test_a_colour_has_the_same_coefficients_in_every_space(space):
    model = bases.fitted(9)
    there = np.linalg.solve(upsample.rgb_to_xyz(space), upsample.rgb_to_xyz() @ CUBE.T).T
    np.testing.assert_allclose(
        there @ upsample.rgb_matrix(model, space).T, CUBE @ upsample.rgb_matrix(model).T, atol=1e-9
    )


def test_unknown_space_is_refused():
    with pytest.raises(ModelError, match="Linear Rec.709"):
        upsample.rgb_to_xyz("Adobe")


def test_only_wider_spaces_have_colours_outside_rec709():
    assert not any(upsample.is_outside_rec709(rgb) for rgb in CUBE)
    for space in ("Linear Rec.2020", "ACEScg"):
        assert upsample.is_outside_rec709((0.0, 1.0, 0.0), space)
        assert not upsample.is_outside_rec709((0.5, 0.5, 0.5), space)
        there = np.linalg.solve(upsample.rgb_to_xyz(space), upsample.rgb_to_xyz() @ (0.0, 0.7, 0.0))
        assert not upsample.is_outside_rec709(there, space)


def test_white_light_differs_on_no_surface_and_a_deep_filter_does_on_some():
    model = bases.fitted(9)
    assert upsample.filter_difference(model, (2.0, 2.0, 2.0)) < 1e-2
    assert upsample.filter_difference(model, (0.0, 0.0, 0.0)) == 0.0
    warm, deep = (upsample.filter_difference(model, rgb) for rgb in ((1.0, 0.8, 0.6), (1.0, 0.0, 0.0)))
    assert warm < 3 < 20 < deep
    assert upsample.filter_difference(bases.rgb(), (1.0, 0.0, 0.0)) < 1e-2, "RGB's own product"
