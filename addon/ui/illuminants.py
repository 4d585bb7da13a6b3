"""Choosing an illuminant by name: the search, a menu by families, and favourites, which the preferences keep."""

import json
from pathlib import Path

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty
from bpy.types import Menu, Operator

from ...core.errors import UsageError
from ...core.picture import drawing
from ...core.spectra import files, library
from ..store import mixer, preferred
from . import icons, own_spectra, translation
from .mixer_operators import reporting

__all__ = ["CLASSES", "FAMILIES", "ROW", "favourites", "is_favourite"]

FAMILIES = ("Daylight", "Tungsten", "Equal energy", "Fluorescent", "LED", "Discharge", "Measured lamps")
ROW = "relume_row"  # in the context of a menu: the row of the mixer that it is of
_ITEMS, _ITEMS_IN = [], {}  # Blender keeps no reference to the strings; the language that they are in
_SHOWN = {}  # the same with favourites first, by those
_OWN = {}  # the files, by those that were listed


def favourites() -> list[str]:
    """Names of the illuminants that the user marked, in the order in which they were."""
    kept = preferred.of()
    return kept.favourites.splitlines() if kept else []


def is_favourite(name: str) -> bool:
    return name in favourites()


def _items() -> list[tuple]:
    """Every named illuminant with its family, icon and number, as a menu wants them."""
    locale = bpy.app.translations.locale
    if _ITEMS_IN.get("locale") != locale:
        _ITEMS_IN["locale"] = locale
        _ITEMS.clear()
        for family, names in library.illuminants().items():
            for name in names:
                spectrum = library.illuminant(name)
                icon = icons.swatch_and_curve(drawing.curve(spectrum).tolist(), drawing.swatch(spectrum).tolist())
                _ITEMS.append((name, translation.illuminant(name), family, icon, len(_ITEMS)))
    return _ITEMS


def _illuminants(self=None, context=None) -> list[tuple]:
    """What the search offers: favourites, all others, and the user's own files."""
    own, first = own_spectra.listed(own_spectra.LAMPS), favourites()
    items = _items()
    if not own and not first:
        return items
    key = (bpy.app.translations.locale, id(own), tuple(first))
    if _SHOWN.get("key") != key:
        by_name = {item[0]: item for item in items}
        starred = [(name, f"★ {by_name[name][1]}", *by_name[name][2:]) for name in first if name in by_name]
        _SHOWN.update(key=key, items=[*starred, *(item for item in items if item[0] not in first), *_own_lamps()])
    return _SHOWN["items"]


def _own_lamps() -> list[tuple]:
    """The files of the user's own folder of lamps, as `_items` gives its own."""
    found = own_spectra.listed(own_spectra.LAMPS)
    if _OWN.get("files") is not found:
        items = [(path, f"{name}  (own)", path, 0, len(_ITEMS) + k) for k, (path, name) in enumerate(found)]
        _OWN.update(files=found, items=items)
    return _OWN["items"]


class ChooseIlluminant(Operator):
    """Choose the spectrum of the lamps in this light group. The picture follows without rendering"""

    # An operator, because Blender's own search field leaves no undo step
    bl_idname = "relume.choose_illuminant"
    bl_label = "Illuminant"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}
    bl_property = "illuminant"

    illuminant: EnumProperty(name="Illuminant", items=_illuminants)
    group: IntProperty(options={"HIDDEN"})
    part: IntProperty(options={"HIDDEN"}, default=-1)

    def invoke(self, context, event) -> set[str]:
        context.window_manager.invoke_search_popup(self)
        return {"INTERFACE"}

    @reporting
    def execute(self, context) -> None:
        row = context.scene.relume.light_groups[self.group]
        part = row.blend[self.part] if self.part >= 0 else None
        name, measured = self.illuminant, ""
        if own_spectra.is_own(name):  # a file of the user's own folder
            name, measured = Path(name).stem, json.dumps(files.illuminant(name).to_dict())
        with mixer.quiet():
            if part is not None:
                part.illuminant, part.measured = name, measured
            elif measured:
                row.path, row.measured, row.source = self.illuminant, measured, "FILE"
            else:
                row.source, row.illuminant = "LIBRARY", name
        mixer.mix_changed(row, context)


class Favourite(Operator):
    """Have this illuminant first in the search and in the menu, or no longer"""

    bl_idname = "relume.favourite"
    bl_label = "Favourite Illuminant"
    bl_options = {"INTERNAL"}

    name: StringProperty(options={"HIDDEN", "SKIP_SAVE"})

    @reporting
    def execute(self, context) -> None:
        kept, known = preferred.of(), favourites()
        if kept is None:
            raise UsageError("favourites are kept in the preferences of an extension that is enabled in a window")
        names = [name for name in known if name != self.name] if self.name in known else [*known, self.name]
        kept.favourites = "\n".join(names)
        context.preferences.is_dirty = True


class _Choice:
    """A menu of illuminants for the row in its context."""

    def draw_names(self, context, wanted) -> None:
        row = getattr(context, ROW, None)
        if row is None:
            return
        index = row.id_data.relume.light_groups.find(row.name)
        by_name = {item[0]: item for item in _items()}
        self.layout.operator_context = "EXEC_DEFAULT"
        for name in wanted:
            if name in by_name:
                _, words, _, icon, _ = by_name[name]
                shown = {"icon_value": icon} if icon else {"icon": "LIGHT"}
                chosen = self.layout.operator("relume.choose_illuminant", text=words, translate=False, **shown)
                chosen.illuminant, chosen.group, chosen.part = name, index, -1


class FamiliesMenu(_Choice, Menu):
    bl_idname = "RELUME_MT_families"
    bl_label = "Illuminants by Family"

    def draw(self, context) -> None:
        row = getattr(context, ROW, None)
        if row is None:
            return
        marked = favourites()
        if marked:
            self.layout.label(text="Favourites", icon="SOLO_ON")
            self.draw_names(context, marked)
            self.layout.separator()
        self.layout.context_pointer_set(ROW, row)
        for family in FAMILIES:
            self.layout.menu(_menu_of(family))
        if row.source == "LIBRARY":
            self.layout.separator()
            marked = self.layout.operator(
                "relume.favourite",
                text="Remove from Favourites" if is_favourite(row.illuminant) else "Add to Favourites",
                icon="SOLO_OFF",
            )
            marked.name = row.illuminant


def _menu_of(family: str) -> str:
    return f"RELUME_MT_family_{family.lower().replace(' ', '_')}"


def _of_family(family: str) -> type[Menu]:
    def draw(self, context) -> None:
        self.draw_names(context, library.illuminants()[family])

    name = _menu_of(family)
    return type(name, (_Choice, Menu), {"bl_idname": name, "bl_label": family, "draw": draw})


CLASSES = (ChooseIlluminant, Favourite, FamiliesMenu, *map(_of_family, FAMILIES))
