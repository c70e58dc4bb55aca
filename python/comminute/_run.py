"""Runs: the folders that scenes leave."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

from . import _comminute, _tables
from ._figures import Figure, Figures
from ._progress import Progress, Teller
from ._scene import Scene


class Run:
    """The folder of a run. Tables are read when they are asked for, and kept.

    ``attrs`` of a table hold the unit (``units``) and the meaning (``meanings``) of each column, and its ``file``.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = Path(folder)
        """The folder."""
        if not (self.folder / "scene.resolved.toml").is_file():
            raise FileNotFoundError(f"{self.folder}: holds no run")

    @classmethod
    def open(cls, folder: str | os.PathLike[str]) -> Run:
        """The run in a folder, whoever made it."""
        return cls(folder)

    @cached_property
    def scene(self) -> Scene:
        """The scene with every default; running it repeats the run."""
        return Scene.load(self.folder / "scene.resolved.toml")

    @property
    def summary(self) -> dict[str, Any]:
        """What ``summary.json`` says; empty where the run has not ended."""
        path = self.folder / "summary.json"
        found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
        return found

    @property
    def finished(self) -> bool:
        """Whether the run has ended."""
        return bool(self.summary) and not (self.folder / "checkpoint.bin").exists()

    @property
    def tables(self) -> list[str]:
        """Names of the tables that the folder holds."""
        return sorted(path.name for path in self.folder.glob("*.csv"))

    def table(self, name: str, *, pandas: bool | None = None) -> Any:
        """The table ``name``, as in ``"platen.csv"`` or ``"platen"``: a pandas frame; a structured array of numpy where pandas is not
        installed, or with ``pandas=False``."""
        path = self.folder / (name if name.endswith(".csv") else f"{name}.csv")
        if not path.is_file():
            raise FileNotFoundError(f"{self.folder}: has no table {path.name}; it has {', '.join(self.tables) or 'none'}")
        return _tables.read(path, str(self.scene["kind"]), pandas=pandas)

    def to_parquet(self, out: str | os.PathLike[str]) -> list[Path]:
        """Writes every table as a file of Parquet into the folder ``out``, and gives their paths; pandas and pyarrow must be installed.
        ``pandas.read_parquet`` gives the same frames, units and meanings included. Files of these names are overwritten."""
        folder = Path(out)
        folder.mkdir(parents=True, exist_ok=True)
        files = [folder / f"{Path(name).stem}.parquet" for name in self.tables]
        for name, file in zip(self.tables, files, strict=True):
            self.table(name, pandas=True).to_parquet(file, engine="pyarrow")
        return files

    @cached_property
    def history(self) -> Any:
        """``history.csv``: what the test shows, a row for each record."""
        return self.table("history")

    @cached_property
    def gradation(self) -> Any:
        """``gsd.csv``: the gradations at the records."""
        return self.table("gsd")

    @cached_property
    def breakage(self) -> Any:
        """``breakage.csv``: every breakage with its cause."""
        return self.table("breakage")

    @cached_property
    def grains(self) -> Any:
        """``grains_final.csv``: the grains at the end."""
        return self.table("grains_final")

    @cached_property
    def specimen(self) -> Any:
        """``specimen.csv``: the grains before the test."""
        return self.table("specimen")

    def plot(self) -> Figures:
        """The figures of the run, as the command draws them; drawn now where they are not there yet."""
        drawn = self.folder / "figures" / "drawn.txt"
        if drawn.is_file():
            names = drawn.read_text(encoding="utf-8").splitlines()
            return Figures([drawn.parent / name for name in names])
        return Figures([Path(file) for file in _comminute.draw(self.folder)])

    def report(self, out: str | os.PathLike[str] | None = None, *, force: bool = False) -> Path:
        """Writes the page that shows the run, into its folder as ``report.html`` if ``out`` is not given, and gives its path. ``force``
        overwrites a file that is no report."""
        page = self.folder / "report.html" if out is None else Path(out)
        _comminute.report(self.folder, page, force)
        return page

    def _repr_html_(self) -> str:
        rows = "".join(f"<tr><td>{key}</td><td>{value}</td></tr>" for key, value in self.summary.items())
        return f"<b>{self.folder}</b><table>{rows}</table>"

    def __repr__(self) -> str:
        return f"Run({str(self.folder)!r})"


def resume(
    folder: str | os.PathLike[str],
    *,
    threads: int | None = None,
    backend: str | None = None,
    stop_after: int | None = None,
    progress: Progress = None,
) -> Run:
    """Goes on with the run that was stopped in ``folder``, as ``comminute resume`` does. The records end with the same bytes as without
    the stop. Arguments are those of :meth:`Scene.run`."""
    with Teller(progress) as tell:
        summary = _comminute.resume(folder, threads=threads, backend=backend, stop_after=stop_after, tell=tell)
        tell.finish(json.loads(summary))
    return Run(folder)


def plot(
    runs: Sequence[Run | str | os.PathLike[str]], out: str | os.PathLike[str], data: Sequence[str | os.PathLike[str]] = ()
) -> Figures:
    """Draws several runs into common figures in the folder ``out``, with measurements (CSV files) as symbols, as ``comminute plot``."""
    folders = [run.folder if isinstance(run, Run) else run for run in runs]
    return Figures([Path(file) for file in _comminute.overlay(folders, data, out)])


__all__ = ["Figure", "Figures", "Run", "plot", "resume"]
