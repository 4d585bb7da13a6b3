"""Meshes for still lifes: turned on a lathe, or a cloth that has fallen. Metres, z up."""

from collections.abc import Sequence

import bpy
import numpy as np

__all__ = ["apple", "cloth", "grapes", "lathe", "lemon", "mesh_object", "pear", "profile", "smooth_profile", "stalk"]


def mesh_object(scene, name: str, corners, faces, material=None, smooth: bool = False):
    """A new object of a mesh, of one material."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(map(float, corner)) for corner in corners], [], [tuple(map(int, face)) for face in faces])
    if smooth:
        mesh.shade_smooth()
    if material is not None:
        mesh.materials.append(material)
    thing = bpy.data.objects.new(name, mesh)
    scene.collection.objects.link(thing)
    return thing


def lathe(scene, name: str, profile, material=None, segments: int = 64):
    """Turn a profile (points, 2) of radius and height about the z axis; where the radius is 0 it is closed.

    The profile runs with the outside on its right when it goes upwards, so that normals point outwards.
    """
    corners, rings = [], []
    angles = np.linspace(0.0, 2 * np.pi, segments, endpoint=False)
    for radius, height in np.asarray(profile, dtype=float):
        first = len(corners)
        if radius < 1e-6:
            corners.append((0.0, 0.0, height))
            rings.append([first] * segments)
        else:
            corners += [(radius * np.cos(a), radius * np.sin(a), height) for a in angles]
            rings.append(list(range(first, first + segments)))
    faces = []
    for lower, upper in zip(rings, rings[1:], strict=False):
        for k in range(segments):
            following = (k + 1) % segments
            face = [lower[k], lower[following], upper[following], upper[k]]
            faces.append(list(dict.fromkeys(face)))
    return mesh_object(scene, name, corners, faces, material, smooth=True)


def profile(text: str) -> np.ndarray:
    """Points of a profile, "radius height  radius height ..." in millimetres -> (points, 2) in metres."""
    return np.array(text.split(), dtype=float).reshape(-1, 2) / 1000


def smooth_profile(points: Sequence[tuple[float, float]], count: int = 64) -> np.ndarray:
    """A curve through the points of a profile (centripetal Catmull-Rom) -> (count, 2); radii stay above 0."""
    points = np.asarray(points, dtype=float)
    padded = np.vstack([2 * points[0] - points[1], points, 2 * points[-1] - points[-2]])
    found = []
    for t in np.linspace(0, len(points) - 1, count):
        k = min(int(t), len(points) - 2)
        u, (a, b, c, d) = t - k, padded[k : k + 4]
        found.append(0.5 * (2 * b + (c - a) * u + (2 * a - 5 * b + 4 * c - d) * u**2 + (3 * b - a - 3 * c + d) * u**3))
    found = np.array(found)
    found[:, 0] = np.maximum(found[:, 0], 0.0)
    found[[0, -1]] = points[[0, -1]]
    return found


def apple(radius: float) -> np.ndarray:
    """The profile of an apple, its stalk in a hollow; the lowest point at height 0."""
    t = np.linspace(0.0, np.pi, 72)
    across = np.sin(t) * (1.0 - 0.08 * np.cos(t))
    height = -0.88 * np.cos(t)
    height -= 0.42 * np.exp(-((across / 0.24) ** 2)) * (t > np.pi / 2)
    height += 0.24 * np.exp(-((across / 0.2) ** 2)) * (t < np.pi / 2)
    return _standing(across, height, radius)


def pear(radius: float) -> np.ndarray:
    """The profile of a pear."""
    points = [(0.0, 0.12), (0.3, 0.0), (0.78, 0.3), (1.0, 0.92), (0.82, 1.55), (0.52, 2.05), (0.4, 2.45), (0.26, 2.68)]
    profile = smooth_profile([*points, (0.0, 2.66)], 80)
    return _standing(profile[:, 0], profile[:, 1], radius)


def lemon(radius: float) -> np.ndarray:
    """The profile of a lemon that stands on its tip."""
    t = np.linspace(0.0, np.pi, 80)
    across, height = np.sin(t) ** 1.05, -1.18 * np.cos(t)
    height += np.sign(height) * 0.24 * np.exp(-((across / 0.2) ** 2)) * (1.0 + 0.4 * (height > 0))
    return _standing(across, height, radius)


def _standing(across, height, radius: float) -> np.ndarray:
    profile = np.stack([across, height - height.min()], axis=1) * radius
    profile[[0, -1], 0] = 0.0
    return profile


def stalk(scene, name: str, bottom, bend, radius: float, material):
    """A thin bent stalk that rises from a point by the vector `bend`."""
    curve = bpy.data.curves.new(name, "CURVE")
    curve.dimensions, curve.bevel_depth, curve.bevel_resolution, curve.use_fill_caps = "3D", radius, 3, True
    spline = curve.splines.new("BEZIER")
    spline.bezier_points.add(1)
    bottom, bend = np.asarray(bottom, float), np.asarray(bend, float)
    middle = bottom + bend * (0.2, 0.2, 0.6)
    spline.bezier_points[0].co, spline.bezier_points[1].co = bottom, bottom + bend
    spline.bezier_points[0].handle_left, spline.bezier_points[0].handle_right = bottom - bend * 0.2, middle
    spline.bezier_points[1].handle_left, spline.bezier_points[1].handle_right = middle, bottom + bend * 1.2
    spline.bezier_points[1].radius = 1.5
    curve.materials.append(material)
    thing = bpy.data.objects.new(name, curve)
    scene.collection.objects.link(thing)
    return thing


def grapes(count: int, radius: float, long: float, wide: float, seed: int = 3) -> np.ndarray:
    """Places (count, 3) of the grapes of a cluster that lies along x, pushed apart until they touch, above z = 0."""
    random = np.random.default_rng(seed)
    along = random.beta(1.1, 1.7, count)
    room = wide * (1.0 - 0.75 * along)[:, None]
    places = np.column_stack(
        [along * long, random.uniform(-1, 1, (count, 1)) * room, random.uniform(0, 1, count) * wide]
    )
    for _ in range(300):
        apart = places[:, None] - places[None]
        distance = np.linalg.norm(apart, axis=2) + np.eye(count)
        push = np.maximum(1.86 * radius - distance, 0.0) * (1 - np.eye(count))
        places += 0.25 * (push[..., None] * apart / distance[..., None]).sum(axis=1)
        places[:, 2] -= 0.02 * radius
        places[:, 1] *= 0.997
        places[:, 2] = np.maximum(places[:, 2], radius)
    return places


def cloth(scene, name: str, size, place, turned: float, material, frames: int = 60, seed: int = 5):
    """A cloth of `size` (x, y) that has fallen upon what is in the scene and collides, crumpled; a plain mesh."""
    columns, rows = (max(8, int(side / 0.0075)) for side in size)
    random = np.random.default_rng(seed)
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, columns) * size[0], np.linspace(-0.5, 0.5, rows) * size[1])
    z = np.zeros_like(x)
    for _ in range(7):  # long waves to fold along
        direction, phase = random.uniform(-0.7, 0.7), random.uniform(0, 6.3)
        z += 0.011 * np.sin((x * np.cos(direction) + y * np.sin(direction)) * random.uniform(25, 70) + phase)
    x *= 0.66  # gathered: what is too long for its place makes folds
    cosine, sine = np.cos(turned), np.sin(turned)
    corners = np.stack([x * cosine - y * sine + place[0], x * sine + y * cosine + place[1], z + place[2]], -1)
    index = np.arange(columns * rows).reshape(rows, columns)
    faces = np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]], -1).reshape(-1, 4)
    thing = mesh_object(scene, name, corners.reshape(-1, 3), faces, material, smooth=True)
    rest = mesh_object(scene, "rest", np.stack([x / 0.66, y, z * 0], -1).reshape(-1, 3), faces)
    modifier = thing.modifiers.new("Cloth", "CLOTH")
    settings, collisions = modifier.settings, modifier.collision_settings
    settings.quality, settings.mass, settings.bending_stiffness = 7, 0.25, 0.25
    settings.tension_stiffness = settings.compression_stiffness = settings.shear_stiffness = 20
    settings.air_damping = 2.0
    collisions.distance_min = collisions.self_distance_min = 0.002
    collisions.use_self_collision, collisions.friction = True, 20.0
    settings.rest_shape_key = None
    thing.shape_key_add(name="Basis")
    key = thing.shape_key_add(name="flat")
    key.data.foreach_set("co", np.ravel([v.co for v in rest.data.vertices]))
    key.value = 0.0
    settings.rest_shape_key = key
    bpy.data.objects.remove(rest)
    for frame in range(1, frames + 1):
        scene.frame_set(frame)
    evaluated = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    fallen = bpy.data.meshes.new_from_object(evaluated)
    thing.modifiers.clear()
    thing.shape_key_clear()
    thing.data = fallen
    fallen.shade_smooth()
    scene.frame_set(1)
    return thing
