"""What commands say of the error that is expected of a picture, and what would make it less."""

from ...core.errors import MeasureError, RelumeError
from ...core.picture import expectation
from ...core.picture.coefficients import CoefficientImage
from ...core.picture.content import Content
from ...core.picture.mix import Mix
from ..host import console
from ..host.steps import finished
from ..scene import content

__all__ = ["of", "seen", "tell"]


def seen(scene) -> Content | None:
    """What a scene shows; None where that cannot be said, which is no reason not to render it."""
    try:
        return content.content_of(scene)
    except RelumeError:
        return None


def of(image: CoefficientImage, mix: Mix) -> dict:
    """What is expected of a mix, as summary.json has it; where it is red, with what would help.

    Empty where nothing can be said: all that the scene shows is black.
    """
    try:
        found = expectation.expected(image.model, image.shows, mix)
    except MeasureError:
        return {}
    record = {"median": round(found.median, 4), "p98": round(found.p98, 4), "level": found.level}
    if found.level != expectation.LEVELS[-1]:
        return record
    better = finished(expectation.advising(image.model, image.shows, mix))
    return record | ({"better": better} if better else {})


def tell(record: dict, image: CoefficientImage, name: str = "") -> None:
    """Say what `of` found in a line. name: of the picture, where there may be several."""
    if not record or console.event("expected", picture=name, **record):
        return
    figures = expectation.words(expectation.Expectation(record["median"], record["p98"]), image.shows)
    better = f"; {record['better']}" if "better" in record else ""
    console.say(f"{name}{': ' if name else ''}{figures}{better}")
