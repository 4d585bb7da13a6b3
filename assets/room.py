"""Interiors as data, the test room of [WE] section 3 first: `make_room` builds them in Blender, benchmarks elsewhere.

Metres; x to the right, y away from the viewer, z up. The near wall stands behind the camera.
"""

from dataclasses import dataclass

import numpy as np

__all__ = ["ROOM", "SIZE", "Camera", "Interior", "Lamp", "Sphere", "Wall", "walls"]


@dataclass(frozen=True)
class Wall:
    """A rectangle: its corners in order, its normal pointing into the room, and a reflectance of the library."""

    name: str
    corners: tuple[tuple[float, float, float], ...]
    reflectance: str


@dataclass(frozen=True)
class Sphere:
    name: str
    centre: tuple[float, float, float]
    radius: float
    material: str  # "plastic", "conductor" or "glass"
    spectrum: str  # a reflectance, which tints what passes a glass or is mirrored in it, or a conductor of the library
    specular: float = 0.0  # mirror part of a plastic
    index: float = 1.0  # of refraction of a glass
    roughness: float = 0.0  # of a glass: Blender's, the root of the width of GGX


@dataclass(frozen=True)
class Lamp:
    """A square area light; `watts` are Blender's, before any spectrum."""

    name: str
    centre: tuple[float, float, float]
    side: float
    illuminant: str
    watts: float
    facing: tuple[float, float, float] = (0.0, 0.0, -1.0)  # along an axis
    group: str = ""  # its light group, called as it is where none is given

    @property
    def light_group(self) -> str:
        return self.group or self.name

    @property
    def corners(self) -> np.ndarray:
        """(4, 3), in the order of which the normal is where it shines."""
        normal = np.array(self.facing)
        across = np.roll(np.abs(normal), 1)
        signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
        return self.centre + self.side / 2 * (signs @ np.stack([across, np.cross(normal, across)]))


@dataclass(frozen=True)
class Camera:
    position: tuple[float, float, float]
    target: tuple[float, float, float]
    horizontal_degrees: float
    resolution: tuple[int, int]


@dataclass(frozen=True)
class Interior:
    name: str
    walls: tuple[Wall, ...]
    spheres: tuple[Sphere, ...]
    lamps: tuple[Lamp, ...]
    camera: Camera
    max_bounces: int = 8

    @property
    def lighting(self) -> dict[str, str]:
        """{light group: its illuminant}."""
        return {lamp.light_group: lamp.illuminant for lamp in self.lamps}


def walls(
    width: float, depth: float, height: float, near: str, left: str, right: str, neutral: str
) -> tuple[Wall, ...]:
    """Those of a box that the viewer looks into, from the reflectances of three; all else is neutral."""
    w, d, h = width / 2, depth, height
    return (
        Wall("floor", ((-w, 0, 0), (w, 0, 0), (w, d, 0), (-w, d, 0)), neutral),
        Wall("ceiling", ((-w, 0, h), (-w, d, h), (w, d, h), (w, 0, h)), neutral),
        Wall("far wall", ((-w, d, 0), (w, d, 0), (w, d, h), (-w, d, h)), neutral),
        Wall("near wall", ((-w, 0, 0), (-w, 0, h), (w, 0, h), (w, 0, 0)), near),
        Wall("left wall", ((-w, 0, 0), (-w, d, 0), (-w, d, h), (-w, 0, h)), left),
        Wall("right wall", ((w, 0, 0), (w, 0, h), (w, d, h), (w, d, 0)), right),
    )


SIZE = (4.0, 4.0, 3.2)
ROOM = Interior(
    "Room",
    walls(
        *SIZE,
        near="ColorChecker: blue flower",
        left="ColorChecker: red",
        right="ColorChecker: blue",
        neutral="ColorChecker: neutral 8 (.23 D)",
    ),
    (
        Sphere("green plastic", (-0.75, 2.95, 0.6), 0.6, "plastic", "ColorChecker: green", specular=0.05),
        Sphere("gold", (0.75, 2.45, 0.6), 0.6, "conductor", "gold"),
    ),
    (
        Lamp("tungsten", (-1.0, 2.3, SIZE[2] - 0.02), 1.2, "A", 60.0),
        Lamp("fluorescent", (1.0, 2.3, SIZE[2] - 0.02), 1.2, "FL2", 60.0),
    ),
    Camera((0.0, 0.05, 1.75), (0.0, 4.0, 1.22), 70.0, (480, 360)),
)
