"""Pixels drawn from what a scene shows: what they truly look like, and what a model makes of them.

A surface that the camera sees, light that was reflected up to a number of times, each light group's share in it. The
truth is integrated from spectra as they were measured, at 1 nm where any is finer than 5; of RGB colours it is the
spectra that the reference gives them.
"""

import numpy as np

from ..colour import differences
from ..colour.spaces import srgb_decoded
from ..model import integration
from ..model.factor_model import FactorModel
from ..model.relight import scaled
from ..model.upsample import rgb_matrix, rgb_spectra
from ..spectra.arrays import Array, resampled
from ..spectra.library import OBSERVER
from ..spectra.spectrum import WAVELENGTHS, Spectrum
from .content import Content

__all__ = ["PIXELS", "Pixels", "difference", "true_weights"]

SEED = 20240607
PIXELS = 3000
ORDERS = 8  # reflections followed at most

Observer = str | tuple[Spectrum, ...]


class Pixels:
    """Pixels drawn from a scene, always the same: which surfaces light met on its way, and how much of each order."""

    def __init__(self, content: Content, count: int = PIXELS):
        random = np.random.default_rng(SEED)
        self.content, self.count = content, count
        self._kept: dict[int, Array] = {}  # spectra on the grids that were asked for
        shares = np.append(content.parts, content.textures)
        shares = shares / shares.sum() if shares.sum() > 0 else np.append(np.zeros(len(shares) - 1), 1.0)
        orders = 1 + min(content.bounces, ORDERS)
        # Evenly spread over the surfaces that the camera sees; light comes from any surface
        seen = np.searchsorted(np.cumsum(shares)[:-1], (np.arange(count) + 0.5) / count, side="right")
        others = random.choice(len(shares), p=shares, size=(orders - 1, count))
        self.surfaces = np.concatenate([seen[None], others])
        # Textures are spread evenly over what is seen, not over light
        self.texels = srgb_decoded(random.random((orders, count, 3)))
        # What a point gathers of the light of all others: all of it in a closed room, half of it in the open
        self.orders = random.uniform(0.5, 1.0, count) ** np.arange(orders)[:, None]
        if orders > 1:
            self.orders[0] = random.uniform(0.0, 1.0, count)  # lamps, which may be hidden

    def mixture(self, lights: int) -> Array:
        """(count, lights): the share of each light in the light of a pixel, of sum 1."""
        return np.random.default_rng(SEED + 1).dirichlet(np.ones(lights), self.count)

    def coefficients(self, model: FactorModel) -> Array:
        """(count, p): what a renderer makes of the pixels with this model."""
        content = self.content
        measured = np.empty((0, model.channels))
        if content.reflectances:
            measured = model.coefficients(list(content.reflectances))
        return self._gathered(measured, rgb_matrix(model, content.space))

    def true_xyz(self, light: Spectrum, observer: Observer = OBSERVER) -> Array:
        """(count, 3) XYZ of the pixels under a light, Y = 1 for a perfect white, from spectra at their own sampling."""
        weights = true_weights(light, observer, self._needs_fine(light))
        return self._spectra(len(weights)) @ weights

    def _needs_fine(self, light: Spectrum) -> bool:
        return any(integration.is_finer(spectrum) for spectrum in [light, *self.content.reflectances])

    def _spectra(self, count: int) -> Array:
        """(pixels, count): what reaches the camera under light of 1 at every wavelength, at 5 or at 1 nm."""
        if count not in self._kept:
            grid = integration.FINE if count == integration.FINE.size else WAVELENGTHS
            measured = [spectrum.sampled(grid) for spectrum in self.content.reflectances]
            colours = resampled(rgb_spectra(self.content.space).T, grid).T
            self._kept[count] = self._gathered(np.array(measured).reshape(-1, grid.size), colours)
        return self._kept[count]

    def _gathered(self, measured: Array, of_colours: Array) -> Array:
        """The sum over the orders of products of surfaces: those measured (m, n), and of RGB by (n, 3)."""
        nothing = np.zeros((1, of_colours.shape[0]))
        known = np.concatenate([measured, self.content.rgb @ of_colours.T, nothing])
        met, total = np.ones((self.count, known.shape[1])), np.zeros((self.count, known.shape[1]))
        for surfaces, texels, amounts in zip(self.surfaces, self.texels, self.orders, strict=True):
            factors = known[surfaces]
            unknown = surfaces == len(known) - 1
            factors[unknown] = texels[unknown] @ of_colours.T
            met *= factors
            total += amounts[:, None] * met
        return total


def true_weights(light: Spectrum, observer: Observer = OBSERVER, fine: bool = True) -> Array:
    """(401, 3) on `integration.FINE`, or (81, 3): spectra to XYZ, Y = 1 for a perfect white. Raises SpectrumError."""
    weights = (integration.fine_weights if fine else integration.light_weights)(light, observer)
    return scaled(weights / np.abs(light.values).max())


def difference(xyz: Array, true: Array, white: Array) -> Array:
    """CIEDE2000 (count,) of pixels in XYZ (count, 3), exposed as a picture is."""
    return differences.picture_delta_E(xyz, true, white)
