"""What may be typed after `relume`: the commands, their options, and the ranges of their numbers."""

import argparse
import io
import json
import re
import shlex
from contextlib import redirect_stderr
from functools import partial
from pathlib import Path

from ...core.errors import RelumeError, UsageError
from ...core.picture.mix import GAINS
from ...core.spectra.spectrum import WAVELENGTHS
from ..store import mix_file, properties

__all__ = ["QUALITIES", "REPORTS", "SIZES", "mix", "number", "parse"]

# Commands of the core, which read their own arguments.
REPORTS = {
    "tables": "the tables of Drew & Finlayson (2003), made again",
    "stability": "what every model does with difficult input",
    "palette": "lights and reflectances designed together",
}

FRAMES = (-1048574, 1048574)  # Blender's
SAMPLES = (1, 1 << 24)  # of Cycles
PERCENT = (1, 32767)  # of Blender's resolution
SIZES = (16, 8192)  # pixels of the longer side of a web page's pictures
QUALITIES = (0.1, 20.0)  # ΔE of a web page

_SCENE = "what the file was rendered from, for renders whose note does not say enough"
_LAYER = "one of the artist's view layers; default: the first"
_MODELS = ("rgb", "prefiltered", "sharpened", "block", "fitted")
_CHANNELS = [name for name, *_ in properties.CHANNELS]
_RANGE = re.compile(r"(-?[0-9]+)(?:-(-?[0-9]+))?")
_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
# What Blender's own output path fills in
_TEMPLATE = re.compile(r"\{(blend_(name|dir)(_lib)?|fps|resolution_[xy]|scene_name|camera_name|node_name)(:[^{}]*)?\}")


def parse(argv: list[str], in_blender: bool) -> argparse.Namespace:
    """The command and its options. Exits as argparse does: 2 for wrong usage, 0 after help."""
    told = _parser(in_blender).parse_args(_joined(argv))
    told.kept = None
    if getattr(told, "mix", None) is not None:
        told.light, told.kept = told.mix.light + told.light, told.mix.kept
        told.white = told.mix.white if told.white is None else told.white
    return told


def mix(words: str) -> argparse.Namespace:
    """The light and white that a mix says: what Copy Mix gives, or a file of it. Raises ArgumentTypeError.

    kept: what a JSON file of Save Mix says of the mixer, None for words.
    """
    try:
        words = mix_file.read(Path(words)) if words.endswith((".json", ".txt")) else words
        if mix_file.is_json(words):
            kept = mix_file.mix_from(words)
            white = kept["balance"].get("white_balance", 0.0)
            return argparse.Namespace(light=[], white=white, kept=kept)
    except RelumeError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
    parser = argparse.ArgumentParser(add_help=False, exit_on_error=False, allow_abbrev=False)
    _add_lights(parser)
    try:
        with redirect_stderr(io.StringIO()):
            told = parser.parse_args(shlex.split(words))
    except (argparse.ArgumentError, ValueError, SystemExit):
        told = None
    if told is None or not (told.light or told.white is not None):
        raise argparse.ArgumentTypeError("not a mix: expected --light 'GROUP=ILLUMINANT*GAIN' … --white 0..1")
    told.kept = None
    return told


def _add_lights(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--light",
        metavar="GROUP=ILLUMINANT[*GAIN]",
        nargs="+",
        action="extend",
        default=[],
        help="what lights a group, the others stay as they were rendered; ILLUMINANT: a name, FILE#COLUMN, or a blend "
        f'as [["D65", 0.25], ["A", 0.75]]; GAIN: 0 to {GAINS[1]:.0f}',
    )
    parser.add_argument("--white", type=_white, metavar="none|full|0..1", help="white balance")


def _joined(argv: list[str]) -> list[str]:
    """What argparse would take for an option: --frame -10--5 as --frame=-10--5, a file -x.blend as ./-x.blend."""
    joined = []
    for text in argv:
        if text.startswith("-") and text.endswith((".blend", ".exr")) and "=" not in text:
            text = f"./{text}"
        if joined and joined[-1] == "--frame" and "--" not in joined and _RANGE.fullmatch(text):
            joined[-1] += f"={text}"
        else:
            joined.append(text)
    return joined


