"""Interiors in LuxCore, which renders red, green and blue: for orientation beside the spectral renderers.

Reflectances, conductors and lamps are given in linear Rec.709, as Blender's own RGB render shows them. Its lamps are
meshes and let no light through. It renders in a process of its own (`luxcore_session`).
"""

import importlib.util
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from ..assets import room
from ..core.colour import spaces
from ..core.model import bases, upsample
from ..core.spectra import library
from . import luxcore_session

__all__ = ["LuxCore"]

_RINGS, _SEGMENTS = 64, 128  # of a sphere, as in Blender


def _words(values) -> list[float]:
    return [float(value) for value in values]


def _paint(name: str) -> list[float]:
    return _words(bases.rgb().coefficients(library.reflectance(name)))


def _matte(color: list[float]) -> dict:
    return {"type": "matte", "kd": color}


def _material(sphere: room.Sphere) -> tuple[dict, dict]:
    """The settings of a sphere's material, and {key: value} of what it is made of."""
    name = _key(sphere.name)
    if sphere.material == "conductor":
        n, k = (_words(bases.rgb().coefficients(each)) for each in library.conductor(sphere.spectrum))
        fresnel = {"type": "fresnelconst", "n": n, "k": k}
        metal = {"type": "metal2", "fresnel": f"{name}_fresnel", "uroughness": 1e-3, "vroughness": 1e-3}
        return metal, {f"scene.textures.{name}_fresnel.{key}": value for key, value in fresnel.items()}
    tint = _paint(sphere.spectrum)
    if sphere.material == "glass":
        width = sphere.roughness**2
        rough = {"type": "roughglass", "uroughness": width, "vroughness": width} if width else {"type": "glass"}
        return rough | {"kr": tint, "kt": tint, "interiorior": sphere.index}, {}
    parts = {"matte": _matte(tint), "mirror": {"type": "mirror", "kr": [1.0, 1.0, 1.0]}}
    mix = {"type": "mix", "material1": f"{name}_matte", "material2": f"{name}_mirror", "amount": sphere.specular}
    return mix, {f"scene.materials.{name}_{a}.{key}": value for a, b in parts.items() for key, value in b.items()}


def _sphere(sphere: room.Sphere) -> tuple[np.ndarray, list, list]:
    """Points, triangles and normals."""
    polar, around = np.meshgrid(
        np.linspace(0, np.pi, _RINGS + 1), np.linspace(0, 2 * np.pi, _SEGMENTS + 1), indexing="ij"
    )
    normals = np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], axis=-1)
    index = np.arange(normals.shape[0] * normals.shape[1]).reshape(normals.shape[:2])
    a, b, c, d = (each.ravel() for each in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]))
    triangles = [*zip(a, b, c, strict=True), *zip(a, c, d, strict=True)]
    normals = normals.reshape(-1, 3)
    return sphere.centre + sphere.radius * normals, triangles, list(normals)


def _lamp_color(lamp: room.Lamp) -> np.ndarray:
    """(3,) radiance in linear Rec.709, with the luminance that Blender's watts have."""
    color = spaces.xyz_to_rgb() @ bases.bands().relight(library.illuminant(lamp.illuminant)).sum(axis=1)
    return np.maximum(color, 0.0) * lamp.watts / (np.pi * lamp.side**2)


def _mesh(name: str, points, triangles=((0, 1, 2), (0, 2, 3)), normals=None) -> tuple:
    """As `luxcore_session` takes it."""
    rows = [_words(point) for point in points]
    return _key(name), rows, [[int(i) for i in each] for each in triangles], normals and [*map(_words, normals)]


def _key(name: str) -> str:
    """A name as LuxCore's keys take it, whose parts are divided by dots."""
    return "".join(letter if letter.isalnum() else "_" for letter in name)


def _scene(interior: room.Interior, aspect: float) -> tuple[dict, list]:
    """{key: value}, and the meshes."""
    camera = interior.camera
    found: dict = {
        "scene.camera.type": "perspective",
        "scene.camera.lookat.orig": _words(camera.position),
        "scene.camera.lookat.target": _words(camera.target),
        "scene.camera.up": [0.0, 0.0, 1.0],
        "scene.camera.fieldofview": camera.horizontal_degrees,
        "scene.camera.screenwindow": [-1.0, 1.0, -aspect, aspect],
        "scene.camera.cliphither": 0.01,
    }
    things = [(wall.name, _matte(_paint(wall.reflectance)), _mesh(wall.name, wall.corners)) for wall in interior.walls]
    things += [
        (lamp.name, _matte([0.0] * 3) | {"emission": _words(_lamp_color(lamp))}, _mesh(lamp.name, lamp.corners))
        for lamp in interior.lamps
    ]
    for sphere in interior.spheres:
        material, more = _material(sphere)
        things.append((sphere.name, material, _mesh(sphere.name, *_sphere(sphere))))
        found |= more
    for name, material, _ in things:
        key = _key(name)
        found |= {f"scene.materials.{key}.{setting}": value for setting, value in material.items()}
        found |= {f"scene.objects.{key}.shape": key, f"scene.objects.{key}.material": key}
    return found, [mesh for *_, mesh in things]


class LuxCore:
    """An interior in LuxCore, in pictures of one size. Raises ImportError where it is not installed."""

    def __init__(self, interior: room.Interior, size: tuple[int, int]):
        if importlib.util.find_spec("pyluxcore") is None:
            raise ImportError("the package pyluxcore is not installed")
        self.size, self.bounces = size, interior.max_bounces
        self.scene, self.meshes = _scene(interior, size[1] / size[0])

    def samples(self, count: int) -> int:
        return count

    def render(self, count: int, seed: int) -> tuple[float, np.ndarray]:
        """The processor's seconds, and (height, width, 3) XYZ in Blender's unit."""
        width, height = self.size
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "rgb"
            asked = {"settings": self._settings(count, seed), "scene": self.scene, "meshes": self.meshes}
            command = [sys.executable, "-m", luxcore_session.__name__]
            said = json.dumps(asked | {"path": str(path)})
            done = subprocess.run(command, input=said, capture_output=True, text=True)
            if done.returncode:
                raise RuntimeError(f"LuxCore failed:\n{done.stdout}{done.stderr}")
            rgb = np.fromfile(path, dtype=np.float32).reshape(height, width, 3)[::-1]
        return json.loads(done.stdout.splitlines()[-1]), rgb @ upsample.rgb_to_xyz().T

    def _settings(self, count: int, seed: int) -> dict:
        depths = {f"path.pathdepth.{kind}": self.bounces + 1 for kind in ("total", "diffuse", "glossy", "specular")}
        return depths | {
            "renderengine.type": "PATHCPU",
            "sampler.type": "SOBOL",
            "sampler.sobol.adaptive.strength": 0.0,
            "batch.haltspp": count,
            "renderengine.seed": seed + 1,
            "film.width": self.size[0],
            "film.height": self.size[1],
            "film.filter.type": "BOX",
            "film.filter.width": 0.5,
            "film.outputs.0.type": "RGB",
            "film.outputs.0.filename": "unused.exr",
        }
