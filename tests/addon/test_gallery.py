"""The scenes of the gallery: what the papers' pictures rest on, without rendering them."""

import re

import bpy
import numpy as np
import pytest

from relume.addon.graph import transfer
from relume.addon.scene import content
from relume.assets import make_spheres, make_volumes
from relume.benchmarks import gallery
from relume.core import palette
from relume.core.colour import differences
from relume.core.model import bases
from relume.core.model.relight import power_weights
from relume.core.spectra import library
from relume.studies.reports import Section


def test_spheres_are_pairs_that_match_in_daylight_and_part_under_tungsten():
    bpy.ops.wm.open_mainfile(filepath=str(make_spheres.PATH))
    scene = bpy.context.scene
    assert scene.cycles.max_bounces == make_spheres.BOUNCES
    found = {spectrum.name: spectrum.sampled() for spectrum in content.content_of(scene).reflectances}
    for name in make_spheres.NAMES:
        pair = np.stack([found[name], found[f"{name}'s metamer"]])
        apart = []
        for light in ("D65", "A"):
            weights = power_weights(library.illuminant(light).sampled(), library.observer())
            apart.append(differences.delta_E_1976(*(pair @ weights), weights.sum(axis=0)))
        assert apart[0] < 0.01 and apart[1] > 20


@pytest.mark.parametrize("name", ["anatomy", "machine", "brain"])
def test_parts_of_a_volume_have_ranges_of_their_own(name):
    scene = make_volumes.build(name)
    (function,) = transfer.of(bpy.data.materials[name])
    ranges = transfer.ranges_of(function)
    organs = [organ for organ in make_volumes.SCENES[name].organs if organ.reflectance]
    assert [transfer.spectrum_of(one).name for one in ranges] == [organ.reflectance for organ in organs]
    for one, organ in zip(ranges, organs, strict=True):
        assert (one.low.inputs[1].default_value, one.high.inputs[1].default_value) == pytest.approx(organ.values)
    assert len(make_volumes.lightings(name)) == 4 and scene.camera


def test_under_the_stomach_light_only_the_stomach_is_left():
    make_volumes.build("anatomy")
    (function,) = transfer.of(bpy.data.materials["anatomy"])
    illuminant, gain = make_volumes.lightings("anatomy")["stomach light"]
    weights = gain * power_weights(illuminant.sampled(), library.observer())
    seen = {s.name: s.sampled() @ weights[:, 1] for s in map(transfer.spectrum_of, transfer.ranges_of(function))}
    stomach = seen.pop("stomach")
    assert stomach > 0.3 and max(seen.values()) < 0.005


def test_smoke_is_black_and_no_lighting_needs_more_than_nine_channels():
    scene, model = make_volumes.SCENES["machine"], bases.fitted(9)
    values = make_volumes.reflectances("machine")
    names = [entry.name for entry in palette.read(make_volumes.PALETTES / "machine.toml").reflectances]
    for title, (illuminant, gain) in make_volumes.lightings("machine").items():
        weights = power_weights(illuminant.sampled(), library.observer())
        true, found = gain * values @ weights, gain * model.coefficients(values) @ model.relight(illuminant).T
        assert differences.delta_E_2000(true, found, weights.sum(axis=0)).max() < 0.2
        if title in ("daylight", "complement"):
            smoke = true[names.index("smoke")][None]
            assert differences.delta_E_2000(np.zeros((1, 3)), smoke, weights.sum(axis=0)).max() < 0.1
    assert {organ.reflectance for organ in scene.organs if organ.reflectance} == set(names)


def test_the_page_has_every_part_with_its_figure_picture_and_table(tmp_path, monkeypatch):
    section = Section("Table <1>", "Words & figures.", ("light", "median"), [["daylight", 0.1]])
    parts = {
        "one": lambda out, samples, reflectances: [gallery._entry(section, "Someone, Table 1", "one.png")],
        "two": lambda out, samples, reflectances: [gallery.Entry("Two", "Someone, Fig. 2")],
    }
    monkeypatch.setattr(gallery, "PARTS", parts)
    gallery.main(["--only", "one", "two", "--out", str(tmp_path / "page")])
    markdown, page = ((tmp_path / "page" / f"gallery.{kind}").read_text(encoding="utf-8") for kind in ("md", "html"))
    for words in ("Someone, Table 1", "Someone, Fig. 2", "one.png", "daylight", "0.1"):
        assert words in markdown and words in page
    assert "Table &lt;1&gt;" in page and "Words &amp; figures." in page
    assert "| light | median |\n| --- | --- |\n| daylight | 0.1 |" in markdown


@pytest.mark.torture
def test_the_whole_gallery_is_made(tmp_path):
    gallery.main(["--samples", "1", "--out", str(tmp_path)])
    page = (tmp_path / "gallery.md").read_text(encoding="utf-8")
    pictures = re.findall(r"!\[[^]]*\]\(([^)]+)\)", page)
    assert {"spheres.png", "anatomy.png", "brain.png", "machine.png", "dial.webp", "figure_1.png"} <= set(pictures)
    assert all((tmp_path / name).stat().st_size > 10_000 for name in pictures)
    for heading in ("Spheres", "Machine", "Table 1", "Table 5", "The room: One thing changed"):
        assert f"## {heading}\n" in page
