"""The interiors that Relume and its peers render: the room, the same with glasses, and a shop with many lamps."""

import numpy as np

from ..assets import room
from ..assets.room import Camera, Interior, Lamp, Sphere, Wall

__all__ = ["GLASS", "INTERIORS", "SHOP"]

GLASS = Interior(
    "Glass",
    room.ROOM.walls,
    (
        Sphere("clear glass", (-0.75, 2.95, 0.6), 0.6, "glass", "ColorChecker: bluish green", index=1.5),
        Sphere("frosted glass", (0.75, 2.45, 0.6), 0.6, "glass", "ColorChecker: yellow", index=1.5, roughness=0.3),
        Sphere("gold", (0.0, 1.9, 0.3), 0.3, "conductor", "gold"),
    ),
    room.ROOM.lamps,
    room.ROOM.camera,
)

_SEED = 20240612
_SIZE = (6.0, 6.0, 3.0)
_ON_EACH = {"ceiling": 32, "left wall": 8, "right wall": 8}  # lamps
_OFF = 0.02  # metres between a lamp and its wall
_SIDE = 0.12
_ILLUMINANTS = ("A", "FL2", "LED-B3", "D65")
_PAINTS = ("orange", "cyan", "purple", "yellow green", "magenta", "light skin", "moderate red", "foliage")


def _shop_lamps() -> tuple[Lamp, ...]:
    """Small lamps of uneven power at random places, in a light group for each illuminant."""
    random = np.random.default_rng(_SEED)
    width, depth, height = _SIZE
    lamps: list[Lamp] = []
    for wall, count in _ON_EACH.items():
        side = {"ceiling": 0.0, "left wall": -1.0, "right wall": 1.0}[wall]
        for u, v, watts in random.uniform((0.05, 0.05, 1.0), (0.95, 0.95, 8.0), (count, 3)):
            if side:
                centre, facing = (side * (width / 2 - _OFF), v * depth, (0.35 + 0.6 * u) * height), (-side, 0.0, 0.0)
            else:
                centre, facing = ((u - 0.5) * width, v * depth, height - _OFF), (0.0, 0.0, -1.0)
            illuminant = _ILLUMINANTS[len(lamps) % len(_ILLUMINANTS)]
            lamps.append(Lamp(f"lamp {len(lamps)}", centre, _SIDE, illuminant, watts, facing, illuminant))
    return tuple(lamps)


def _partition() -> tuple[Wall, ...]:
    """A screen that hides half of the lamps from what stands behind it: two walls back to back."""
    x, near, far, top = 0.9, 3.2, 5.4, 2.0
    front = ((x, near, 0), (x, far, 0), (x, far, top), (x, near, top))
    back = tuple((x + _OFF, *rest) for _, *rest in front)
    paint = "ColorChecker: moderate red"
    return Wall("screen, right", back, paint), Wall("screen, left", tuple(front[i] for i in (0, 3, 2, 1)), paint)


def _shop_spheres() -> tuple[Sphere, ...]:
    """Balls of many paints on the floor, and one of copper."""
    balls = []
    for index, paint in enumerate(_PAINTS):
        x, y = -2.2 + 1.25 * (index % 4), 3.1 + 1.5 * (index // 4)
        balls.append(Sphere(paint, (x, y, 0.4), 0.4, "plastic", f"ColorChecker: {paint}", specular=0.05))
    return (*balls, Sphere("copper", (-0.2, 2.3, 0.3), 0.3, "conductor", "Copper"))


SHOP = Interior(
    "Shop",
    (
        *room.walls(
            *_SIZE,
            near="ColorChecker: blue sky",
            left="ColorChecker: blue flower",
            right="ColorChecker: orange yellow",
            neutral="ColorChecker: neutral 8 (.23 D)",
        ),
        *_partition(),
    ),
    _shop_spheres(),
    _shop_lamps(),
    Camera((0.0, 0.05, 1.7), (0.0, 6.0, 0.9), 75.0, (480, 360)),
)

INTERIORS = {"room": room.ROOM, "glass": GLASS, "shop": SHOP}
