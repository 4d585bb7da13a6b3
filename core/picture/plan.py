"""Which model a scene needs, and what it can leave out.

Pixels of the scene are simulated: a surface that the camera sees, light that was reflected up to a number of times,
each light group's share in it. What a candidate model makes of them is held against the reference model, and the
cheapest candidate whose 98th percentile stays within the tolerance is chosen.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache

import numpy as np

from ..colour import differences
from ..colour.spaces import REC709, srgb_decoded
from ..errors import UsageError
from ..model import bases
from ..model.factor_model import FactorModel
from ..model.rules import Fitted
from ..model.upsample import rgb_matrix
from ..spectra.arrays import Array
from ..spectra.spectrum import WAVELENGTHS, Spectrum

__all__ = ["Candidate", "Content", "LeftOut", "Plan", "choose", "left_out", "predict"]

SEED = 20240607
PIXELS = 3000
ORDERS = 8  # reflections followed at most
CHANNELS = (3, 6, 9, 12, 15)
SPECTRUM = 9  # channels that a spectrum behind a prism needs


@dataclass(frozen=True, eq=False)
class Content:
    """What a scene shows and how it is lit, as far as the choice of a model depends on it.

    reflectances: the measured spectra. colours: (m, 3) RGB colours of `space`. shares: part of the picture of each
    reflectance, then of each colour; need not sum to 1. textures: part of the picture whose colours are not known.
    lights: what shines in each light group. choices: illuminants that the artist wants to switch to later. bounces: how
    often light is reflected between surfaces at most. disperses: whether a glass makes a spectrum.
    """

    reflectances: Sequence[Spectrum] = ()
    colours: Array = field(default_factory=lambda: np.empty((0, 3)))
    shares: Array | None = None
    textures: float = 0.0
    lights: Sequence[Spectrum] = ()
    choices: Sequence[Spectrum] = ()
    bounces: int = 4
    space: str = REC709
    disperses: bool = False

    def __post_init__(self) -> None:
        colours = np.asarray(self.colours, dtype=np.float64).reshape(-1, 3)
        count = len(self.reflectances) + len(colours)
        shares = np.ones(count) if self.shares is None else np.asarray(self.shares, dtype=np.float64)
        if shares.shape != (count,) or (shares < 0).any():
            raise UsageError(f"a scene of {count} surfaces needs as many shares of 0 or more, got {shares.shape}")
        if not self.lights:
            raise UsageError("a scene needs at least one light")
        object.__setattr__(self, "colours", colours)
        object.__setattr__(self, "shares", shares)

    @property
    def switches(self) -> bool:
        """Whether the light may become another than the one rendered for."""
        lit = self.lights[0].sampled()
        return any(not np.allclose(_unit(other.sampled()), _unit(lit)) for other in [*self.lights[1:], *self.choices])


@dataclass(frozen=True, eq=False)
class Candidate:
    """A model and the error that it is expected to make: the 98th percentile of CIEDE2000 over the picture, under the
    worst of the scene's lightings, whose name is `worst`."""

    model: FactorModel
    error: float
    worst: str

    @property
    def words(self) -> str:
        """What an artist calls it."""
        return self.model.label


