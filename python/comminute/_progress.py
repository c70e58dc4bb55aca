"""What a run tells while it goes on: a bar, a function of the caller, warnings."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Callable
from typing import Any

from .errors import RunWarning

Progress = bool | Callable[[float, str], object] | None
"""``True``: a bar by tqdm, if it is installed, else nothing; a function: called with the share that is done, 0 to 1, and a line about
the present stage; ``None`` or ``False``: nothing."""

_log = logging.getLogger("comminute")


class Teller:
    """Hands on what a run tells. An exception that the caller's function raises stops the run."""

    def __init__(self, progress: Progress) -> None:
        self._call = progress if callable(progress) else None
        self._bar = _bar() if progress is True else None

    def __call__(self, kind: str, share: float, text: str) -> None:
        if kind == "warning":
            warnings.warn(text, RunWarning, stacklevel=4)
        elif kind == "note":
            _log.info(text)
        elif self._call is not None:
            self._call(share, text)
        elif self._bar is not None:
            self._bar.n = round(100.0 * share, 1)
            self._bar.set_postfix_str(text)

    def __enter__(self) -> Teller:
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()

    def finish(self, summary: dict[str, Any]) -> None:
        """Hands on the warnings of a finished run, and fills the bar."""
        if self._bar is not None:
            self._bar.n = 100.0
            self._bar.set_postfix_str("done")
        for text in summary.get("warnings") or []:
            self("warning", 1.0, text)


def _bar() -> Any:
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None
    return tqdm(total=100.0, bar_format="{l_bar}{bar}| {elapsed} {postfix}")