def _parser(in_blender: bool) -> argparse.ArgumentParser:
    program = "blender -b SCENE.blend -c relume" if in_blender else "relume"
    parser = argparse.ArgumentParser(prog=program, description="Spectral rendering, and the light chosen afterwards.")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)

    render = commands.add_parser("render", help="render a scene's spectral coefficients, and pictures of them")
    _add_scene(render, in_blender)
    render.add_argument("--channels", choices=_CHANNELS, help="auto: as few as needed; default: what the scene says")
    render.add_argument(
        "--illuminant",
        metavar="[GROUP=]NAME",
        nargs="+",
        action="extend",
        default=[],
        help="NAME: a picture with this illuminant in every light group; GROUP=NAME: what lights a group of the scene",
    )
    render.add_argument("--samples", type=_samples, metavar="N", help="samples per pixel, shared among the passes")
    render.add_argument("--frame", type=_frames, metavar="N | A-B", help="frame or frames instead of the current one")
    _add_out(render, "DIR", "folder for the results, // for that of the .blend; default: this one", default=".")
    render.add_argument(
        "--resume",
        action="store_true",
        help="keep frames that are whole and newer than the .blend, and leave those that another process renders to it",
    )

    relight = commands.add_parser("relight", help="a new picture of a coefficient EXR, without rendering")
    relight.add_argument(
        "coefficients", metavar="COEFFICIENTS.exr", type=_path, help="a file, or a sequence such as shot.####.exr"
    )
    _add_lights(relight)
    relight.add_argument(
        "--mix",
        metavar="MIX.json | WORDS",
        type=mix,
        help="a file of Save Mix in Blender, or what Copy Mix gives on a page of `relume web`, in quotes or in a file; "
        "--light and --white come after it",
    )
    relight.add_argument(
        "--scene",
        dest="blend",
        metavar="SCENE.blend",
        type=_path,
        help=_SCENE,
    )
    relight.add_argument("--layer", metavar="NAME", help=_LAYER)
    _add_out(relight, "PICTURE", "PICTURE.png, .tif or .exr; with #### for a sequence", required=True)
    relight.add_argument(
        "--resume", action="store_true", help="keep the pictures that are there and newer than their coefficients"
    )

    describe = commands.add_parser("describe", help="a sidecar for what other Blenders render of a scene")
    _add_scene(describe, in_blender)
    _add_out(describe, "FILE.json", "default: SCENE.relume.json in this folder; put it beside the EXRs")

    web = commands.add_parser("web", help="a web page of a coefficient EXR, in which anyone can choose the light")
    words = "a file, a sequence such as shot.####.exr, or a folder of files"
    web.add_argument("coefficients", metavar="COEFFICIENTS.exr|FOLDER", type=_path, help=words)
    words = "illuminants to choose from; default: all"
    web.add_argument("--lamps", metavar="NAME", nargs="+", action="extend", default=[], help=words)
    words = "the longer side at most; default: 1920"
    web.add_argument("--size", type=_size, metavar="PIXELS", default=1920, help=words)
    words = "what 98 %% of the picture keeps to under all lamps, against `relume relight`; default: 1"
    web.add_argument("--quality", type=_quality, metavar="ΔE", default=1.0, help=words)
    web.add_argument("--title", metavar="TEXT", default="", help="default: the names of the files")
    web.add_argument("--bare", action="store_true", help="the picture alone, to embed in another page")
    _add_out(web, "PAGE.html", "the page", required=True)
    web.add_argument("--scene", dest="blend", metavar="SCENE.blend", type=_path, help=_SCENE)
    web.add_argument("--layer", metavar="NAME", help=_LAYER)

    demo = commands.add_parser("demo", help="render the test room and relight it")
    _add_out(demo, "DIR", "folder for the results", default="out/demo")

    report = commands.add_parser("report", help="error against run time of a scene, for every model")
    _add_scene(report, in_blender)
    report.add_argument("--channels", type=_channels, nargs="+", metavar="P", default=[3, 6, 9, 12, 15])
    report.add_argument("--models", choices=_MODELS, nargs="+", default=["rgb", "prefiltered", "fitted"])
    report.add_argument("--samples", type=_samples, metavar="N", help="samples per pixel")
    report.add_argument("--percent", type=_percent, metavar="P", help="resolution, of the scene's own")
    report.add_argument("--frame", type=_frame, metavar="N", help="frame instead of the current one")
    _add_out(report, "DIR", "folder for the report, // for that of the .blend", default="report")

    for name, words in REPORTS.items():
        commands.add_parser(name, help=words, add_help=False)
    return parser


