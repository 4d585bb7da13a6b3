"""Pixels drawn from what a scene shows: what they truly look like, and what a model makes of them.

A surface or a medium that the camera sees, light that was reflected up to a number of times, each light group's share
in it. The truth is integrated from spectra as they were measured, at 1 nm where any is finer than 5; of RGB colours it
is the spectra that the reference gives them.
"""

import numpy as np

from ..colour import differences
from ..colour.spaces import srgb_decoded
from ..model import absorption, integration
from ..model.factor_model import FactorModel
from ..model.relight import scaled
from ..model.upsample import rgb_matrix, rgb_spectra
from ..spectra.arrays import Array, resampled
from ..spectra.library import OBSERVER
from ..spectra.spectrum import WAVELENGTHS, Spectrum
from . import finish
from .content import Content

__all__ = ["PIXELS", "Pixels", "difference", "true_weights"]

SEED = 20240607
PIXELS = 3000
ORDERS = 8  # reflections followed at most
WAYS = 4  # by which light of other surfaces comes to one
EVENNESS = 3.0  # of lights, of which several reach most places: the parameter of a Dirichlet distribution

Observer = str | tuple[Spectrum, ...]


class Pixels:
    """Pixels drawn from a scene, always the same: which surfaces light met on its way, and how much of each order.

    A pixel shows a surface, lit by lamps and by the light that some ways of its own through the scene bring to it: one
    way alone would show products that a render's sum over all directions does not. Where it shows a medium, what is
    behind that is what a way brings.
    """

    def __init__(self, content: Content, count: int = PIXELS):
        random = np.random.default_rng(SEED)
        self.content, self.count = content, count
        self._kept: dict[int, Array] = {}  # spectra on the grids that were asked for
        shares = np.append(content.parts, content.textures)
        shares = shares / shares.sum() if shares.sum() > 0 else np.append(np.zeros(len(shares) - 1), 1.0)
        absorbs = np.append(content.optical_depths > 0, False)
        orders = 1 + max(min(content.bounces, ORDERS), int(absorbs.any()))
        # Evenly spread over the surfaces that the camera sees; light comes from any surface
        seen = np.searchsorted(np.cumsum(shares)[:-1], (np.arange(count) + 0.5) / count, side="right")
        others = random.choice(len(shares), p=shares, size=(orders - 1, count))
        self.surfaces = np.concatenate([seen[None], others])
        # Textures are spread evenly over what is seen, not over light
        self.texels = srgb_decoded(random.random((orders, count, 3)))
        # Angles, and ways through a medium, differ from place to place
        self.spread = random.uniform(0.25, 1.75, (orders, count))
        # Lamps, which may be hidden, light a surface but no medium
        direct = random.uniform(0.0, 1.0, (orders, count)) * ~absorbs[self.surfaces]
        # What a point gathers of the light of all others: all of it in a closed room, less in the open
        gathers = random.uniform(0.75, 1.0, count) ** np.arange(orders)[:, None]
        self.direct, self.amounts = direct[0], direct[1:] * gathers[1:]
        self.through = absorbs[seen]
        ways = random.integers(count, size=(WAYS, count))
        self.ways = np.where(self.through, ways[0], ways)
        self.gathers = np.where(self.through, 1.0, float(content.bounces > 0))
        self.brightness = random.uniform(0.0, 1.0, count)  # far from lamps, near them

    def mixture(self, lights: int) -> Array:
        """(count, lights): the share of each light in the light of a pixel, of sum 1."""
        return np.random.default_rng(SEED + 1).dirichlet(np.full(lights, EVENNESS), self.count)

    def coefficients(self, model: FactorModel) -> Array:
        """(count, p): what a renderer makes of the pixels with this model."""
        content = self.content
        measured = np.empty((0, model.channels))
        if content.reflectances:
            measured = model.coefficients(list(content.reflectances))
            for number in np.flatnonzero(content.rights[: len(measured)]):
                measured[number] = absorption.tint(model, content.reflectances[int(number)], content.rights[number])
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
        """The light of the pixels, by the colours of surfaces: those measured (m, n), and of RGB by (n, 3)."""
        nothing = np.zeros((1, of_colours.shape[0]))
        known = np.concatenate([measured, self.content.rgb @ of_colours.T, nothing])
        shown, *met = (self._met(known, of_colours, order) for order in range(len(self.surfaces)))
        way, light = np.ones_like(shown), np.zeros_like(shown)
        for factors, amounts in zip(met, self.amounts, strict=True):
            way *= factors
            light += amounts[:, None] * way
        gathered = self.gathers[:, None] * light[self.ways].mean(axis=0)
        return self.brightness[:, None] * shown * (self.direct[:, None] + gathered)

    def _met(self, known: Array, of_colours: Array, order: int) -> Array:
        """(count, n): what becomes of light at the surfaces of one order."""
        surfaces, spread = self.surfaces[order], self.spread[order][:, None]
        factors = known[surfaces]
        unknown = surfaces == len(known) - 1
        factors[unknown] = self.texels[order][unknown] @ of_colours.T
        depths = np.append(self.content.optical_depths, 0.0)[surfaces]
        again = self.content.parts_again[surfaces][:, None] * spread
        rough, deep = again[:, 0] > 0, depths > 0
        factors[rough] = finish.reflected(factors[rough], again[rough])
        factors[deep] = finish.let_through(factors[deep], (depths[:, None] * spread)[deep])
        return factors


def true_weights(light: Spectrum, observer: Observer = OBSERVER, fine: bool = True) -> Array:
    """(401, 3) on `integration.FINE`, or (81, 3): spectra to XYZ, Y = 1 for a perfect white. Raises SpectrumError."""
    weights = (integration.fine_weights if fine else integration.light_weights)(light, observer)
    return scaled(weights / np.abs(light.values).max())


def difference(xyz: Array, true: Array, white: Array) -> Array:
    """CIEDE2000 (count,) of pixels in XYZ (count, 3), exposed as a picture is."""
    return differences.picture_delta_E(xyz, true, white)
