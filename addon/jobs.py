"""What the commands do: render a scene into files, relight a file."""

import json
import os
import sys
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import islice
from pathlib import Path

import bpy

from ..core import coefficients, description, library, sequences, view
from . import denoise, describe, render, setup
from .setup import SetupError

__all__ = ["Progress", "describe_scene", "file_name", "relight_file", "render_scene", "writable"]


class Progress:
    """One line in a terminal that moves; in a log, one line for each pass."""

    def __init__(self, passes: int, words: str = "rendering"):
        self.passes, self.words, self.last = passes, words, -1
        self.moving = sys.stderr.isatty()

    def __call__(self, index: int, part: float):
        if self.moving:
            width = 30
            filled = round(width * (index + part) / self.passes)
            bar = "█" * filled + "·" * (width - filled)
            print(f"\r{self.words}  {bar}  pass {index + 1} of {self.passes}", end="", file=sys.stderr, flush=True)
        elif index != self.last:
            print(f"{self.words}: pass {index + 1} of {self.passes}", file=sys.stderr, flush=True)
        self.last = index

    def done(self):
        if self.moving and self.last >= 0:
            print(file=sys.stderr)


def writable(folder: Path) -> Path:
    """Make a folder for results, and make sure that files can be written there before anything long begins."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".relume-probe"
        probe.write_bytes(b"")
        probe.unlink()
    except OSError as error:
        raise OSError(f"{folder}: cannot write there ({error.strerror})") from error
    return folder


def _prepare(scene, channels: str | None, samples: int | None):
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
        if group not in scene.relume.light_groups:
            known = ", ".join(row.name for row in scene.relume.light_groups)
            raise SetupError(f"scene {scene.name!r} has no light group {group!r}; it has {known}")
        scene.relume.light_groups[group].source = "LIBRARY"
        scene.relume.light_groups[group].illuminant = name
    return plain


def file_name(text: str) -> str:
    """A name as part of a file's: without what some file systems forbid."""
    return "".join("-" if c in '/\\:*?"<>|' else c for c in text).replace(" ", "_")


