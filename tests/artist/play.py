"""Plays sequences of edits in a session with Relume and in its twin without, and compares the two."""

import random
import re
import subprocess
import sys
import time
from dataclasses import dataclass, field, replace
from multiprocessing import Pipe
from pathlib import Path

ROOT = Path(__file__).parents[2]
CHANNELS = ("3", "6", "9", "auto")
_SECONDS = 240  # for one answer, on a machine that others use too
_NOTHING = re.compile(r"(?!)")
_SEEN = re.compile(r"Traceback|Error in bpy|^Error:", re.MULTILINE)

__all__ = ["Crew", "Edit", "Failure", "Take", "play", "sequence", "shrunk", "told"]


@dataclass(frozen=True)
class Edit:
    """One edit: its kind, the number that its choices are drawn from, and whether the artist pauses after it."""

    kind: str
    number: int
    pause: bool


@dataclass
class Failure:
    """What differed, each line with its kind of difference and its place; after which edit; all edits in words."""

    lines: list[str]
    at: int
    words: list[str] = field(default_factory=list)

    @property
    def causes(self) -> set[str]:
        """What it has in common with other failures of the same cause: kinds and places, without names and numbers."""
        return {_place(line) for line in self.lines}


def _place(line: str) -> str:
    path = re.sub(r"^(\w+/\w+)[/ ][^/:]*", r"\1", line.partition(": ")[0])
    return re.sub(r"/[^/]* [^/]*", "/#", re.sub(r"[\d.]+", "#", path))


class Ended(Exception):
    """A Blender that crashed, hung or printed a traceback: what it said last."""


class Actor:
    """One Blender in a process of its own (`actor`)."""

    def __init__(self, role: str, folder: Path) -> None:
        self.role, self.folder = role, folder / role
        self.folder.mkdir(exist_ok=True)
        self.process = None

    def start(self) -> None:
        self.pipe, theirs = Pipe()
        words = [sys.executable, "-m", "tests.artist.actor", str(theirs.fileno()), str(self.folder / "log.txt")]
        self.process = subprocess.Popen(words, cwd=ROOT, pass_fds=[theirs.fileno()])
        theirs.close()
        self.asked = "start"
        self._receive()

    def ask(self, name: str, *arguments) -> None:
        if self.process is None or self.process.poll() is not None:
            self.start()
        self.asked = f"{name} {arguments[:2] if name == 'do' else ''}"
        self.pipe.send((name, arguments))

    def _receive(self):
        try:
            if not self.pipe.poll(_SECONDS):
                raise EOFError
            return self.pipe.recv()
        except (EOFError, ConnectionError):
            hung = self._is_alive()
            self.stop()
            said = (self.folder / "log.txt").read_text(errors="replace")[-3000:]
            raise Ended(f"{'hung' if hung else 'crashed'}/{self.role} in {self.asked}\n{said}") from None

    def _is_alive(self) -> bool:
        """Whether the process goes on a moment after it gave no answer."""
        try:
            self.process.wait(2.0)
        except subprocess.TimeoutExpired:
            return True
        return False

    def answer(self):
        """The result of what was asked. Raises Ended."""
        result, error, printed = self._receive()
        if error or _SEEN.search(printed):
            raise Ended(f"raised/{self.role} in {self.asked}: {_last_line(error or printed)}\n{error}{printed}")
        return result

    def stop(self) -> None:
        if self.process is not None:
            self.process.kill()
            self.process.wait()
            self.process = None


def _last_line(text: str) -> str:
    found = [line for line in text.splitlines() if re.match(r"\w*(\.\w+)*(Error|Exception|Interrupt)\b", line.strip())]
    return (found or text.strip().splitlines() or [""])[-1].strip()


