"""Every error that Relume raises on purpose. Its message is the sentence that the user gets."""

__all__ = [
    "CoefficientImageError",
    "LibraryError",
    "MeasureError",
    "ModelError",
    "PaletteError",
    "RelumeError",
    "RenderError",
    "ResultError",
    "SequenceError",
    "SetupError",
    "SpectrumError",
    "UsageError",
]


class RelumeError(Exception):
    """Something that cannot be done; the message says what, where and what was expected."""


class SpectrumError(RelumeError, ValueError):
    """Samples that do not make a spectrum; the message says which and why."""


class LibraryError(RelumeError, KeyError):
    """A name that the library does not hold; the message suggests the nearest ones."""

    def __str__(self) -> str:
        return self.args[0]


class ModelError(RelumeError, ValueError):
    """A factor model that cannot be made, or cannot do what was asked; the message says why."""


class MeasureError(RelumeError, ValueError):
    """Colours that cannot be compared; the message says why."""


class PaletteError(RelumeError, ValueError):
    """A design of lights and reflectances that cannot mean anything; the message says which part of it and why."""


class CoefficientImageError(RelumeError, ValueError):
    """An EXR that does not hold what was expected; the message says which file and what is missing."""


class SequenceError(RelumeError, ValueError):
    """A sequence that cannot be used; the message says which frames are missing."""


class SetupError(RelumeError, RuntimeError):
    """A scene that cannot be set up; the message says what it lacks."""


class RenderError(RelumeError, RuntimeError):
    """A render that could not be made; the message says why."""


class ResultError(RelumeError, OSError):
    """A file or folder that cannot be written or claimed; the message says which and why."""


class UsageError(RelumeError, ValueError):
    """A command or an argument that cannot mean anything; the message says what was expected."""
