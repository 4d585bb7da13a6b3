import colour
import numpy as np
import pytest

from relume.core import bases, library, upsample
from relume.core.factor_model import ModelError

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
