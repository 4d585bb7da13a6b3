"""The page: everything that it shows and knows, in one HTML file that needs nothing else."""

import base64
import gzip
import hashlib
import html
import json
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path

import numpy as np

from .. import results
from ..colour.spaces import ADAPTATIONS, rgb_to_xyz, xyz_to_rgb
from ..errors import CoefficientImageError, UsageError
from ..model.factor_model import FactorModel
from ..picture.coefficient_image import CoefficientImage
from ..spectra import library
from ..spectra.spectrum import Spectrum
from . import encoding, lamps, luts

__all__ = ["Picture", "shrunk", "write"]

HERE = Path(__file__).parent
SCRIPTS = ("data.js", "mix.js", "gl.js", "cpu.js", "words.js", "spectrum.js", "mixer.js", "relight.js")
_GAMMA = (0.01, 5.0)  # Blender's
_EXPOSURE = (-32.0, 32.0)

# What Blender shows of a picture: (linear RGB, image) -> sRGB, 0..1
Show = Callable[[np.ndarray, CoefficientImage], np.ndarray]


@dataclass(frozen=True)
class Picture:
    """What a page shows under one name: a coefficient image, or the frames of a sequence by their numbers."""

    name: str
    frames: Mapping[int, Callable[[], CoefficientImage]]


@dataclass
class _Page:
    """A page as it grows: `data` for JSON, the numbers of tables, and the files of planes."""

    data: dict
    tables: list[np.ndarray] = field(default_factory=list)
    planes: list[bytes] = field(default_factory=list)
    length: int = 0

    def table(self, values: np.ndarray) -> list[int]:
        """Keep numbers; where a page finds them: the first of them, and their shape."""
        values = np.asarray(values, np.float32)
        self.tables.append(values.ravel())
        self.length += values.size
        return [self.length - values.size, *values.shape]

    def plane(self, data: bytes) -> int:
        """Keep a file; its number."""
        self.planes.append(data)
        return len(self.planes) - 1


def write(
    out: Path,
    pictures: Sequence[Picture],
    *,
    names: Sequence[str] = ("all",),
    size: int | None = 1920,
    quality: float = 1.0,
    title: str = "",
    bare: bool = False,
    show: Show | None = None,
    progress: Callable[[str], None] = lambda words: None,
) -> dict[str, float]:
    """Write a page of `pictures` whose lamps are `names`; 98 % of each are within `quality` ΔE under all of them.

    size: pixels of the longer side, at most; None keeps them all. bare: without the interface. show: how Blender shows
    a picture that is not plain sRGB; without it, it is shown as that. The file appears whole or not at all.
    Returns what was reached, {picture: ΔE}. Raises LibraryError, CoefficientImageError, UsageError, ResultError.
    """
    if not pictures:
        raise UsageError(f"{out}: there is no picture to show")
    families = lamps.chosen(names)
    first = [next(iter(picture.frames.values()))() for picture in pictures]
    known = _Lamps({name: library.illuminant(name) for name in families}, families)
    seen_by = lamps.observers(first[0].observer)
    seen_by += [image.observer for image in first[1:] if image.observer not in seen_by]
    rendered = [known.indices(image) for image in first]
    page = _Page(_head(title or " · ".join(picture.name for picture in pictures), bare, seen_by))
    page.data["lamps"] = known.catalogue()
    page.data["lampPower"] = page.table(lamps.power(known.spectra))
    page.data["kinds"] = {kind: _kind(page, kind) for kind in lamps.KINDS}
    models: dict[str, int] = {}
    reached = {}
    for picture, image, own in zip(pictures, first, rendered, strict=True):
        described = json.dumps(image.model.to_dict())
        if described not in models:
            progress(f"{picture.name}: lamps")
            models[described] = len(models)
            page.data["models"].append(_model(page, image.model, known.spectra, seen_by))
        seen = seen_by.index(image.observer)
        matrices = lamps.matrices(image.model, known.spectra[: len(families)], [image.observer])[0]
        entry = {"name": picture.name, "model": models[described], "observer": seen}
        entry |= _look(page, image, own, show)
        frames, reached[picture.name] = _frames(page, picture, image, matrices, size, quality, progress)
        page.data["pictures"].append(entry | frames)
    results.write_text(out, _html(page))
    return reached


