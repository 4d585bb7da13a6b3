"""A picture of a finished render as it would be with another reflectance on one material, and how far off it may be.

The lamps of a light group shine alike in all channels, and the world as where it is seen, so the shape of a pixel's
coefficients over the channels tells what its light has met. In every pixel they are taken apart by least squares, no
part below 0: light that comes from other things, light that has met the material before, and, where the material
mirrors, what it mirrors. The first is multiplied by new over old, the second twice, the third not at all.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from ..colour.differences import picture_delta_E
from ..errors import PaletteError
from ..model.factor_model import FactorModel
from ..picture.mix import Mix
from ..picture.recombination import color_of, mixed_white
from ..spectra.arrays import Array

__all__ = ["HATCHED", "Trial", "Worn", "coefficients_under", "hatched", "trial"]

WHOLE = 0.99  # of a pixel, that counts as all of it
FAINT = 0.01  # a coefficient below which too little of the light came back to say what it was
ALIKE = 0.02  # square of the sine of the angle between parts that are too much alike to be told apart
NEIGHBOURS = 0.7  # cosine of the angle between colours, less their grey, from which their light is not told apart
SHARE = 0.5  # of what is put right by the shape of coefficients, that may be wrong: measured, see docs/palette.md
HATCHED = 3.0  # CIEDE2000 from which a pixel is hatched: plain to see
_APART = 6  # pixels from one line to the next
DARK = 0.05  # coefficients below this count alike when mirror images are looked for
_ROWS = 64  # rows that are solved at a time: the temporary arrays stay small


@dataclass(frozen=True, eq=False)
class Worn:
    """A reflectance that a material is to wear: coefficients (p,), and whether its surface also mirrors."""

    material: str
    coefficients: Array
    mirrors: bool = False


@dataclass(frozen=True, eq=False)
class Trial:
    """groups: {light group: (height, width, p)} of the picture as it would be. covered: (height, width), the part of
    each pixel that is of these materials. expected: (height, width), CIEDE2000 by which each pixel may be off. worn:
    names of the materials. unseen: those that the picture does not show. grey: those of which it cannot be told what
    of their light falls on other things, and which `expected` says nothing of.
    """

    groups: dict[str, Array]
    covered: Array
    expected: Array
    worn: tuple[str, ...]
    unseen: tuple[str, ...]
    grey: tuple[str, ...]

    def words(self) -> str:
        """What was tried on and how far off the picture may be: a line for each."""
        here, there = self.expected[self.covered > WHOLE], self.expected[self.covered < 1.0 - WHOLE]
        said = [f"Tried on: {', '.join(self.worn)}."]
        for where, values in (("There", here), ("Elsewhere", there)):
            # Nothing is known of greys: nothing is no small number
            if values.size and (set(self.grey) != set(self.worn) or np.percentile(values, 90) >= 0.05):
                middle, tenth = np.median(values), np.percentile(values, 90)
                said.append(f"{where} it may be off by ΔE {middle:.1f}, in a tenth of it by {tenth:.1f} or more.")
        said.append(f"Hatched: by more than {HATCHED:g}. F12 makes it exact.")
        if self.grey:
            said.append(f"Where light of {', '.join(self.grey)} falls is not known: a grey leaves no mark on it.")
        if self.unseen:
            said.append(f"Not seen in the picture: {', '.join(self.unseen)}.")
        return "\n".join(said)


def coefficients_under(surface: Array, covered: Array) -> Array:
    """(p,) coefficients of a material: the median of the surfaces (height, width, p) that it covers (height, width).

    Raises PaletteError where it covers no pixel.
    """
    seen = np.asarray(covered) > WHOLE
    if not seen.any():
        raise PaletteError("this material is not seen in the picture")
    return np.median(np.asarray(surface)[seen], axis=0).astype(np.float64)


def trial(
    model: FactorModel,
    mix: Mix,
    groups: Mapping[str, Array],
    surface: Array,
    materials: Mapping[str, Array],
    wanted: Sequence[Worn],
) -> Trial:
    """The picture `groups` {light group: (height, width, p)} with other reflectances on some materials -> Trial.

    surface: (height, width, p) of the AOV, 0 where nothing was carried. materials: {name: (height, width)}, the part of
    each pixel that is the material. Raises PaletteError where none of the materials is seen.
    """
    world = np.maximum(1.0 - sum(materials.values(), np.zeros(np.shape(surface)[:2])), 0.0)
    nothing = world > WHOLE  # it has met nothing
    surface = _grey_where_unknown(np.asarray(surface, np.float64))
    worlds = {name: _world(np.asarray(values)[nothing], surface.shape[-1]) for name, values in groups.items()}
    # Edges before the world have a part of it, which is put back in the end
    edge = np.where(nothing | (world < 1.0 - WHOLE), 0.0, world)[..., None].astype(np.float32)
    behind = {name: np.minimum(edge * worlds[name], values) for name, values in groups.items()}
    changed = {name: values - behind[name] for name, values in groups.items()}
    plain = dict(changed)
    everywhere, worn, grey = np.zeros(surface.shape[:2]), [], []
    for one in wanted:
        covered = np.clip(np.asarray(materials.get(one.material, everywhere * 0.0), np.float64), 0.0, 1.0)
        if not (covered > WHOLE).any():
            continue
        old, new = coefficients_under(surface, covered), np.asarray(one.coefficients, np.float64)
        if _alike(old):
            grey.append(one.material)
        share = _share(one.material, materials, surface)
        becomes = _exchanged(surface, covered[..., None], old, new)
        for name in groups:
            shape, done = _shape(worlds[name]), (np.empty_like(changed[name]), np.empty_like(changed[name]))
            for top in range(0, len(surface), _ROWS):
                rows = slice(top, top + _ROWS)
                at, here = surface[rows], covered[rows, :, None]
                light, met, mirrored = _light(changed[name][rows] / shape, at, here, old, one.mirrors)
                met *= share
                met[nothing[rows]] = 0.0
                done[0][rows] = ((light + met * (new - old)) * becomes[rows] + mirrored) * shape
                simply = _light_alone(plain[name][rows], at, light * shape) * becomes[rows]
                done[1][rows] = np.where(here > 0.0, simply, plain[name][rows])
            changed[name], plain[name] = done
        surface = becomes
        everywhere += covered
        worn.append(one.material)
    unseen = tuple(one.material for one in wanted if one.material not in worn)
    if not worn:
        raise PaletteError(f"not seen in the picture: {', '.join(unseen)}")
    for pictures in (changed, plain):
        pictures.update({name: values + behind[name] for name, values in pictures.items()})
    shown, simply = (color_of(model, mix, list(each.values())) for each in (changed, plain))
    apart = picture_delta_E(simply, shown, mixed_white(model, mix))
    return Trial(changed, np.minimum(everywhere, 1.0), SHARE * apart, tuple(worn), unseen, tuple(grey))


def hatched(picture: Array, expected: Array) -> Array:
    """A linear picture (height, width, 3), with lines where the `expected` error (height, width) is above `HATCHED`."""
    rows, columns = np.indices(expected.shape)
    lines = ((rows + columns) % _APART == 0) & (expected > HATCHED)
    # Dark lines on what is bright, bright ones on what is dark
    luminance = picture.mean(axis=-1, keepdims=True)
    middle = np.median(luminance)
    ink = np.where(luminance > middle, 0.3 * picture, picture + 0.5 * max(float(middle), 0.02))
    return np.where(lines[..., None], ink, picture)


def _exchanged(surface: Array, covered: Array, old: Array, new: Array) -> Array:
    """Surfaces (height, width, p) with `new` in place of what is `old` of them."""
    # Passes have samples of their own, and parts of edges that differ a little: no more is taken than there is
    taken = np.clip(covered * old, 0.0, np.maximum(surface, 0.0))
    given = np.where(old > FAINT, taken / np.where(old > FAINT, old, 1.0), covered) * new
    return np.where(covered > WHOLE, new, surface - taken + given)


def _world(seen: Array, channels: int) -> Array:
    """(p,) what a light group is where nothing but the world is seen, in pixels (n, p)."""
    return np.median(seen, axis=0).astype(np.float64) if len(seen) else np.zeros(channels)


def _shape(world: Array) -> Array:
    """(p,) how the light of a group is over the channels, its highest 1: as the world's, where it has any."""
    return np.maximum(world / world.max(), FAINT) if world.max() > 0.0 else np.ones_like(world)


