"""The coefficients of a light group as pictures of one byte a pixel, which browsers decode by themselves.

A pixel's coefficients c are split into their brightness I = v·c (v: how much lamps make of each channel) and what is
left in proportion to it: c = I + (I + ε + κT) B r. T is the brightness of all light groups together: where others
outshine a group, it may be coarser. The relight matrices give a metric that turns r into units of CIEDE2000 at mid
grey: the one in which noise of a given volume is seen least under the lamp that shows most of it, a D-optimal design
over lamps. Its principal axes are the columns of B: an axis that no lamp can tell apart costs nothing. Brightness goes
in steps of a logarithm, coarser above white; r in steps that grow with the chroma, as CIEDE2000's tolerance does. Every
one of the p planes is an AVIF in grey; a table of 256 values says what its bytes mean.
"""

import io
import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial

import numpy as np

from ..colour.differences import delta_E_2000
from ..colour.spaces import rgb_to_xyz
from ..errors import MeasureError
from ..model.relight import local_metric
from ..spectra.arrays import Array

__all__ = [
    "SHARED",
    "Encoded",
    "decode",
    "difference",
    "encode",
    "encode_within",
    "luminous",
    "plane_bytes",
    "quality_for",
    "quantised",
    "reached",
    "tiles",
    "white_of",
]

FLOOR = 0.04  # ε, in parts of what is bright: below it, brightness goes in equal steps
SHARED = 0.25  # κ: how much of the brightness of all groups counts as a group's own
ABOVE_WHITE = 0.35  # how fine the steps above white are, to those below
CHROMA = 25.0  # where the steps of r begin to grow, in ΔE at mid grey
STEPS = (0.008, 0.2)  # the finest that pay: of the logarithm of brightness, and of r in ΔE where 1 ΔE is wanted
PIXELS = 4000  # on which quality is measured
SAMPLE = 128  # pixels to a side of the tiles that quality is measured on
QUALITIES = (40, 98)  # of the AVIF encoder
FAST, KEPT = 7, 5  # speeds of the AVIF encoder: the slower one takes a tenth less, a quarter in smooth planes
_ROUNDS = 60  # of the search for weights of lamps


@dataclass(frozen=True)
class Encoded:
    """One light group of one picture. `c = I + (I + floor + κT) basis @ r`, where `(I, *r) = tables[plane, byte]`.

    planes: p files, each of (height, width) bytes. tables: (p, 256) float32. basis: (p, p - 1) float32.
    """

    planes: tuple[bytes, ...]
    tables: np.ndarray
    basis: np.ndarray
    floor: float


def plane_bytes(codes: np.ndarray, quality: int, speed: int = KEPT) -> bytes:
    """An AVIF of (height, width) uint8, grey."""
    from PIL import Image

    file = io.BytesIO()
    # Least squares, not what pleases the eye: these bytes are no picture
    Image.fromarray(codes).save(file, "AVIF", quality=quality, speed=speed, max_threads=1, advanced={"tune": "psnr"})
    return file.getvalue()


def _codes_in(plane: bytes) -> np.ndarray:
    from PIL import Image

    return np.asarray(Image.open(io.BytesIO(plane)).convert("L"))


def luminous(matrices: np.ndarray) -> np.ndarray:
    """(p,) v, of sum 1: how much of the brightness each channel makes, over lamps (lamps, 3, p)."""
    weights = np.maximum(matrices[:, 1].mean(axis=0), 0.0)
    return weights / weights.sum()


def _metric_root(matrices: np.ndarray) -> np.ndarray:
    """(p, p) symmetric M such that |M dc| is the CIEDE2000 of a small change dc of a mid grey, over lamps.

    Of the weighted means of the lamps' metrics the one of largest determinant: noise that is even in it has the same
    CIEDE2000 under all lamps that carry weight, and less under the others (Kiefer & Wolfowitz 1960; the weights by
    Titterington's rule).
    """
    channels = matrices.shape[2]
    metrics = []
    for matrix in matrices.astype(np.float64):
        white = matrix.sum(axis=1)
        rows = 0.2 * local_metric(0.2 * white[None], white)[0] @ matrix
        metrics.append(rows.T @ rows)
    every = np.array(metrics)
    weights = np.full(len(every), 1.0 / len(every))
    for _ in range(_ROUNDS):
        total = np.tensordot(weights, every, axes=1)
        total += 1e-4 * np.trace(total) / channels * np.eye(channels)  # what no lamp shows comes back roughly
        seen = np.einsum("lij,ij->l", every, np.linalg.inv(total))
        weights *= seen / (weights @ seen)
    values, vectors = np.linalg.eigh(total)
    return (vectors * np.sqrt(values)) @ vectors.T


