"""Files that an older Relume saved open, relight and are given back, for ever after."""

import json
from pathlib import Path

import bpy
import numpy as np
import pytest
from dump import differences, dump
from test_mixer import sockets

from relume.addon.scene import setup, view_layers
from relume.addon.store import mixer, schema

DATA = Path(__file__).parents[1] / "data"


@pytest.fixture
def old():
    bpy.ops.wm.open_mainfile(filepath=str(DATA / "saved_by_0_1_0.blend"))
    return bpy.context.scene


def test_a_scene_of_0_1_0_is_relit(old):
    assert schema.VERSION > 1 and "relume_version" not in old, "it was written before versions were noted"
    shown, preview = sockets(old), np.array(old.view_layers["ViewLayer"]["relume_w0"])
    setup.relight(old)
    assert old.relume.problem == ""
    assert np.allclose(sockets(old), shown, rtol=1e-4, atol=1e-6), "what 0.1.0 wrote"
    assert np.allclose(np.array(old.view_layers["ViewLayer"]["relume_w0"]), preview, rtol=1e-4)
    old.frame_set(10)
    assert [row.stops for row in old.relume.light_groups] == [0.0, -3.0, 0.0]
    # The last group's pass holds all light: of the others it shows the difference
    fill = [(each[1] + each[2]).sum(axis=0)[1] for each in (shown, sockets(old))]
    assert fill[1] == pytest.approx(fill[0] / 8, rel=0.05), "three stops darker, but for the white balance"


def test_a_snapshot_of_0_1_0_is_applied(old):
    assert bpy.ops.relume.apply_snapshot() == {"FINISHED"}
    rows = {row.name: (row.source, row.illuminant, row.temperature) for row in old.relume.light_groups}
    assert rows["key"][:2] == ("LIBRARY", "HP1") and rows["fill"][::2] == ("PLANCKIAN", 3200.0)
    assert old.relume.white_balance == 0.0


def test_a_scene_of_0_1_0_is_given_back_as_0_1_0_did(old):
    bpy.ops.wm.open_mainfile(filepath=str(DATA / "removed_by_0_1_0.blend"))
    removed = dump()
    bpy.ops.wm.open_mainfile(filepath=str(DATA / "saved_by_0_1_0.blend"))
    setup.remove(bpy.context.scene)
    # A glass gets nodes of the Blender that removes it, which may be wider
    assert [line for line in differences(removed, dump()) if "/BK7/" not in line or "/width: " not in line] == []


def test_a_scene_of_0_1_0_is_set_up_again(old):
    chosen = mixer.choices(old.relume)
    setup.update(old)
    assert mixer.choices(old.relume) == chosen
    assert len(view_layers.pass_layers(old)["ViewLayer"]) == 2 and len(old.relume.lit) == 3
    assert old["relume_version"] == schema.VERSION


def test_a_snapshot_that_lacks_fields_takes_their_defaults(old):
    snapshot = old.relume.snapshots[0]
    kept = json.loads(snapshot.mix)
    del kept["light_groups"]["key"]["stops"], kept["light_groups"]["fill"]["blend"], kept["balance"]["observer"]
    kept["light_groups"]["key"]["tint of a later version"] = 3
    snapshot.mix = json.dumps(kept)
    old.relume.light_groups["key"].stops, old.relume.observer = 2.0, "CIE 1964 10°"
    assert bpy.ops.relume.apply_snapshot() == {"FINISHED"}
    assert old.relume.light_groups["key"].stops == 0.0 and old.relume.observer == "CIE 1931 2°"
    assert old.relume.light_groups["key"].illuminant == "HP1"
    assert bpy.ops.relume.compare() == {"FINISHED"}


@pytest.mark.parametrize("mix", ["", "{", "[]", '{"version": 1}', '{"light_groups": {}}'])
def test_a_damaged_snapshot_is_named(old, mix):
    old.relume.snapshots[0].mix = mix
    before = mixer.choices(old.relume)
    for operator in (bpy.ops.relume.apply_snapshot, bpy.ops.relume.compare):
        with pytest.raises(RuntimeError, match="the snapshot is damaged: take another"):
            operator()
    assert mixer.choices(old.relume) == before


def test_what_a_newer_relume_wrote_is_refused_and_stays(old):
    old["relume_version"] = schema.VERSION + 1
    old.relume.snapshots[0].mix = json.dumps({**json.loads(old.relume.snapshots[0].mix), "version": 99})
    before = dump()
    for operator in (bpy.ops.relume.set_up, bpy.ops.relume.remove, bpy.ops.relume.apply_snapshot):
        with pytest.raises(RuntimeError, match="a newer Relume"):
            operator()
    assert differences(before, dump()) == []
