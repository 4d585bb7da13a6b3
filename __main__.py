"""`relume …`, or `python -m relume …`: the command line in a Python environment with bpy."""

import os
import sys
from contextlib import suppress


def main(argv: list[str] | None = None):
    """Run a command, that which was typed if none is given, and end the process with its exit status."""
    from . import register

    try:
        from .addon.cli.commands import execute
    except ModuleNotFoundError as error:
        if error.name != "bpy":
            raise
        sys.exit("relume: needs Blender as a Python module: pip install 'relume[blender]', with Python 3.11 or 3.13")
    register()
    status = execute(sys.argv[1:] if argv is None else argv)
    with suppress(OSError):
        sys.stdout.flush()
    # Python's own way out takes bpy 5.0 apart in an order in which it reports leaks on standard output; 5.2 does not
    os._exit(status)


if __name__ == "__main__":
    main()
