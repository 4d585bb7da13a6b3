"""The mixer as it is drawn: light groups, white balance, snapshots, animation. Reads only what is at hand."""

from bpy.types import Menu, UIList

from ...core.picture.coefficients import EVERYTHING_ELSE
from ..host import animation
from ..store.mixer import CURVE
from . import expected, icons, illuminants
from .translation import illuminant, said
from .wrapping import is_narrow, words

__all__ = ["CLASSES", "MANY", "draw"]

MANY = 8  # light groups that stand one below the other; more are a list
_PATH = "relume.light_groups"  # of the rows, as animation names them
_ROW_BUTTONS = {
    "relume.select_lights": "RESTRICT_SELECT_OFF",
    "relume.copy_illuminant": "COPYDOWN",
    "relume.paste_illuminant": "PASTEDOWN",
    "relume.reset_mix": "LOOP_BACK",
}


def draw(layout, settings) -> None:
    """The mixer of a scene that is set up."""
    if len(settings.light_groups) > MANY:
        _draw_list(layout, settings)
    else:
        for index, row in enumerate(settings.light_groups):
            _draw_row(layout, settings, row, index)
    line = layout.row(align=True)
    line.operator_menu_enum("relume.regroup", "way", text="Light Groups", icon="OUTLINER_OB_LIGHT")
    line.operator("relume.remove_empty_groups", text="", icon="BRUSH_DATA")
    line.menu("RELUME_MT_mix", text="", icon="DOWNARROW_HLT")
    expected.draw_mix(layout, settings)
    if settings.problem:
        words(layout, settings.problem, alert=True)
    _draw_balance(layout, settings)
    _draw_snapshots(layout, settings)
    _draw_output(layout, settings)


def _draw_list(layout, settings) -> None:
    """Many groups: a list that scrolls, and below it the group that is chosen there."""
    index = settings.active_light_group
    row = settings.light_groups[index] if 0 <= index < len(settings.light_groups) else None
    line = layout.row()
    line.template_list(
        "RELUME_UL_light_groups", "", settings, "light_groups", settings, "active_light_group", rows=6, maxrows=10
    )
    if row is not None:
        _draw_moves(line.column(align=True), row)
        box = layout.box().column(align=True)
        box.use_property_split = False
        icon = icons.swatch_and_curve(row.get(CURVE, ()), row.swatch)
        line = box.row(align=True)
        line.label(text=row.name, translate=False)
        _draw_level(box.row(align=True) if is_narrow() else line, row, dot=True)
        _draw_illuminant(box, settings, row, index, icon)
        _draw_details(box, row, index, icon)


def _draw_moves(layout, row) -> None:
    for down in (False, True):
        moved = layout.operator("relume.move_group", text="", icon="TRIA_DOWN" if down else "TRIA_UP")
        moved.group, moved.down = row.name, down


class LightGroupList(UIList):
    bl_idname = "RELUME_UL_light_groups"

    def draw_item(self, context, layout, settings, row, icon, chosen_in, chosen) -> None:
        icon = icons.swatch_and_curve(row.get(CURVE, ()), row.swatch)
        line = layout.row(align=True)
        line.active = _sounds(settings, row)
        shown = {"icon_value": icon} if icon else {"icon": "LIGHT"}
        if row.name == EVERYTHING_ELSE:
            line.label(text=row.name, **shown)
        else:
            line.prop(row, "name", text="", emboss=False, **shown)
        if is_narrow():
            _draw_switches(line, row)
        else:
            _draw_level(line, row, unit="")


def _sounds(settings, row) -> bool:
    return row.is_lit and not row.mute and (row.solo or not any(other.solo for other in settings.lit))


def _draw_dotted(layout, struct, name: str, **options) -> None:
    """A value, and the dot that keys it."""
    line = layout.row(align=True)
    line.prop(struct, name, **options)
    line.prop_decorator(struct, name)


