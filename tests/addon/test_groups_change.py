"""Light groups that change outside the mixer: renamed in Blender's lists, deleted, back. Nothing chosen is lost."""

import bpy
import pytest
from dump import differences, dump
from test_render import close, composite

from relume.addon.scene import exr, light_groups, render, setup, view_layers
from relume.addon.store import mixer, remarks
from relume.core.errors import SetupError
from relume.core.model import bases
from relume.core.picture import coefficients

CHOSEN = {"tungsten": "HP1", "fluorescent": "FL11"}


@pytest.fixture
def mixed(room):
    """The room, set up, with illuminants, gains, a white, and a snapshot that the artist chose."""
    setup.set_up(room, bases.fitted(3))
    settings = room.relume
    for number, (group, illuminant) in enumerate(CHOSEN.items(), 1):
        settings.light_groups[group].source = "LIBRARY"
        settings.light_groups[group].illuminant, settings.light_groups[group].stops = illuminant, number
    settings.white_source, settings.white_group = "GROUP", "tungsten"
    bpy.ops.relume.take_snapshot()
    return room


def rows(scene) -> dict:
    """What the mixer says: {group: (illuminant, stops)} in the order of its rows."""
    return {row.name: (row.illuminant, row.stops) for row in scene.relume.light_groups}


def grouped(scene) -> str:
    """Set a scene up with a light group for every light; returns why that was not done."""
    steps = light_groups.setting_up(scene, "LIGHT")
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return end.value


@pytest.mark.parametrize("pieces", [1, 2, 4, 6])
@pytest.mark.parametrize("before", [None, 3])
def test_setting_up_that_is_stopped_leaves_the_scene_as_it_was(startup, pieces, before):
    _lamp("Lamp")
    if before:
        setup.set_up(startup, bases.fitted(before))
    was = dump()
    steps = light_groups.setting_up(startup, "KEEP" if before else "LIGHT")
    for _ in range(pieces):
        next(steps)
    steps.close()
    assert startup.relume.is_set_up == bool(before)
    found = differences(was, dump())
    assert [line for line in found if "relume_plan" not in line] == []


def rename_in_blenders_list(scene, before: str, after: str):
    layer = next(iter(view_layers.pass_layers(scene).values()))[0]
    layer.lightgroups[before].name = after
    assert bpy.data.objects[before].lightgroup == after, "Blender renames it in objects, too"


def test_a_row_follows_its_group_renamed_in_blenders_list(mixed):
    rename_in_blenders_list(mixed, "tungsten", "warm")
    setup.update(mixed)
    assert rows(mixed) == {"warm": ("HP1", 1.0), "fluorescent": ("FL11", 2.0)}
    assert mixed.relume.white_group == "warm"
    mixed.relume.light_groups["warm"].stops = 3.0
    assert bpy.ops.relume.apply_snapshot() == {"FINISHED"}
    assert rows(mixed)["warm"] == ("HP1", 1.0), "the snapshot knows the new name"


def test_rows_follow_groups_renamed_on_objects(mixed):
    for before, after in (("tungsten", "fluorescent"), ("fluorescent", "tungsten")):
        bpy.data.objects[before].lightgroup = f"{after} of {before}"
    setup.update(mixed)
    assert rows(mixed) == {"fluorescent of tungsten": ("HP1", 1.0), "tungsten of fluorescent": ("FL11", 2.0)}


def test_a_row_follows_its_lamps_out_of_any_group(mixed):
    bpy.data.objects["tungsten"].lightgroup = ""
    setup.update(mixed)
    assert rows(mixed) == {"fluorescent": ("FL11", 2.0), coefficients.EVERYTHING_ELSE: ("HP1", 1.0)}


def test_a_row_without_lights_stays_and_says_so_and_its_lamps_come_back(mixed, tmp_path):
    lamp = bpy.data.objects["tungsten"]
    before = composite(mixed, tmp_path / "before.exr")
    mixed.collection.objects.unlink(lamp)
    bpy.context.view_layer.update()
    setup.update(mixed)
    assert rows(mixed) == {"fluorescent": ("FL11", 2.0), "tungsten": ("HP1", 1.0)}
    assert [row.name for row in mixed.relume.lit] == ["fluorescent"]
    assert [remark.why for remark in remarks.of(mixed) if remark.owner == "tungsten"]
    image = render.render(mixed, tmp_path).image
    assert list(image.groups) == ["fluorescent"], "no pass is rendered for it"
    assert len(mixed.relume.lights()) == 1
    mixed.collection.objects.link(lamp)
    setup.update(mixed)
    assert rows(mixed) == {"tungsten": ("HP1", 1.0), "fluorescent": ("FL11", 2.0)}
    assert not remarks.of(mixed) and close(composite(mixed, tmp_path / "after.exr"), before, 0.05)


