"""The mixer's keys, the menu of families, favourites, gels and the order of groups, in the real window."""

from gestures import ROOM, STEPS


def test_keys_families_a_favourite_a_gel_and_the_order_of_groups(window):
    pictures = window(
        STEPS
        + """
# As `at` takes them
MENU, LAMP = (-57, -103), (-150, -103)


def steps():
    scene = bpy.context.scene
    scene.relume.channels = "6"
    yield from layout()
    assert bpy.ops.relume.set_up() == {"FINISHED"}
    yield from render()
    picture = region_of(area_of("IMAGE_EDITOR"), "WINDOW")
    middle = picture.x + picture.width // 2, picture.y + picture.height // 2
    yield from press("C", *middle, shift=True, alt=True)
    assert scene.relume.comparing == "Mix 1", "it takes the snapshot that it compares with"
    groups()[0].illuminant = "HP1"
    yield
    yield "keys_compare.png"
    yield from press("C", *middle, shift=True, alt=True)
    assert scene.relume.comparing == ""
    groups()[1].source, groups()[1].is_open = "BLEND", True
    yield from press("D", *middle, shift=True, alt=True)
    yield "keys_dial.png"
    yield from press("ESC", *middle)
    groups()[1].source, groups()[1].is_open = "LIBRARY", False
    yield
    assert bpy.ops.relume.favourite(name="HP1") == {"FINISHED"}
    yield from click(*at(MENU))
    yield "keys_families.png"
    yield from press("ESC", *at(MENU))
    yield from click(*at(LAMP))
    yield "keys_favourites.png"
    yield from press("ESC", *at(LAMP))
    groups()[0].is_open, groups()[0].tint = True, (0.3, 0.6, 1.0)
    yield
    yield "keys_gel.png"
    assert bpy.ops.relume.move_group(group="tungsten", down=True) == {"FINISHED"}
    yield
    yield "keys_moved.png"
    assert [row.name for row in groups()] == ["fluorescent", "tungsten"] and groups()[1].is_tinted
    bpy.ops.relume.favourite(name="HP1")
""",
        ROOM,
        "--enable-event-simulate",
    )
    assert len(pictures) == 6
