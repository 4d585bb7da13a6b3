import colour
import numpy as np
import pytest

from relume.core.colour import differences
from relume.core.model.relight import local_metric

WHITE = np.array([0.95, 1.0, 1.09])


@pytest.fixture(scope="module")
def pairs():
    random = np.random.default_rng(0)
    first = random.random((2000, 3))
    return first, np.clip(first + random.normal(0, 0.05, first.shape), 0, 2)


def test_colour_differences_agree_with_colour_science(pairs):
    labs = [colour.XYZ_to_Lab(xyz, colour.XYZ_to_xy(WHITE)) for xyz in pairs]
    for function, method in (
        (differences.delta_E_1976, "CIE 1976"),
        (differences.delta_E_1994, "CIE 1994"),
        (differences.delta_E_2000, "CIE 2000"),
    ):
        np.testing.assert_allclose(function(*pairs, WHITE), colour.delta_E(*labs, method=method), atol=1e-9)


def test_local_metric_is_the_limit_of_small_differences(pairs):
    xyz = pairs[0]
    step = np.random.default_rng(1).normal(0, 1e-5, xyz.shape)
    length = np.linalg.norm(np.einsum("nij,nj->ni", local_metric(xyz, WHITE), step), axis=1)
    np.testing.assert_allclose(length, differences.delta_E_2000(xyz, xyz + step, WHITE), rtol=2e-3)


def test_statistics():
    values = differences.statistics(np.arange(101.0))
    assert values == {"median": 50, "p90": 90, "p98": 98, "p99": 99, "max": 100}
    with pytest.raises(ValueError, match="no values"):
        differences.statistics([])
