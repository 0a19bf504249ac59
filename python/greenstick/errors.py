"""Exceptions: one class for each error of the library, with its message.

``kind`` says who can do something about it: ``"request"`` where the request or its input must change, ``"work"`` where the
request is right and the work failed, ``"cancelled"`` where the caller stopped it.
"""

import pickle


class GreenstickError(Exception):
    """The base of all errors of this library."""

    kind: str

    def __init__(self, message: str, kind: str = "request") -> None:
        super().__init__(message)
        self.kind = kind

    def __reduce__(self) -> tuple[type["GreenstickError"], tuple[str, str]]:
        return type(self), (str(self), self.kind)


class Cancelled(GreenstickError):
    """The work was cancelled by its caller."""


class InputError(GreenstickError, ValueError):
    """An argument, such as an array, is wrong."""


class ParameterError(GreenstickError, ValueError):
    """A parameter, a recipe or a preset is wrong."""


class SpeciesError(GreenstickError, LookupError):
    """The species is not known."""


class MoistureError(GreenstickError, ValueError):
    """The wood is not known at a moisture content."""


class StemError(GreenstickError):
    """There is no stem at the place, or it cannot be broken there."""


class CutError(GreenstickError):
    """The mesh cannot be cut."""


class TextureError(GreenstickError):
    """The textures of the wood inside cannot be made."""


class CrackError(GreenstickError):
    """Cracks cannot be made."""


class ScanError(GreenstickError):
    """No bark can be made of a scan."""


class AnatomyError(GreenstickError):
    """The inside of the stem cannot be made."""


class SectionError(GreenstickError, ValueError):
    """A section has no rings."""


class BendingError(GreenstickError):
    """A bending test cannot be made."""


class SimulateError(GreenstickError):
    """A scene cannot be simulated."""


class SweepError(GreenstickError):
    """A sweep cannot be begun or go on."""


class FilmError(GreenstickError):
    """No skin or film can be made of a run."""


class FormatError(GreenstickError):
    """A format cannot represent the result, or a file is damaged."""


class FileError(GreenstickError, OSError):
    """A file cannot be read or written."""


class PictureError(GreenstickError):
    """A picture cannot be taken."""


class ReportError(GreenstickError):
    """A report cannot be made."""


class PickleError(GreenstickError, pickle.UnpicklingError):
    """A pickle is damaged, or of another version of the library."""


class BusyError(GreenstickError):
    """A session is at work for another thread."""


class WorkError(GreenstickError):
    """The work failed for a reason that the library does not know."""
