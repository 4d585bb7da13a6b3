"""What a person does with a page: clicks, keys, touch, links, other languages, other pages around it."""

import json
import os
from dataclasses import replace
from pathlib import Path
from urllib.parse import quote

import browsers
import numpy as np
import pytest
from conftest import HOSTILE

from relume.core.colour import spaces
from relume.core.picture import coefficients
from relume.core.picture.mix import Light
from relume.core.picture.recombination import recombination_matrices
from relume.core.spectra import library
from relume.core.web import page

ENTER, RIGHT, DOWN, ESCAPE = "\ue007", "\ue014", "\ue015", "\ue00c"


# The line of the comparison taken by a pointer, and let go of at a part of the picture's width
DRAG = """const [kind, to] = arguments, handle = document.getElementById("handle");
const box = document.getElementById("picture").getBoundingClientRect();
handle.setPointerCapture = () => (handle.held = true);
handle.hasPointerCapture = () => handle.held;
const send = (name, x) => handle.dispatchEvent(new PointerEvent(name, { pointerId: 7, pointerType: kind, bubbles: true,
  clientX: box.left + x * box.width, clientY: box.top + 20 }));
send("pointerdown", now.wipe); send("pointermove", (now.wipe + to) / 2); send("pointermove", to);
handle.held = false; send("pointermove", 0.5);"""


def wanted(image, lights, degree=0.0, exposure=0.0):
    """What the page should show of an image: uint8."""
    chosen = dict(zip(image.groups, lights, strict=True))
    mix = image.mix({g: Light(library.illuminant(name), gain) for g, (name, gain) in chosen.items()}, degree)
    linear = coefficients.recombine(list(image.groups.values()), recombination_matrices(image.model, mix))
    return np.round(255 * spaces.srgb_encoded(linear * 2.0**exposure)).astype(int)


def assert_shows(browser, picture):
    off = np.abs(browser.pixels()[..., :3].astype(int) - picture)
    assert np.median(off) <= 1 and np.percentile(off, 98) <= 8, np.percentile(off, [50, 98])


def test_lamps_are_typed_slid_and_switched(browser, chart, chart_page):
    browser.open(chart_page, "#picture=chart")
    assert_shows(browser, wanted(chart, [("A", 1), ("D65", 1), ("FL2", 1)]))
    field = browser.element("#groups fieldset:nth-child(1) [role=combobox]")
    field.click()
    field.send_keys("sod")
    assert browser.run("return document.querySelectorAll('#lamps li').length") >= 2
    assert browser.run("return arguments[0].getAttribute('aria-activedescendant')", field)
    field.send_keys(ENTER)
    assert_shows(browser, wanted(chart, [("Sodium (low pressure)", 1), ("D65", 1), ("FL2", 1)]))
    gain = browser.element("#groups fieldset:nth-child(2) input[type=range]")
    gain.send_keys(RIGHT * 20)  # steps of a twentieth of a stop
    assert_shows(browser, wanted(chart, [("Sodium (low pressure)", 1), ("D65", 2), ("FL2", 1)]))
    browser.element("#groups fieldset:nth-child(1) [data-state=solo]").click()
    assert_shows(browser, wanted(chart, [("Sodium (low pressure)", 1), ("D65", 0), ("FL2", 0)]))
    words = browser.run("return document.getElementById('words').value")
    assert "'key=Sodium (low pressure)*1'" in words and "'window = 2=D65*0'" in words and "'lamp'\\''s=FL2*0'" in words
    assert browser.errors() == []


def test_a_click_in_the_list_chooses_and_escape_does_not(browser, chart, chart_page):
    browser.open(chart_page, "#picture=chart")
    field = browser.element("#groups fieldset:nth-child(3) [role=combobox]")
    field.click()
    field.send_keys("LED-B3")
    browser.element("#lamps li").click()
    assert_shows(browser, wanted(chart, [("A", 1), ("D65", 1), ("LED-B3", 1)]))
    field.click()
    field.send_keys("mercury" + DOWN + ESCAPE)
    assert browser.run("return arguments[0].value", field) == "LED-B3"
    field.click()
    field.send_keys("no such lamp" + ENTER)
    assert_shows(browser, wanted(chart, [("A", 1), ("D65", 1), ("LED-B3", 1)]))
    assert browser.errors() == []


def test_temperatures_blends_white_and_exposure(browser, chart, chart_page):
    browser.open(chart_page, "#picture=chart")
    kind = browser.element("#groups fieldset:nth-child(1) select")
    browser.run("arguments[0].value = 'planckian'; arguments[0].dispatchEvent(new Event('change'))", kind)
    number = browser.element("#groups fieldset:nth-child(1) input.number")
    browser.run("arguments[0].value = '2500'; arguments[0].dispatchEvent(new Event('change'))", number)
    browser.element("#white").send_keys(RIGHT * 60)
    browser.element("#exposure").send_keys(RIGHT * 10)
    lamps = [("Planckian 2500 K", 1), ("D65", 1), ("FL2", 1)]
    assert_shows(browser, wanted(chart, lamps, degree=0.6, exposure=0.5))
    assert "--white 0.6" in browser.run("return document.getElementById('words').value")
    assert browser.run("return document.getElementById('unsaid').textContent")  # the exposure
    blend = json.dumps([["D65", 0.25], ["A", 0.75]])
    browser.run("say(arguments[0])", f"light={quote('key=' + blend + '*1')}")
    handle = browser.run("return dialHandle(now.mix.lights[0].parts.map((part) => part.weight))")
    weights = browser.run("return dialWeights(arguments[0], 2)", handle)
    assert np.allclose(weights, [0.25, 0.75])
    assert browser.errors() == []


