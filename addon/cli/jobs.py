"""What the commands do: render a scene into files, relight a file."""

import argparse
import hashlib
import json
import os
import sys
from collections import deque
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import replace
from itertools import islice
from pathlib import Path

import bpy
import numpy as np

from ...core import results
from ...core.errors import CoefficientImageError, ResultError, SequenceError, SetupError, UsageError
from ...core.picture import coefficients, description, mixing, recombination, sequences
from ...core.picture.coefficients import CoefficientImage
from ...core.picture.mix import GAINS, Light
from ...core.spectra import files, library
from ...core.spectra.spectrum import Spectrum
from ..host import console, denoising
from ..scene import describe, render, setup
from ..store import mix_file, mixes
from . import arguments, expected

__all__ = ["describe_scene", "file_name", "lights_of", "relight_file", "render_scene"]

_LONGEST = 100  # bytes of a name within a file's; file systems end at 255


def _prepare(scene, channels: str | None, samples: int | None) -> None:
    if samples is not None:
        scene.cycles.samples = samples
    settings = scene.relume
    settings.channels = channels or settings.channels
    if samples is None and settings.is_set_up and settings.request == settings.plan.get("request"):
        return
    setup.set_up(scene)


def _choose_illuminants(scene, chosen: list[str]) -> list[str]:
    """Put GROUP=NAME into the scene's mixer; returns the plain names. Raises LibraryError, SetupError."""
    plain = []
    for text in chosen:
        group, equals, name = text.rpartition("=")
        library.illuminant(name)
        if not equals:
            plain.append(name)
            continue
        names = [row.name for row in scene.relume.lit]
        if group not in names:
            raise SetupError(f"scene {scene.name!r} has no light group {group!r}; it has {', '.join(names)}")
        scene.relume.light_groups[group].source = "LIBRARY"
        scene.relume.light_groups[group].illuminant = name
    return plain


def file_name(text: str) -> str:
    """A name as part of a file's: without what some file systems forbid, and not too long for any."""
    name = "".join("-" if c in '/\\:*?"<>|' or not c.isprintable() else c for c in text).replace(" ", "_")
    if len(name.encode()) <= _LONGEST:
        return name
    short = name.encode()[: _LONGEST - 9].decode(errors="ignore")
    return f"{short}-{hashlib.sha1(name.encode()).hexdigest()[:8]}"


def render_scene(scene, options: argparse.Namespace) -> None:
    """`relume render`: for each frame the coefficient EXR and a picture for each illuminant; then summary.json."""
    if options.out.suffix.lower() in render.FORMATS and not options.out.is_dir():
        raise UsageError(f"{options.out}: expected a folder; the scene and the illuminants name the pictures")
    _prepare(scene, options.channels, options.samples)
    plain = _choose_illuminants(scene, options.illuminant)
    stem = Path(bpy.data.filepath).stem or "untitled"
    if scene.relume.plan.get("reason"):
        console.say(scene.relume.plan["reason"])
    if scene.cycles.use_denoising and not denoising.available():
        console.say("this Blender has no denoiser; the pictures keep their noise")
    with results.folder(options.out) as folder:
        for frame in [scene.frame_current] if options.frame is None else options.frame:
            name = stem if options.frame is None else f"{stem}_{frame:04d}"
            _claim_frame(scene, folder, name, plain, frame, options.resume)
        console.wrote(folder / "summary.json")


def _claim_frame(scene, folder: Path, name: str, plain: list[str], frame: int, resume: bool) -> None:
    """Render a frame, unless it is there or another process is at it and both may be left as they are."""
    scene.frame_set(frame)
    exr = folder / f"{name}.exr"
    pictures = {label: folder / f"{name}_{file_name(label)}.png" for label in plain or [_own_mix(scene)]}
    if len({path.name.casefold() for path in pictures.values()}) < len(pictures):
        raise UsageError(f"{', '.join(pictures)}: two of these illuminants would give pictures of one name")
    for path in (exr, *pictures.values(), folder / "summary.json"):
        results.expect(path)

    def wait() -> None:
        console.say(f"{exr}: another process renders this frame; waiting for it to end")

    with results.claim(exr, None if resume else wait) as claimed:
        if not claimed:
            console.say(f"{exr}: another process renders this frame; skipped")
        elif resume and _is_whole(scene, exr, pictures.values()):
            console.say(f"{exr}: kept")
        else:
            _render_frame(scene, exr, pictures, bool(plain), frame)


def _own_mix(scene) -> str:
    return "+".join(dict.fromkeys(row.label for row in scene.relume.lit))


def _is_whole(scene, exr: Path, pictures: Iterable[Path]) -> bool:
    """Whether a frame is there, newer than the .blend, of as many channels as asked for, and can be read."""
    blend = Path(bpy.data.filepath)
    if not all(_is_newer(path, blend) for path in (exr, *pictures)):
        return False
    try:
        for path in pictures:
            coefficients.read_rgb(path)
        return coefficients.read(exr).model.to_dict() == scene.relume.model().to_dict()
    except CoefficientImageError as error:
        console.say(f"{error}; rendered again")
        return False


