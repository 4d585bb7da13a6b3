"""The report in Blender's window: a button, how far it is, and what it found."""

from pathlib import Path

import bpy
from bpy.props import IntProperty, StringProperty
from bpy.types import Operator

from ..cli import background
from ..host import viewing
from . import mixer_panels
from .panel_places import in_both_places
from .translation import said

__all__ = ["CLASSES", "end"]

_SECONDS = 0.5  # between two looks at the report
_SHOWN = 12  # rows of its table


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
        name="Folder", description="Where the report is written", default="//report", subtype="DIR_PATH"
    )

    @classmethod
    def poll(cls, context) -> bool:
        if not bpy.data.filepath:
            cls.poll_message_set("save the file first: a second Blender opens it")
            return False
        report = background.current()
        return report is None or not report.is_running

    def invoke(self, context, event) -> set[str]:
        return context.window_manager.invoke_props_dialog(self, confirm_text="Make Report")

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
            layout.operator("relume.stop_report", icon="CANCEL")
            return
        layout.operator("relume.report", text="Make Report …", icon="TEXT")
        if report is None:
            mixer_panels.words(layout, "Error against run time of this scene, for every model.")
        elif not report.rows:
            mixer_panels.words(layout, said("Report: {words}", words=report.words), alert=True)
        else:
            _draw_rows(layout, report)


def _draw_rows(layout, report: background.Report) -> None:
    column = layout.column(align=True)
    cells = [("", "seconds", "ΔE")]
    cells += [(r["name"], f"{r['seconds']:.3g}", f"{r['model']['p98']:.2f}") for r in report.rows[:_SHOWN]]
    for name, *numbers in cells:
        line = column.split(factor=0.5)
        line.label(text=name)
        line = line.row()
        for number in numbers:
            line.label(text=number)
    mixer_panels.words(layout, "ΔE2000 to the reference, 98th percentile")
    layout.operator("wm.path_open", text="Open Folder", icon="FILE_FOLDER").filepath = str(report.folder)


CLASSES = (MakeReport, StopReport, *in_both_places(_Report, "report"))


def end() -> None:
    """Stop what runs: the add-on goes."""
    background.forget()
    if bpy.app.timers.is_registered(_follow):
        bpy.app.timers.unregister(_follow)
