"""The command line: `relume …` in a Python environment with bpy, `blender -b SCENE.blend -c relume …` in Blender.

Exit status: 0 done, 1 failed with one line that says what and where, 2 wrong usage.
"""

import argparse
import importlib
import os
import sys
from pathlib import Path

import bpy

from . import properties

__all__ = ["blender_command", "execute", "main", "register", "unregister"]

# Commands of the core, which read their own arguments.
_REPORTS = {
    "tables": "the tables of Drew & Finlayson (2003), made again",
    "stability": "what every model does with difficult input",
    "palette": "lights and reflectances designed together",
}

_MODELS = ("rgb", "prefiltered", "sharpened", "block", "fitted")
_CHANNELS = [name for name, _, _ in properties.CHANNELS]


def _arguments(in_blender: bool) -> argparse.ArgumentParser:
    program = "blender -b SCENE.blend -c relume" if in_blender else "relume"
    parser = argparse.ArgumentParser(prog=program, description="Spectral rendering, and the light chosen afterwards.")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)

    render = commands.add_parser("render", help="render a scene's spectral coefficients, and pictures of them")
    if in_blender:
        render.set_defaults(scene=None)
    else:
        render.add_argument("scene", metavar="SCENE.blend", type=Path)
    render.add_argument("--channels", choices=_CHANNELS, help="auto: as few as needed; default: what the scene says")
    render.add_argument(
        "--illuminant",
        metavar="[GROUP=]NAME",
        nargs="+",
        action="extend",
        default=[],
        help="NAME: a picture with this illuminant in every light group; GROUP=NAME: what lights a group of the scene",
    )
    render.add_argument("--samples", type=_positive, metavar="N", help="samples per pixel, shared among the passes")
    render.add_argument("--frame", type=_frames, metavar="N | A-B", help="frame or frames instead of the current one")
    render.add_argument("--out", type=Path, metavar="DIR", default=Path(), help="folder for the results")

    relight = commands.add_parser("relight", help="a new picture of a coefficient EXR, without rendering")
    relight.add_argument(
        "coefficients", metavar="COEFFICIENTS.exr", type=Path, help="a file, or a sequence such as shot.####.exr"
    )
    relight.add_argument(
        "--light",
        metavar="GROUP=ILLUMINANT[*GAIN]",
        nargs="+",
        action="extend",
        default=[],
        help="what lights a group; the others stay as they were rendered",
    )
    relight.add_argument("--white", type=_white, metavar="none|full|0..1", help="white balance")
    relight.add_argument(
        "--out", type=Path, metavar="PICTURE", required=True, help="PICTURE.png, .tif or .exr; with #### for a sequence"
    )
    relight.add_argument(
        "--resume", action="store_true", help="keep the pictures that are there and newer than their coefficients"
    )

    demo = commands.add_parser("demo", help="render the test room and relight it")
    demo.add_argument("--out", type=Path, metavar="DIR", default=Path("out/demo"), help="folder for the results")

    report = commands.add_parser("report", help="error against run time of a scene, for every model")
    if in_blender:
        report.set_defaults(scene=None)
    else:
        report.add_argument("scene", metavar="SCENE.blend", type=Path)
    report.add_argument("--channels", type=_positive, nargs="+", metavar="P", default=[3, 6, 9, 12, 15])
    report.add_argument("--models", choices=_MODELS, nargs="+", default=["rgb", "prefiltered", "fitted"])
    report.add_argument("--samples", type=_positive, metavar="N", help="samples per pixel")
    report.add_argument("--percent", type=_positive, metavar="P", help="resolution, of the scene's own")
    report.add_argument("--frame", type=int, metavar="N")
    report.add_argument("--out", type=Path, metavar="DIR", default=Path("report"), help="folder for the report")

    for name, words in _REPORTS.items():
        commands.add_parser(name, help=words, add_help=False)
    return parser


def _positive(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text} is not 1 or more")
    return value


def _frames(text: str) -> list[int]:
    first, dash, last = text.partition("-") if not text.startswith("-") else (text, "", "")
    frames = list(range(int(first), int(last if dash else first) + 1))
    if not frames:
        raise argparse.ArgumentTypeError(f"{text}: the last frame comes before the first")
    return frames


def _white(text: str) -> float:
    degree = {"none": 0.0, "full": 1.0}.get(text)
    degree = float(text) if degree is None else degree
    if not 0.0 <= degree <= 1.0:
        raise argparse.ArgumentTypeError(f"{text} is not none, full or a number from 0 to 1")
    return degree


class Failure(Exception):
    """A command that cannot be done; its message is the one line that the user gets."""


def _run(arguments: argparse.Namespace) -> None:
    from ..core import figures
    from . import demo, jobs, report

    if arguments.command == "render":
        if arguments.scene is not None:
            _open(arguments.scene)
        jobs.render_scene(bpy.context.scene, arguments)
    elif arguments.command == "relight":
        jobs.relight_file(arguments)
    elif arguments.command == "report":
        if arguments.scene is not None:
            _open(arguments.scene)
        report.run(arguments)
    else:
        if not figures.available():
            raise Failure("relume demo draws with matplotlib, which this Python lacks: see the README")
        demo.run(arguments.out)


def _open(path: Path):
    if not path.is_file():
        raise Failure(f"{path}: no such file")
    try:
        bpy.ops.wm.open_mainfile(filepath=str(path.resolve()), load_ui=False)
    except RuntimeError as error:
        raise Failure(f"{path}: not a file that Blender can open ({_first_line(error)})") from error


def _first_line(error: Exception) -> str:
    return str(error).strip().removeprefix("Error: ").splitlines()[0]


def execute(argv: list[str], in_blender: bool = False) -> int:
    """Run one command; returns the exit status."""
    try:
        if argv and argv[0] in _REPORTS:
            return importlib.import_module(f"..core.{argv[0]}", __package__).main(argv[1:])
        arguments = _arguments(in_blender).parse_args(argv)
    except SystemExit as stop:
        return stop.code or 0
    from ..core.coefficients import CoefficientImageError
    from ..core.library import LibraryError
    from .render import RenderError
    from .setup import SetupError

    try:
        _run(arguments)
    except (Failure, CoefficientImageError, LibraryError, RenderError, SetupError, OSError, ValueError) as error:
        print(f"relume: {_first_line(error)}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("relume: stopped", file=sys.stderr)
        return 130
    return 0


def main(argv: list[str] | None = None):
    """Entry point of the `relume` program."""
    from .. import register as register_addon

    register_addon()
    status = execute(sys.argv[1:] if argv is None else argv)
    sys.stdout.flush()
    sys.stderr.flush()
    # bpy and OpenImageIO both tear down at exit, in an order that makes the latter report leaks
    os._exit(status)


def blender_command(argv: list[str]) -> int:
    """Entry point of `blender -c relume`."""
    return execute(argv, in_blender=True)


_registered = []


def register():
    _registered.append(bpy.utils.register_cli_command("relume", blender_command))


def unregister():
    bpy.utils.unregister_cli_command(_registered.pop())
