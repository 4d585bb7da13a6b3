"""Ways to denoise a spectral render: what each leaves of the error of colour, over Blender's own denoised RGB.

`python -m relume.benchmarks.denoisers [--samples N] [--percent P] [--runs R] [--long N] [--scenes NAME ...]
[--picture FILE]`

Nine channels, samples shared among the passes, on the scenes of `overhead`. Error: mean CIEDE2000 to a long render of
the same kind, over that of RGB denoised with albedo and normal as guides. Below it stands by how much what is left of
noise in two passes correlates: relative errors of brightness, in the first light group. `--picture` shows a part of the
first scene's first run.
"""

import argparse
import tempfile
from dataclasses import replace
from pathlib import Path
from unittest import mock

import bpy
import numpy as np

from ..addon.host import denoising
from ..addon.scene import render, setup
from ..core.colour import differences, spaces
from ..core.model import bases, upsample
from ..core.picture import noise, recombination
from ..core.picture.coefficients import CoefficientImage
from ..core.picture.mix import Mix
from ..studies import figures
from . import overhead

_LEAST = 1e-6  # what light is divided by
_WIDTH = 480  # pixels of each picture that is shown, at least
_SHOWN = "as shown: noise of colour taken out"
_DEFAULT = "**both: as it is set up, and by `relume render`**"


def _ways(rendered: render.Rendered, lights: dict) -> dict[str, np.ndarray]:
    """{words: (height, width, 3) picture}."""
    image, guides = replace(rendered.image, groups=rendered.sampled), rendered.guides
    shown = recombination.recombination_matrices(image.model, Mix({group: lights[group] for group in image.groups}))
    matrices = [np.array_split(matrix, image.model.passes, axis=1) for matrix in shown]  # of group g and pass k: (3, 3)
    coefficients = [np.array_split(values, image.model.passes, axis=-1) for values in image.groups.values()]
    parts = [sum(c[k] @ m[k].T for c, m in zip(coefficients, matrices, strict=True)) for k in range(len(guides))]
    picture = sum(parts)
    joint = _joint_guides(guides, shown)
    equalised = _equalised(coefficients, parts, joint)

    def ours(image: CoefficientImage = image, guides=guides, **without) -> np.ndarray:
        with mock.patch.multiple(noise, **({"SHARE": noise.SHARE} | without)):
            return render.picture(denoising.denoised_image(image, guides), lights)

    straight = {"mirrored": lambda index: (False, False)}
    apart = ours(SHARE=0.0, **straight)
    together = denoising.denoised(picture, joint)
    return {
        "as sampled": picture,
        _SHOWN: render.picture(rendered.image, lights),
        "the picture alone": denoising.denoised(picture),
        "guides of the first pass (without *Denoise Every Pass*)": denoising.denoised(picture, guides[0]),
        "guides of all passes": together,
        "the passes' brightness made alike first, then the same": denoising.denoised(equalised, joint),
        "every pass, its light groups together": _each_pass(coefficients, matrices, guides),
        "every pass and light group, without guides": ours(guides=[{}] * len(guides), SHARE=0.0, **straight),
        "every pass and light group": apart,
        "the same, and the picture once more": denoising.denoised(apart, joint),
        "every pass as another mirror image": ours(SHARE=0.0),
        "every pass, held to the picture of a light group": ours(**straight),
        _DEFAULT: ours(),
        "the same, with noise of colour taken out first": ours(rendered.image),
        "luminance of the picture with all guides, colour of the passes": _with_luminance(apart, together),
        "luminance of the passes, colour of the picture with all guides": _with_luminance(together, apart),
    }


def _joint_guides(guides, matrices: np.ndarray) -> dict[str, np.ndarray]:
    """Albedo as it would be recombined under all lights, and the mean normal."""
    albedo = np.concatenate([guide["Albedo"] for guide in guides], axis=-1)
    lit = matrices.sum(axis=0)
    albedo = albedo @ lit.T / lit.sum(axis=1)
    return {"Albedo": np.clip(albedo, 0.0, 1.0), "Normal": np.mean([guide["Normal"] for guide in guides], axis=0)}


