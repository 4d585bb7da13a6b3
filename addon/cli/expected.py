"""What commands say of the error that is expected of a picture, and what would make it less."""

from ...core.picture import expectation
from ...core.picture.coefficients import CoefficientImage
from ...core.picture.mix import Mix
from ..host import console

__all__ = ["of", "tell"]


def of(image: CoefficientImage, mix: Mix) -> dict:
    """What is expected of a mix, as summary.json has it; where it is red, with what would help."""
    found = expectation.expected(image.model, image.shows, mix)
    record = {"median": round(found.median, 4), "p98": round(found.p98, 4), "level": found.level}
    better = expectation.advice(image.model, image.shows, mix) if found.level == expectation.LEVELS[-1] else ""
    return record | ({"better": better} if better else {})


def tell(record: dict, image: CoefficientImage, name: str = "") -> None:
    """Say what `of` found in a line. name: of the picture, where there may be several."""
    if console.event("expected", picture=name, **record):
        return
    figures = expectation.words(expectation.Expectation(record["median"], record["p98"]), image.shows)
    better = f"; {record['better']}" if "better" in record else ""
    console.say(f"{name}{': ' if name else ''}{figures}{better}")
