"""The light dial as a moving picture."""

import numpy as np
import pytest
from PIL import Image

from relume.core.colour import spaces
from relume.core.picture import mixing
from relume.studies import dial


def test_the_handle_rests_at_every_light_and_comes_back():
    places = dial.path(4)
    weights = np.array([mixing.weights(place, 4) for place in places])
    assert [int((weights[:, light] > 1 - 1e-9).sum()) for light in range(4)] == [dial.REST] * 4
    # From one light to the next the others are out
    assert ((weights > 1e-9).sum(axis=1) <= 2).all()
    np.testing.assert_allclose(np.diff(places, axis=0, append=places[:1]), 0, atol=0.2)


def test_frames_are_mixtures_of_the_lightings(tmp_path):
    colours = np.array([[0.2, 0.1, 0.1], [0.1, 0.3, 0.1], [0.1, 0.1, 0.4]]) @ spaces.rgb_to_xyz().T
    lightings = [(name, np.broadcast_to(xyz, (120, 160, 3))) for name, xyz in zip("abc", colours, strict=True)]
    dial.animate(tmp_path / "dial.webp", lightings, np.eye(3))
    with Image.open(tmp_path / "dial.webp") as picture:
        assert picture.is_animated and picture.size == (320, 240)
        first = np.asarray(picture.convert("RGB"), float)
        picture.seek(1)  # frames that are alike are one that lasts longer
        second = np.asarray(picture.convert("RGB"), float)
    expected = 255 * spaces.srgb_encoded(np.array([0.2, 0.1, 0.1]))
    np.testing.assert_allclose(first[10, 10], expected, atol=6)
    assert np.abs(first - second).max() > 40, "the handle has moved"


def test_without_pillow_it_says_so(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "PIL", None)
    with pytest.raises(ImportError):
        dial.animate(tmp_path / "dial.webp", [("a", np.zeros((2, 2, 3)))], np.eye(3)[:1])