def _render_frame(scene, exr: Path, names: dict[str, Path], plain: bool, frame: int) -> None:
    """Render the current frame; names: {illuminant: its picture}. All files appear at the end, or none."""
    progress = console.Progress(scene.relume.model().passes, f"rendering {exr.stem}")
    denoises = scene.cycles.use_denoising and denoising.available()
    try:
        rendered = render.render(scene, exr.parent, progress, denoising.guides_of(scene) if denoises else None)
    finally:
        progress.done()
    image = replace(rendered.image, shows=expected.seen(scene))
    lights = dict(zip(image.groups, scene.relume.lights(), strict=True))
    mixes = dict.fromkeys(names, lights)
    if plain:
        # The scene's own mix is a picture of its own only where the caller asked for no other
        mixes = {n: {g: replace(light, illuminant=library.illuminant(n)) for g, light in lights.items()} for n in names}
    sampled, prefilter = replace(image, groups=rendered.sampled), denoising.prefilter_of(scene)
    clean = denoising.denoised_image(sampled, rendered.guides, prefilter) if denoises else image
    written = [exr, *names.values()]
    summary = exr.with_name("summary.json")
    record = {
        "frame": frame,
        "scene": bpy.data.filepath,
        "channels": image.model.channels,
        "reduced_color_noise": scene.relume.shares_brightness,
        "size": list(image.size),
        "samples": {layer: times["samples"] for layer, times in rendered.times.items()},
        "seconds": {layer: times["seconds"] for layer, times in rendered.times.items()},
        "light_groups": {group: light.illuminant.name for group, light in lights.items()},
        "illuminants": list(mixes),
        "expected": {label: expected.of(image, image.mix(mix)) for label, mix in mixes.items()},
        "files": [path.name for path in written],
    }
    with ExitStack() as until_there, results.together():
        coefficients.write(exr, image, render.picture(image, lights))
        for label, mix in mixes.items():
            render.save_picture(names[label], render.picture(clean, mix), image)
        until_there.enter_context(results.claim(summary, waiting=lambda: None))
        results.write_text(summary, _summary(scene, summary, record))
    for path in written:
        console.wrote(path)
    for label, found in record["expected"].items():
        expected.tell(found, image, label)


def _summary(scene, path: Path, record: dict) -> str:
    """summary.json with one more frame, or with a frame replaced; what other runs noted stays."""
    settings = scene.relume
    head = {"scene": bpy.data.filepath, "channels": settings.model().channels, "passes": settings.model().passes}
    head |= {"model": settings.model().name, "reason": settings.plan.get("reason", "")}
    frames = {each["files"][0]: each for each in _noted(path)}
    frames[record["files"][0]] = record
    ordered = sorted(frames.values(), key=lambda each: (each["files"][0].rpartition("_")[0], each["frame"]))
    return json.dumps(head | {"frames": ordered}, indent=2, ensure_ascii=False) + "\n"


def _noted(path: Path) -> list[dict]:
    """The frames in a summary.json. Raises ResultError for a file that is something else."""
    try:
        frames = json.loads(path.read_text(encoding="utf-8"))["frames"]
        if all(isinstance(each["files"][0], str) and isinstance(each["frame"], int) for each in frames):
            return frames
    except FileNotFoundError:
        return []
    except (ValueError, TypeError, LookupError):
        pass
    raise ResultError(f"{path}: not a summary that Relume wrote; move it away, or choose another folder")


def lights_of(image: CoefficientImage, chosen: list[str], kept: dict | None = None) -> dict[str, Light]:
    """A light for each group of a coefficient image, from GROUP=ILLUMINANT[*GAIN] where one is given.

    kept: a mix that was saved, as `mix_file.mix_from` returns it; what is chosen comes after it.
    """
    lights = {group: Light(image.illuminants[group], image.gains.get(group, 1.0)) for group in image.illuminants}
    if kept is not None:
        lights |= mix_file.lights_in(kept, list(lights))
    for text in chosen:
        group, equals, what = text.rpartition("=")
        name, star, gain = what.partition("*")
        if not equals:
            raise UsageError(f"--light {text}: expected GROUP=ILLUMINANT or GROUP=ILLUMINANT*GAIN")
        if group not in lights:
            raise UsageError(f"no light group {group!r} in the file; it has {', '.join(lights)}")
        try:
            gained = arguments.number(gain, *GAINS) if star else 1.0
        except UsageError as error:
            raise UsageError(f"--light {text}: the gain {error}") from error
        parts = tuple((library.illuminant(part), weight) for part, weight in arguments.blend(name))
        lights[group] = Light(mixing.blend(parts) if parts else _illuminant(name), gained)
    return lights


def _illuminant(name: str) -> Spectrum:
    """An illuminant of the library, or FILE#COLUMN for one of a file of spectra. Raises LibraryError, SpectrumError."""
    path, mark, column = name.rpartition("#")
    if not mark:
        return library.illuminant(name)
    found = {spectrum.name: spectrum for spectrum in files.read(path, "illuminant")}
    if column not in found:
        raise UsageError(f"{path} has no column {column!r}; it has {', '.join(found)}")
    return found[column]


