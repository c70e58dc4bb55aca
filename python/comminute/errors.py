"""What can go wrong, with the texts of the command.

Each kind of error of the library has a class here. All are :class:`Error`; most are a kind of ``ValueError``, ``OSError`` or
``RuntimeError`` as well, so that a program can catch them as it is used to.
"""

from __future__ import annotations

from pathlib import Path


class Error(Exception):
    """Why nothing was started, or why a run ended."""

    exit_code: int = 1
    """Exit code of the command for this error: 1 the run failed; 2 the call, scene or data is wrong and nothing was started; 3 the run
    became unstable, physically impossible or came to a standstill; 130 stopped from outside."""


class InputError(Error, ValueError):
    """A scene, material, data file or value laid over them says something that is not allowed."""

    place: str = ""
    """File (with a line where there is one), or ``override key=value``."""
    key: str = ""
    """Dotted key or column; empty when the whole place is meant."""
    value: str | None = None
    """The value as written."""
    message: str = ""
    """What is allowed and what to do."""


class InputErrors(InputError):
    """Several mistakes found in one reading."""

    errors: list[Error] = []
    """One exception for each."""


class ReadError(Error, OSError):
    """A file could not be read."""

    path: Path | None = None


class NotFoundError(ReadError, FileNotFoundError):
    """There is no such file."""


class WriteError(Error, OSError):
    """A file could not be written."""

    path: Path | None = None


class ExistsError(Error, FileExistsError):
    """The folder holds a run already; ``force=True`` overwrites it."""

    path: Path | None = None


class OtherRunError(ExistsError):
    """The folder holds a run of another scene; ``force=True`` overwrites it."""


class BusyError(Error, OSError):
    """Another process is running in the folder."""

    path: Path | None = None


class CampaignError(Error, RuntimeError):
    """Some of several runs failed; the others are done."""

    failed: list[tuple[Path, str]] = []
    """Folder and reason of each."""


class StoppedError(Error):
    """Several runs were stopped from outside; what is done is kept, and the same call goes on with the rest."""

    failed: list[tuple[Path, str]] = []


class UnstableError(Error, ArithmeticError):
    """A number of the state is not finite, or out of the range in which the method is valid."""

    step: int = 0
    grain: int | None = None


class ImpossibleError(Error, RuntimeError):
    """A test shows something that is physically impossible. The records so far are kept."""

    step: int = 0


class StalledError(Error, RuntimeError):
    """A test does not come to what the scene asks for. The records so far are kept."""

    step: int = 0


class FailedError(Error, RuntimeError):
    """The run could not be prepared."""

    step: int = 0


class DeviceError(Error, RuntimeError):
    """What a graphics device could not do; the processor can (``backend="cpu"``)."""


class CheckpointError(Error, ValueError):
    """A run that cannot be continued."""

    path: Path | None = None


class FigureError(Error, RuntimeError):
    """Figures could not be drawn from the records."""


class Interrupted(Error):
    """A run was stopped at the step that the caller asked for (``stop_after``). ``comminute.resume(error.path)`` goes on from there.
    Without a path: what was stopped keeps nothing."""

    step: int = 0
    path: Path | None = None


class RunWarning(UserWarning):
    """What speaks against a run, or what a run found; the command prints the same after ``warning:``."""
