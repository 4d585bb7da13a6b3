"""The test room of [WE] section 3, as data: what `make_room` builds in Blender and the benchmarks build elsewhere.

Metres; x to the right, y away from the viewer, z up. The near wall stands behind the camera.
"""

from dataclasses import dataclass

__all__ = ["CAMERA", "LAMPS", "MAX_BOUNCES", "SIZE", "SPHERES", "WALLS", "Camera", "Lamp", "Sphere", "Wall"]

SIZE = (4.0, 4.0, 3.2)
MAX_BOUNCES = 8


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
    material: str  # "plastic" or "conductor"
    spectrum: str  # a reflectance, or a conductor of the library
    specular: float = 0.0  # mirror part of a plastic


@dataclass(frozen=True)
class Lamp:
    """A square area light in the ceiling that shines down; `watts` are Blender's, before any spectrum."""

    name: str
    centre: tuple[float, float, float]
    side: float
    illuminant: str
    watts: float


@dataclass(frozen=True)
class Camera:
    position: tuple[float, float, float]
    target: tuple[float, float, float]
    horizontal_degrees: float
    resolution: tuple[int, int]


_W, _D, _H = SIZE[0] / 2, SIZE[1], SIZE[2]
_NEUTRAL = "ColorChecker: neutral 8 (.23 D)"

WALLS = (
    Wall("floor", ((-_W, 0, 0), (_W, 0, 0), (_W, _D, 0), (-_W, _D, 0)), _NEUTRAL),
    Wall("ceiling", ((-_W, 0, _H), (-_W, _D, _H), (_W, _D, _H), (_W, 0, _H)), _NEUTRAL),
    Wall("far wall", ((-_W, _D, 0), (_W, _D, 0), (_W, _D, _H), (-_W, _D, _H)), _NEUTRAL),
    Wall("near wall", ((-_W, 0, 0), (-_W, 0, _H), (_W, 0, _H), (_W, 0, 0)), "ColorChecker: blue flower"),
    Wall("left wall", ((-_W, 0, 0), (-_W, _D, 0), (-_W, _D, _H), (-_W, 0, _H)), "ColorChecker: red"),
    Wall("right wall", ((_W, 0, 0), (_W, 0, _H), (_W, _D, _H), (_W, _D, 0)), "ColorChecker: blue"),
)
SPHERES = (
    Sphere("green plastic", (-0.75, 2.95, 0.6), 0.6, "plastic", "ColorChecker: green", specular=0.05),
    Sphere("gold", (0.75, 2.45, 0.6), 0.6, "conductor", "gold"),
)
LAMPS = (
    Lamp("tungsten", (-1.0, 2.3, _H - 0.02), 1.2, "A", 60.0),
    Lamp("fluorescent", (1.0, 2.3, _H - 0.02), 1.2, "FL2", 60.0),
)
CAMERA = Camera((0.0, 0.05, 1.75), (0.0, 4.0, 1.22), 70.0, (480, 360))
