"""Pages in real browsers: Debian's Chromium and Firefox where they are installed, with what drives them."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))
import browsers  # noqa: E402

from relume.core.model import bases
from relume.core.picture import coefficients
from relume.core.picture.coefficient_image import CoefficientImage
from relume.core.spectra import library

FOUND = browsers.found()
HOSTILE = "<img src=x onerror=alert(1)>\"'&</script><!--\u202eevil\u2066"


@pytest.fixture(scope="session", params=sorted(FOUND) or ["none"])
def browser(request, tmp_path_factory):
    """Each browser of this machine, started once."""
    if request.param == "none":
        pytest.skip("no browser that can be driven: see CONTRIBUTING.md")
    started = FOUND[request.param](tmp_path_factory.mktemp(request.param))
    started.name = request.param
    yield started
    started.quit()


@pytest.fixture(scope="session")
def chart():
    """A coefficient image of patches, each lit and half of it lit once more by what another patch sends back."""
    model = bases.fitted(9)
    patches = np.stack([model.coefficients(each) for each in library.reflectances("colorchecker")]).reshape(4, 6, 9)
    colours = np.kron(patches, np.ones((30, 32, 1)))  # (120, 192, 9)
    height, width, _ = colours.shape
    y, x = np.mgrid[:height, :width] / np.array([height, width])[:, None, None]
    rng = np.random.default_rng(3)
    groups = {}
    for name, level in {"key": 1.1 - x[..., None], "window = 2": 0.3 + 0.8 * y[..., None], "lamp's": 0.15}.items():
        lit = level * (colours + 0.3 * colours * np.roll(colours, 32, axis=1))
        groups[name] = (lit * (1 + 0.01 * rng.standard_normal((height, width, 1)))).astype(np.float32)
    groups["key"][50:60, 90:102] *= 12.0  # a highlight, more than three stops above white
    return CoefficientImage(
        model=model,
        groups=groups,
        illuminants=dict(zip(groups, map(library.illuminant, ("A", "D65", "FL2")), strict=True)),
        alpha=np.ones((height, width), np.float32),
        view={"view_transform": "Standard", "look": "None", "exposure": 0.0, "gamma": 1.0, "display_device": "sRGB"},
    )


@pytest.fixture(scope="session")
def chart_exr(chart, tmp_path_factory):
    path = tmp_path_factory.mktemp("chart") / "chart.exr"
    coefficients.write(path, chart, chart.groups["key"][..., :3])
    return path


@pytest.fixture(scope="session")
def chart_page(chart, tmp_path_factory):
    """The page of the chart, and one more picture in it."""
    from relume.core.web import page

    path = tmp_path_factory.mktemp("page") / "chart.html"
    small = replace(chart, groups={k: v[:40] for k, v in chart.groups.items()}, alpha=chart.alpha[:40])
    page.write(
        path, [page.Picture("chart", {1: lambda: chart}), page.Picture("small", {5: lambda: small, 6: lambda: small})]
    )
    return path
