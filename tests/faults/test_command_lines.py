"""Command lines by the hundred: what can be done is done and right, what cannot is refused in one line."""

import os

import numpy as np
import pytest

from relume.core.colour import spaces
from relume.core.errors import ModelError
from relume.core.model import bases
from relume.core.picture import coefficients
from relume.core.picture.mix import Light
from relume.core.spectra import library

from . import grammar, outcome

bpy = pytest.importorskip("bpy", reason="commands need bpy")

GROUPS = {"tungsten": "A", "Röhre 2": "FL2"}


@pytest.fixture
def run(relume, capfd):
    """Run `relume` with arguments in this process, in the current folder, and return how it ended."""
    from relume.addon.cli import commands

    def execute(*arguments) -> outcome.Ended:
        capfd.readouterr()
        status = commands.execute(list(arguments))
        out, err = capfd.readouterr()
        return outcome.Ended(status, out, err)

    return execute


@pytest.fixture(scope="session")
def image():
    """A coefficient image of 6 by 4 pixels, two light groups and nine channels."""
    random = np.random.default_rng(1)
    return coefficients.CoefficientImage(
        model=bases.fitted(9),
        groups={group: random.random((4, 6, 9), dtype=np.float32) for group in GROUPS},
        illuminants={group: library.illuminant(name) for group, name in GROUPS.items()},
        alpha=np.ones((4, 6), dtype=np.float32),
    )


@pytest.fixture
def folder(tmp_path, monkeypatch, image):
    """A folder to stand in: a coefficient EXR under several names, an older picture, a file and a folder in the way."""
    coefficients.write(tmp_path / "same.exr", image, np.zeros((4, 6, 3)))
    os.symlink("same.exr", tmp_path / "linked.exr")
    os.link(tmp_path / "same.exr", tmp_path / "kept.exr")
    (tmp_path / "a.file").write_text("in the way")
    (tmp_path / "a.folder.png").mkdir()
    (tmp_path / "x.png").write_text("an older picture")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path))
    return tmp_path


def _expected(image, arguments):
    """The picture that `relight` has to make of arguments that it can do, worked out without the add-on."""
    lights = {group: Light(image.illuminants[group]) for group in image.groups}
    said = " ".join(arguments).replace("--white=", "--white ").split("--white ")
    degree = said[1].split()[0] if len(said) > 1 else "none"
    white = {"none": 0.0, "full": 1.0}[degree] if degree in ("none", "full") else float(degree)
    for group, name, gain in _lights_in(arguments):
        lights[group] = Light(library.illuminant(name), gain)
    matrices = [light.gain * image.model.relight(light.illuminant) for light in lights.values()]
    xyz = sum(image.groups[group] @ matrix.T for group, matrix in zip(image.groups, matrices, strict=True))
    to_rgb = np.linalg.inv(spaces.rgb_to_xyz("Linear Rec.709"))
    if white:
        mixed = sum(matrix.sum(axis=1) for matrix in matrices)
        to_rgb = to_rgb @ spaces.adaptation(mixed, spaces.rgb_to_xyz("Linear Rec.709").sum(axis=1), white)
    return xyz @ to_rgb.T


def _lights_in(arguments):
    inside = False
    for word in arguments:
        if word.startswith("--"):
            option, equals, value = word.partition("=")
            inside = option == "--light"
            if not (inside and equals):
                continue
            word = value
        if inside:
            group, _, what = word.rpartition("=")
            name, _, gain = what.partition("*")
            yield group, name, float(gain or 1.0)


@pytest.mark.parametrize("seed", [*outcome.seeds(60, 600)])
def test_relight(seed, run, folder, image, settle):
    arguments, verdict = grammar.line(seed, grammar.RELIGHT, [*GROUPS], needed="--out")
    before = outcome.files_of(folder)
    ended = run("relight", "same.exr", *arguments)

    def right():
        made = [line for line in ended.out.splitlines() if line]
        assert made, "no picture was named"
        picture = folder / os.path.expanduser(made[-1])
        found = coefficients.read_rgb(picture)
        assert found.shape == (4, 6, 3)
        if picture.suffix.lower() == ".exr":
            wanted = _expected(image, arguments)
            np.testing.assert_allclose(found, wanted, rtol=2e-4, atol=2e-4 * np.abs(wanted).max())

    how = outcome.of_command(ended, right)
    if verdict and "lacks a colour altogether" in ended.err:
        with pytest.raises(ModelError):  # sodium alone is not to be made white, and needs no Relume to find that out
            _expected(image, arguments)
        verdict = None
    assert verdict is None or how == (outcome.RIGHT if verdict else outcome.SAID), (arguments, ended)
    after = outcome.files_of(folder)
    assert after["same.exr"] == before["same.exr"], "the coefficients were changed"
    if how == outcome.SAID:
        assert after == before, "a refused command left something"
    settle(how)


@pytest.mark.parametrize("seed", [*outcome.seeds(20, 240)])
def test_render(seed, run, folder, little, settle):
    arguments, verdict = grammar.line(seed, grammar.RENDER, ["tungsten", "fluorescent"])
    (folder / "little.blend").write_bytes(little.read_bytes())
    before = outcome.files_of(folder)
    ended = run("render", "little.blend", *arguments)

    def right():
        made = [folder / os.path.expanduser(line) for line in ended.out.splitlines() if line]
        assert {path.suffix for path in made} >= {".exr", ".png", ".json"}, ended
        for path in made:
            if path.suffix == ".exr":
                found = coefficients.read(path)
                assert found.size == (16, 12)
                assert all(np.isfinite(group).all() for group in found.groups.values())
                assert max(group.max() for group in found.groups.values()) > 0.01
            elif path.suffix == ".png":
                assert coefficients.read_rgb(path).shape == (12, 16, 3)

    how = outcome.of_command(ended, right)
    assert verdict is None or how == (outcome.RIGHT if verdict else outcome.SAID), (arguments, ended)
    after = outcome.files_of(folder)
    assert all(after[name] == data for name, data in before.items()), "an older file was changed"
    if how == outcome.SAID:
        assert after == before, "a refused command left something"
    settle(how)