def relight_file(options: argparse.Namespace) -> None:
    """`relume relight`: pictures of a coefficient EXR, or of a sequence, under other illuminants."""
    if options.out.suffix.lower() not in render.FORMATS:
        raise UsageError(f"{options.out}: a picture's name ends in {', '.join(render.FORMATS)}")
    sources = _sources(options.coefficients, options.out)
    _check_apart(sources)
    waiting = {out: source for out, source in sources.items() if not (options.resume and _is_newer(out, source))}
    found = coefficients.describe_all(waiting.values(), options.described, options.layer)
    for source, image in zip(waiting.values(), found, strict=True):  # says what is wrong before any picture is made
        lights_of(image, options.light, options.kept)
        if options.out.suffix.lower() != ".exr":
            render.check_view(source, image)
    if options.kept is not None and options.kept["balance"].get("white_source", "MIX") != "MIX":
        console.say("the saved mix takes its white from a light group or a pixel; here it is that of all light")
    if waiting:
        _remark(next(iter(waiting.values())), options)
    with results.folder(options.out.parent):
        for out in waiting:
            results.expect(out)
        for number, (out, image, rgb) in enumerate(_relit(waiting, options), 1):
            render.save_picture(out, rgb, image)
            console.wrote(out)
            if len(sources) > 1:
                done = len(sources) - len(waiting) + number
                console.event("relit", number=done, of=len(sources)) or print(
                    f"relit {done} of {len(sources)}", file=sys.stderr, flush=True
                )
    if waiting:
        image, mix = found[0], found[0].mix(lights_of(found[0], options.light), options.white)
        expected.tell(expected.of(image, mix), image)


def _check_apart(sources: dict[Path, Path]) -> None:
    """Raise UsageError where a picture would take the place of coefficients, by whatever name or link."""
    taken = {_identity(source) for source in sources.values()} - {None}
    for out in sources:
        if _identity(out) in taken:
            raise UsageError(f"{out}: holds coefficients to be relit; choose another name for the picture")


def _identity(path: Path) -> tuple[int, int] | None:
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_dev, found.st_ino


def _remark(source: Path, options: argparse.Namespace) -> None:
    """Say what was chosen for the user where an EXR of another Blender's holds more than one picture or mix."""
    if coefficients.is_own(source):
        return
    found = description.of_file(source, options.described)
    first, *others = found.layers
    if others and options.layer is None:
        console.say(f"took view layer {first!r}; --layer takes {', '.join(map(repr, others))}")
    if found.animated:
        console.say("the mix is animated; took that of the frame at which the scene was saved")


def describe_scene(out: Path | None) -> None:
    """`relume describe`: a sidecar for what other Blenders render of the open file."""
    described = describe.of_open_file()
    out = out or Path(f"{Path(bpy.data.filepath).stem or 'untitled'}{description.SUFFIX}")
    with results.folder(out.parent):
        description.write(out, described)
    console.wrote(out)


def _sources(path: Path, out: Path) -> dict[Path, Path]:
    """{picture: its coefficients}, of one file or of a sequence. Raises SequenceError."""
    if not sequences.is_pattern(path):
        return {out: path}
    if not sequences.is_pattern(out):
        raise SequenceError(f"{out}: expected #### for the frame number, as in {path.name}")
    return {sequences.numbered(out, frame): source for frame, source in sequences.files(path).items()}


def _is_newer(out: Path, source: Path) -> bool:
    return out.is_file() and source.is_file() and out.stat().st_mtime >= source.stat().st_mtime


def _seen(image: CoefficientImage, kept: dict | None) -> CoefficientImage:
    """A coefficient image, seen as a saved mix says: by its observer, adapted to its own white. Raises RelumeError."""
    if kept is None:
        return image
    balance = {"observer": image.observer, "white_balance_method": image.white_balance_method} | kept["balance"]
    observed = balance["observer"]
    observer = mixes.stored_observer(balance["observer_measured"]) if observed == mixes.FILE else observed
    return replace(image, white=None, white_balance_method=balance["white_balance_method"], observer=observer)


def _relit(waiting: dict[Path, Path], options: argparse.Namespace) -> Iterator:
    """Yield (path, coefficient image, picture) of each file, in order; a frame for each core is worked on ahead."""

    def relit(item: tuple[Path, Path]) -> tuple[Path, CoefficientImage, np.ndarray]:
        out, source = item
        return out, *coefficients.relit(source, matrices, options.described, options.layer)

    def matrices(image: CoefficientImage) -> np.ndarray:
        lights = lights_of(image, options.light, options.kept)
        return recombination.recombination_matrices(image.model, _seen(image, options.kept).mix(lights, options.white))

    cores = os.cpu_count() or 1
    items, ahead = iter(waiting.items()), deque()
    with ThreadPoolExecutor(cores) as pool:
        for item in islice(items, cores):
            ahead.append(pool.submit(relit, item))
        while ahead:
            done = ahead.popleft().result()
            for item in islice(items, 1):
                ahead.append(pool.submit(relit, item))
            yield done