def test_the_address_keeps_the_mix(browser, chart, chart_page):
    words = (
        "picture=chart&light=key%3DFL11*0.5&light=window+%3D+2%3DD+7000+K*2&solo=key&white=0.3&exposure=-1&method=sharp"
    )
    browser.open(chart_page, "#" + words)
    browser.run("changed()")
    browser.wait("return new URLSearchParams(location.hash.slice(1)).get('method') === 'sharp'")
    first, address = browser.pixels(), browser.run("return location.href")
    browser.run("setMix(renderedMix(now.picture))")
    assert not np.array_equal(first, browser.pixels())
    browser.open(Path(chart_page), "#" + address.partition("#")[2])
    assert np.array_equal(first, browser.pixels())
    browser.open(
        chart_page, "#light=&light=%00*&light=key%3D%5B%5B1%5D%5D*x&white=NaN&exposure=1e9&observer=nobody&solo="
    )
    assert browser.run("return now.mix.white") == 0 and browser.run("return now.mix.exposure") == 0
    assert browser.errors() == []


def test_wipe_snapshots_keys_and_the_spectrum(browser, chart, chart_page):
    browser.open(chart_page, "#picture=chart&light=key%3DMercury*1")
    browser.run("compareWith('rendered'); now.wipe = 0.5; changed()")
    shown, left = browser.pixels()[..., :3].astype(int), wanted(chart, [("Mercury", 1), ("D65", 1), ("FL2", 1)])
    right = wanted(chart, [("A", 1), ("D65", 1), ("FL2", 1)])
    assert (
        np.median(np.abs(shown[:, :95] - left[:, :95])) <= 1 and np.median(np.abs(shown[:, 98:] - right[:, 98:])) <= 1
    )
    handle, key = browser.element("#handle"), "new KeyboardEvent('keydown', { key: 'ArrowRight', bubbles: true })"
    browser.run(f"arguments[0].dispatchEvent({key}); arguments[0].dispatchEvent({key})", handle)
    assert browser.run("return now.wipe") == pytest.approx(0.54)
    for kind in ("mouse", "touch"):
        browser.run(DRAG, kind, 0.25 if kind == "mouse" else 0.8)
        assert browser.run("return now.wipe") == pytest.approx(0.25 if kind == "mouse" else 0.8, abs=0.01)
    shown = browser.pixels()[..., :3].astype(int)
    assert np.median(np.abs(shown[:, :150] - left[:, :150])) <= 1
    assert np.median(np.abs(shown[:, 158:] - right[:, 158:])) <= 1
    browser.element("#keep").click()
    browser.run("setMix(renderedMix(now.picture)); compareWith('')")
    assert not handle.is_displayed()
    browser.element("#snapshots button").click()
    assert browser.run("return page.lamps[now.mix.lights[0].lamp].name") == "Mercury"
    picture = browser.element("#picture")
    browser.run("arguments[0].focus()", picture)
    picture.send_keys("2")
    assert browser.run("return now.mix.lights.map((light) => light.solo)") == [False, True, False]
    for key, exposure in (("]", 0.25), ("[", 0.0)):  # as a German keyboard sends them, with AltGr
        pressed = f"new KeyboardEvent('keydown', {{ key: '{key}', ctrlKey: true, altKey: true, bubbles: true }})"
        browser.run(f"arguments[0].dispatchEvent({pressed})", picture)
        assert browser.run("return now.mix.exposure") == exposure
    picture.send_keys("0" + RIGHT)
    browser.wait("return document.getElementById('reading').textContent.includes('nm')")
    reading = browser.run("return document.getElementById('reading').textContent")
    x, y = (int(each) for each in reading.partition(":")[0].split(","))
    from relume.core.picture.recombination import color_of

    xyz = color_of(chart.model, chart.mix(), [each[y, x] for each in chart.groups.values()])
    shown = [float(part.split()[1]) for part in reading.partition(":")[2].split(",")[:3]]
    assert np.allclose(shown[:2], xyz[:2] / xyz.sum(), atol=0.01) and abs(shown[2] - xyz[1]) < 0.05 * xyz[1]
    assert browser.errors() == []


