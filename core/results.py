"""Results on disk: files that appear whole or not at all, in folders that several runs may share.

Whatever is not finished has a name that begins with `.relume-`, and beside it a lock that ends with its process. So a
later run knows what is left by one that is gone, and a reader never meets half a file.
"""

import hashlib
import os
import re
import secrets
import shutil
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path

from .errors import ResultError

__all__ = ["abandon", "claim", "expect", "folder", "replacing", "scratch", "sweep", "together", "write_text"]

_NAME = re.compile(r"(\.relume-([0-9a-f]{8})-[0-9a-f]{8})(\..*)?")
_CLAIM = re.compile(r"\.relume-claim-[0-9a-f]{16}\.lock")
_DAY = 86400.0
_MOMENT = 0.5  # seconds in which a sweep lets go of a claim that it looks at

_set: ContextVar[list | None] = ContextVar("results that appear together", default=None)
_unfinished: dict[int, Callable[[], None]] = {}  # what takes away everything that this process has not finished
_committing = threading.RLock()


def _host() -> str:
    """Eight digits for this machine, or for the container that is one of its own."""
    try:
        space = os.stat("/proc/self/ns/pid").st_ino
    except OSError:
        space = 0
    return hashlib.sha1(f"{socket.gethostname()} {space}".encode()).hexdigest()[:8]


def _reason(error: OSError) -> str:
    return error.strerror or str(error)


def _lock(path: Path):
    from filelock import FileLock

    return FileLock(path, thread_local=False)


def _let_go(lock):
    """Give a lock back, and take its file away while nobody else can hold it: who waits for it notices."""
    if os.name != "nt":
        Path(lock.lock_file).unlink(missing_ok=True)
    lock.release()
    with suppress(OSError):  # Windows deletes no open file; and the one there now may be another's
        if os.name == "nt":
            Path(lock.lock_file).unlink()


@contextmanager
def _until_done(undo: Callable[[], None]) -> Iterator[None]:
    """`undo` is called at the end, or by `abandon` where the process ends before."""
    key = secrets.randbits(64)
    _unfinished[key] = undo
    try:
        yield
    finally:
        _unfinished.pop(key, None)
        undo()


def abandon() -> None:
    """Take away all that this process has begun and not finished: it is about to end. May be called from a thread."""
    with _committing:
        for undo in reversed(list(_unfinished.values())):
            with suppress(OSError):
                undo()


@contextmanager
def _partial(target: Path) -> Iterator[Path]:
    """A name of its own beside `target`, locked as long as it lasts; what it names is gone afterwards."""
    stem = target.parent / f".relume-{_host()}-{secrets.token_hex(4)}"
    partial = stem.with_name(stem.name + target.suffix)
    try:
        lock = _lock(stem.with_name(stem.name + ".lock"))
        lock.acquire(timeout=_MOMENT, poll_interval=0.05)
    except OSError as error:
        raise ResultError(f"{target.parent}: cannot write there ({_reason(error)})") from error

    def undo():
        _remove(partial)
        _remove(_older(partial))
        _let_go(lock)

    with _until_done(undo):
        yield partial


def _older(partial: Path) -> Path:
    return partial.with_name(partial.name + ".older")


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        with suppress(OSError):
            path.unlink()