def _add_scene(parser: argparse.ArgumentParser, in_blender: bool) -> None:
    if in_blender:
        parser.set_defaults(scene=None)
    else:
        parser.add_argument("scene", metavar="SCENE.blend", type=_path)


def _add_out(parser: argparse.ArgumentParser, metavar: str, words: str, **options) -> None:
    parser.add_argument("--out", type=_out, metavar=metavar, help=words, **options)


def number(text: str, low: float, high: float) -> float:
    """A plain decimal number of a range. Raises UsageError, which says the range."""
    value = float(text) if _NUMBER.fullmatch(text) else float("nan")
    if not low <= value <= high:
        raise UsageError(f"{text!r} is not a number from {low:.7g} to {high:.7g}")
    return value


def blend(text: str) -> list[tuple[str, float]]:
    """Illuminants and weights of a blend, [["D65", 0.25], ["A", 0.75]]; none where it is a name. Raises UsageError."""
    if not text.startswith("["):
        return []
    try:
        parts = [(name, float(weight)) for name, weight in json.loads(text)]
        if parts and all(isinstance(name, str) and 0.0 <= weight <= 1.0 for name, weight in parts):
            return parts
    except (ValueError, TypeError, RecursionError):
        pass
    raise UsageError(f'{text}: expected a blend as [["D65", 0.25], ["A", 0.75]], weights from 0 to 1')


def _whole(text: str, low: int, high: int) -> int:
    """A whole number in plain digits."""
    # 20 digits are out of every range, and Python reads no more than 4300
    if not re.fullmatch("-?[0-9]+", text):
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from {low} to {high}")
    value = int(text[:20])
    if value < low:
        raise argparse.ArgumentTypeError(f"{text} is not {low} or more and at most {high}")
    if value > high:
        raise argparse.ArgumentTypeError(f"{text} is more than {high}")
    return value


_samples, _percent, _channels, _frame, _size = (
    partial(_whole, low=low, high=high) for low, high in (SAMPLES, PERCENT, (1, WAVELENGTHS.size), FRAMES, SIZES)
)


def _frames(text: str) -> range:
    found = _RANGE.fullmatch(text)
    if not found:
        raise argparse.ArgumentTypeError(f"{text!r} is not a frame or frames, such as 12, 1-250 or -10--5")
    first = _frame(found[1])
    last = _frame(found[2]) if found[2] else first
    if last < first:
        raise argparse.ArgumentTypeError(f"{text}: the last frame comes before the first")
    return range(first, last + 1)


def _white(text: str) -> float:
    degree = {"none": 0.0, "full": 1.0}.get(text)
    try:
        return number(text, 0, 1) if degree is None else degree
    except UsageError as error:
        raise argparse.ArgumentTypeError(f"{text} is not none, full or a number from 0 to 1") from error


def _quality(text: str) -> float:
    try:
        return number(text, *QUALITIES)
    except UsageError as error:
        raise argparse.ArgumentTypeError(str(error)) from error


def _path(text: str) -> str:
    try:
        text.encode()
    except UnicodeEncodeError:
        raise argparse.ArgumentTypeError(f"{ascii(text)}: Blender needs names in UTF-8") from None
    if not text.strip():
        raise argparse.ArgumentTypeError(f"{text!r} names no file")
    return text


def _out(text: str) -> str:
    template = _TEMPLATE.search(_path(text))
    if template:
        raise argparse.ArgumentTypeError(f"{text}: {template[0]} is filled in by Blender only; write the name itself")
    return text