def test_a_row_that_is_solo_and_without_lights_leaves_the_others_lit(mixed):
    mixed.relume.light_groups["tungsten"].solo = True
    bpy.data.objects["tungsten"].lightgroup = "fluorescent"
    setup.update(mixed)
    assert [row.name for row in mixed.relume.light_groups] == ["fluorescent", "tungsten"]
    assert [light.gain for light in mixed.relume.lights()] == [4.0]
    assert light_groups.remove_empty(mixed) == ["tungsten"]
    assert rows(mixed) == {"fluorescent": ("FL11", 2.0)}


def test_a_group_that_is_split_leaves_its_row(mixed):
    lamp = bpy.data.objects["tungsten"].copy()
    lamp.lightgroup = "tungsten"
    mixed.collection.objects.link(lamp)
    setup.update(mixed)
    bpy.data.objects["tungsten"].lightgroup, lamp.lightgroup = "left", "right"
    setup.update(mixed)
    assert rows(mixed)["tungsten"] == ("HP1", 1.0)
    assert {row.name for row in mixed.relume.lit} == {"left", "right", "fluorescent"}


def test_removed_and_set_up_again_the_mixer_is_what_it_was(mixed):
    bpy.data.objects["tungsten"].lightgroup = "fluorescent"
    chosen = mixer.choices(mixed.relume)
    setup.remove(mixed)
    assert mixer.choices(mixed.relume) == chosen
    bpy.data.objects["tungsten"].lightgroup = "tungsten"
    setup.set_up(mixed, bases.fitted(3))
    assert mixer.choices(mixed.relume) == chosen
    bpy.data.objects["fluorescent"].lightgroup = "new"
    setup.remove(mixed)
    setup.set_up(mixed, bases.fitted(3))
    assert rows(mixed) == {"tungsten": ("HP1", 1.0), "new": ("FL11", 2.0)}, "one row without light, one new group"


def test_remove_gives_back_the_order_of_the_rows(mixed):
    setup.remove(mixed)
    bpy.data.objects["tungsten"].lightgroup = "fluorescent"
    before = dump()
    setup.set_up(mixed, bases.fitted(3))
    assert [row.name for row in mixed.relume.light_groups] == ["fluorescent", "tungsten"]
    setup.remove(mixed)
    assert differences(before, dump()) == []


def test_keyframes_and_drivers_stay_with_their_rows(mixed):
    for number, row in enumerate(mixed.relume.light_groups):
        row.keyframe_insert("stops", frame=1)
        mixed.driver_add(f"relume.light_groups[{number}].temperature").driver.expression = str(3000 + number)
    curves = mixed.animation_data.action.layers[0].strips[0].channelbags[0].fcurves
    values = {row.name: row.stops for row in mixed.relume.light_groups}

    def animated() -> dict:
        found = {}
        for curve in curves:
            row = mixed.path_resolve(curve.data_path.rpartition(".")[0])
            found[row.name] = curve.evaluate(1)
        return found

    assert animated() == values
    bpy.data.objects["tungsten"].lightgroup = "fluorescent"
    setup.update(mixed)
    assert animated() == values
    driven = {curve.data_path: curve.driver.expression for curve in mixed.animation_data.drivers}
    assert driven["relume.light_groups[1].temperature"] == "3000", "tungsten is the second row now"
    light_groups.remove_empty(mixed)
    assert animated() == {"fluorescent": 2.0}, "what moved a row that is gone moves no other"


def test_animation_made_while_a_scene_is_set_up_stays(mixed):
    mixed.relume.light_groups["tungsten"].keyframe_insert("stops", frame=1)
    mixed.keyframe_insert("gravity", frame=1)
    setup.update(mixed)
    setup.remove(mixed)
    curves = mixed.animation_data.action.layers[0].strips[0].channelbags[0].fcurves
    assert {curve.data_path for curve in curves} == {"gravity", "relume.light_groups[0].stops"}


