"""Interiors in Cycles with any factor model, asked for as the peers are (`mitsuba_interiors`, `luxcore_interiors`)."""

import tempfile
import time
from pathlib import Path

import numpy as np

from ..addon.scene import render, setup
from ..assets import make_room, room
from ..core.model.factor_model import FactorModel
from ..core.picture import coefficients

__all__ = ["Cycles"]

_SEED_STEP = 1000


class Cycles:
    """An interior with a factor model. same_seed: every pass takes all its samples, with the same noise. as_sampled:
    noise of colour is not taken out."""

    def __init__(
        self,
        interior: room.Interior,
        percent: int,
        model: FactorModel,
        same_seed: bool = False,
        as_sampled: bool = False,
    ):
        self.interior, self.percent, self.model = interior, percent, model
        self.same_seed, self.as_sampled = same_seed, as_sampled

    def samples(self, count: int) -> int:
        """Of all passes together, where `count` of them are asked for."""
        return self._set(count) * self.model.passes if self.same_seed else count

    def _set(self, count: int) -> int:
        return -(-count // self.model.passes) if self.same_seed else count

    def render(self, count: int, seed: int) -> tuple[float, np.ndarray]:
        """The processor's seconds, and (height, width, 3) XYZ under the interior's own lamps."""
        scene = make_room.build(self.interior)
        scene.render.resolution_percentage, scene.cycles.samples = self.percent, self._set(count)
        scene.cycles.pixel_filter_type, scene.cycles.seed = "BOX", _SEED_STEP * seed
        scene.relume.same_seed, scene.relume.split_samples = self.same_seed, not self.same_seed
        scene.relume.reduce_color_noise = not self.as_sampled
        setup.set_up(scene, self.model)
        with tempfile.TemporaryDirectory() as folder:
            began = time.process_time()
            image = render.render(scene, Path(folder)).image
            xyz = coefficients.to_xyz(image, {group.name: group.light() for group in scene.relume.light_groups})
            return time.process_time() - began, xyz