def _draw_level(line, row, unit: str = "EV", dot: bool = False) -> None:
    """The gain of a group with its unit, and with the dot that keys it, solo and mute."""
    if is_narrow():
        line = line.split(factor=0.5, align=True)
        gain, line = line.row(align=True), line.row(align=True)
    else:
        gain = line.row(align=True)
        gain.ui_units_x = 7.2
    gain.prop(row, "stops", text="")
    if unit:
        label = line.row(align=True)
        label.ui_units_x = 1.3
        label.label(text=unit)
    if dot:
        key = line.row(align=True)
        key.ui_units_x = 1.0
        key.prop_decorator(row, "stops")
    _draw_switches(line, row)


def _draw_switches(line, row) -> None:
    line.prop(row, "solo", text="", icon="SOLO_ON" if row.solo else "SOLO_OFF")
    line.prop(row, "mute", text="", icon="HIDE_ON" if row.mute else "HIDE_OFF")


def _shining(row) -> str:
    """What shines in a row, as people call it."""
    if row.source == "PLANCKIAN":
        return said("Black body {kelvin:.0f} K", kelvin=row.temperature)
    if row.source == "DAYLIGHT":
        return said("Daylight {kelvin:.0f} K", kelvin=row.cct)
    if row.source == "BLEND":
        return said("Blend of {number}", number=len(row.blend))
    return said(row.label) if row.source == "FILE" else illuminant(row.label)


def _gelled(words: str, row) -> str:
    return said("{lamp} + gel", lamp=words) if row.is_tinted else words


def _draw_illuminant(box, settings, row, index: int, icon: int) -> None:
    # The name of an illuminant can be long: it has the whole width
    line = box.row(align=True)
    expected.draw_dot(line, settings, row)
    chosen = line.operator(
        "relume.choose_illuminant",
        text=_gelled(_shining(row), row),
        translate=False,
        **({"icon_value": icon} if icon else {"icon": "LIGHT"}),
    )
    chosen.group, chosen.part = index, -1
    line.context_pointer_set(illuminants.ROW, row)
    line.menu("RELUME_MT_families", text="", icon="DOWNARROW_HLT")


def _draw_row(layout, settings, row, index: int) -> None:
    box = layout.box().column(align=True)
    box.use_property_split = False
    line = box.row(align=True)
    line.active = _sounds(settings, row)
    line.prop(row, "is_open", text="", icon="DOWNARROW_HLT" if row.is_open else "RIGHTARROW", emboss=False)
    icon = icons.swatch_and_curve(row.get(CURVE, ()), row.swatch)
    if row.name == EVERYTHING_ELSE:
        line.label(text=row.name)
    else:
        line.prop(row, "name", text="")
    if not row.is_lit:
        line.label(text="no lights")
    scene = row.id_data
    moves = animation.has_any(scene) and animation.is_animated(scene, f"{_PATH}[{index}].stops")
    if is_narrow():
        line = box.row(align=True)
        line.active = _sounds(settings, row)
    _draw_level(line, row, dot=row.is_open or moves)
    _draw_illuminant(box, settings, row, index, icon)
    if row.is_open:
        _draw_details(box, row, index, icon, is_alone=True)


def _draw_details(box, row, index: int, icon: int, is_alone: bool = False) -> None:
    box.separator(factor=0.5)
    box.prop(row, "source", text="")
    if row.source == "PLANCKIAN":
        _draw_dotted(box, row, "temperature", slider=True)
    elif row.source == "DAYLIGHT":
        _draw_dotted(box, row, "cct", slider=True)
    elif row.source == "FILE":
        box.prop(row, "path", text="")
        if row.origin:
            words(box, said("From {file}", file=row.origin), boxed=True)
    elif row.source == "BLEND":
        _draw_blend(box, row, index)
    _draw_gel(box, row)
    if icon:
        box.template_icon(icon_value=icon, scale=5.0)
    sign = "NONE" if is_narrow() else "ADD"
    box.operator("relume.add_lights", text="Add Selected Lights", icon=sign).group = row.name
    line = box.row(align=True)
    line.alignment = "CENTER"
    for name, sign in _ROW_BUTTONS.items():
        line.operator(name, text="", icon=sign).group = row.name
    if is_alone:
        _draw_moves(line, row)


