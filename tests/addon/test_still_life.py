"""The still life that ships: measured throughout, lit as its script says, and its print shows what it should."""

import itertools

import bpy
import numpy as np
import pytest

from relume.addon.graph import spectra
from relume.addon.scene import setup
from relume.assets import still_life
from relume.core.colour import differences
from relume.core.model import bases, relight
from relume.core.spectra import library


@pytest.fixture(scope="module")
def scene():
    bpy.ops.wm.open_mainfile(filepath=str(still_life.PATH), load_ui=False)
    return bpy.context.scene


def apart(illuminant: str) -> list[float]:
    """CIEDE2000 between the inks of the print, two by two, under an illuminant."""
    weights = relight.power_weights(library.illuminant(illuminant).sampled(), library.observer())
    inks = [spectra.spectra_of(t)["Color"].sampled() for t in bpy.data.node_groups if t.name.startswith("ink, ")]
    assert len(inks) == 3
    white = np.ones(81) @ weights
    seen = [ink @ weights / white[1] for ink in inks]
    return [float(differences.delta_E_2000(a, b, white / white[1])) for a, b in itertools.combinations(seen, 2)]


def test_the_print_is_one_grey_in_daylight_alone(scene):
    assert max(apart("D65")) < 0.2
    assert min(apart("A")) > 8
    assert min(apart("Sodium (low pressure)")) > 2


def test_it_is_lit_as_its_script_says(scene):
    setup.set_up(scene, bases.fitted(9))
    found = {row.name: row.illuminant for row in scene.relume.lit}
    assert found == {"candle": "Planckian 1900 K", "window": "D65", "bulb": "LED-B1", "tube": "FL2"}
    gains = {row.name: row.gain for row in scene.relume.lit}
    first = next(iter(still_life.LIGHTS.values()))()
    assert gains == pytest.approx({name: light.gain for name, light in first.items()}, abs=1e-6)
    for mix in still_life.LIGHTS.values():
        assert mix().keys() == found.keys()
