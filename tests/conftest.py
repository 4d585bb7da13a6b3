"""What each part of the tests needs: core/ nothing but Python, addon/ the package bpy, gui/ the variable BLENDER."""

import importlib.util

# Its modules import bpy, so without it they are not even collected.
collect_ignore = [] if importlib.util.find_spec("bpy") else ["addon"]


def pytest_terminal_summary(terminalreporter):
    for directory in collect_ignore:
        terminalreporter.write_line(f"tests/{directory} left out: bpy is not installed")
