"""Fit a factor model to one scene's paints and lamps, and see what that gains: python examples/fit_a_scene_model.py"""

import numpy as np

from relume.core import bases, library, measure

paints = library.reflectances("colorchecker")
lamps = [library.illuminant(name) for name in ("D65", "FL11")]
cmfs = library.observer()


def error(model) -> float:
    """98th percentile of CIEDE2000 of all products of two paints under the lamps, against the full spectrum."""
    sampled = np.stack([paint.sampled() for paint in paints])
    twice = (sampled[:, None] * sampled).reshape(-1, sampled.shape[1])
    coefficients = model.coefficients(paints)
    products = (coefficients[:, None] * coefficients).reshape(-1, model.channels)
    found = []
    for lamp in lamps:
        power = lamp.sampled()
        weights = power[:, None] * cmfs / (power @ cmfs[:, 1])
        found.append(measure.delta_E_2000(twice @ weights, products @ model.relight(lamp).T, weights.sum(axis=0)))
    return float(np.percentile(found, 98))


print(f"6 channels for any scene:  {error(bases.fitted(6)):.2f}")
print(f"6 channels for this scene: {error(bases.scene(6, paints, lamps, exact=False)):.2f}")
