"""Noise of passes: held against what would be without it."""

import numpy as np
import pytest

from relume.core.colour import differences, spaces
from relume.core.model import bases
from relume.core.picture import noise
from relume.core.picture.recombination import relight_matrix
from relume.core.spectra import library

SIZE = (72, 90)
EDGE = SIZE[1] // 2  # the column where one paint ends and the other begins
MODEL = bases.fitted(9)
TO_XYZ = relight_matrix(MODEL, library.illuminant("D65"))


def painted(channels=9):
    """Two paints under light that falls off: what passes hold without noise, (height, width, p), and their albedo."""
    model = bases.fitted(channels)
    library_paints = list(library.reflectances("ces"))
    paints = [model.coefficients(each) for each in (library_paints[3], library_paints[40])]
    rows, columns = np.mgrid[: SIZE[0], : SIZE[1]]
    albedo = np.where((columns < EDGE)[..., None], *paints)
    light = np.exp(-((rows - 30) ** 2 + (columns - 50) ** 2) / 4000)[..., None]
    warm = np.linspace(1.0, 0.6, channels) * columns[..., None] / SIZE[1] + np.ones(channels)
    return (albedo * light * warm).astype(np.float32), albedo.astype(np.float32)


def parts(values):
    return [values[..., k : k + 3] for k in range(0, values.shape[-1], 3)]


def sampled(truth, spread, seed=0):
    """With noise of brightness in each pass, of that standard deviation."""
    chance = np.random.default_rng(seed)
    passes = [each * chance.gamma(1 / spread**2, spread**2, (*SIZE, 1)).astype(np.float32) for each in parts(truth)]
    return np.concatenate(passes, axis=-1)


def error(values, truth):
    white = TO_XYZ.sum(axis=1)
    return differences.picture_delta_E(values @ TO_XYZ.T, truth @ TO_XYZ.T, white)


def estimated(values, albedo):
    return noise.estimated({"a": values}, guided(albedo))["a"]


def guided(albedo, normal=(0.0, 0.0, 1.0)):
    return [{"Albedo": each, "Normal": np.broadcast_to(np.float32(normal), (*SIZE, 3))} for each in parts(albedo)]


def test_the_error_of_colour_falls_and_brightness_stays():
    truth, albedo = painted()
    values = sampled(truth, 0.3)
    found = estimated(values, albedo)
    # As much noise of brightness as three passes have together, in all of them: what no ratio can take away
    chance = np.random.default_rng(1).gamma(3 / 0.3**2, 0.3**2 / 3, (*SIZE, 1))
    least = error(truth * chance, truth).mean()
    assert error(found, truth).mean() < 1.25 * least < 0.4 * error(values, truth).mean()
    kept = found.mean(axis=(0, 1)) / values.mean(axis=(0, 1))
    np.testing.assert_allclose(kept, 1.0, atol=0.02)


def test_with_less_noise_it_changes_less_and_in_the_end_nothing():
    truth, albedo = painted()
    changes = []
    for spread in (0.2, 0.05, 0.0125):
        values = sampled(truth, spread)
        changes.append(error(estimated(values, albedo), values).mean())
    assert changes[0] > 3 * changes[1] > 9 * changes[2]
    assert error(estimated(truth, albedo), truth).max() < 0.05, "without noise, at the edge too"


def test_edges_that_albedo_does_not_know_stay_where_there_is_little_noise():
    truth, albedo = painted()
    for spread in (0.01, 0.001):
        values = sampled(truth, spread)
        assert error(estimated(values, np.ones_like(albedo)), truth).max() < 2 * error(values, truth).max()


def test_strips_show_no_seam(monkeypatch):
    truth, albedo = painted()
    values = sampled(truth, 0.3)
    whole = estimated(values, albedo)
    monkeypatch.setattr(noise, "_ROWS", 16)
    np.testing.assert_allclose(estimated(values, albedo), whole, rtol=1e-5)


