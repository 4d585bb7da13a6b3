"""Error against run time, drawn without a library."""

import xml.etree.ElementTree as ElementTree

import numpy as np

from relume.core.picture import scatter

POINTS = [
    scatter.Point("RGB", 2.0, 4.0, 3.9),
    scatter.Point("9 channels", 4.0, 0.9, 0.12),
    scatter.Point("automatic", 3.0, 0.95, 0.3),
    scatter.Point("reference", 12.0, 0.8, 0.0),
]
NAMESPACE = "{http://www.w3.org/2000/svg}"


def centre_of(picture, colour):
    rows, columns = np.nonzero(np.abs(picture[..., :3] - colour).max(axis=2) < 0.02)
    return columns.mean(), rows.mean()


def test_slower_is_to_the_right_and_worse_is_higher():
    picture = scatter.picture(POINTS, "automatic")
    assert picture.shape == (256, 256, 4) and picture.dtype == np.float32
    places = [centre_of(picture, colour) for colour in scatter.colours(POINTS, "automatic")]
    order = [point.seconds for point in POINTS]
    assert np.argsort([x for x, _ in places]).tolist() == np.argsort(order).tolist()
    assert places[0][1] > max(y for _, y in places[1:]), "RGB errs most"


def test_no_two_of_a_dozen_points_share_a_colour():
    many = [scatter.Point(str(number), 1.0, 1.0, 1.0) for number in range(12)]
    assert len(set(scatter.colours(many, "7"))) == len(many)


def test_the_document_names_every_point_and_its_words_do_not_lie_on_each_other():
    crowded = [*POINTS, scatter.Point("a < b & c", 3.01, 0.95, 0.3)]
    root = ElementTree.fromstring(scatter.svg(crowded, "automatic", "title", "seconds", "error"))
    texts = {node.text: node for node in root.iter(f"{NAMESPACE}text")}
    assert {point.name for point in crowded} <= texts.keys() and {"title", "seconds", "error"} <= texts.keys()
    heights = sorted(float(texts[point.name].get("y")) for point in crowded)
    assert min(np.diff(heights)) >= 14
    width, height = (float(number) for number in root.get("viewBox").split()[2:])
    for dot in root.iter(f"{NAMESPACE}circle"):
        assert 0 < float(dot.get("cx")) < width and 0 < float(dot.get("cy")) < height


def test_one_point_is_enough():
    (one,) = [scatter.Point("RGB", 1.0, 1.0, 1.0)]
    assert np.isfinite(scatter.picture([one], "")).all()
    assert "RGB" in scatter.svg([one], "", "", "", "")
