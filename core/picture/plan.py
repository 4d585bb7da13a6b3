"""Which model a scene needs, and what it can leave out.

Pixels of the scene are drawn (`pixels`): what a candidate model makes of them is held against full spectra, and the
cheapest candidate whose 98th percentile stays within the tolerance is chosen.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np

from ..colour.spaces import srgb_decoded
from ..errors import UsageError
from ..model import bases
from ..model.factor_model import FactorModel
from ..model.rules import Direct, Fitted
from ..model.upsample import rgb_spectra
from ..spectra.arrays import Array
from ..spectra.spectrum import WAVELENGTHS, Spectrum
from . import finish
from .content import Content
from .pixels import PIXELS, Pixels, difference

__all__ = ["Candidate", "Content", "LeftOut", "Plan", "choose", "fitted_to", "left_out", "predict"]

CHANNELS = (3, 6, 9, 12, 15, 18, 21, 24)
SPECTRUM = 9  # channels that a spectrum behind a prism needs
SCENE = 12  # channels of a model whose filters are made for a scene, where general ones of as many do not do
WORTH = 3.5  # times the tolerance: general filters beyond which the scene's own do not do either
BOUNCES = (1.0, 0.5, 0.25)  # how much products of 1, 2 and 3 of its surfaces count for them
SURE = 0.9  # times the tolerance: renders of what is nearly too coarse are as often beyond it
MOST_SURFACES, MOST_LIGHTS = 60, 8


@dataclass(frozen=True, eq=False)
class Candidate:
    """A model and the error that it is expected to make: the 98th percentile of CIEDE2000 over the picture, under the
    worst of the scene's lightings, whose name is `worst`."""

    model: FactorModel
    error: float
    worst: str

    @property
    def passes(self) -> int:
        return self.model.passes

    @property
    def words(self) -> str:
        """What an artist calls it."""
        own = self.model.name == "scene" and not np.array_equal(self.model.filters, _general_filters(self.model))
        return f"{self.model.label} made for this scene" if own else self.model.label


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
            return f"{found}; only Exact, 27 passes, is nearer"
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
    """The model with the fewest passes that surely stays within `tolerance` (CIEDE2000 at the 98th percentile) -> Plan.

    Of models with as many passes the most exact is taken, and where none stays within it the most exact of all, but
    for one of 81 channels, which nobody wants without asking for it. A glass that makes a spectrum leaves only models
    of SPECTRUM channels or more. least: channels that there are at least, for a scene whose content may change.
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
        if best.error <= SURE * tolerance:
            return Plan(best, tuple(rejected), tolerance, content.disperses)
        rejected += weighed
        if best.model.channels == SCENE and best.error <= WORTH * tolerance and least <= SCENE:
            own = _made_for(content)
            # The last digits of its filters are those of the machine
            if own is not None and own.error <= SURE * tolerance:
                return Plan(own, tuple(rejected), tolerance, content.disperses)
    best = min(rejected, key=lambda candidate: candidate.error)
    cheaper = tuple(candidate for candidate in rejected if candidate.model.passes < best.passes)
    return Plan(best, cheaper, tolerance, content.disperses)


def predict(model: FactorModel, content: Content) -> tuple[float, str]:
    """98th percentile of CIEDE2000 to full spectra, under the scene's worst lighting -> (error, that lighting)."""
    pixels = _pixels(content)
    found = pixels.coefficients(model)
    errors = {"its own lights": _difference(model, pixels, found, content.lights, pixels.mixture(len(content.lights)))}
    for light in content.choices:
        errors[light.name] = _difference(model, pixels, found, [light], np.ones((PIXELS, 1)))
    worst = max(errors, key=lambda name: errors[name])
    return errors[worst], worst


@lru_cache(maxsize=4)
def _made_for(content: Content) -> Candidate | None:
    """A model of SCENE channels with filters of the scene's own; None where it is of too many kinds for one."""
    lights = [*content.lights, *content.choices]
    if not content.reflectances or len(content.parts) > MOST_SURFACES or len(lights) > MOST_LIGHTS or content.textures:
        return None
    own = [Spectrum(WAVELENGTHS, values) for values in _known(content, content.rgb)]
    bounces = BOUNCES if content.bounces else None
    made = bases.scene(SCENE, own, lights, exact=False, rule=_rule(content), bounces=bounces)
    return Candidate(made, *predict(made, content))


def _general_filters(model: FactorModel) -> Array:
    return bases.fitted(model.channels).filters


@lru_cache(maxsize=2)
def _pixels(content: Content) -> Pixels:
    """Pixels of a scene, the same for every candidate."""
    return Pixels(content)


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
        alternatives = [fitted_to(content, channels)]
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


def fitted_to(content: Content, channels: int) -> FactorModel:
    """The fitted filters, with matrices for the scene's spectra: measured, of its colours, of any texture."""
    colours = content.rgb
    if content.textures > 0:
        levels = srgb_decoded(np.linspace(0, 1, 4))
        colours = np.concatenate([colours, np.stack(np.meshgrid(levels, levels, levels), axis=-1).reshape(-1, 3)])
    known = _known(content, colours)
    return FactorModel("scene", WAVELENGTHS, bases.fitted(channels).filters, _rule(content)(known))


def _known(content: Content, colours: Array) -> Array:
    """(m, 81): spectra of a scene's surfaces, those of RGB `colours` among them, and of light behind its media."""
    upsampled = np.clip(colours @ rgb_spectra(content.space).T, 0, 1)
    measured = np.array([each.sampled() for each in content.reflectances]).reshape(-1, WAVELENGTHS.size)
    spectra = np.concatenate([measured, upsampled])
    depths = np.zeros(len(spectra))
    depths[: len(content.parts)] = content.optical_depths
    deep = depths > 0
    spectra[deep] = finish.let_through(spectra[deep], depths[deep, None])
    return spectra


def _rule(content: Content) -> type[Fitted]:
    return Fitted if content.bounces else Direct


def _difference(model: FactorModel, pixels: Pixels, found: Array, lights: Sequence[Spectrum], mixture: Array) -> float:
    """98th percentile of CIEDE2000 of coefficients (pixels, p) under a mixture (pixels, lights) of lights."""
    matrices = np.array([model.relight(light) for light in lights])
    xyz = np.einsum("ng,gxp,np->nx", mixture, matrices, found)
    true = np.einsum("ng,gnx->nx", mixture, np.array([pixels.true_xyz(light) for light in lights]))
    return float(np.percentile(difference(xyz, true, matrices.sum(axis=(0, 2))), 98))
