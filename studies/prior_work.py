"""Factor models that others have, made again as far as their descriptions go.

[W] C. A. Waddle, "Real-time spectral rendering", Color and Imaging Conference 21 (2013) 240-246,
    https://doi.org/10.2352/CIC.2013.21.1.art00044
[L] Lark Spectral Lighting, https://github.com/larkspectral/Lark_Spectral_Lighting: nine bins for Radiance.
[H] J. Yu, D. Guarnera, G. C. Guarnera, "Compact Hadamard latent codes for efficient spectral rendering" (2026),
    https://arxiv.org/abs/2602.18741

What each does not say, or this project has not read, is inferred; the docstrings say what.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..core.model import bases, sharpening
from ..core.model.factor_model import FactorModel
from ..core.model.optimise import one_thread
from ..core.model.rules import Reconstructed
from ..core.spectra import library
from ..core.spectra.arrays import Array
from ..core.spectra.spectrum import WAVELENGTHS

__all__ = ["Code", "hadamard", "lark", "residual_gradient", "waddle"]

# Of versions 1 and 2; version 3 has others, which were not found in print.
LARK_EDGES = (380, 422, 460, 498, 524, 550, 586, 650, 714, 780)  # nm
LIMITS = (400, 700)  # nm, of the basis that [W] starts from, as the rows of [DF] beside it
STEPS = 3000  # most of them
COLOUR = 3e4  # weight of the colour in the loss of [H]


@dataclass(frozen=True, eq=False)
class Code:
    """encoder (81, p): a spectrum's numbers are encoder^T S. decoder (81, p): what a product of numbers stands for."""

    encoder: Array
    decoder: Array

    def model(self, name: str) -> FactorModel:
        """The same with filters that sum to 1; what the decoder makes of a product of two is the same."""
        sums = self.encoder.sum(axis=0)
        return FactorModel(name, WAVELENGTHS, self.encoder / sums, Reconstructed(self.decoder * sums**2))


def training_spectra(names: list[str] | None = None) -> tuple[Array, Array]:
    """Lights (l, 81), each with Y = 1 for a white, and reflectances (m, 81): the CES, and what is named or the "
    "CIE's."""
    chosen = names or [name for family in library.cie_illuminants().values() for name in family]
    lights = np.stack([library.illuminant(name).sampled() for name in chosen])
    surfaces = np.stack([spectrum.sampled() for spectrum in library.reflectances("ces")])
    visible = library.observer()[:, 1:2] / library.observer()[:, 1].sum()
    return lights / (lights @ visible), surfaces


def lark() -> Code:
    """[L]: averages over nine bins, spectra flat within each.

    Inferred: that colours are made by integrating those flat spectra; Lark itself has photopic and melanopic weights
    for its bins, and no XYZ.
    """
    edges = np.array(LARK_EDGES)
    # A sample stands for 5 nm, so at an edge it belongs to two bins in part.
    low, high = WAVELENGTHS[:, None] - 2.5, WAVELENGTHS[:, None] + 2.5
    part = np.clip(np.minimum(high, edges[1:]) - np.maximum(low, edges[:-1]), 0, None) / 5
    return Code(part / part.sum(axis=0), part)


def waddle(channels: int) -> Code:
    """[W]: the change of basis T of the singular vectors with the least residual of products.

    With B the basis and e, s the projections of light and surface, a product comes to B T^-T ((T^T e) (T^T s)); T is
    found by descent from eq. 11 of [DF]. Inferred: plain squared residuals within the span, the colour signals of the
    CES in daylights and A, 400 to 700 nm, and L-BFGS.
    """
    from scipy.optimize import minimize

    lights, surfaces = training_spectra(["A", "D50", "D55", "D65", "D75"])
    within = (LIMITS[0] <= WAVELENGTHS) & (LIMITS[1] >= WAVELENGTHS)
    signals = (lights[:, None] * surfaces).reshape(-1, WAVELENGTHS.size) * within
    basis = sharpening.principal_components(signals, channels) * within[:, None]
    start = np.linalg.lstsq(basis, bases.sharpened(channels, "lagrange", limits=LIMITS).filters, rcond=None)[0]
    light = np.repeat(lights @ basis, len(surfaces), axis=0)
    surface = np.tile(surfaces @ basis, (len(lights), 1))

    def cost(flat: Array) -> tuple[float, Array]:
        value, gradient = residual_gradient(flat.reshape(channels, channels), light, surface, signals @ basis)
        return value, gradient.ravel()

    with one_thread():
        found = minimize(cost, start.ravel(), jac=True, method="L-BFGS-B", options={"maxiter": STEPS})
    change = found.x.reshape(channels, channels)
    return Code(basis @ change, basis @ np.linalg.inv(change).T)


