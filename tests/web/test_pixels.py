"""What a browser shows is what `relume relight` makes."""

import shlex
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from relume.core import coefficients, measure, spaces
from relume.core.picture import exr

pytest.importorskip("bpy", reason="`relume relight` needs bpy")
ROOM = Path(__file__).resolve().parents[2] / "assets" / "room.blend"
LAMPS = ("D65", "A", "FL2", "FL11", "LED-B3", "LED-RGB1", "HP1", "Sodium (low pressure)", "Mercury", "Planckian 2900 K")


def relume_command(*words):
    from relume.addon.cli import commands

    assert commands.execute([str(word) for word in words]) == 0


def differences(shown, wanted):
    """CIEDE2000 of two pictures (height, width, 3) as encoded for sRGB, 0..1."""
    to_xyz = spaces.rgb_to_xyz()
    xyz = [spaces.srgb_decoded(each.astype(float)) @ to_xyz.T for each in (shown, wanted)]
    return measure.delta_E_2000(*xyz, to_xyz.sum(axis=1))


@pytest.fixture(scope="module")
def room_exr(relume, tmp_path_factory):
    import bpy

    folder = tmp_path_factory.mktemp("room")
    bpy.ops.wm.open_mainfile(filepath=str(ROOM))
    bpy.context.scene.render.resolution_percentage = 33
    bpy.context.scene.cycles.use_denoising = False
    blend = folder / "room.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    relume_command("render", blend, "--channels", "9", "--samples", "96", "--out", folder)
    return folder / "room.exr"


@pytest.fixture(scope="module")
def shared(tmp_path_factory):
    """shared(name): a folder for what every browser and renderer is compared with, and which is made once."""
    return cache(lambda name: tmp_path_factory.mktemp(name.replace(" ", "_")))


@pytest.fixture(scope="module")
def chart_page(chart, tmp_path_factory):
    """The page of the chart with the lamps of these tests alone: with all of them it takes a quarter of a minute."""
    from relume.core.web import page

    path = tmp_path_factory.mktemp("page") / "chart.html"
    page.write(path, [page.Picture("chart", {1: lambda: chart})], names=[*LAMPS, "D 9000 K"])
    return path


def compared(browser, page: Path, source: Path, query: str, degree: float = 0.0, lamps=LAMPS):
    """ΔE of every pixel under ten lamps, chosen by the address; the light groups get them in turn.

    The pictures of `relume relight` stay beside the page, for the next browser.
    """
    groups = list(coefficients.describe(source).groups)
    found = []
    for turn, lamp in enumerate(lamps):
        chosen = [f"{group}={LAMPS[(turn + 3 * g) % len(LAMPS)]}*{1 + 0.5 * g:g}" for g, group in enumerate(groups)]
        chosen[0] = f"{groups[0]}={lamp}*1"
        picture = page.with_name(f"{turn}.png")
        if not picture.exists():
            relume_command("relight", source, "--light", *chosen, "--white", degree, "--out", picture)
        if turn == 0:
            browser.open(page, query)
        words = "&".join(f"light={_quoted(words)}" for words in chosen)
        browser.run("say(arguments[0])", f"{words}&white={degree}")
        found.append(differences(browser.pixels()[..., :3] / 255, exr.read_rgb(picture)))
    return np.array(found)


def _quoted(text):
    from urllib.parse import quote

    return quote(text, safe="")


@pytest.mark.parametrize("renderer", ["cpu", "gpu"])
@pytest.mark.parametrize("scene", ["chart", "room"])
def test_the_page_shows_what_relight_makes(browser, request, relume, shared, renderer, scene):
    if renderer == "gpu" and not browser.has_webgl():
        pytest.skip(f"{browser.name} has no WebGL2 here")
    source = request.getfixturevalue(f"{scene}_exr")
    page = shared(scene) / "page.html"
    if not page.exists():
        # A browser rounds to a byte, and the groups have other lamps and gains here than where quality is measured
        relume_command("web", source, "--quality", "0.7", "--out", page)
    found = compared(browser, page, source, f"?renderer={renderer}", 0.5 if scene == "chart" else 0)
    median, most = np.percentile(found.reshape(len(found), -1), [50, 98], axis=1)  # of each lamp by itself
    worst = LAMPS[most.argmax()]
    print(browser.name, renderer, scene, f"median {median.max():.2f}, 98 % {most.max():.2f} under {worst}")
    assert median.max() <= 0.5 and most.max() <= 1.0, worst
    assert browser.errors() == []


VIEWS = {
    "agx": {"view_transform": "AgX", "exposure": 0.4},
    "agx punchy": {"view_transform": "AgX", "look": "AgX - Punchy", "gamma": 1.2},
    "filmic": {"view_transform": "Filmic", "look": "High Contrast", "exposure": -0.5},
    "standard": {"exposure": 0.7, "gamma": 1.4},
}