def test_a_row_that_is_only_animated_stays(room):
    setup.set_up(room, bases.fitted(3))
    bpy.data.objects["tungsten"].lightgroup = "lamp"
    setup.update(room)
    number = room.relume.light_groups.find("lamp")
    room.driver_add(f"relume.light_groups[{number}].stops")
    bpy.data.objects["tungsten"].lightgroup = "fluorescent"
    setup.update(room)
    assert "lamp" in room.relume.light_groups


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["a.b"], [coefficients.EVERYTHING_ELSE]),
        (["a.b", "a_b"], ["a_b", coefficients.EVERYTHING_ELSE]),
        (["x" * 63], [coefficients.EVERYTHING_ELSE]),
        (["x" * 54], ["x" * 54]),
        (["ä" * 31], [coefficients.EVERYTHING_ELSE]),
        (["Räume über uns", "灯"], ["Räume über uns", "灯"]),
        (["Image", "Depth"], ["Image", "Depth"]),
        (["Alpha", "Combined"], ["Alpha", "Combined"]),
        ([coefficients.EVERYTHING_ELSE, ""], [coefficients.EVERYTHING_ELSE]),
        (["", "lamp"], ["lamp", coefficients.EVERYTHING_ELSE]),
        (["lamp 1", "lamp"], ["lamp 1", "lamp"]),
    ],
)
def test_names_of_light_groups(room, tmp_path, names, expected):
    lamps = [bpy.data.objects["tungsten"], bpy.data.objects["fluorescent"]]
    for lamp in lamps[len(names) :]:
        bpy.data.objects.remove(lamp)
    for lamp, name in zip(lamps, names, strict=False):
        lamp.lightgroup = name
    room.relume.light_groups.clear()
    setup.set_up(room, bases.fitted(3))
    assert sorted(row.name for row in room.relume.light_groups) == sorted(expected)
    owners = {remark.owner for remark in remarks.of(room)}
    assert {name for name in names if name and name not in expected} == owners
    image = render.render(room, tmp_path).image
    lit = dict(zip(image.groups, room.relume.lights(), strict=True))
    assert close(composite(room, tmp_path / "composite.exr"), render.picture(image, lit), 1e-3)
    assert all(channels.max() > 0 for channels in image.groups.values())


def test_a_scene_that_relights_an_exr_is_left_alone(mixed, tmp_path):
    image = render.render(mixed, tmp_path).image
    path = tmp_path / "shot.exr"
    coefficients.write(path, image, render.picture(image, dict(zip(image.groups, mixed.relume.lights(), strict=True))))
    other = exr.new_scene(path)
    before = composite(other, tmp_path / "a.exr")
    setup.set_up(mixed, bases.fitted(6))
    assert close(composite(other, tmp_path / "b.exr"), before)
    setup.remove(mixed)
    assert close(composite(other, tmp_path / "c.exr"), before)
    assert not any(node.type == "GROUP" for node in bpy.data.node_groups["red"].nodes), "spectra are plain again"
    with pytest.raises(setup.SetupError, match="relights .*shot.exr"):
        setup.set_up(other)


def _lamp(name: str):
    bpy.context.scene.collection.objects.link(bpy.data.objects.new(name, bpy.data.lights.new(name, "POINT")))


def test_setting_up_puts_lights_into_groups_first(startup):
    for number in range(light_groups.MOST - 2):
        _lamp(f"Lamp {number}")
    startup.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 1.0
    count = len(light_groups.lamps_of(startup))
    assert count == light_groups.MOST, "with the scene's own lamp and its world"
    assert grouped(startup) == ""
    assert len(startup.relume.lit) == count
    assert {thing.lightgroup for thing in light_groups.lamps_of(startup)} == {r.name for r in startup.relume.lit}
    setup.remove(startup)
    _lamp("One more")
    assert grouped(startup) == f"by collection, for {count + 1} lights are more than {count}"
    assert len(startup.relume.lit) < count


def test_light_groups_are_as_before_where_setting_up_fails(startup, monkeypatch):
    _lamp("Lamp")
    monkeypatch.setattr(setup, "bring_in_line", lambda *_: (_ for _ in ()).throw(SetupError("no")))
    with pytest.raises(SetupError):
        grouped(startup)
    assert {thing.lightgroup for thing in light_groups.lamps_of(startup)} == {""}
    assert not any(len(layer.lightgroups) for layer in startup.view_layers)