def _grey_where_unknown(surface: Array) -> Array:
    """What carries nothing, as a metal, is taken for grey."""
    return np.where(np.abs(surface).max(axis=-1, keepdims=True) < 1e-3, 1.0, surface)


def _share(name: str, materials: Mapping[str, Array], surface: Array) -> float:
    """How much of the light with the shape of a material's colour is taken to have met it, and not others like it.

    By how much of the picture they have, and how colourful they are.
    """
    weights: dict[str, float] = {}
    towards: dict[str, Array] = {}
    for each, covered in materials.items():
        if (np.asarray(covered) > WHOLE).any():
            colour = coefficients_under(surface, covered)
            towards[each] = colour - colour.mean()
            weights[each] = float(np.sum(covered) * np.linalg.norm(towards[each]))
    length = float(np.linalg.norm(towards[name]))
    alike = [
        weights[each]
        for each, other in towards.items()
        if towards[name] @ other > NEIGHBOURS * length * np.linalg.norm(other)
    ]
    return weights[name] / float(np.sum(alike)) if alike else 1.0


def _alike(old: Array) -> bool:
    """Whether light that has met a material of coefficients (p,) has the shape of light that has not."""
    return bool(1.0 - old.sum() ** 2 / (len(old) * float(old @ old) + 1e-12) < ALIKE)