@pytest.mark.parametrize("channels", [4, 5, 12])
def test_passes_that_the_model_does_not_fill_and_more_than_three(channels):
    truth, albedo = painted(channels)
    values = sampled(truth, 0.3)
    found = estimated(values, albedo)
    assert found.shape == values.shape and np.isfinite(found).all()
    brightness = [np.stack([each.mean(axis=-1) for each in parts(v / (albedo + 0.001))]) for v in (values, found)]
    spread = [(each / each.mean(axis=0)).std() for each in brightness]
    assert spread[1] < 0.7 * spread[0]


def test_dark_passes_sparks_and_negative_coefficients_stay_finite():
    truth, albedo = painted()
    values = sampled(truth, 0.3)
    values[:20] = 0.0
    values[20:40, :, 3:6] = 0.0  # one pass has no light
    values[50, 50, :3] = 1e4  # a firefly
    values[60:, :30, 6:] *= -1.0
    with np.errstate(all="raise", under="ignore"):
        found = estimated(values, albedo)
    assert np.isfinite(found).all() and not found[:20].any() and not found[20:40, :, 3:6].any()
    assert found[49:52, 49:52].max() < 1e4 * noise.MOST and found[49, 40] @ TO_XYZ[1] < 5 * truth[49, 40] @ TO_XYZ[1]
    np.testing.assert_array_less(np.abs(found), noise.MOST * np.abs(values) + 1e-6)


def test_one_pass_stays_as_it_is():
    values = np.random.default_rng(0).random((*SIZE, 3), dtype=np.float32)
    assert noise.estimated({"a": values}, guided(values))["a"] is values


def test_what_shines_itself_stays():
    truth, albedo = painted()
    values = sampled(truth, 0.3)
    found = noise.estimated({"a": values}, guided(albedo, (0.0, 0.0, 0.0)))["a"]
    np.testing.assert_allclose(found, values, rtol=1e-5)


def test_a_denoiser_that_changes_nothing_changes_nothing():
    truth, albedo = painted()
    values = sampled(truth, 0.3)
    values[:5] *= -1.0
    guides = [{"Albedo": each, "Normal": each} for each in parts(albedo)]
    found = noise.denoised(MODEL, {"a": values}, guides, lambda picture, guides: picture)["a"]
    np.testing.assert_allclose(found, values, rtol=1e-4, atol=1e-5)


def test_each_pass_is_denoised_as_another_mirror_image_with_its_own_guides():
    truth, albedo = painted()
    seen = []

    def denoiser(picture, guides):
        seen.append((picture, guides))
        return picture

    guides = [{"Albedo": each} for each in parts(albedo)]
    noise.denoised(MODEL, {"a": truth}, guides, denoiser)
    turned = [lambda v: v[:, ::-1], lambda v: v[::-1], lambda v: v[::-1, ::-1]]
    for turn, image, guide, (picture, guided) in zip(turned, parts(truth), parts(albedo), seen, strict=False):
        np.testing.assert_array_equal(picture, turn(np.maximum(image, 0.0)))
        np.testing.assert_array_equal(guided["Albedo"], turn(guide))
    picture, guided = seen[3]
    to_rgb = spaces.xyz_to_rgb("Linear Rec.2020") @ TO_XYZ
    np.testing.assert_allclose(picture, np.maximum(truth @ to_rgb.T, 0.0), rtol=1e-4, atol=1e-5)
    np.testing.assert_allclose(guided["Albedo"], np.clip(albedo @ to_rgb.T, 0.0, 1.0), rtol=1e-4, atol=1e-5)


def test_half_of_what_the_whole_picture_knows_better_goes_to_the_passes(monkeypatch):
    truth, _ = painted()
    together, to_passes = noise.to_picture(MODEL)
    np.testing.assert_allclose(together @ to_passes, np.eye(3), atol=1e-5)

    def denoiser(picture, guides):
        # Of a single pass it makes all too dark, and the picture of all passes it has right
        return picture if "whole" in guides else 0.8 * picture

    monkeypatch.setattr(noise, "_joint", lambda guides, matrix: {"whole": None})
    monkeypatch.setattr(noise, "_turned", lambda picture, mirror: picture)
    values = np.maximum(truth, 0.0)
    found = noise.denoised(MODEL, {"a": values}, [{}] * 3, denoiser)["a"]
    np.testing.assert_allclose(found @ together.T, 0.9 * (values @ together.T), rtol=1e-3, atol=1e-4)
