"""What could not be made spectral in a scene, in the artist's words."""

import json
from dataclasses import astuple, dataclass

__all__ = ["REMARKS", "Remark", "clear", "of", "write"]

REMARKS = "relume_remarks"  # on a scene, as JSON


@dataclass(frozen=True)
class Remark:
    """One thing that stays as it was: which data-block, which of its nodes ("" for the whole), and why."""

    owner: str
    node: str
    why: str

    def __str__(self) -> str:
        return f"{self.owner}{f', {self.node}' if self.node else ''}: {self.why}"


def write(scene, remarks: list[Remark]) -> None:
    """Note the remarks of a scene's set-up, each once."""
    text = json.dumps([astuple(remark) for remark in dict.fromkeys(remarks)], ensure_ascii=False)
    if scene.get(REMARKS) != text:
        scene[REMARKS] = text


def of(scene) -> list[Remark]:
    """The remarks of a scene's last set-up."""
    return [Remark(*parts) for parts in json.loads(scene.get(REMARKS, "[]"))]


def clear(scene) -> None:
    if REMARKS in scene:
        del scene[REMARKS]