def _equalised(coefficients, parts, joint) -> np.ndarray:
    """The picture with each pass scaled so that passes are to one another as they are without noise."""
    brightness = np.stack([sum(c[k].sum(axis=-1) for c in coefficients) for k in range(len(parts))], axis=-1)
    clean = denoising.denoised(brightness, joint)  # three passes, as red, green and blue
    ratio = clean / np.maximum(clean.sum(axis=-1, keepdims=True), _LEAST) * brightness.sum(axis=-1, keepdims=True)
    scale = np.where(brightness > _LEAST, ratio / np.maximum(brightness, _LEAST), 1.0)
    return sum(scale[..., k : k + 1] * part for k, part in enumerate(parts))


def _each_pass(coefficients, matrices, guides) -> np.ndarray:
    """One denoising for each pass: what its light groups add, as coefficients under their mean light."""
    picture = 0.0
    for k, guide in enumerate(guides):
        mean = np.mean([m[k] for m in matrices], axis=0)
        to_mean = np.linalg.inv(mean)
        seen = sum(c[k] @ (to_mean @ m[k]).T for c, m in zip(coefficients, matrices, strict=True))
        picture = picture + denoising.denoised(seen, guide) @ mean.T
    return picture


def _with_luminance(colored: np.ndarray, bright: np.ndarray) -> np.ndarray:
    luminance = [np.maximum(picture @ upsample.rgb_to_xyz()[1], _LEAST) for picture in (colored, bright)]
    return colored * (luminance[1] / luminance[0])[..., None]


def _error(picture: np.ndarray, truth: np.ndarray, white: np.ndarray) -> float:
    to_xyz = upsample.rgb_to_xyz()
    return float(differences.picture_delta_E(picture @ to_xyz.T, truth @ to_xyz.T, white).mean())


def _open(path: Path, arguments, seed: int):
    bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
    scene = bpy.context.scene
    scene.render.resolution_percentage, scene.cycles.seed = arguments.percent, 100 * seed
    scene.cycles.samples = arguments.samples if seed else arguments.long
    return scene


def _plain(path: Path, arguments, seed: int) -> tuple[np.ndarray, dict]:
    scene = _open(path, arguments, seed)
    overhead.color_lamps(scene)
    return overhead.plain(scene, path.with_name("plain.exr"))[1:]


def _spectral(path: Path, arguments, seed: int) -> tuple[render.Rendered, dict]:
    scene = _open(path, arguments, seed)
    setup.set_up(scene, bases.fitted(9))
    rendered = render.render(scene, path.parent, guides=overhead.GUIDES)
    return rendered, {group.name: group.light() for group in scene.relume.light_groups}


def _correlations(rendered: render.Rendered, truth: np.ndarray) -> dict[str, float]:
    """{words: mean over pairs of passes}; truth: coefficients of the first light group."""

    def brightness(values) -> np.ndarray:
        return values.reshape(*values.shape[:2], -1, 3).sum(axis=-1)

    def found(groups) -> float:
        true = np.maximum(brightness(truth), 1e-3)
        error = np.clip(brightness(next(iter(groups.values()))) / true - 1.0, -1.0, 1.0)
        matrix = np.corrcoef(error.reshape(-1, error.shape[-1]).T)
        return float(matrix[np.triu_indices(len(matrix), 1)].mean())

    def apart(groups, **without) -> float:
        with mock.patch.multiple(noise, SHARE=0.0, **without):
            image = replace(rendered.image, groups=groups)
            return found(denoising.denoised_image(image, rendered.guides).groups)

    straight = {"mirrored": lambda index: (False, False)}
    return {
        "as sampled": found(rendered.sampled),
        "noise of colour taken out": found(rendered.image.groups),
        "every pass denoised": apart(rendered.sampled, **straight),
        "every pass as another mirror image": apart(rendered.sampled),
        "noise of colour taken out, then every pass denoised": apart(rendered.image.groups, **straight),
    }