class Crew:
    """The artist, the twin and the checker, and the folder of their files."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.artist, self.twin, self.checker = (Actor(role, folder) for role in ("artist", "twin", "checker"))
        self.checker.ask("library", str(folder / "library.blend"))
        self.checker.answer()
        self.checker.ask("names")
        self.scenes, self.kinds = self.checker.answer()

    def both(self, name: str, *arguments) -> list:
        """The answers of artist and twin. Raises Ended."""
        for actor in (self.artist, self.twin):
            actor.ask(name, *(a(actor) if callable(a) else a for a in arguments))
        answers, ended = [], None
        for actor in (self.artist, self.twin):
            try:
                answers.append(actor.answer())
            except Ended as error:
                ended = ended or error
        if ended:
            raise ended
        return answers

    def stop(self) -> None:
        for actor in (self.artist, self.twin, self.checker):
            actor.stop()


@dataclass(frozen=True)
class Take:
    """A sequence of edits in a scene that is set up with so many channels."""

    scene: str
    channels: str
    edits: tuple[Edit, ...]

    def __str__(self) -> str:
        return f"{self.scene}, {self.channels} channels, {len(self.edits)} edits"


def sequence(seed: int, length: int, scenes: list[str], kinds: list[str]) -> Take:
    """The take of a seed; the same seed gives the same."""
    chance = random.Random(seed)
    scene, channels = scenes[seed % len(scenes)], chance.choice(CHANNELS)
    edits = (Edit(chance.choice(kinds), chance.randrange(1 << 30), chance.random() < 0.5) for _ in range(length))
    return Take(scene, channels, tuple(edits))


def play(crew: Crew, take: Take, every: int, pictures: float = 0.0, ignored: re.Pattern = _NOTHING) -> Failure | None:
    """Play a take and compare after `every` few edits and at the end; returns the first failure.

    pictures: part of the checks that render and compare pictures too. ignored: differences that do not count.
    """
    words, at, chance = [], 0, random.Random(repr(take))
    try:
        crew.both("begin", take.scene, take.channels, lambda a: a is crew.artist, lambda a: str(a.folder))
        for at, edit in enumerate(take.edits, 1):
            said = crew.both("do", edit.kind, edit.number, edit.pause)
            words.append(f"{edit.kind}: {said[0]}{', pause' if edit.pause else ''}")
            unlike = f"words/{edit.kind}: {said[1]!r} became {said[0]!r}"
            if said[0] != said[1] and not str(said[0]).startswith("mixer") and not ignored.search(unlike):
                return Failure([unlike], at, words)
            if at % every == 0 or at == len(take.edits):
                lines = [line for line in _check(crew, chance.random() < pictures) if not ignored.search(line)]
                if lines:
                    return Failure(lines, at, words)
    except Ended as error:
        return Failure([str(error)], at, words)
    return None


def _check(crew: Crew, with_pictures: bool) -> list[str]:
    kept = {actor: str(actor.folder / "kept.blend") for actor in (crew.artist, crew.twin)}
    carries, _ = crew.both("keep", lambda actor: kept[actor])
    crew.checker.ask("compare", *kept.values(), carries)
    found = crew.checker.answer()
    if not found and with_pictures:
        crew.checker.ask("pictures", kept[crew.artist], str(crew.folder))
        found = crew.checker.answer()
    return found


def shrunk(crew: Crew, take: Take, failure: Failure, causes: set[str], seconds: float) -> tuple[Take, Failure]:
    """The shortest take found within a time that fails of one of these causes: edits are dropped, and pauses."""
    ends = time.monotonic() + seconds
    pictures = float(any(cause.startswith("pictures") for cause in causes))
    best, edits = failure, list(take.edits[: failure.at])

    def fails(fewer: list[Edit]) -> Failure | None:
        if time.monotonic() > ends:
            return None
        found = play(crew, replace(take, edits=tuple(fewer)), len(fewer) or 1, pictures)
        return found if found and found.causes & causes else None

    size = len(edits)
    while size:
        start = 0
        while start < len(edits):
            fewer = edits[:start] + edits[start + size :]
            if found := fails(fewer):
                best, edits = found, fewer
            else:
                start += size
        size //= 2
    calm = [replace(edit, pause=False) for edit in edits]
    if calm != edits and (found := fails(calm)):
        best, edits = found, calm
    return replace(take, edits=tuple(edits)), best


def told(seed: int, take: Take, failure: Failure, lines: int = 12) -> str:
    """A failure as whoever mends it reads it: seed, scene, edits in words, what differs."""
    edits = [f"  {number}. {words}" for number, words in enumerate(failure.words, 1)]
    found = [f"    {line[:1500]}" for line in failure.lines[:lines]]
    more = [f"    … {len(failure.lines) - lines} more"] if len(failure.lines) > lines else []
    return "\n".join([f"\nRELUME_SEED={seed}, {take}:", *edits, *found, *more])