def expect(path: str | Path) -> Path:
    """The file that a result of that name goes to, behind links. Raises ResultError where none can be written."""
    path = Path(path)
    target = Path(os.path.realpath(path))
    try:
        target.lstat()
    except FileNotFoundError:
        if not target.parent.is_dir():
            raise ResultError(f"{path}: cannot be written (there is no folder {target.parent})") from None
    except OSError as error:
        raise ResultError(f"{path}: cannot be written ({_reason(error)})") from None
    else:
        if target.is_dir():
            raise ResultError(f"{path}: is a folder; expected the name of a file")
        if not target.is_file():
            raise ResultError(f"{path}: is a device or a pipe; expected the name of an ordinary file")
    return target


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Yield the name to write a file under; it takes the place of `path` when the block ends well.

    Where the block raises, `path` is as it was. Inside `together` the file appears when that ends. The name lies in
    the same folder and has the same ending. Raises ResultError, also for an OSError of the block.
    """
    path, waiting = Path(path), _set.get()
    target = expect(path)
    with ExitStack() as stack:
        partial = stack.enter_context(_partial(target))
        with _in_words(path):
            yield partial
        if waiting is None:
            _commit([(partial, target, path)])
        else:
            waiting.append((partial, target, path, stack.pop_all()))


def write_text(path: str | Path, text: str) -> None:
    """Write a text file as UTF-8, as `replacing` does. Raises ResultError."""
    with replacing(path) as partial:
        partial.write_text(text, encoding="utf-8")


@contextmanager
def together() -> Iterator[None]:
    """All files that `replacing` writes in this block appear at its end: every one, or none. Raises ResultError."""
    waiting = []
    token = _set.set(waiting)
    with ExitStack() as stack:
        try:
            yield
        finally:
            _set.reset(token)
            for *_, cleanup in waiting:
                stack.push(cleanup)
        _commit([names for *names, _ in waiting])


@contextmanager
def _in_words(path: Path) -> Iterator[None]:
    try:
        yield
    except ResultError:
        raise
    except OSError as error:
        raise ResultError(f"{path}: cannot be written ({_reason(error)})") from error


def _commit(results: list[tuple[Path, Path, Path]]) -> None:
    """Put each (partial file, target, its name in words) in its place, or leave every target as it was."""
    with _committing:
        for partial, _, path in results:
            with _in_words(path), open(partial, "rb+") as file:
                os.fsync(file.fileno())  # only then is a disk that is full, or goes, noticed
        done = []
        try:
            for partial, target, path in results:
                with _in_words(path):
                    done.append((target, _keep(target, partial) if len(results) > 1 else None))
                    os.replace(partial, target)
        except BaseException:
            for target, put_back in reversed(done):
                if put_back:
                    put_back(target)
            raise


def _keep(target: Path, partial: Path) -> Callable[[Path], None] | None:
    """What puts an older result back: a second name for it, as it must never be without its first."""
    if not target.exists():
        return lambda target: target.unlink(missing_ok=True)
    try:
        os.link(target, _older(partial))
    except OSError:
        return None  # a file system without second names
    return lambda target: os.replace(_older(partial), target)


@contextmanager
def folder(path: str | Path) -> Iterator[Path]:
    """Make a folder for results, sure that files can be written there before anything long begins.

    What runs that are gone have left is swept out. If the block raises, folders made here that are empty go again.
    Raises ResultError.
    """
    path = Path(path)
    made = _missing(path)

    def undo():
        for each in made:
            with suppress(OSError):
                each.rmdir()

    with _until_done(undo):
        try:
            path.mkdir(parents=True, exist_ok=True)
            with _partial(path / "probe") as probe:
                probe.write_bytes(b"")
        except FileExistsError:
            raise ResultError(f"{path}: cannot write there (it is a file, not a folder)") from None
        except (OSError, ResultError) as error:
            reason = _reason(error.__cause__ or error)
            raise ResultError(f"{path}: cannot write there ({reason})") from error
        sweep(path)
        yield path


def _missing(path: Path) -> list[Path]:
    """The folders that are to be made for a path, the innermost first."""
    missing = []
    for each in (path.absolute(), *path.absolute().parents):
        try:
            each.lstat()
            break
        except OSError:
            missing.append(each)
    return missing


@contextmanager
def scratch(path: str | Path) -> Iterator[Path]:
    """A folder inside `path` that is gone at the end, with all that is in it. Raises ResultError."""
    with _partial(Path(path) / "scratch") as partial:
        try:
            partial.mkdir()
        except OSError as error:
            raise ResultError(f"{path}: cannot write there ({_reason(error)})") from error
        yield partial


@contextmanager
def claim(path: str | Path, waiting: Callable[[], None] | None = None) -> Iterator[bool]:
    """Hold the name of a result against other processes; yields whether it is held.

    Where another process holds it: with `waiting`, call that once and wait; without, yield False. A process that is
    gone holds nothing. Raises ResultError.
    """
    from filelock import Timeout

    path = Path(path)
    digest = hashlib.sha1(path.name.casefold().encode(errors="surrogateescape")).hexdigest()
    lock = _lock(path.with_name(f".relume-claim-{digest[:16]}.lock"))
    try:
        try:
            lock.acquire(timeout=_MOMENT, poll_interval=0.05)
        except Timeout:
            if waiting is not None:
                waiting()
                lock.acquire(poll_interval=0.2)
    except OSError as error:
        if not isinstance(error, Timeout):
            raise ResultError(f"{path}: cannot be claimed ({_reason(error)})") from error
    if not lock.is_locked:
        yield False
        return
    with _until_done(lambda: _let_go(lock)):
        yield True


def sweep(path: str | Path) -> None:
    """Remove what runs that are gone have left in a folder: those of this machine at once, others after a day."""
    from filelock import Timeout

    own = _host()
    names = sorted(os.listdir(path))
    for name in names:
        found = _NAME.fullmatch(name)
        if not found and not _CLAIM.fullmatch(name):
            continue
        left = Path(path) / name
        with suppress(OSError, Timeout):
            if found and found[2] != own and time.time() - left.stat().st_mtime < _DAY:
                continue
            lock = _lock(left.with_name(found[1] + ".lock") if found else left)
            lock.acquire(blocking=False)
            if not name.endswith(".lock"):
                _remove(left)
            _let_go(lock)