@pytest.mark.parametrize(
    ("view", "renderer"),
    [
        ("agx", "cpu"),
        ("agx", "gpu"),
        ("agx punchy", "cpu"),
        ("filmic", "cpu"),
        ("standard", "cpu"),
        ("standard", "gpu"),
    ],
)
def test_the_view_transform_is_blenders(browser, relume, chart, shared, renderer, view):
    if renderer == "gpu" and not browser.has_webgl():
        pytest.skip(f"{browser.name} has no WebGL2 here")
    source, page = shared(view) / "chart.exr", shared(view) / "page.html"
    if not page.exists():
        shown = replace(chart, view={**chart.view, **VIEWS[view]})
        coefficients.write(source, shown, chart.groups["key"][..., :3])
        relume_command("web", source, "--quality", "0.5", "--lamps", *LAMPS, "--out", page)
    # What `relume relight` writes as PNG is Blender's own Image.save_render
    lamps = LAMPS if view == "agx" else LAMPS[4:7]
    found = compared(browser, page, source, f"?renderer={renderer}", lamps=lamps)
    median, most = np.percentile(found, [50, 98])
    print(browser.name, renderer, view, f"median {median:.2f}, 98 % {most:.2f}")
    assert median <= 0.5 and most <= 1.0


def test_a_gpu_that_was_taken_away_comes_back(browser, chart_page):
    if not browser.has_webgl():
        pytest.skip(f"{browser.name} has no WebGL2 here")
    browser.open(chart_page, "?renderer=gpu#picture=chart")
    before = browser.pixels()
    browser.run(
        "const gl = document.getElementById('picture').getContext('webgl2');"
        "window.taken = gl.getExtension('WEBGL_lose_context'); taken.loseContext(); now.frame = null"
    )
    browser.wait("return document.getElementById('picture').getContext('webgl2').isContextLost()")
    browser.run("setTimeout(() => taken.restoreContext(), 100)")
    browser.wait("return now.frame")
    assert np.array_equal(before, browser.pixels())
    assert [words for words in browser.errors() if "CONTEXT_LOST" not in words] == []


@pytest.mark.parametrize("renderer", ["cpu", "gpu"])
def test_what_is_transparent_stays_so(browser, chart, tmp_path, renderer):
    if renderer == "gpu" and not browser.has_webgl():
        pytest.skip(f"{browser.name} has no WebGL2 here")
    from relume.core.picture.recombination import recombination_matrices
    from relume.core.web import page

    cover = np.ones_like(chart.alpha)
    cover[:, 96:] = 0.5
    cover[90:] = 0.0
    clear = replace(chart, groups={k: v * cover[..., None] for k, v in chart.groups.items()}, alpha=cover)
    page.write(tmp_path / "clear.html", [page.Picture("clear", {1: lambda: clear})], names=["D65", "A", "FL2"])
    browser.open(tmp_path / "clear.html", f"?renderer={renderer}")
    shown = browser.pixels()
    assert np.abs(shown[..., 3] / 255.0 - cover).max() < 0.02
    linear = coefficients.recombine(list(chart.groups.values()), recombination_matrices(chart.model, chart.mix()))
    found = differences(shown[:88, :, :3] / 255, spaces.srgb_encoded(linear)[:88])
    away = np.abs(np.arange(chart.size[0]) - 96) > 4  # but for the edge itself
    assert np.percentile(found[:, away], 98) <= 1.5
    assert browser.errors() == []


def test_the_words_that_are_copied_make_the_picture(browser, relume, chart_exr, chart_page, tmp_path):
    browser.open(
        chart_page,
        "#picture=chart&light=key%3DD+9000+K*0.7&light=lamp%27s%3DMercury*3&white=0.8"
        "&light=window+%3D+2%3D[[%22Sodium+(low+pressure)%22,0.3],[%22A%22,0.7]]*0.5",
    )
    words = shlex.split(browser.run("return document.getElementById('words').value"))
    relume_command("relight", chart_exr, *words, "--out", tmp_path / "copied.png")
    relume_command("relight", chart_exr, "--mix", shlex.join(words), "--out", tmp_path / "mix.png")
    assert np.array_equal(exr.read_rgb(tmp_path / "mix.png"), exr.read_rgb(tmp_path / "copied.png"))
    found = differences(browser.pixels()[..., :3] / 255, exr.read_rgb(tmp_path / "copied.png"))
    assert np.percentile(found, 50) <= 0.5 and np.percentile(found, 98) <= 1.5


def test_highlights_come_back_four_stops_down(browser, chart, chart_page):
    browser.open(chart_page)
    browser.run("say('exposure=-4')")
    mix = chart.mix()
    from relume.core.picture.recombination import recombination_matrices

    linear = coefficients.recombine(list(chart.groups.values()), recombination_matrices(chart.model, mix))
    assert linear[50:60, 90:102].max() > 4.0
    found = differences(browser.pixels()[..., :3] / 255, spaces.srgb_encoded(linear / 16))
    assert np.percentile(found, 98) <= 1.0 and np.percentile(found[50:60, 90:102], 90) <= 1.5
