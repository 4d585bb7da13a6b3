"""The room of [WE] section 3 without noise: matte walls that light each other, and two spheres looked into.

[WE] G. Ward, E. Eydelberg-Vileshin, "Picture perfect RGB rendering using spectral prefiltering and sharp color
     primaries", Eurographics Workshop on Rendering (2002).

Light between the walls is a radiosity of square patches; rays from the eye are traced, and what they meet is looked up:
spectra and coefficients of any model see the same geometry and differ by what they multiply alone. The spheres take in
light and mirror it, but throw none back and no shadow on the walls. Light is in units of what a lamp sends out.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from ..core.spectra.arrays import Array

__all__ = ["Room", "Surfaces", "look"]

Point = tuple[float, float, float]  # m

PATCHES = 12  # along each side of a wall
LAMP_POINTS = 8  # along each side of a lamp, for the light that falls on a patch
SEEN = 3  # mirrors one after the other


@dataclass(frozen=True)
class Room:
    """Its size (width, depth, height), bounces, and what is in it.

    x from -width/2, y and z from 0, m. spheres: (centre (3,), radius) of the plastic and of the metal; lamps: (centre
    (3,), side), squares that shine down. eye: position, target (3,), horizontal degrees, (width, height) in pixels.
    """

    size: Point
    bounces: int
    plastic: tuple[Point, float]
    metal: tuple[Point, float]
    lamps: tuple[tuple[Point, float], ...]
    eye: tuple[Point, Point, float, tuple[int, int]]


@dataclass(frozen=True, eq=False)
class Surfaces:
    """What is multiplied, in c wavelengths or channels: walls (6, c) in the order of `_frames`; the plastic's own (c,)
    under a mirror that takes `specular`; metal: cosines (n,) -> (n, c)."""

    walls: Array
    plastic: Array
    specular: float
    metal: Callable[[Array], Array]


def _frames(size: Point) -> list[tuple[Array, Array, Array]]:
    """(corner, one side, other side) of floor, ceiling, far, near, left and right wall."""
    w, d, h = size
    x, y, z = np.diag(size)
    low = np.array([-w / 2, 0, 0])
    return [(low, x, y), (low + z, x, y), (low + y, x, z), (low, x, z), (low, y, z), (low + x, y, z)]


INWARD = np.array([[0, 0, 1], [0, 0, -1], [0, -1, 0], [0, 1, 0], [1, 0, 0], [-1, 0, 0]], float)


def _centres(size: Point) -> tuple[Array, Array, Array]:
    """Centres (6 n², 3), normals (6 n², 3) and areas (6 n²,) of all patches, wall after wall."""
    steps = (np.arange(PATCHES) + 0.5) / PATCHES
    a, b = (part.ravel() for part in np.meshgrid(steps, steps, indexing="ij"))
    centres, areas = [], []
    for corner, one, other in _frames(size):
        centres.append(corner + a[:, None] * one + b[:, None] * other)
        areas.append(np.full(a.size, np.linalg.norm(one) * np.linalg.norm(other) / a.size))
    return np.concatenate(centres), np.repeat(INWARD, a.size, axis=0), np.concatenate(areas)


def _received(points: Array, normals: Array, sources: Array, facing: Array, areas: Array) -> Array:
    """Of the light that leaves each source, what falls on each point: (points, sources)."""
    between = sources - points[:, None]
    squared = np.maximum((between**2).sum(axis=-1), 1e-12)
    here = np.maximum((between * normals[:, None]).sum(axis=-1), 0)
    there = np.maximum(-(between * facing).sum(axis=-1), 0)
    return here * there / (np.pi * squared**2) * areas


def _lamp_light(points: Array, normals: Array, centre: Point, side: float) -> Array:
    """What falls of a lamp on each point (points,)."""
    steps = ((np.arange(LAMP_POINTS) + 0.5) / LAMP_POINTS - 0.5) * side
    a, b = (part.ravel() for part in np.meshgrid(steps, steps))
    sources = np.array(centre) + np.stack([a, b, 0 * a], axis=1)
    facing = np.tile([0.0, 0.0, -1.0], (a.size, 1))
    return _received(points, normals, sources, facing, np.full(a.size, side**2 / a.size)).sum(axis=1)


@cache
def _exchange(size: Point) -> Array:
    """(patches, patches): what each receives of each; all that leaves one arrives somewhere, for the room is closed."""
    centres, normals, areas = _centres(size)
    matrix = _received(centres, normals, centres, normals, areas)
    return matrix / matrix.sum(axis=1, keepdims=True)


def _falling(room: Room, surfaces: Surfaces, lamp: int, power: Array) -> Array:
    """Light that falls on every patch (patches, c) of one lamp of `power` (c,), after all bounces."""
    centres, normals, _ = _centres(room.size)
    direct = _lamp_light(centres, normals, *room.lamps[lamp])[:, None] * power
    back, falling = np.repeat(surfaces.walls, PATCHES**2, axis=0), direct
    for _ in range(room.bounces):
        falling = direct + _exchange(room.size) @ (back * falling)
    return falling


def rays(room: Room) -> tuple[Array, Array]:
    """Origins and directions (pixels, 3), row by row from the top left."""
    position, target, degrees, (width, height) = (np.array(part) for part in room.eye)
    ahead = (target - position) / np.linalg.norm(target - position)
    right = np.cross(ahead, [0, 0, 1.0])
    right /= np.linalg.norm(right)
    up = np.cross(right, ahead)
    half = np.tan(np.radians(degrees) / 2)
    across = ((np.arange(width) + 0.5) / width * 2 - 1) * half
    down = (1 - (np.arange(height) + 0.5) / height * 2) * half * height / width
    directions = ahead + across[None, :, None] * right + down[:, None, None] * up
    directions = directions.reshape(-1, 3)
    return np.tile(position, (len(directions), 1)), directions / np.linalg.norm(directions, axis=1, keepdims=True)


def _sphere(origins: Array, directions: Array, centre: Point, radius: float) -> Array:
    """Distances (n,) along rays to a sphere; infinite where it is missed."""
    towards = origins - np.array(centre)
    middle = (towards * directions).sum(axis=1)
    inside = middle**2 - (towards**2).sum(axis=1) + radius**2
    distance = -middle - np.sqrt(np.maximum(inside, 0))
    return np.where((inside > 0) & (distance > 1e-6), distance, np.inf)


def _walls(room: Room, origins: Array, directions: Array) -> tuple[Array, Array]:
    """Which wall (n,) rays meet and how far away (n,)."""
    corners = np.array([frame[0] for frame in _frames(room.size)])
    speed = directions @ INWARD.T
    heights = ((origins[:, None] - corners) * INWARD).sum(axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        distances = np.where(speed < -1e-9, -heights / speed, np.inf)
    return distances.argmin(axis=1), distances.min(axis=1)


def _on_wall(room: Room, wall: Array, points: Array, values: Array) -> Array:
    """Values of patches (patches, c) at points (n, 3) of walls (n,), between centres linearly."""
    found = np.empty((len(points), values.shape[1]))
    grids = values.reshape(6, PATCHES, PATCHES, -1)
    for index, (corner, *sides) in enumerate(_frames(room.size)):
        here = wall == index
        part = [((points[here] - corner) @ side) / (side @ side) * PATCHES - 0.5 for side in sides]
        low = [np.clip(np.floor(each), 0, PATCHES - 2).astype(int) for each in part]
        a, b = (np.clip(each - first, -0.5, 1.5)[:, None] for each, first in zip(part, low, strict=True))
        (i, j), grid = low, grids[index]
        first = grid[i, j] * (1 - a) + grid[i + 1, j] * a
        found[here] = first * (1 - b) + (grid[i, j + 1] * (1 - a) + grid[i + 1, j + 1] * a) * b
    return found


def _mirrored(directions: Array, normals: Array) -> Array:
    return directions - 2 * (directions * normals).sum(axis=1, keepdims=True) * normals


def look(room: Room, surfaces: Surfaces, lamp: int, power: Array) -> tuple[Array, Array]:
    """What every pixel sees with one lamp of `power` (c,) lit -> light (height, width, c), what it meets first.

    That is (height, width) of str: "walls", "plastic", "gold" or "lamp".
    """
    falling = _falling(room, surfaces, lamp, power)
    leaving = np.repeat(surfaces.walls, PATCHES**2, axis=0) * falling
    centres, normals, areas = _centres(room.size)

    def seen(origins: Array, directions: Array, mirrors: int) -> tuple[Array, Array]:
        wall, distance = _walls(room, origins, directions)
        points = origins + distance[:, None] * directions
        light = surfaces.walls[wall] * _on_wall(room, wall, points, falling)
        names = np.full(len(origins), "walls", dtype=object)
        for index, (centre, side) in enumerate(room.lamps):
            down = (centre[2] - origins[:, 2]) / np.where(directions[:, 2] > 1e-9, directions[:, 2], np.nan)
            at = origins + down[:, None] * directions
            shines = (np.abs(at[:, :2] - centre[:2]) < side / 2).all(axis=1) & (down > 0)
            light[shines] = power if index == lamp else 0.0
            names[shines] = "lamp"
            distance = np.where(shines, down, distance)
        for name, (centre, radius) in (("plastic", room.plastic), ("gold", room.metal)):
            reached = _sphere(origins, directions, centre, radius)
            here = reached < distance
            if not here.any() or not mirrors:
                continue
            distance = np.where(here, reached, distance)
            at = origins[here] + reached[here, None] * directions[here]
            outward = (at - np.array(centre)) / radius
            mirror, _ = seen(at, _mirrored(directions[here], outward), mirrors - 1)
            names[here] = name
            if name == "gold":
                light[here] = surfaces.metal(-(directions[here] * outward).sum(axis=1)) * mirror
            else:
                arriving = _received(at, outward, centres, normals, areas) @ leaving
                arriving += _lamp_light(at, outward, *room.lamps[lamp])[:, None] * power
                light[here] = (1 - surfaces.specular) * surfaces.plastic * arriving + surfaces.specular * mirror
        return light, names

    light, names = seen(*rays(room), SEEN)
    width, height = room.eye[3]
    return light.reshape(height, width, -1), names.reshape(height, width)
