"""The documentation's site: it builds without a warning, needs no network, and every page can be read."""

import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import browsers
import numpy as np
import pytest

from relume.core.colour import differences, spaces
from relume.core.errors import ModelError
from relume.core.spectra import library, names

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The folder of the site, built as `make docs` does."""
    if importlib.util.find_spec("furo") is None:
        pytest.skip("`make docs` needs Sphinx with Furo and MyST")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "--fail-on-warning", "--keep-going", "--quiet"]
    done = subprocess.run([*command, "-d", str(folder / "doctrees"), str(DOCS), str(folder / "html")], text=True)
    assert done.returncode == 0
    return folder / "html"


def pages(site: Path) -> list[Path]:
    return sorted(path for path in site.rglob("*.html") if "_downloads" not in path.parts)


def test_it_needs_no_network(site):
    for page in pages(site):
        loaded = re.findall(
            r"<(?:link|script|img|iframe|source)\b[^>]*\b(?:href|src)=\"((?:https?:)?//[^\"]+)", page.read_text()
        )
        assert not loaded, page.name
    for sheet in site.rglob("*.css"):
        assert not re.search(r"@import|url\(['\"]?(https?:)?//", sheet.read_text()), sheet.name


def test_every_module_of_the_core_is_described(site):
    described = set(re.findall(r'id="module-(relume\.core[.\w]*)"', "".join(page.read_text() for page in pages(site))))
    modules = {
        "relume." + ".".join(path.relative_to(ROOT).with_suffix("").parts)
        for path in (ROOT / "core").rglob("*.py")
        if path.stem != "__init__"
    }
    assert modules <= described


def test_every_page_fits_and_has_no_barriers(site, browser, tmp_path):
    """On a desktop and on a telephone. RELUME_PICTURES names a folder for photographs."""
    if browser.name != "chromium" or browsers.axe() is None:
        pytest.skip("Chromium and axe-core look at the pages")
    found = {}
    for page in pages(site):
        browser.size(1280)
        browser.visit(page)
        if barriers := browser.barriers():
            found[page.name] = barriers
        for width in (1280, 360):
            browser.size(width)
            if folder := os.environ.get("RELUME_PICTURES"):
                browser.screenshot(Path(folder) / f"{page.stem}_{width}.png")
            if browser.run("return document.documentElement.scrollWidth > innerWidth"):
                found[f"{page.name} at {width} px"] = "is wider than the window"
    browser.size(1440)
    assert not found


def test_the_lamps_are_called_as_in_the_mixer():
    rows = re.findall(r"^\| .* \| (.*) \| `(.*)` \| .* \|$", (DOCS / "lamps.md").read_text(), re.MULTILINE)
    assert len(rows) > 15
    for said, code in rows:
        spectrum = library.illuminant(code)
        words, short = names.parts(spectrum.name)
        assert f"*{words}*" in said or not short and words == spectrum.name, (said, code)


def test_the_messages_are_ones_that_relume_says():
    page = (DOCS / "troubleshooting.md").read_text(encoding="utf-8")
    messages = re.findall(r"^\| `(.*)` \|", page, re.MULTILINE)
    source = "".join(
        path.read_text(encoding="utf-8") for room in ("addon", "core") for path in (ROOT / room).rglob("*.py")
    )
    assert len(messages) > 5
    assert not [message for message in messages if message not in source]


def test_lamps_do_to_colours_what_the_page_says():
    """Chroma of patches of the ColorChecker, white balanced, against daylight."""
    patches = {
        patch.name.split(": ")[1].split(" (")[0]: patch.sampled() for patch in library.reflectances("colorchecker")
    }

    def chroma(lamp: str, patch: str) -> float:
        power = library.illuminant(lamp).sampled()
        weights = power[:, None] * library.observer() / (power @ library.observer()[:, 1])
        balance = spaces.adaptation(weights.sum(axis=0), spaces.D65_WHITE)
        return float(np.hypot(*differences.lab(balance @ (patches[patch] @ weights), spaces.D65_WHITE)[1:]))

    def more(lamp: str, patch: str) -> float:
        return chroma(lamp, patch) - chroma("D65", patch)

    assert all(more(lamp, "red") > 8 for lamp in ("Planckian 1900 K", "Planckian 2700 K", "A", "LED-RGB1"))
    assert all(more(lamp, "red") < -8 for lamp in ("FL2", "Sodium (high pressure)", "Mercury", "Metal halide"))
    assert all(more(lamp, "yellow") > 4 for lamp in ("LED-B1", "LED-B3", "FL11", "Mercury"))
    assert more("LED-RGB1", "yellow") < -4 and more("LED-B1", "red") < more("Planckian 2700 K", "red") - 5
    near = ("LED-V2", "FL7", "Kinoton 75P", "D55", "D75", "D 12000 K")
    assert all(abs(more(lamp, patch)) < 7 for lamp in near for patch in patches)
    with pytest.raises(ModelError, match="lacks a colour altogether"):
        chroma("Sodium (low pressure)", "red")