def white_of(groups: Sequence[np.ndarray], weights: np.ndarray, exposure: float) -> float:
    """The brightness that the picture shows as white, or its own highlights where they stay below."""
    total = sum(coefficients @ weights for coefficients in groups)
    return float(max(min(np.percentile(total, 98), 2.0**-exposure), 1e-6))


def quantised(
    coefficients: np.ndarray, total: np.ndarray, matrices: np.ndarray, white: float, wanted: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Codes (p, height, width) uint8 of coefficients (height, width, p), with the tables, basis and floor.

    total: (height, width) brightness of all light groups. white: what of it is shown as white, see `white_of`.
    wanted: the ΔE that it is for.
    """
    shape, channels = coefficients.shape[:2], coefficients.shape[2]
    flat = coefficients.reshape(-1, channels)
    root = _metric_root(matrices)
    brightness = flat @ luminous(matrices).astype(np.float32)
    floor = float(max(FLOOR * np.sqrt(white * max(float(np.percentile(brightness, 98)), 0.0)), 1e-3 * white))
    scale = np.maximum(brightness + floor + SHARED * total.ravel(), 0.1 * floor)
    rest = (flat - brightness[:, None]) / scale[:, None]
    spread = root @ (rest.T @ rest / len(rest)).astype(np.float64) @ root
    axes = np.linalg.eigh(spread)[1][:, ::-1][:, : channels - 1]
    r = rest @ (root @ axes).astype(np.float32)

    knee = np.log1p(white / floor)
    bright = np.log1p(np.maximum(brightness, -0.5 * floor) / floor)
    bright = np.where(bright > knee, knee + ABOVE_WHITE * (bright - knee), bright)
    codes, level = _quantised(bright, STEPS[0], 0.0)
    level = np.where(level > knee, knee + (level - knee) / ABOVE_WHITE, level)
    found, tables = [codes], [floor * np.expm1(level)]
    for axis in r.T:
        codes, level = _quantised(
            np.sign(axis) * CHROMA * np.log1p(np.abs(axis) / CHROMA), STEPS[1] * min(wanted, 1.0), 1e-4
        )
        found.append(codes)
        tables.append(np.sign(level) * CHROMA * np.expm1(np.abs(level) / CHROMA))
    basis = np.linalg.solve(root, axes).astype(np.float32)
    return np.array(found).reshape(channels, *shape), np.array(tables, np.float32), basis, floor


def _quantised(values: np.ndarray, finest: float, left_out: float) -> tuple[np.ndarray, Array]:
    """Codes uint8 of values, and what each of the 256 means; a part `left_out` at either end may be clipped."""
    low, high = np.quantile(values, [left_out, 1.0 - left_out])
    step = max(finest, (high - low) / 255)
    first = step * np.round((low + high) / 2 / step - 127.5)  # zero is one of the values: an even picture stays even
    codes = np.clip(np.round((values - first) / step), 0, 255).astype(np.uint8)
    return codes, first + step * np.arange(256)


def encode(
    groups: Mapping[str, np.ndarray],
    matrices: np.ndarray,
    exposure: float = 0.0,
    quality: int = 85,
    wanted: float = 1.0,
    speed: int = KEPT,
) -> dict[str, Encoded]:
    """Encode light groups, each (height, width, p), for lamps whose relight matrices are (lamps, 3, p).

    quality, speed: of the AVIF encoder. wanted: the ΔE that it is for.
    """
    weights = luminous(matrices)
    white = white_of(list(groups.values()), weights, exposure)
    total = np.sum([coefficients @ weights.astype(np.float32) for coefficients in groups.values()], axis=0)
    coded = {}
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        for name, coefficients in groups.items():
            codes, tables, basis, floor = quantised(coefficients, total, matrices, white, wanted)
            planes = pool.map(partial(plane_bytes, quality=quality, speed=speed), codes)
            coded[name] = planes, tables, basis, floor
        return {name: Encoded(tuple(files), each, axes, low) for name, (files, each, axes, low) in coded.items()}


def decode(coded: Mapping[str, Encoded]) -> dict[str, np.ndarray]:
    """(height, width, p) float32 of each light group: what a browser makes of them."""
    values = {
        name: [table[_codes_in(plane)] for table, plane in zip(each.tables, each.planes, strict=True)]
        for name, each in coded.items()
    }
    total = sum(planes[0] for planes in values.values())
    found = {}
    for name, (brightness, *rest) in values.items():
        found[name] = np.repeat(brightness[..., None], 1 + len(rest), axis=-1)
        if rest:
            scale = brightness + coded[name].floor + SHARED * total
            found[name] += scale[..., None] * (np.stack(rest, axis=-1) @ coded[name].basis.T)
    return found


def difference(
    groups: Sequence[np.ndarray], shown: Sequence[np.ndarray], matrices: Sequence[np.ndarray], exposure: float = 0.0
) -> Array:
    """(pixels,) CIEDE2000 of two pictures as an sRGB display shows them.

    groups, shown: (pixels, p) for each light group; the picture meant, and the picture to be judged. matrices: (3, p)
    for each light group.
    """
    to_xyz = rgb_to_xyz()
    turns = [np.linalg.solve(to_xyz, matrix.astype(np.float64) * 2.0**exposure).T for matrix in matrices]
    meant, judged = (
        np.clip(sum(each @ turn for each, turn in zip(picture, turns, strict=True)), 0.0, 1.0) @ to_xyz.T
        for picture in (groups, shown)
    )
    return delta_E_2000(meant, judged, to_xyz.sum(axis=1))


def reached(
    groups: Mapping[str, np.ndarray], coded: Mapping[str, Encoded], matrices: np.ndarray, exposure: float = 0.0
) -> float:
    """The CIEDE2000 that 98 % of pixels keep to under every lamp, the worst one too; of some thousand pixels.

    Every lamp lights all groups, and once more one of them, with other lamps in the others.
    """
    count = next(iter(groups.values()))[..., 0].size
    pixels = np.random.default_rng(1).permutation(count)[:PIXELS]
    meant, shown = (
        [each.reshape(-1, matrices.shape[2])[pixels] for each in pictures]
        for pictures in (groups.values(), decode(coded).values())
    )
    lamps, worst = len(matrices), 0.0
    for first in range(lamps):
        for apart in {0, lamps // 3 + 1} if len(groups) > 1 else {0}:
            lit = [matrices[(first + g * apart) % lamps] for g in range(len(groups))]
            worst = max(worst, float(np.percentile(difference(meant, shown, lit, exposure), 98)))
    return worst


def quality_for(groups: Mapping[str, np.ndarray], matrices: np.ndarray, exposure: float, wanted: float) -> int:
    """The lowest quality at which 98 % of pixels are within `wanted` ΔE under every lamp, measured on tiles.

    Raises MeasureError for a ΔE that is not positive.
    """
    if not wanted > 0.0:
        raise MeasureError(f"a quality of ΔE {wanted:g} cannot be reached: give more than 0")
    parts = {name: tiles(coefficients) for name, coefficients in groups.items()}
    low, high = QUALITIES
    # What is encoded slowly has a little less error at the same quality
    for speed in (FAST, KEPT):
        while low < high:
            middle = (low + high) // 2
            coded = encode(parts, matrices, exposure, middle, wanted, speed)
            low, high = (low, middle) if reached(parts, coded, matrices, exposure) <= wanted else (middle + 1, high)
        low, high = (max(low - 6, QUALITIES[0]), low) if speed == FAST else (low, high)
    return low


def tiles(coefficients: np.ndarray) -> np.ndarray:
    """One picture of every third tile, in both directions; a small picture whole."""
    height, width = coefficients.shape[:2]
    if height <= 3 * SAMPLE or width <= 3 * SAMPLE:
        return coefficients
    rows, columns = (range(size % (3 * SAMPLE) // 3, size - SAMPLE + 1, 3 * SAMPLE) for size in (height, width))
    return np.concatenate(
        [np.concatenate([coefficients[y : y + SAMPLE, x : x + SAMPLE] for x in columns], axis=1) for y in rows]
    )


def encode_within(
    wanted: float, groups: Mapping[str, np.ndarray], matrices: np.ndarray, exposure: float, quality: int
) -> tuple[dict[str, Encoded], int, float]:
    """Light groups encoded at `quality`, or higher where that misses `wanted`; the quality, and the ΔE reached."""
    while True:
        coded = encode(groups, matrices, exposure, quality, wanted)
        found = reached(groups, coded, matrices, exposure)
        if found <= wanted or quality >= QUALITIES[1]:
            return coded, quality, found
        quality = min(quality + max(1, round(8 * (found / wanted - 1))), QUALITIES[1])