def _light(values: Array, surface: Array, covered: Array, old: Array, mirrors: bool) -> tuple:
    """Of rows of one light group: the light (..., p) on what is seen, that of it which has met the material (..., 1),
    in amounts of `old`, and what is mirrored (..., 1).
    """
    again = surface * old
    first, met = _two_apart(surface, again, values)
    mirrored = np.zeros_like(first)
    if mirrors and (here := covered[..., 0] > 0.5).any():
        parts = np.stack([surface[here], again[here], np.ones_like(again[here])], axis=-2)
        # What is mirrored shows in dark channels, and noise is as large as what it is of
        weights = 1.0 / (np.maximum(surface[here], 0.0) + DARK)
        first[here], met[here], mirrored[here] = _apart(parts * weights[:, None], values[here] * weights)
    return _light_alone(values - mirrored, surface, first + met * old), met, mirrored


def _two_apart(one: Array, other: Array, values: Array) -> tuple:
    """Amounts (..., 1) of two parts (..., p), none below 0, whose sum is nearest to `values` (..., p)."""
    ones, both, others, first, second = (
        np.einsum("...p,...p->...", a, b)
        for a, b in ((one, one), (one, other), (other, other), (one, values), (other, values))
    )
    ones, others = ones + 1e-12, others + 1e-12
    apart = ones * others - both * both
    # Parts that are alike, as those of a grey, are told apart by nothing but noise
    alike = apart < ALIKE * ones * others
    amounts = [
        each / np.where(alike, 1.0, apart) for each in (first * others - second * both, second * ones - first * both)
    ]
    only_one, only_other = alike | (amounts[1] < 0.0), ~alike & (amounts[0] < 0.0)
    x = np.where(only_one, first / ones, np.where(only_other, 0.0, amounts[0]))
    y = np.where(only_one, 0.0, np.where(only_other, second / others, amounts[1]))
    return np.maximum(x, 0.0)[..., None], np.maximum(y, 0.0)[..., None]


def _light_alone(values: Array, surface: Array, otherwise: Array) -> Array:
    """The light that a surface made `values` of; `otherwise` in channels of which it reflects next to nothing."""
    known = surface > FAINT
    return np.where(known, values / np.where(known, surface, 1.0), otherwise)


def _apart(parts: Array, values: Array) -> list:
    """Amounts (..., 1), none below 0, of the `parts` (..., k, p) whose sum is nearest to `values` (..., p)."""
    count = parts.shape[-2]
    best, least = np.zeros(values.shape[:-1] + (count,)), np.full(values.shape[:-1], np.inf)
    for others in product((False, True), repeat=count - 1):
        used = [0, *(index + 1 for index, kept in enumerate(others) if kept)]
        kept = parts[..., used, :]
        square = np.einsum("...ip,...jp->...ij", kept, kept)
        # Parts that are alike, as those of a grey, are told apart by nothing
        size = np.trace(square, axis1=-2, axis2=-1)[..., None, None]
        square = square + (1e-9 * size + 1e-12) * np.eye(len(used))
        amounts = np.linalg.solve(square, np.einsum("...ip,...p->...i", kept, values)[..., None])[..., 0]
        left = np.square(np.einsum("...i,...ip->...p", amounts, kept) - values).sum(axis=-1)
        better = (left < least) & (amounts >= 0.0).all(axis=-1)
        full = np.zeros_like(best)
        full[..., used] = amounts
        best, least = np.where(better[..., None], full, best), np.where(better, left, least)
    return [best[..., index, None] for index in range(count)]