def test_a_gallery_and_a_sequence(browser, chart_page):
    browser.open(chart_page)
    browser.element("#keep").click()
    buttons = browser.run("return [...document.querySelectorAll('#gallery button')].map((each) => each.textContent)")
    assert buttons == ["chart", "small"]
    browser.element("#gallery button:nth-child(2)").click()
    browser.wait("return document.getElementById('picture').height === 40 && now.frame")
    assert not browser.run("return document.getElementById('time').hidden")
    browser.element("#frame").send_keys(RIGHT)
    browser.wait(
        "const text = (id) => document.getElementById(id).textContent;"
        "return text('frameNumber') === '6' && !text('status')"
    )
    assert browser.run("return now.snapshots.length") == 0
    browser.element("#gallery button:nth-child(1)").click()
    browser.wait("return document.getElementById('picture').height === 120 && now.frame")
    assert browser.run("return now.snapshots.length") == 1, "each picture keeps its own"
    assert browser.errors() == []


def test_names_are_text(browser, chart, tmp_path):
    hostile = replace(
        chart,
        groups={HOSTILE: chart.groups["key"]},
        illuminants={
            HOSTILE: replace(chart.illuminants["key"], name=HOSTILE, values=chart.illuminants["key"].values ** 2)
        },
    )
    path = tmp_path / "hostile.html"
    page.write(path, [page.Picture(HOSTILE, {1: lambda: hostile})], names=["D65", "A"], title=HOSTILE)
    browser.open(path)
    assert browser.run("return document.querySelector('legend').textContent") == HOSTILE
    assert browser.run("return document.getElementById('title').textContent") == HOSTILE
    assert browser.run("return document.title.replace(/\\s+/g, ' ')") == HOSTILE
    assert browser.run("return document.querySelectorAll('img, script:not([id]):not(:last-of-type)').length") == 0
    browser.element("[role=combobox]").click()
    assert browser.run("return document.querySelectorAll('#lamps li bdi')[2].textContent") == HOSTILE
    assert browser.errors() == []


def test_a_bare_page_answers_the_page_around_it(browser, chart, tmp_path):
    page.write(
        tmp_path / "bare.html", [page.Picture("chart", {1: lambda: chart})], names=["D65", "A", "Mercury"], bare=True
    )
    host = tmp_path / "host.html"
    host.write_text(
        "<!DOCTYPE html><title>host</title><iframe src='bare.html' style='width: 400px; height: 300px'></iframe>"
        "<script>heard = []; addEventListener('message', (event) => { heard.push(event.data);"
        "document.documentElement.dataset.shown = 'host'; })</script><p id='status'></p>"
    )
    browser.open(host)
    browser.wait("return heard.length")
    ready = browser.run("return heard[0]")
    assert ready["relume"] == "ready" and ready["groups"] == list(chart.groups) and "Mercury" in ready["lamps"]
    browser.run("frames[0].postMessage({ relume: 'set', mix: 'light=key%3DMercury*2' }, '*')")
    browser.wait("return heard.length > 1")
    assert "key%3DMercury*2" in browser.run("return heard.at(-1).mix")
    for said in ("{ relume: 'get' }", "{ relume: 'frame', number: 0 }"):
        before = browser.run("return heard.length")
        browser.run(f"frames[0].postMessage({said}, '*')")
        browser.wait(f"return heard.length > {before}")
        answer = browser.run("return heard.at(-1)")
        assert answer["relume"] == "mix" and "key%3DMercury*2" in answer["mix"] and answer["frames"] == 1
        assert answer["picture"] == "chart" and answer["pictures"] == ["chart"]
    before = browser.run("return heard.length")
    for said in ("'set'", "null", "{ relume: 7 }", "{ relume: 'set', mix: 3 }", "{ relume: 'frame', number: 'x' }"):
        browser.run(f"frames[0].postMessage({said}, '*')")
    browser.wait(f"return heard.length >= {before + 2}")
    assert "key%3DMercury*2" in browser.run("return heard.at(-1).mix"), "what it cannot read changes nothing"
    assert browser.errors() == []


@pytest.mark.parametrize("width", [1440, 768, 360])
def test_the_page_fits(browser, chart_page, tmp_path, width):
    if browser.name == "firefox" and width < 500:
        pytest.skip("Firefox makes no window as narrow as a phone")
    browser.size(width)
    browser.open(chart_page)
    browser.screenshot(Path(os.environ.get("RELUME_PICTURES", tmp_path)) / f"{browser.name}_{width}.png")
    assert browser.run("return document.documentElement.scrollWidth <= innerWidth")
    browser.size(1440)
    assert browser.errors() == []


@pytest.mark.parametrize(("language", "scheme"), [("en", "light"), ("de", "dark")])
def test_axe_finds_nothing_serious(browser, chart_page, language, scheme):
    if browsers.axe() is None:
        pytest.skip("axe-core is not there: npm install -g axe-core")
    if browser.name != "chromium":
        pytest.skip("one browser is enough for what axe looks at")
    browser.scheme(scheme)
    browser.open(chart_page, "#picture=chart&light=key%3D%5B%5B%22D65%22%2C1%5D%2C%5B%22A%22%2C1%5D%5D*1")
    browser.run(
        "language = arguments[0]; translate(); drawMixer();"
        "showSearch(document.querySelector('[role=combobox]'), () => 0)",
        language,
    )
    serious = browser.barriers()
    browser.scheme("light")
    assert not serious
