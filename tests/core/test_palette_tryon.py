"""A reflectance tried on in a picture that is there."""

import numpy as np
import pytest

from relume.core import palette
from relume.core.model import bases
from relume.core.palette import PaletteError
from relume.core.spectra import library

MODEL = bases.fitted(9)
OLD, NEW, OTHER = (MODEL.coefficients(library.reflectance(name)) for name in ("CES 10", "CES 60", "CES 80"))


@pytest.fixture
def picture():
    """Six rows: the surface above, another below, lit by light of some coefficients -> picture, surface, light."""
    light = np.random.default_rng(1).uniform(0.5, 2.0, (6, 8, 9))
    surface = np.where(np.arange(6)[:, None, None] < 3, OLD, OTHER) * np.ones((6, 8, 1))
    return light * surface, surface, light


def test_one_reflection_is_exact(picture):
    coefficients, surface, light = picture
    tried = palette.try_on(coefficients, surface, OLD, NEW)
    np.testing.assert_allclose(tried.coefficients[:3], light[:3] * NEW, rtol=1e-12)
    np.testing.assert_array_equal(tried.coefficients[3:], coefficients[3:])
    assert tried.seen[:3].all() and not tried.seen[3:].any()
    assert tried.doubtful[3].all(), "beside the surface there may be a mixture"


def test_what_is_mirrored_stays(picture):
    coefficients, surface, light = picture
    tried = palette.try_on(coefficients + 0.1, surface, OLD, NEW, diffuse=coefficients)
    np.testing.assert_allclose(tried.coefficients[:3], light[:3] * NEW + 0.1, rtol=1e-12)


def test_what_reflected_nothing_says_nothing(picture):
    dark = OLD.copy()
    dark[4] = 0.0
    light = picture[2]
    tried = palette.try_on(light * dark, np.ones_like(light) * dark, dark, NEW)
    assert np.isfinite(tried.coefficients).all() and tried.doubtful.all()


def test_a_surface_that_is_nowhere(picture):
    with pytest.raises(PaletteError, match="not seen in the picture"):
        palette.try_on(picture[0], picture[1], NEW, OLD)
