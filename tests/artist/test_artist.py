"""A scene that is set up follows its artist: sequences of random edits, compared with a fresh set-up and with the same
edits without Relume. `python -m tests.artist` plays as many as you like."""

import importlib.util
import os
import time

import pytest

pytest.importorskip("bpy", reason="an artist's session needs bpy")

from .play import Crew, play, sequence, shrunk, told  # noqa: E402

SEED = int(os.environ.get("RELUME_SEED", "0"))
_MINUTE = 60.0

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("relume.addon.scene.follower") is None, reason="nothing follows the artist yet"
)


@pytest.fixture(scope="module")
def crew(tmp_path_factory):
    crew = Crew(tmp_path_factory.mktemp("artist"))
    yield crew
    crew.stop()


def _plays(crew, seed: int, length: int, every: int, pictures: float, shrinking: float):
    take = sequence(seed, length, crew.scenes, crew.kinds)
    failure = play(crew, take, every, pictures)
    if failure is not None:
        pytest.fail(told(seed, *shrunk(crew, take, failure, failure.causes, shrinking)), pytrace=False)


@pytest.mark.parametrize("seed", range(SEED, SEED + 5), ids="RELUME_SEED={}".format)
def test_a_few_edits(crew, seed):
    _plays(crew, seed, 12, 4, 0.3 if seed == SEED else 0.0, 30.0)


@pytest.mark.torture
def test_many_edits(crew):
    ends = time.monotonic() + 20 * _MINUTE * float(os.environ.get("RELUME_TORTURE", "1"))
    seed, edits = SEED, 0
    while time.monotonic() < ends:
        _plays(crew, seed, 40, 4, 0.05, 3 * _MINUTE)
        seed, edits = seed + 1, edits + 40
    print(f"{edits} edits of {seed - SEED} sequences from RELUME_SEED={SEED} on")