class _Lamps:
    """The lamps of a page: those chosen, then what files bring with them."""

    def __init__(self, chosen: Mapping[str, Spectrum], families: Mapping[str, str]):
        self.names = list(chosen)
        self.spectra = list(chosen.values())
        self.families = dict(families)
        self.own: set[str] = set()

    def indices(self, image: CoefficientImage) -> list[int]:
        """The number of what lit each light group of an image, which a page knows from now on."""
        return [self._index(image.illuminants[group]) for group in image.groups]

    def _index(self, spectrum: Spectrum) -> int:
        for number, known in enumerate(self.spectra):
            if np.array_equal(known.sampled(), spectrum.sampled()):
                return number
        taken, name = set(self.names), spectrum.name or lamps.RENDERED
        while name in taken:
            name += " *"
        if not _in_library(spectrum):
            self.own.add(name)
        self.names.append(name)
        self.spectra.append(spectrum)
        self.families[name] = lamps.RENDERED
        return len(self.names) - 1

    def catalogue(self) -> list[dict]:
        entries = lamps.catalogue(dict(zip(self.names, self.spectra, strict=True)), self.families)
        return [entry | {"own": entry["name"] in self.own} for entry in entries]


def _in_library(spectrum: Spectrum) -> bool:
    """Whether `relume relight` finds a spectrum by its name."""
    try:
        return np.array_equal(library.illuminant(spectrum.name).sampled(), spectrum.sampled())
    except ValueError:
        return False
    except KeyError:
        return False


def _head(title: str, bare: bool, seen_by: Sequence) -> dict:
    return {
        "title": title,
        "bare": bare,
        "observers": [one if isinstance(one, str) else lamps.RENDERED for one in seen_by],
        "xyzToRgb": xyz_to_rgb().ravel().tolist(),
        "white": rgb_to_xyz().sum(axis=1).tolist(),
        "shared": encoding.SHARED,
        "adaptations": {name: matrix.ravel().tolist() for name, matrix in ADAPTATIONS.items()},
        "words": json.loads((HERE / "words.json").read_text(encoding="utf-8")),
        "models": [],
        "luts": [],
        "pictures": [],
    }


@cache
def _spectra_of(kind: str) -> tuple[Spectrum, ...]:
    return tuple(lamps.temperature_spectra(kind))


def _kind(page: _Page, kind: str) -> dict:
    return {
        "range": list(lamps.KINDS[kind][1:3]),
        "mireds": page.table(1e6 / lamps.temperatures(kind)),
        "power": page.table(lamps.power(_spectra_of(kind))),
    }


def _model(page: _Page, model: FactorModel, spectra: Sequence[Spectrum], seen_by: Sequence) -> dict:
    rebuilt = np.stack(
        [np.interp(lamps.WAVELENGTHS, model.wavelengths, row) for row in model.reconstruct(np.eye(model.channels))]
    )
    return {
        "channels": model.channels,
        "spectrum": page.table(rebuilt),
        "lamps": page.table(lamps.matrices(model, spectra, seen_by)),
        **{kind: page.table(lamps.matrices(model, _spectra_of(kind), seen_by)) for kind in lamps.KINDS},
    }


def _number(value: object, low: float, high: float, otherwise: float) -> float:
    return float(value) if isinstance(value, (int, float)) and low <= value <= high else otherwise


def _look(page: _Page, image: CoefficientImage, own: Sequence[int], show: Show | None) -> dict:
    """How a picture was lit and shown when it was rendered."""
    view = {"exposure": _number(image.view.get("exposure"), *_EXPOSURE, 0.0), "lut": None}
    view["gamma"] = _number(image.view.get("gamma"), *_GAMMA, 1.0)
    if show is not None and not luts.is_plain(image.view):
        unexposed = replace(image, view={**image.view, "exposure": 0.0})
        lut = luts.bake(lambda rgb: show(rgb, unexposed), image.space)
        entry = {"size": len(lut.values), "range": list(luts.STOPS), "matrix": lut.matrix.ravel().tolist()}
        page.data["luts"].append(entry | {"values": page.table(lut.values)})
        view["lut"] = len(page.data["luts"]) - 1
    groups = zip(image.groups, own, strict=True)
    return {
        "groups": [{"name": name, "lamp": lamp, "gain": image.gains.get(name, 1.0)} for name, lamp in groups],
        "whiteBalance": image.white_balance,
        "method": image.white_balance_method,
        "white": None if image.white is None else [float(value) for value in image.white],
        "view": view,
    }


