"""A report that a second Blender makes of the saved file, while the artist goes on."""

import json
import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import bpy

__all__ = ["Report", "current", "forget", "start"]

_current = None


class Report:
    """A report under way, or the last one: what it says, how far it is, what came of it.

    folder: where it is written. words: what it does, or why it stopped. part: of its passes that are rendered, 0 to 1.
    rows: once it is done, those of report.json.
    """

    def __init__(self, blend: Path, folder: Path, percent: int, samples: int) -> None:
        self.folder, self.words, self.rows = folder, "starting", []
        self._passes, self._rendered, self._stopped = 0, 0, False
        self._began = time.monotonic()
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
            env=os.environ | {"RELUME_EVENTS": "json"},
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    @property
    def part(self) -> float:
        return min(self._rendered / self._passes, 1.0) if self._passes else 0.0

    @property
    def seconds_left(self) -> float | None:
        """About how long it goes on, as its passes took so far; None before there are any."""
        return (time.monotonic() - self._began) * (1.0 / self.part - 1.0) if self.part else None

    @property
    def is_running(self) -> bool:
        return self._reader.is_alive()

    def stop(self) -> None:
        """End it; what is rendered stays in its folder, and the next report goes on from there."""
        self._stopped = True
        self._process.terminate()

    def wait(self, seconds: float) -> None:
        """Return when it is done, or after some seconds."""
        self._reader.join(seconds)

    def _read(self) -> None:
        """Follow what the second Blender reports, until it ends."""
        failure = ""
        with self._process.stdout as lines:
            for said in map(_event, lines):
                kind = said.get("event")
                if kind == "passes":
                    self._passes, self._began = said["number"], time.monotonic()
                elif kind == "pass":
                    self._rendered += 1
                    self.words = said["words"]
                elif kind == "failed":
                    failure = said["words"]
                elif kind == "rows":
                    self.rows = said["rows"]
        status = self._process.wait()
        if self._stopped:
            self.words = "stopped; the next report goes on from here"
        elif status or not self.rows:
            self.rows = []
            self.words = failure or f"Blender ended with status {status}"
        else:
            self.words = "done"


def _event(line: str) -> dict:
    """What `console.event` wrote in a line; empty for one that Blender printed by itself, before or besides."""
    try:
        said = json.loads(line)
    except ValueError:
        return {}
    return said if isinstance(said, dict) else {}


def _command(blend: Path, options: list[str]) -> list[str]:
    if bpy.app.binary_path:
        return [bpy.app.binary_path, "-b", str(blend), "-c", "relume", "report", *options]
    # Blender as a Python package has no program of its own
    return [sys.executable, "-m", __package__.partition(".addon")[0], "report", str(blend), *options]


def current() -> Report | None:
    """The report under way, or the last one of this session."""
    return _current


def start(blend: Path, folder: Path, percent: int, samples: int) -> Report:
    """Begin a report of a saved file. samples: 0 for the scene's own. Raises OSError if it cannot be begun."""
    global _current
    _current = Report(blend, folder, percent, samples)
    return _current


def forget() -> None:
    """Stop what is under way."""
    global _current
    if _current is not None and _current.is_running:
        _current.stop()
    _current = None
