"""A report that a second Blender makes of the saved file, while the artist goes on."""

import json
import re
import subprocess
import sys
import threading
from pathlib import Path

import bpy

__all__ = ["Report", "current", "forget", "start"]

_TO_RENDER = re.compile(r"relume: (\d+) passes to render")
_PASS = re.compile(r"^(.*): pass \d+ of \d+$")
_current = None


class Report:
    """A report under way, or the last one: what it says, how far it is, what came of it.

    folder: where it is written. words: what it does, or why it stopped. part: of its passes that are rendered, 0 to 1.
    rows: once it is done, those of report.json.
    """

    def __init__(self, blend: Path, folder: Path, percent: int, samples: int):
        self.folder, self.words, self.rows = folder, "starting", []
        self._passes, self._rendered, self._stopped = 0, 0, False
        options = ["--percent", str(percent), "--out", str(folder)]
        options += ["--samples", str(samples)] if samples else []
        self._process = subprocess.Popen(
            _command(blend, options),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            encoding="utf-8",
            errors="replace",
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    @property
    def part(self) -> float:
        return min(self._rendered / self._passes, 1.0) if self._passes else 0.0

    @property
    def is_running(self) -> bool:
        return self._reader.is_alive()

    def stop(self):
        """End it; what is rendered stays in its folder, and the next report goes on from there."""
        self._stopped = True
        self._process.terminate()

    def wait(self, seconds: float):
        """Return when it is done, or after some seconds."""
        self._reader.join(seconds)

    def _read(self):
        """Follow what the second Blender prints, until it ends."""
        failure = ""
        with self._process.stdout as lines:
            for line in lines:
                line = line.rstrip()
                if found := _TO_RENDER.match(line):
                    self._passes = int(found[1])
                elif found := _PASS.match(line):
                    self._rendered += 1
                    self.words = found[1].strip()
                elif line.startswith("relume: "):
                    failure = line.removeprefix("relume: ")
        status = self._process.wait()
        if self._stopped:
            self.words = "stopped; the next report goes on from here"
        elif status:
            self.words = failure or f"Blender ended with status {status}"
        else:
            self.rows = json.loads((self.folder / "report.json").read_text(encoding="utf-8"))["rows"]
            self.words = "done"


def _command(blend: Path, options: list[str]) -> list[str]:
    if bpy.app.binary_path:
        return [bpy.app.binary_path, "-b", str(blend), "-c", "relume", "report", *options]
    package = __package__.rpartition(".")[0]  # Blender as a Python package has no program of its own
    run = f"from {package}.addon.commands import main; main()"
    return [sys.executable, "-c", run, "report", str(blend), *options]


def current() -> Report | None:
    """The report under way, or the last one of this session."""
    return _current


def start(blend: Path, folder: Path, percent: int, samples: int) -> Report:
    """Begin a report of a saved file. samples: 0 for the scene's own. Raises OSError if it cannot be begun."""
    global _current
    _current = Report(blend, folder, percent, samples)
    return _current


def forget():
    """Stop what is under way."""
    global _current
    if _current is not None and _current.is_running:
        _current.stop()
    _current = None
