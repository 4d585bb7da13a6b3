"""The report in Blender's window: a button, how far it is, and what it found."""

from pathlib import Path

import bpy
from bpy.props import IntProperty, StringProperty
from bpy.types import Operator

from ...core.picture import scatter
from ..cli import background
from ..host import viewing
from . import icons
from .panel_places import in_both_places
from .translation import said
from .wrapping import words

__all__ = ["CLASSES", "end"]

_MARKED = "automatic"
_SECONDS = 0.5  # between two looks at the report
_SHOWN = 12  # rows of its table
_PICTURES = 24  # renders of the scene that a report takes: each model three times, the reference of twelve passes


def _follow() -> float | None:
    """Show how far the report is, until it is done."""
    report = background.current()
    viewing.redraw()
    return _SECONDS if report is not None and report.is_running else None


class MakeReport(Operator):
    """Render the saved file with every model and the reference, beside this Blender: error against run time, with \
pictures. What is rendered already is not rendered again"""

    bl_idname = "relume.report"
    bl_label = "Make Report"

    percent: IntProperty(
        name="Resolution", description="Of the scene's own", default=25, min=1, max=100, subtype="PERCENTAGE"
    )
    samples: IntProperty(
        name="Samples", description="Per pixel, shared among the passes; 0: as many as the scene has", default=0, min=0
    )
    folder: StringProperty(
        name="Folder",
        description="Where the report is written",
        default="//report",
        subtype="DIR_PATH",
        options={"OUTPUT_PATH", "PATH_SUPPORTS_BLEND_RELATIVE"},  # else it is red while it is not there
    )

    @classmethod
    def poll(cls, context) -> bool:
        if not bpy.data.filepath:
            cls.poll_message_set("save the file first: a second Blender opens it")
            return False
        report = background.current()
        return report is None or not report.is_running

    def invoke(self, context, event) -> set[str]:
        self.samples = self.samples or context.scene.cycles.samples
        return context.window_manager.invoke_props_dialog(self, confirm_text="Make Report")

    def draw(self, context) -> None:
        layout = self.layout
        layout.use_property_split = True
        for name in ("percent", "samples", "folder"):
            layout.prop(self, name)
        render = context.scene.render
        part = render.resolution_percentage and self.percent / render.resolution_percentage
        layout.label(
            text=said("As long as about {number} of your renders", number=f"{_PICTURES * part**2:.2g}"), icon="TIME"
        )

    def execute(self, context) -> set[str]:
        folder = Path(bpy.path.abspath(self.folder))
        try:
            background.start(Path(bpy.data.filepath), folder, self.percent, self.samples)
        except OSError as error:
            self.report({"ERROR"}, f"the report cannot begin: {error}")
            return {"CANCELLED"}
        if bpy.data.is_dirty:
            self.report({"INFO"}, "the report is of the file as it was last saved")
        bpy.app.timers.register(_follow, first_interval=_SECONDS, persistent=True)
        return {"FINISHED"}


class StopReport(Operator):
    """End the report. What is rendered stays, and the next one goes on from there"""

    bl_idname = "relume.stop_report"
    bl_label = "Stop"

    def execute(self, context) -> set[str]:
        report = background.current()
        if report is not None and report.is_running:
            report.stop()
        return {"FINISHED"}


class _Report:
    bl_label = "Report"
    bl_translation_context = "Relume"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 101

    def draw(self, context) -> None:
        layout, report = self.layout, background.current()
        if report is not None and report.is_running:
            layout.progress(factor=report.part, text=report.words)
            if report.seconds_left is not None:
                layout.label(text=said("About {time} left", time=_time(report.seconds_left)), icon="TIME")
            layout.operator("relume.stop_report", icon="CANCEL")
            return
        layout.operator("relume.report", text="Make Report …", icon="TEXT")
        if not bpy.data.filepath:
            words(layout, "Save the file first: a second Blender opens it.")
        if report is None:
            words(layout, "Error against run time of this scene, for every model.")
        elif not report.rows:
            words(layout, said("Report: {words}", words=report.words), alert=True)
        else:
            _draw_rows(layout, report)


def _draw_rows(layout, report: background.Report) -> None:
    shown = report.rows[:_SHOWN]
    points = [scatter.Point(r["name"], r["seconds"], r["total"]["p98"], r["model"]["p98"]) for r in shown]
    plot = icons.scatter(points, _MARKED)
    if plot:
        layout.template_icon(icon_value=plot, scale=9.0)
        words(layout, "Up: ΔE, with noise a dot, without a dash. Across: seconds. The bright line is ΔE 1.")
    column = layout.column(align=True)
    _draw_cells(column, "", "s", "ΔE", {})
    for row, colour in zip(shown, scatter.colours(points, _MARKED), strict=True):
        icon = icons.patch(colour, colour, colour)
        drawn = {"icon_value": icon} if icon else {}
        _draw_cells(column, row["name"], f"{row['seconds']:.3g}", f"{row['model']['p98']:.2f}", drawn)
    words(layout, "ΔE2000 to the reference, 98th percentile")
    layout.operator("wm.path_open", text="Open Folder", icon="FILE_FOLDER").filepath = str(report.folder)


def _draw_cells(column, name: str, seconds: str, error: str, icon: dict) -> None:
    line = column.split(factor=0.58)
    line.label(text=name, **icon)
    line = line.row()
    for number in (seconds, error):
        line.label(text=number)


def _time(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.0f} min"


CLASSES = (MakeReport, StopReport, *in_both_places(_Report, "report"))


def end() -> None:
    """Stop what runs: the add-on goes."""
    background.forget()
    if bpy.app.timers.is_registered(_follow):
        bpy.app.timers.unregister(_follow)
