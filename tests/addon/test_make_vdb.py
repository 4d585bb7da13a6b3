"""Measured volumes become OpenVDB, and are shown by a spectral transfer function."""

import numpy as np
import pytest

from relume.assets import make_vdb, make_volumes
from relume.core.errors import RelumeError


def values_of(grid) -> np.ndarray:
    low, high = grid.evalActiveVoxelBoundingBox()
    found = np.zeros([b - a + 1 for a, b in zip(low, high, strict=True)], np.float32)
    grid.copyToArray(found, ijk=low)
    return found


@pytest.fixture
def ball(tmp_path):
    """A ball of 8 voxels across in a block of 20 × 24 × 28, brighter at its core."""
    place = np.stack(np.meshgrid(*(np.arange(n) - n / 2 + 0.5 for n in (20, 24, 28)), indexing="ij"))
    distance = np.linalg.norm(place, axis=0)
    path = tmp_path / "ball.npy"
    np.save(path, np.where(distance < 2, 900.0, np.where(distance < 4, 300.0, 0.0)) - 50.0)
    return path


def test_a_volume_keeps_its_shape_and_the_order_of_its_values(ball, capsys):
    assert make_vdb.main([str(ball), "--size", "2", "--notice", "Mine."]) == 0
    path = ball.with_suffix(".vdb")
    assert str(path) in capsys.readouterr().out
    grids, notes = make_vdb.openvdb().readAll(str(path))
    assert [grid.name for grid in grids] == ["density"] and notes["notice"] == "Mine."
    found = values_of(grids[0])
    assert found.shape == (8, 8, 8) and found.max() == 1.0
    assert found[4, 4, 4] == 1.0 and found[0, 4, 4] == pytest.approx(1 / 3, abs=1 / make_vdb.LEVELS)
    corner, opposite = (np.array(grids[0].transform.indexToWorld(at)) for at in ((1, 1, 1), (8, 8, 8)))
    np.testing.assert_allclose(corner, -opposite, atol=1e-6)  # centred
    np.testing.assert_allclose(opposite - corner, 2 * 7 / 10, rtol=1e-5)  # ten voxels, with an empty one around


def test_shrinking_takes_means_and_keeps_the_size(ball):
    grid = make_vdb.convert(*make_vdb.read(ball), shrink=2, size=2.0)
    found = values_of(grid)
    assert found.shape == (4, 4, 4)
    assert 0 == found[0, 0, 0] < found[1, 1, 1] < 1


@pytest.mark.parametrize(
    "name, content, words",
    [
        ("volume.tif", b"", "a volume is .nii, .nii.gz or .npy"),
        ("flat.npy", np.zeros((3, 3, 3)), "no values"),
        ("plane.npy", np.eye(3), "no values"),
        ("broken.npy", b"nothing", "cannot be read"),
        ("absent.npy", None, "cannot be read"),
    ],
)
def test_what_is_no_volume_is_said(tmp_path, name, content, words, capsys):
    path = tmp_path / name
    if isinstance(content, bytes):
        path.write_bytes(content)
    elif content is not None:
        np.save(path, content)
    with pytest.raises(RelumeError, match=words):
        make_vdb.read(path)
    assert make_vdb.main([str(path)]) == 1
    assert words in capsys.readouterr().err


def test_the_brain_that_ships_says_whose_it_is():
    _, notes = make_vdb.openvdb().readAll(str(make_volumes.PALETTES / "brain.vdb"))
    said = (make_volumes.PALETTES / "brain.txt").read_text(encoding="utf-8")
    assert notes["notice"].split() == said.split() and "McConnell Brain Imaging Centre" in said


def test_ranges_hold_the_values_that_the_brain_has():
    grid = make_vdb.openvdb().read(str(make_volumes.PALETTES / "brain.vdb"), make_vdb.GRID)
    found = values_of(grid)
    shares = [
        ((low < found) & (found <= high)).sum() / (found > 0).sum()
        for low, high in (organ.values for organ in make_volumes.SCENES["brain"].organs)
    ]
    assert sum(shares) > 0.95 and min(shares) > 0.05