def _draw(file: Path, plain: np.ndarray, ways: dict[str, np.ndarray], guides: dict) -> None:
    """The middle of a run's pictures, in two rows: not denoised, and denoised."""
    shown = {
        "Blender's RGB": plain,
        "nine channels as sampled": ways["as sampled"],
        "noise of colour taken out": ways[_SHOWN],
        "RGB, denoised": denoising.denoised(plain, guides),
        "nine channels, the picture denoised": ways["guides of all passes"],
        "nine channels, denoised by default": ways[_DEFAULT],
    }
    height, width, _ = plain.shape
    middle = (slice(height // 4, 3 * height // 4), slice(width // 4, 3 * width // 4))
    scale = -(-_WIDTH // (width // 2))
    figures.picture_row(
        file,
        [(title, np.kron(spaces.srgb_encoded(p[middle]), np.ones((scale, scale, 1)))) for title, p in shown.items()],
        columns=3,
    )


def _measure(path: Path, arguments, file: Path | None) -> tuple[dict[str, float], dict[str, float]]:
    """{way: error over RGB's} and {way: correlation}."""
    truth, _ = _plain(path, arguments, 0)
    long_run, lights = _spectral(path, arguments, 0)
    spectral_truth = render.picture(replace(long_run.image, groups=long_run.sampled), lights)
    white = recombination.mixed_white(bases.bands(), Mix(lights))
    plain, found, related = [], {}, {}
    for seed in range(1, arguments.runs + 1):
        picture, guides = _plain(path, arguments, seed)
        plain.append(_error(denoising.denoised(picture, guides), truth, white))
        rendered, lights = _spectral(path, arguments, seed)
        ways = _ways(rendered, lights)
        if file and seed == 1:
            _draw(file, picture, ways, guides)
        for words, way in ways.items():
            found.setdefault(words, []).append(_error(way, spectral_truth, white))
        for words, each in _correlations(rendered, next(iter(long_run.sampled.values()))).items():
            related.setdefault(words, []).append(each)
    errors = {words: np.mean(each) / np.mean(plain) for words, each in found.items()}
    return errors, {words: np.mean(each) for words, each in related.items()}


def _print(head: str, columns: dict[str, dict[str, float]]) -> None:
    print(f"\n| {head} |" + "".join(f" {name} |" for name in columns))
    print("|---|" + "---|" * len(columns))
    for words in next(iter(columns.values())):
        print(f"| {words} |" + "".join(f" {column[words]:.2f} |" for column in columns.values()), flush=True)


def main(argv: list[str] | None = None):
    parser = argparse.ArgumentParser(prog="python -m relume.benchmarks.denoisers", description=__doc__)
    parser.add_argument("--samples", type=int, default=48, help="per pixel, of all passes together (48)")
    parser.add_argument("--percent", type=int, default=30, help="of the scenes' own resolution (30)")
    parser.add_argument("--runs", type=int, default=4, help="renders of each (4)")
    parser.add_argument("--long", type=int, default=2048, metavar="N", help="samples of the long renders (2048)")
    scenes = list(overhead.SCENES)
    parser.add_argument("--scenes", nargs="+", choices=scenes, default=scenes, metavar="NAME", help="(all)")
    parser.add_argument("--picture", type=Path, metavar="FILE")
    arguments = parser.parse_args(argv)

    from .. import register

    register()
    errors, correlations = {}, {}
    with tempfile.TemporaryDirectory() as temporary:
        for name in arguments.scenes:
            path = Path(temporary) / f"{name}.blend"
            overhead.SCENES[name]()
            bpy.ops.wm.save_as_mainfile(filepath=str(path))
            file = arguments.picture if name == arguments.scenes[0] else None
            errors[name], correlations[name] = _measure(path, arguments, file)
    _print("ΔE2000 over RGB's, denoised with guides", errors)
    _print("correlation of what is left of two passes' noise", correlations)


if __name__ == "__main__":
    main()
