"""Hostile input, counted: a few of each kind in `make test`, thousands in `make torture`."""

import os
from collections import Counter

import pytest

from . import outcome

_counted = Counter()


@pytest.fixture(scope="session")
def little(relume, tmp_path_factory):
    """The room that ships, so small and coarse that it renders in a second."""
    bpy = pytest.importorskip("bpy", reason="rendering needs bpy")
    from relume.assets import make_room

    path = tmp_path_factory.mktemp("little") / "little.blend"
    bpy.ops.wm.open_mainfile(filepath=str(make_room.PATH))
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 16, 12, 100
    scene.cycles.samples, scene.cycles.use_denoising, scene.relume.channels = 3, False, "3"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


@pytest.fixture
def settle(record_property):
    """Count how a case ended: `settle(outcome.of_call(…))`; a test may settle many."""
    return lambda how, cases=1: record_property("outcome", (how, cases))


def pytest_runtest_logreport(report):
    for name, value in report.user_properties if report.when == "call" else ():
        if name == "outcome" and not report.failed:
            how, cases = value
            _counted[how] += cases
    if report.failed and "/faults/" in f"/{report.nodeid}":
        _counted["failed"] += 1


def pytest_terminal_summary(terminalreporter):
    if _counted:
        right, said, failed = _counted[outcome.RIGHT], _counted[outcome.SAID], _counted["failed"]
        seed = os.environ.get("RELUME_SEED", "0")
        terminalreporter.write_line(
            f"hostile input: {right + said + failed} cases, {right} with the right result, {said} refused in one line, "
            f"{failed} failed (RELUME_SEED={seed})"
        )
