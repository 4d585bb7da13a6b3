"""How large a page of `relume web` is, and how exact: file formats, and qualities at several amounts of noise.

    python -m relume.benchmarks.web_size [--percent 100]

The picture is made, not rendered: 1920 × 1080, nine channels, three light groups; the 99 reflectances of CIE 224 in
fields with grain, lit softly from three sides and once more by one another, with highlights four stops above white.
Noise is that of three passes: their own in each, nearly the same in the three channels of one. What grain and noise
there is in a picture, and nothing else, makes its size.
"""

import argparse
import gzip
import io
import tempfile
import time
from pathlib import Path

import numpy as np

from ..core.model import bases
from ..core.picture.coefficient_image import CoefficientImage
from ..core.spectra import library
from ..core.web import encoding, lamps, page

SIZE = (1920, 1080)
FORMATS = {
    "AVIF": [
        {"format": "AVIF", "quality": q, "speed": 8, "advanced": {"tune": "psnr"}} for q in (99, 96, 92, 88, 84, 78)
    ],
    "AVIF, tuned for the eye": [{"format": "AVIF", "quality": q, "speed": 8} for q in (99, 96, 92, 88, 84, 78)],
    "WebP": [{"format": "WEBP", "quality": q} for q in (100, 98, 95, 90, 80)],
    "WebP, lossless": [{"format": "WEBP", "lossless": True, "quality": 40}],
    "PNG": [{"format": "PNG"}],
}


def picture(percent: int, noise: float) -> CoefficientImage:
    """The coefficient image that is measured; noise: standard deviation in parts of a mid grey."""
    rng = np.random.default_rng(0)
    width, height = (side * percent // 100 for side in SIZE)
    model = bases.fitted(9)
    colours = np.stack([model.coefficients(each) for each in library.reflectances("ces")])
    fields = _fields(rng, width, height, len(colours))
    grain = 1 + 0.05 * _clouds(rng, width, height, (2, 4, 16, 32)) + 0.12 * _clouds(rng, width, height, (64, 256))
    tint = np.clip(1 + 0.04 * _clouds(rng, width, height, (2, 8, 64))[..., None] * rng.standard_normal(9), 0.5, 1.5)
    surface = np.clip(colours[fields] * grain[..., None] * tint, 0.0, 1.0)
    y, x = np.mgrid[:height, :width] / np.array([height, width])[:, None, None]
    lit = {"key": 1.2 - x, "window": 0.1 + y * x, "lamp": 1.5 * np.exp(-8 * ((x - 0.3) ** 2 + (y - 0.4) ** 2))}
    groups = {}
    for name, level in lit.items():
        light = level[..., None] * surface * (0.7 + 0.5 * np.roll(surface, width // 20, axis=1))
        light += 16.0 * np.exp(-((x - 0.7) ** 2 + (y - 0.3) ** 2) * 8000)[..., None] * (name != "window")
        noisy = np.concatenate([_noise(rng, light.shape[:2]) for _ in range(3)], axis=-1)
        groups[name] = (light + noise * np.sqrt(0.2 * np.maximum(light, 0.0)) * noisy).astype(np.float32)
    illuminants = dict(zip(groups, map(library.illuminant, ("A", "D65", "FL11")), strict=True))
    return CoefficientImage(model, groups, illuminants, np.ones((height, width), np.float32))


def _fields(rng, width: int, height: int, count: int) -> np.ndarray:
    """(height, width) numbers of fields: of each pixel the nearest of `count` points."""
    from scipy.spatial import cKDTree

    points = rng.uniform(0, 1, (count, 2)) * (height, width)
    rows, columns = np.mgrid[:height, :width]
    return cKDTree(points).query(np.stack([rows, columns], axis=-1))[1]


def _clouds(rng, width: int, height: int, sizes) -> np.ndarray:
    """(height, width) smooth noise of several sizes in pixels, of variance 1 in all."""
    from scipy.ndimage import zoom

    total = 0.0
    for size in sizes:
        coarse = rng.standard_normal((height // size + 2, width // size + 2))
        total = total + (zoom(coarse, size, order=1) if size > 1 else coarse)[:height, :width]
    return total / total.std()


def _noise(rng, shape) -> np.ndarray:
    return 0.9 * rng.standard_normal((*shape, 1)) + 0.44 * rng.standard_normal((*shape, 3))


def formats(image: CoefficientImage, matrices: np.ndarray) -> dict[str, float]:
    """Megabytes of the planes of 1920 × 1080 pixels at ΔE 1 of 98 %, by format; measured on tiles."""
    tiles = {name: encoding.tiles(each) for name, each in image.groups.items()}
    pixels = next(iter(tiles.values()))[..., 0].size
    scale = SIZE[0] * SIZE[1] / pixels / 1e6
    white = encoding.white_of(list(tiles.values()), encoding.luminous(matrices), 0.0)
    found = {
        "halves, gzip": scale * sum(len(gzip.compress(each.astype("<f2").tobytes(), 6)) for each in tiles.values())
    }
    for name, settings in FORMATS.items():
        # Where nothing is lost but by the steps, the steps are what is chosen
        wanted = (1.0, 2.0, 4.0) if len(settings) == 1 else (1.0,)
        points = sorted(_point(tiles, matrices, white, each, step) for each in settings for step in wanted)
        errors, sizes = np.array(points).T
        found[name] = scale * float(np.exp(np.interp(0.0, np.log(errors), np.log(sizes))))
    return found


def _point(tiles, matrices, white: float, settings: dict, step: float) -> tuple[float, int]:
    from PIL import Image

    coded = {}
    total = sum(coefficients @ encoding.luminous(matrices).astype(np.float32) for coefficients in tiles.values())
    for name, coefficients in tiles.items():
        codes, tables, basis, floor = encoding.quantised(coefficients, total, matrices, white, step)
        planes = []
        for plane in codes:
            file = io.BytesIO()
            Image.fromarray(plane).convert("RGB" if settings["format"] == "WEBP" else "L").save(file, **settings)
            planes.append(file.getvalue())
        coded[name] = encoding.Encoded(tuple(planes), tables, basis, floor)
    size = sum(len(plane) for each in coded.values() for plane in each.planes)
    return encoding.reached(tiles, coded, matrices), size


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--percent", type=int, default=100, help="of 1920 × 1080, to try it")
    parser.add_argument("--noise", type=float, nargs="+", default=[0.0, 0.01, 0.02])
    parser.add_argument("--quality", type=float, nargs="+", default=[0.5, 1.0, 2.0])
    arguments = parser.parse_args()
    for noise in arguments.noise:
        image = picture(arguments.percent, noise)
        chosen = [library.illuminant(name) for name in lamps.chosen(["all"])]
        matrices = lamps.matrices(image.model, chosen, [library.OBSERVER])[0]
        print(f"\nnoise {noise:.1%} of a mid grey: planes at ΔE 1 of 98 %, over {len(chosen)} lamps", flush=True)
        for name, size in formats(image, matrices).items():
            print(f"  {name:24} {size:6.2f} MB", flush=True)
        for quality in arguments.quality:
            with tempfile.TemporaryDirectory() as folder:
                path, started = Path(folder) / "page.html", time.monotonic()
                shown = page.Picture("picture", {1: lambda image=image: image})
                reached = page.write(path, [shown], size=None, quality=quality)["picture"]
                taken = time.monotonic() - started
                size = path.stat().st_size / 1e6
                print(f"  page, ΔE {quality:3.1f}: {size:5.2f} MB, reached {reached:.2f}, {taken:.0f} s", flush=True)


if __name__ == "__main__":
    main()
