"""What a command says, and nothing else: results on standard output, how it goes on standard error, both as it happens.

With RELUME_EVENTS=json every line on standard output is one JSON object instead, with its kind under "event", for a
program that follows. RELUME_LOG=debug (info, warning, error) logs to standard error, Blender's own lines included.
"""

import faulthandler
import io
import json
import logging
import os
import shutil
import signal
import socket
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout, suppress
from pathlib import Path
from typing import IO

from ...core import results
from ...core.errors import ResultError, UsageError

__all__ = ["LOG", "Progress", "apart", "event", "fail", "heard", "reports", "say", "start_log", "stoppable", "wrote"]

LOG = logging.getLogger("relume")
_LEVELS = ("debug", "info", "warning", "error")
_own = None  # standard output as long as `apart` lasts


def _speaks_json() -> bool:
    return os.environ.get("RELUME_EVENTS") == "json"


def event(kind: str, **fields) -> bool:
    """Tell a program that follows; returns whether one does."""
    if _speaks_json():
        _print(json.dumps({"event": kind, **fields}))
    return _speaks_json()


def _print(line: str) -> None:
    stream = _own or sys.stdout
    try:
        print(line, file=stream, flush=True)
    except OSError as error:
        with open(os.devnull, "wb") as nothing:  # else closing it fails once more
            os.dup2(nothing.fileno(), stream.fileno())
        raise ResultError(f"standard output cannot be written ({error.strerror})") from error


def say(words: str) -> None:
    """A remark for the user, in one line."""
    words = " ".join(words.split())
    event("said", words=words) or print(f"relume: {words}", file=sys.stderr, flush=True)


def fail(words: str) -> None:
    """Why a command cannot be done, in one line."""
    words = " ".join(words.split())
    event("failed", words=words) or print(f"relume: {words}", file=sys.stderr, flush=True)


def wrote(path: Path) -> None:
    """A result that is there now."""
    event("wrote", path=str(path)) or _print(str(path))


class Progress:
    """How far a render is: one line in a terminal that is rewritten; in a log, one line for each pass."""

    def __init__(self, passes: int, words: str = "rendering") -> None:
        self.passes, self.words, self.last = passes, words.strip(), -1
        self.moving = sys.stderr.isatty() and not _speaks_json()

    def __call__(self, index: int, part: float) -> None:
        at = f"pass {index + 1} of {self.passes}"
        if self.moving:
            width = 30
            filled = round(width * min((index + part) / self.passes, 1.0))
            line = f"{self.words}  {'█' * filled}{'·' * (width - filled)}  {at}"
            # A line that wraps cannot be rewritten
            print(f"\r{line[: shutil.get_terminal_size().columns - 1]}", end="", file=sys.stderr, flush=True)
        elif index != self.last and not event("pass", words=self.words, number=index + 1, passes=self.passes):
            print(f"{self.words}: {at}", file=sys.stderr, flush=True)
        self.last = index

    def done(self) -> None:
        if self.moving and self.last >= 0:
            print(file=sys.stderr)


def start_log() -> None:
    """Log to standard error as RELUME_LOG says. Raises UsageError for a level that is none."""
    level = os.environ.get("RELUME_LOG", "").lower()
    if level and level not in _LEVELS:
        raise UsageError(f"RELUME_LOG={os.environ['RELUME_LOG']}: expected one of {', '.join(_LEVELS)}")
    if level and not LOG.handlers:
        handler = logging.StreamHandler()
        handler.setFormatter(logging.Formatter("%(name)s %(levelname)s %(message)s"))
        LOG.addHandler(handler)
    LOG.setLevel(level.upper() or logging.WARNING)


@contextmanager
def _redirected(number: int, sink: int) -> Iterator[int]:
    """While it lasts, what C code writes to this file descriptor goes to another."""
    kept = os.dup(number)
    os.dup2(sink, number)
    try:
        yield kept
    finally:
        os.dup2(kept, number)
        os.close(kept)


@contextmanager
def apart() -> Iterator[None]:
    """While it lasts, standard output is Python's alone: Blender's C code writes its own lines there, unasked.

    They are dropped, or go to standard error where the log is at "info" or below; a crash is reported there.
    """
    global _own
    if not faulthandler.is_enabled():
        faulthandler.enable(os.dup(2))
    sys.stdout.flush()
    with ExitStack() as stack:
        sink = 2 if LOG.isEnabledFor(logging.INFO) else stack.enter_context(open(os.devnull, "wb")).fileno()
        out = stack.enter_context(_redirected(1, sink))
        if _writes_to(sys.stdout, 1):
            encoding = sys.stdout.encoding
            own = stack.enter_context(open(os.dup(out), "w", encoding=encoding, errors="backslashreplace"))
            stack.enter_context(redirect_stdout(own))
        before, _own = _own, sys.stdout
        try:
            yield
        finally:
            _own = before


@contextmanager
def reports() -> Iterator[list[str]]:
    """While it lasts, Blender's reports, which it prints as Python does, are not shown; yields them afterwards."""
    lines = []
    with redirect_stdout(io.StringIO()) as text:
        try:
            yield lines
        finally:
            lines += text.getvalue().splitlines()
            for line in lines:
                LOG.info("Blender: %s", line)


@contextmanager
def heard() -> Iterator[list[str]]:
    """While it lasts, nothing at all that Blender says is shown, but for a crash; yields its reports afterwards."""
    sys.stderr.flush()
    with tempfile.TemporaryFile() as file, reports() as lines:
        try:
            with _redirected(1, file.fileno()), _redirected(2, file.fileno()), redirect_stderr(io.StringIO()):
                yield lines
        finally:
            file.seek(0)
            LOG.info("Blender: %s", file.read().decode(errors="replace"))


def _writes_to(stream: IO, number: int) -> bool:
    with suppress(OSError, ValueError, AttributeError):
        return stream.fileno() == number
    return False


@contextmanager
def stoppable() -> Iterator[None]:
    """While it lasts, Ctrl-C and SIGTERM end the process at once, with what is not finished taken away.

    Python itself looks at a signal only between two of its own instructions, that is, after a whole render. A thread
    that waits for the number of the signal need not: the render lets other threads run.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    reader, writer = socket.socketpair()
    writer.setblocking(False)
    numbers = [n for n in (signal.SIGINT, signal.SIGTERM) if signal.getsignal(n) != signal.SIG_IGN]
    before = {number: signal.signal(number, lambda *_: None) for number in numbers}
    woken = signal.set_wakeup_fd(writer.fileno(), warn_on_full_buffer=False)
    threading.Thread(target=_end_on_signal, args=(reader, numbers), daemon=True).start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(woken)
        for number, handler in before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
        writer.close()


def _end_on_signal(reader: socket.socket, numbers: list[int]) -> None:
    with reader:
        while received := reader.recv(1):
            if received[0] in numbers:
                results.abandon()
                with suppress(OSError):
                    os.write(2, b"\nrelume: stopped\n" if sys.stderr.isatty() else b"relume: stopped\n")
                os._exit(128 + received[0])