def _draw_gel(box, row) -> None:
    line = box.row(align=True)
    line.label(text="Gel")
    gel = line.row(align=True)
    gel.ui_units_x = 6.0
    gel.prop(row, "tint", text="")
    line.prop_decorator(row, "tint")


def _draw_blend(box, row, index: int) -> None:
    for number, part in enumerate(row.blend):
        line = box.row(align=True)
        chosen = line.operator("relume.choose_illuminant", text=illuminant(part.illuminant), translate=False)
        chosen.group, chosen.part = index, number
        _draw_dotted(box if is_narrow() else line, part, "weight", text="", slider=True)
        removed = line.operator("relume.change_blend", text="", icon="REMOVE")
        removed.group, removed.part = index, number
    line = box.column(align=True) if is_narrow() else box.row(align=True)
    added = line.operator("relume.change_blend", text="Add Illuminant", icon="ADD")
    added.group, added.part = index, -1
    line.operator("relume.light_dial", text="Light Dial", icon="MESH_CIRCLE").group = index


def _draw_balance(layout, settings) -> None:
    header, body = layout.panel("relume_balance", default_closed=False)
    header.label(text="White and Observer")
    if body is None:
        return
    line = body.row(align=True)
    line.use_property_decorate = True
    line.prop(settings, "white_balance")
    column = body.column()
    column.active = settings.white_balance > 0.0
    column.prop(settings, "white_source")
    if settings.white_source == "GROUP":
        column.prop_search(settings, "white_group", settings, "light_groups")
    elif settings.white_source == "PIXEL":
        column.operator("relume.pick_white", icon="EYEDROPPER")
    column.prop(settings, "white_balance_method")
    body.prop(settings, "observer")
    if settings.observer == "FILE":
        body.prop(settings, "observer_path")
        if settings.observer_origin:
            words(body, said("From {file}", file=settings.observer_origin))


def _draw_snapshots(layout, settings) -> None:
    header, body = layout.panel("relume_snapshots", default_closed=True)
    header.label(text="Snapshots")
    if body is None:
        return
    line = body.row()
    line.template_list(
        "UI_UL_list", "relume_snapshots", settings, "snapshots", settings, "active_snapshot", rows=2, maxrows=5
    )
    buttons = line.column(align=True)
    buttons.operator("relume.take_snapshot", text="", icon="ADD")
    buttons.operator("relume.forget_snapshot", text="", icon="REMOVE")
    line = body.row(align=True)
    line.operator("relume.apply_snapshot", text="Apply")
    line.operator("relume.compare", text="Stop" if settings.comparing else "Compare", depress=bool(settings.comparing))
    if settings.comparing:
        body.label(text=said("Right of the line: {snapshot}", snapshot=settings.comparing), translate=False)
        line = body.row(align=True)
        line.use_property_decorate = True
        line.prop(settings, "wipe", slider=True)
    body.operator("relume.write_to_lights", icon="LIGHT")


def _draw_output(layout, settings) -> None:
    header, body = layout.panel("relume_output", default_closed=True)
    header.label(text="Pixels and Files")
    if body is None:
        return
    body.operator("relume.inspect", icon="EYEDROPPER")
    if settings.exr:
        words(body, said("Lit from {file}", file=settings.exr))
    else:
        body.operator("relume.write_sidecar", icon="FILE_TEXT")
    body.operator("relume.relight_exr", icon="FILE_IMAGE")
    body.operator("relume.share_as_web_page", icon="URL")


class MixMenu(Menu):
    bl_idname = "RELUME_MT_mix"
    bl_label = "Mix"

    def draw(self, context) -> None:
        self.layout.operator_context = "INVOKE_DEFAULT"
        self.layout.operator("relume.copy_mix", icon="COPYDOWN")
        self.layout.operator("relume.paste_mix", icon="PASTEDOWN")
        self.layout.separator()
        self.layout.operator("relume.save_mix", icon="FILE_TICK")
        self.layout.operator("relume.load_mix", icon="FILE_FOLDER")
        self.layout.separator()
        self.layout.operator("relume.reset_mix", icon="LOOP_BACK").group = ""


CLASSES = (LightGroupList, MixMenu)