@dataclass(frozen=True, eq=False)
class Plan:
    """The chosen candidate, those that were weighed before it and found too coarse, and the tolerance.

    disperses: whether fewer channels than a spectrum needs were out of the question.
    """

    chosen: Candidate
    rejected: tuple[Candidate, ...]
    tolerance: float
    disperses: bool = False

    @property
    def model(self) -> FactorModel:
        return self.chosen.model

    @property
    def passes(self) -> int:
        return self.model.passes

    def samples(self, total: int) -> int:
        """Samples of each pass where `total` are shared among them."""
        return -(-total // self.passes)

    @property
    def reason(self) -> str:
        """Why this model, in one sentence."""
        chosen = self.chosen
        found = f"{chosen.words}: ΔE {chosen.error:.2f} expected under {chosen.worst}, {self.tolerance:g} allowed"
        if chosen.error > self.tolerance:
            return f"{found}; nothing is more exact"
        if not self.rejected:
            return f"{found}; a glass makes a spectrum of light" if self.disperses else found
        nearest = min(self.rejected, key=lambda candidate: candidate.error)
        return f"{found}; {nearest.words} would reach {nearest.error:.2f} under {nearest.worst}"


@dataclass(frozen=True)
class LeftOut:
    """Something that a set-up does without, and what keeping it would cost; in words."""

    what: str
    cost: str


def choose(content: Content, tolerance: float = 1.0, least: int = 1) -> Plan:
    """The model with the fewest passes that stays within `tolerance` (CIEDE2000 at the 98th percentile) -> Plan.

    Of models with as many passes the most exact is taken; where none stays within it, the reference. A glass that
    makes a spectrum leaves only models of SPECTRUM channels or more. least: channels that there are at least, for
    a scene whose content may change.
    """
    if not tolerance > 0:
        raise UsageError(f"the tolerance is {tolerance}: expected more than 0")
    rejected: list[Candidate] = []
    least = max(least, SPECTRUM if content.disperses else 1)
    for alternatives in _candidates(content):
        alternatives = [model for model in alternatives if model.channels >= least]
        if not alternatives:
            continue
        weighed = [Candidate(model, *predict(model, content)) for model in alternatives]
        best = min(weighed, key=lambda candidate: candidate.error)
        if best.error <= tolerance or best.model.is_reference:
            return Plan(best, tuple(rejected), tolerance, content.disperses)
        rejected += weighed
    raise AssertionError("the reference is always a candidate")


def predict(model: FactorModel, content: Content) -> tuple[float, str]:
    """98th percentile of CIEDE2000 to the reference, under the scene's worst lighting -> (error, that lighting)."""
    truth = bases.bands()
    pixels = _Pixels(content)
    found, true = pixels.coefficients(model), pixels.coefficients(truth)
    errors = {"its own lights": _difference(model, truth, found, true, content.lights, pixels.mixture)}
    for light in content.choices:
        errors[light.name] = _difference(model, truth, found, true, [light], np.ones((PIXELS, 1)))
    worst = max(errors, key=lambda name: errors[name])
    return errors[worst], worst


def left_out(model: FactorModel, content: Content, pixels: int, groups: int) -> list[LeftOut]:
    """The next finer model and the reference, against the `model` that a scene of so many pixels and light groups has.

    Takes as long as weighing two candidates, about a second.
    """
    error, _ = predict(model, content)
    finer = [found[0] for found in _candidates(content) if found[0].passes > model.passes]
    rows = []
    for each in dict.fromkeys([*finer[:1], *finer[-1:]]):
        candidate, more = Candidate(each, *predict(each, content)), each.passes - model.passes
        megabytes = more * pass_bytes(pixels, groups) / 1e6
        cost = f"{more} more pass{'es' if more > 1 else ''} and {megabytes:.0f} MB"
        rows.append(LeftOut(candidate.words, f"{cost}; ΔE {candidate.error:.2f} in place of {error:.2f}"))
    return rows


def pass_bytes(pixels: int, groups: int) -> int:
    """Memory of one pass of a render: Blender keeps four floats for the whole picture and for each light group."""
    return pixels * (groups + 1) * 4 * 4


def _candidates(content: Content) -> Iterator[list[FactorModel]]:
    """Models by number of passes, those with equally many together."""
    for channels in CHANNELS:
        alternatives = [_fitted_to(content, channels)]
        if channels == CHANNELS[0]:
            alternatives.insert(0, _grey())
            if not content.switches:
                alternatives.append(bases.prefiltered(content.lights[0]))
        yield alternatives
    yield [bases.bands()]


@cache
def _grey() -> FactorModel:
    """One channel, for scenes without colour: whatever shines keeps its own."""
    return FactorModel("grey", WAVELENGTHS, bases.fitted(1).filters)


def _fitted_to(content: Content, channels: int) -> FactorModel:
    """The fitted filters, with matrices for the scene's spectra: measured, of its colours, of any texture."""
    truth = bases.bands()
    colours = content.colours
    if content.textures > 0:
        levels = srgb_decoded(np.linspace(0, 1, 4))
        colours = np.concatenate([colours, np.stack(np.meshgrid(levels, levels, levels), axis=-1).reshape(-1, 3)])
    upsampled = truth.reconstruct(colours @ rgb_matrix(truth, content.space).T)
    known = [*(spectrum.sampled() for spectrum in content.reflectances), *np.clip(upsampled, 0, 1)]
    return FactorModel("scene", WAVELENGTHS, bases.fitted(channels).filters, Fitted(np.array(known)))


class _Pixels:
    """Pixels drawn from a scene, always the same: which surfaces light met on its way, and how much of each order."""

    def __init__(self, content: Content):
        random = np.random.default_rng(SEED)
        self.content = content
        shares = np.append(np.asarray(content.shares), content.textures)
        shares = shares / shares.sum() if shares.sum() > 0 else np.append(np.zeros(len(shares) - 1), 1.0)
        orders = 1 + min(content.bounces, ORDERS)
        # Evenly spread over the surfaces that the camera sees; light comes from any surface
        seen = np.searchsorted(np.cumsum(shares)[:-1], (np.arange(PIXELS) + 0.5) / PIXELS, side="right")
        others = random.choice(len(shares), p=shares, size=(orders - 1, PIXELS))
        self.surfaces = np.concatenate([seen[None], others])
        # Textures are spread evenly over what is seen, not over light
        self.texels = srgb_decoded(random.random((orders, PIXELS, 3)))
        # What a point gathers of the light of all others: all of it in a closed room, half of it in the open
        self.orders = random.uniform(0.5, 1.0, PIXELS) ** np.arange(orders)[:, None]
        if orders > 1:
            self.orders[0] = random.uniform(0.0, 1.0, PIXELS)  # lamps, which may be hidden
        self.mixture = random.dirichlet(np.ones(len(content.lights)), PIXELS)

    def coefficients(self, model: FactorModel) -> Array:
        """(pixels, p): what a renderer makes of the pixels with this model."""
        content, to_coefficients = self.content, rgb_matrix(model, self.content.space)
        measured = np.empty((0, model.channels))
        if content.reflectances:
            measured = model.coefficients(list(content.reflectances))
        known = np.concatenate([measured, content.colours @ to_coefficients.T, np.zeros((1, model.channels))])
        factors = known[self.surfaces]
        unknown = self.surfaces == len(known) - 1
        factors[unknown] = self.texels[unknown] @ to_coefficients.T
        return np.einsum("kn,knp->np", self.orders, np.cumprod(factors, axis=0))


def _difference(
    model: FactorModel, truth: FactorModel, found: Array, true: Array, lights: Sequence[Spectrum], mixture: Array
) -> float:
    """98th percentile of CIEDE2000 between coefficients (pixels, p) of two models under a mixture of lights."""
    matrices, exact = (np.array([m.relight(light) for light in lights]) for m in (model, truth))
    xyz, true_xyz = (np.einsum("ng,gxp,np->nx", mixture, r, c) for r, c in ((matrices, found), (exact, true)))
    white = exact.sum(axis=(0, 2)) / len(lights)
    return float(np.percentile(differences.picture_delta_E(xyz, true_xyz, white), 98))


def _unit(power: Array) -> Array:
    return power / power.max()
