"""What each part of the tests needs: core/ nothing but Python, addon/ the package bpy, gui/ the variable BLENDER."""

import importlib.util

import pytest

# Its modules import bpy, so without it they are not even collected.
collect_ignore = [] if importlib.util.find_spec("bpy") else ["addon"]


@pytest.fixture(scope="session")
def relume():
    """The add-on, registered once in the bpy of this Python."""
    pytest.importorskip("bpy", reason="the add-on needs bpy")
    import relume

    relume.register()
    yield relume
    relume.unregister()


def pytest_collection_modifyitems(items):
    # Long files of few tests begin: begun last, they would have one process wait for the other
    items.sort(key=lambda item: item.path.stem not in {"test_readme", "test_site"})


def pytest_terminal_summary(terminalreporter):
    for directory in collect_ignore:
        terminalreporter.write_line(f"tests/{directory} left out: bpy is not installed")
