"""Models that others have, made again: their derivatives, and what their descriptions promise."""

import numpy as np
import pytest

from relume.studies import prior_work


def derivative(function, at, step=1e-6):
    """By differences, of function(array) -> (value, anything)."""
    found = np.empty_like(at)
    for index in np.ndindex(at.shape):
        change = np.zeros_like(at)
        change[index] = step
        found[index] = (function(at + change)[0] - function(at - change)[0]) / (2 * step)
    return found


def test_the_residual_of_products_has_the_derivative_that_it_says():
    random = np.random.default_rng(3)
    spectra, change = random.random((3, 20, 4)), np.eye(4) + 0.2 * random.random((4, 4))

    def residual(at):
        return prior_work.residual_gradient(at, *spectra)

    np.testing.assert_allclose(residual(change)[1], derivative(residual, change), rtol=1e-5, atol=1e-8)


def test_the_loss_of_codes_has_the_derivative_that_it_says():
    random = np.random.default_rng(4)
    pairs, colour = random.random((2, 6, 7)) / 7, random.random((7, 3)) / 7

    def loss(at):
        return prior_work.hadamard_loss(*at, *pairs, colour)

    both = random.random((2, 7, 3))
    np.testing.assert_allclose(loss(both)[1], derivative(loss, both), rtol=1e-4, atol=1e-6)


def test_optimised_bases_multiply_better_than_where_they_began():
    lights, surfaces = prior_work.training_spectra(["A", "D50", "D55", "D65", "D75"])
    code = prior_work.waddle(5)
    product = (lights[:, None] @ code.encoder) * (surfaces @ code.encoder)
    from relume.core.model import bases

    start = bases.sharpened(5, "lagrange", limits=prior_work.LIMITS).filters
    within = (prior_work.LIMITS[0] <= prior_work.WAVELENGTHS) & (prior_work.LIMITS[1] >= prior_work.WAVELENGTHS)
    true = lights[:, None] * surfaces * within
    before = (lights[:, None] @ start) * (surfaces @ start) @ np.linalg.pinv(start)
    assert np.square(product @ code.decoder.T - true).sum() < np.square(before - true).sum()


def test_codes_are_nonnegative_and_a_model_decodes_alike(monkeypatch):
    monkeypatch.setattr(prior_work, "STEPS", 20)
    code = prior_work.hadamard(6)
    assert code.encoder.min() >= 0 and code.decoder.min() >= 0
    model = code.model("codes")
    one, other = np.random.default_rng(5).random((2, 81))
    published = code.decoder @ ((code.encoder.T @ one) * (code.encoder.T @ other))
    np.testing.assert_allclose(model.reconstruct(model.coefficients(one) * model.coefficients(other)), published)


def test_nine_bins_tile_the_visible_range():
    code = prior_work.lark()
    assert code.encoder.shape == (81, 9)
    assert code.decoder.sum(axis=1)[1:-1] == pytest.approx(1)