def _frames(
    page: _Page,
    picture: Picture,
    first: CoefficientImage,
    matrices: np.ndarray,
    size: int | None,
    quality: float,
    progress: Callable[[str], None],
) -> tuple[dict, float]:
    frames, reached, shape = [], 0.0, (0, 0)
    chosen = None
    for number, read in picture.frames.items():
        image = first if number == next(iter(picture.frames)) else read()
        if list(image.groups) != list(first.groups) or image.size != first.size:
            raise CoefficientImageError(
                f"{picture.name}, frame {number}: other light groups or size than the first frame"
            )
        image = shrunk(image, size)
        shape = image.size
        exposure = _number(image.view.get("exposure"), *_EXPOSURE, 0.0)
        if chosen is None:
            progress(f"{picture.name}: quality")
            chosen = encoding.quality_for(image.groups, matrices, exposure, quality)
        progress(f"{picture.name}: frame {number}" if len(picture.frames) > 1 else f"{picture.name}: picture")
        coded, chosen, found = encoding.encode_within(quality, image.groups, matrices, exposure, chosen)
        reached = max(reached, found)
        frames.append({"number": number, "groups": [_group(page, each) for each in coded.values()], "alpha": None})
        if (image.alpha < 1.0).any():
            frames[-1]["alpha"] = page.plane(
                encoding.plane_bytes((np.clip(image.alpha, 0, 1) * 255 + 0.5).astype(np.uint8), 95)
            )
    return {"size": list(shape), "frames": frames}, reached


def _group(page: _Page, coded: encoding.Encoded) -> dict:
    return {
        "planes": [page.plane(data) for data in coded.planes],
        "tables": page.table(coded.tables),
        "basis": page.table(coded.basis),
        "floor": coded.floor,
    }


def shrunk(image: CoefficientImage, size: int | None) -> CoefficientImage:
    """A coefficient image whose longer side has at most `size` pixels; each is the mean of those that it stands for."""
    longer = max(image.size)
    if size is None or longer <= size:
        return image
    width, height = (max(1, round(side * size / longer)) for side in image.size)
    groups = {name: _resized(each, width, height) for name, each in image.groups.items()}
    return replace(image, groups=groups, alpha=_resized(image.alpha[..., None], width, height)[..., 0])


def _resized(pixels: np.ndarray, width: int, height: int) -> np.ndarray:
    import OpenImageIO as oiio

    source = oiio.ImageBuf(np.ascontiguousarray(pixels, np.float32))
    region = oiio.ROI(0, width, 0, height, 0, 1, 0, pixels.shape[2])
    return np.asarray(oiio.ImageBufAlgo.resize(source, filtername="box", roi=region).get_pixels(oiio.FLOAT))


def _compressed(numbers: np.ndarray) -> bytes:
    """Numbers of 24 bits, 16 of them the mantissa: all first bytes, then all second and third ones: it packs."""
    rounded = (numbers.astype("<f4").view("<u4").astype(np.uint64) + 0x80) >> 8
    three = rounded.astype("<u4").view(np.uint8).reshape(-1, 4)[:, :3]
    return gzip.compress(np.ascontiguousarray(three.T).tobytes(), 9, mtime=0)


def _packed(data: bytes) -> str:
    # No "<": nothing in it can end the script element or begin a comment
    return base64.b85encode(data).decode("ascii").replace("<", ",")


def _json(data: dict) -> str:
    """JSON that may stand in a script element: no character in it means anything to HTML."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)  # ASCII only
    return re.sub("[<>&]", lambda found: f"\\u{ord(found[0]):04x}", text)


def _digest(text: str) -> str:
    return "'sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() + "'"


def _html(page: _Page) -> str:
    script = "\n" + "\n".join((HERE / name).read_text(encoding="utf-8") for name in SCRIPTS)
    style = "\n" + (HERE / "page.css").read_text(encoding="utf-8")
    planes = (f'<script type="text/plain" id="plane{n}">{_packed(data)}</script>' for n, data in enumerate(page.planes))
    parts = {
        "title": html.escape(page.data["title"]),
        "policy": f"default-src 'none'; script-src {_digest(script)}; style-src {_digest(style)}; img-src blob: data:",
        "style": style,
        "script": script,
        "shader": "\n" + (HERE / "shader.glsl").read_text(encoding="utf-8"),
        "data": _json(page.data),
        "numbers": _packed(_compressed(np.concatenate(page.tables))),
        "planes": "\n".join(planes),
        "class": "bare" if page.data["bare"] else "whole",
    }
    template = (HERE / "page.html").read_text(encoding="utf-8")
    return re.sub(r"\{\{(\w+)\}\}", lambda found: parts[found[1]], template)
