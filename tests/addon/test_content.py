"""What the planner is told of a scene, and what automatic channels make of it."""

import bpy
import pytest

from relume.addon import content, setup, spectra
from relume.core import library


def test_the_room_is_told_by_its_spectra_and_what_the_camera_sees(room):
    told = content.content_of(room)
    shares = dict(zip([spectrum.name for spectrum in told.reflectances], told.shares, strict=False))
    assert told.textures == 0.0
    assert [light.name for light in told.lights] == ["A", "FL2"]
    assert max(shares, key=shares.get) == "ColorChecker: neutral 8 (.23 D)"
    assert shares["ColorChecker: blue flower"] < 1.0  # stands behind the camera
    assert shares["ColorChecker: red"] == pytest.approx(shares["ColorChecker: blue"], rel=0.2)


def test_textures_and_colours_are_told_apart(startup):
    told = content.content_of(startup)
    assert told.textures > 0.0
    assert any(color == pytest.approx([0.7, 0.2, 0.1]) for color in told.colors.tolist())


def test_a_scene_that_is_set_up_is_told_as_before(startup):
    before = content.content_of(startup)
    setup.set_up(startup)
    after = content.content_of(startup)
    assert after.textures == before.textures
    assert sorted(after.colors.tolist()) == sorted(before.colors.tolist())


def test_automatic_channels_say_why_and_follow_the_tolerance(room):
    room.relume.channels = "auto"
    setup.set_up(room)
    few = room.relume.model().passes
    assert str(room.relume.model().channels) in room.relume.plan["reason"]
    assert room.relume.plan["request"] == room.relume.request
    room.relume.tolerance = 0.1
    assert room.relume.plan["request"] != room.relume.request
    setup.set_up(room)
    assert room.relume.model().passes > few
    setup.remove(room)
    assert room.relume.plan == {}


def test_greys_take_one_pass(startup):
    startup.relume.channels = "auto"
    for thing in bpy.data.objects:
        for slot in thing.material_slots:
            slot.material = None
    setup.set_up(startup)
    assert startup.relume.model().channels == 1


def test_a_spectrum_takes_the_place_of_the_colour(startup):
    material = bpy.data.objects["Cube"].active_material
    tree = spectra.new_reflectance(library.reflectance("ColorChecker: green"))
    spectra.assign(material, material.node_tree.nodes["Principled BSDF"].inputs["Base Color"], tree)
    assert [spectrum.name for spectrum in content.content_of(startup).reflectances] == ["ColorChecker: green"]
