"""The command line: `relume …` in a Python environment with bpy, `blender -b SCENE.blend -c relume …` in Blender.

Exit status: 0 done, 1 failed with one line that says what and where, 2 wrong usage, 128 + n stopped by signal n.
"""

import argparse
import importlib

import bpy

from ...core.errors import RelumeError
from ..host import console
from ..host.blend_file import first_line, located, open_scene
from . import arguments

__all__ = ["execute", "register", "unregister"]


def _run(options: argparse.Namespace) -> None:
    from ...studies import figures
    from ..scene import describe
    from . import demo, jobs, report, web

    if getattr(options, "scene", None) is not None:
        open_scene(located(options.scene))
    if options.out is not None:
        options.out = located(options.out)
    if options.command == "render":
        jobs.render_scene(bpy.context.scene, options)
    elif options.command in ("relight", "web"):
        options.coefficients, options.described = located(options.coefficients), None
        if options.blend is not None:
            open_scene(located(options.blend))
            options.described = describe.of_open_file()
        web.run(options) if options.command == "web" else jobs.relight_file(options)
    elif options.command == "describe":
        jobs.describe_scene(options.out)
    elif options.command == "report":
        report.run(options)
    else:
        if not figures.available():
            raise RelumeError("relume demo draws with matplotlib, which this Python lacks: see the README")
        demo.run(options.out)


def execute(argv: list[str], in_blender: bool = False) -> int:
    """Run one command; returns the exit status."""
    try:
        console.start_log()
        with console.stoppable(), console.apart():
            if argv and argv[0] in arguments.REPORTS:
                return importlib.import_module(f"...studies.{argv[0]}", __package__).main(argv[1:])
            _run(arguments.parse(argv, in_blender))
    except SystemExit as stop:  # argparse has said why
        return stop.code or 0
    except RelumeError as error:
        console.fail(str(error))
        return 1
    except OSError as error:
        console.fail(f"{error.filename}: {error.strerror}" if error.filename else error.strerror or str(error))
        return 1
    except KeyboardInterrupt:
        console.fail("stopped")
        return 130
    except Exception as error:
        console.LOG.debug("unexpected", exc_info=True)
        console.fail(f"unexpected {type(error).__name__}: {first_line(error)} (RELUME_LOG=debug shows where)")
        return 1
    return 0


def blender_command(argv: list[str]) -> int:
    """Entry point of `blender -c relume`."""
    return execute(argv, in_blender=True)


_registered = []


def register() -> None:
    _registered.append(bpy.utils.register_cli_command("relume", blender_command))


def unregister() -> None:
    bpy.utils.unregister_cli_command(_registered.pop())