def render_scene(scene, arguments):
    """`relume render`: the coefficient EXR, a picture for each illuminant, and summary.json."""
    _prepare(scene, arguments.channels, arguments.samples)
    settings = scene.relume
    plain = _choose_illuminants(scene, arguments.illuminant)
    folder = writable(arguments.out)
    stem = Path(bpy.data.filepath).stem or "untitled"
    frames = arguments.frame or [scene.frame_current]
    if settings.plan.get("reason"):
        print(settings.plan["reason"], file=sys.stderr)
    summary = {"scene": bpy.data.filepath, "channels": settings.model().channels, "passes": settings.model().passes}
    summary |= {"model": settings.model().name, "reason": settings.plan.get("reason", ""), "frames": []}
    for frame in frames:
        scene.frame_set(frame)
        name = stem if arguments.frame is None else f"{stem}_{frame:04d}"
        summary["frames"].append(_render_frame(scene, folder, name, plain, frame))
    path = folder / "summary.json"
    partial = path.with_suffix(".partial")
    partial.write_text(json.dumps(summary, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    partial.replace(path)
    print(path)


def _render_frame(scene, folder: Path, name: str, plain: list[str], frame: int) -> dict:
    progress = Progress(scene.relume.model().passes, f"rendering {name}")
    denoises = scene.cycles.use_denoising and denoise.available()
    if scene.cycles.use_denoising and not denoises:
        print("relume: this Blender has no denoiser; the pictures keep their noise", file=sys.stderr)
    try:
        rendered = render.render(scene, folder, progress, denoise.guides_of(scene) if denoises else None)
    finally:
        progress.done()
    image = rendered.image
    lights = dict(zip(image.groups, scene.relume.lights(), strict=True))
    mixes = {"+".join(dict.fromkeys(row.label for row in scene.relume.light_groups)): lights}
    if plain:
        # The scene's own mix is a picture of its own only where the caller asked for no other
        mixes = {n: {g: replace(light, illuminant=library.illuminant(n)) for g, light in lights.items()} for n in plain}
    clean = denoise.denoised_image(image, rendered.guides, denoise.prefilter_of(scene)) if denoises else image
    pictures = {n: render.picture(clean, mix) for n, mix in mixes.items()}
    lit = render.picture(image, lights)
    written = []
    try:
        path = folder / f"{name}.exr"
        coefficients.write(path, image, lit)
        written.append(path)
        for illuminant, rgb in pictures.items():
            path = folder / f"{name}_{file_name(illuminant)}.png"
            render.save_picture(path, rgb, image)
            written.append(path)
    except OSError:
        for path in written:
            path.unlink(missing_ok=True)
        raise
    for path in written:
        print(path)
    return {
        "frame": frame,
        "size": list(image.size),
        "samples": {layer: times["samples"] for layer, times in rendered.times.items()},
        "seconds": {layer: times["seconds"] for layer, times in rendered.times.items()},
        "light_groups": {group: light.illuminant.name for group, light in lights.items()},
        "illuminants": list(mixes),
        "files": [path.name for path in written],
    }


def _lights_of(image, chosen: list[str]) -> dict[str, view.Light]:
    """A light for each group of a coefficient image, from GROUP=ILLUMINANT[*GAIN] where one is given."""
    lights = {group: view.Light(image.illuminants[group], image.gains.get(group, 1.0)) for group in image.groups}
    for text in chosen:
        group, equals, what = text.rpartition("=")
        name, _, gain = what.partition("*")
        if not equals:
            raise ValueError(f"--light {text}: expected GROUP=ILLUMINANT or GROUP=ILLUMINANT*GAIN")
        if group not in lights:
            raise ValueError(f"no light group {group!r} in the file; it has {', '.join(lights)}")
        try:
            lights[group] = view.Light(library.illuminant(name), float(gain or 1.0))
        except ValueError as error:
            raise ValueError(f"--light {text}: {gain!r} is not a number") from error
    return lights


def relight_file(arguments):
    """`relume relight`: pictures of a coefficient EXR, or of a sequence, under other illuminants."""
    if arguments.out.suffix.lower() not in render.FORMATS:
        raise ValueError(f"{arguments.out}: a picture's name ends in {', '.join(render.FORMATS)}")
    sources = _sources(arguments.coefficients, arguments.out)
    waiting = {out: source for out, source in sources.items() if not (arguments.resume and _is_newer(out, source))}
    found = coefficients.describe_all(waiting.values(), arguments.described, arguments.layer)
    for source, image in zip(waiting.values(), found, strict=True):  # tells what is wrong before any picture is made
        _lights_of(image, arguments.light)
        if arguments.out.suffix.lower() != ".exr":
            render.check_view(source, image)
    if waiting:
        _remark(next(iter(waiting.values())), arguments)
    writable(arguments.out.parent)
    for number, (out, image, rgb) in enumerate(_relit(waiting, arguments), 1):
        render.save_picture(out, rgb, image)
        print(out, flush=True)
        if len(sources) > 1:
            done = len(sources) - len(waiting) + number
            print(f"relit {done} of {len(sources)}", file=sys.stderr, flush=True)


def _remark(source: Path, arguments):
    """Say what was chosen for the user where an EXR of another Blender's holds more than one picture or mix."""
    if coefficients.is_own(source):
        return
    found = description.of_file(source, arguments.described)
    first, *others = found.layers
    if others and arguments.layer is None:
        print(f"relume: took view layer {first!r}; --layer takes {', '.join(map(repr, others))}", file=sys.stderr)
    if found.animated:
        print("relume: the mix is animated; took that of the frame at which the scene was saved", file=sys.stderr)


def describe_scene(out: Path | None):
    """`relume describe`: a sidecar for what other Blenders render of the open file."""
    described = describe.of_open_file()
    out = out or Path(f"{Path(bpy.data.filepath).stem or 'untitled'}{description.SUFFIX}")
    writable(out.parent)
    description.write(out, described)
    print(out)


def _sources(path: Path, out: Path) -> dict[Path, Path]:
    """{picture: its coefficients}, of one file or of a sequence. Raises SequenceError."""
    if not sequences.is_pattern(path):
        return {out: path}
    if not sequences.is_pattern(out):
        raise sequences.SequenceError(f"{out}: expected #### for the frame number, as in {path.name}")
    return {sequences.numbered(out, frame): source for frame, source in sequences.files(path).items()}


def _is_newer(out: Path, source: Path) -> bool:
    return out.is_file() and source.is_file() and out.stat().st_mtime >= source.stat().st_mtime


def _relit(waiting: dict[Path, Path], arguments):
    """Yield (path, coefficient image, picture) of each file, in order; a frame for each core is worked on ahead."""

    def relit(item):
        out, source = item
        image = coefficients.read(source, arguments.described, arguments.layer)
        return out, image, render.picture(image, _lights_of(image, arguments.light), arguments.white)

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