def residual_gradient(change: Array, light: Array, surface: Array, product: Array) -> tuple[float, Array]:
    """Mean squared residual of products (N, p) in the basis, for T (p, p), and its derivative by T (p, p)."""
    back = np.linalg.inv(change).T
    sharp_light, sharp_surface = light @ change, surface @ change
    multiplied = sharp_light * sharp_surface
    made = multiplied @ back.T
    residual = made - product
    pulled = residual @ back
    gradient = light.T @ (pulled * sharp_surface) + surface.T @ (pulled * sharp_light) - made.T @ pulled
    return float((residual**2).sum() / len(light)), 2 * gradient / len(light)


def hadamard(channels: int, seed: int = 18741) -> Code:
    """[H]: a non-negative linear encoder E and decoder D, trained to multiply.

    Its abstract and summaries name the terms of the loss: the product rebuilt, codes that multiply, colour, and
    reflectance and light rebuilt each for itself. Inferred: means of squares; XYZ for colour, with the weight COLOUR,
    which of 1, 30, 1e3, 3e4 and 1e6 has the least error on what was trained on at k = 6; E and D as squares of what is
    free, so that they are not negative; L-BFGS from adjoining bands; the CES under the CIE illuminants, with Y = 1; and
    81 samples for its 47.
    """
    from scipy.optimize import minimize

    lights, surfaces = training_spectra()
    random = np.random.default_rng(seed)
    pairs = random.integers(len(lights), size=1500), random.integers(len(surfaces), size=1500)
    light, surface = lights[pairs[0]], surfaces[pairs[1]]
    colour = library.observer() / library.observer().sum(axis=0)
    shape = (2, WAVELENGTHS.size, channels)
    bands = bases.block(channels).filters
    start = np.sqrt(np.stack([bands, bands / bands.max()]) + 1e-4 * random.random(shape))

    def cost(flat: Array) -> tuple[float, Array]:
        root = flat.reshape(shape)
        value, gradient = hadamard_loss(root[0] ** 2, root[1] ** 2, light, surface, colour)
        return value, (2 * root * gradient).ravel()

    with one_thread():
        found = minimize(cost, start.ravel(), jac=True, method="L-BFGS-B", options={"maxiter": STEPS})
    encoder, decoder = found.x.reshape(shape) ** 2
    return Code(encoder, decoder)


def hadamard_loss(encoder: Array, decoder: Array, light: Array, surface: Array, colour: Array) -> tuple[float, Array]:
    """The loss of `hadamard` for E, D (81, p) on pairs (N, 81), and its derivative by both (2, 81, p)."""
    true, count = light * surface, len(light)
    codes = {"light": light @ encoder, "surface": surface @ encoder, "true": true @ encoder}
    product = codes["light"] * codes["surface"]
    # Each term's residual, the number of what is in it, and the derivative by the code that it decodes.
    value, by_product = 0.0, np.zeros_like(product)
    by_code = {name: np.zeros_like(code) for name, code in codes.items()}
    by_decoder = np.zeros_like(decoder)
    wanted: list[tuple[Array, Array, Array]] = [
        (product, true, by_product),
        (codes["light"], light, by_code["light"]),
        (codes["surface"], surface, by_code["surface"]),
    ]
    for code, spectrum, derivative in wanted:
        residual = (code @ decoder.T - spectrum) / spectrum.shape[1]
        value += float((residual**2).sum()) * spectrum.shape[1]
        derivative += 2 * residual @ decoder
        by_decoder += 2 * residual.T @ code
    apart = product - codes["true"]
    value += float((apart**2).sum()) / product.shape[1]
    by_product += 2 * apart / product.shape[1]
    by_code["true"] -= 2 * apart / product.shape[1]
    seen = (product @ decoder.T - true) @ colour
    value += COLOUR * float((seen**2).sum()) / 3
    by_product += COLOUR * 2 / 3 * seen @ (colour.T @ decoder)
    by_decoder += COLOUR * 2 / 3 * colour @ (seen.T @ product)
    by_code["light"] += by_product * codes["surface"]
    by_code["surface"] += by_product * codes["light"]
    by_encoder = light.T @ by_code["light"] + surface.T @ by_code["surface"] + true.T @ by_code["true"]
    return value / count, np.stack([by_encoder, by_decoder]) / count


MAKERS: dict[str, Callable[[int], Code]] = {"Waddle 2013": waddle, "Hadamard codes 2026": hadamard}
