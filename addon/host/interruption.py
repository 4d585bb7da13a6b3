"""Ctrl-C, which must not stop a change of the scene half-way."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

__all__ = ["held_back"]


@contextmanager
def held_back() -> Iterator[Callable[[], None]]:
    """While it is entered, Ctrl-C waits; yields a function that lets one through that came, for places fit for it.

    At the end it comes through in any case, as the KeyboardInterrupt that it would have been. In threads and where
    Python does not answer Ctrl-C, nothing changes.
    """
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(before):
        yield lambda: None
        return
    waiting = []

    def let_through() -> None:
        if waiting:
            before(*waiting.pop())

    signal.signal(signal.SIGINT, lambda *arguments: waiting.append(arguments))
    try:
        yield let_through
    finally:
        signal.signal(signal.SIGINT, before)
        if waiting:
            before(*waiting.pop())
