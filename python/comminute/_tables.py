"""Tables of runs as pandas frames, or as arrays of numpy where pandas is missing."""

from __future__ import annotations

import csv
import io
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import numpy as np

from . import _comminute


class Table(np.ndarray):
    """A structured array, with units and meanings of its columns in ``attrs`` as pandas frames have them."""

    attrs: dict[str, Any]

    def __array_finalize__(self, obj: Any) -> None:
        self.attrs = dict(getattr(obj, "attrs", {}))


def read(path: Path, kind: str, *, pandas: bool | None = None) -> Any:
    """The table in a CSV file that a run of a scene of this kind left. ``pandas``: whether to use it; ``None``: where it is installed.

    Lines that begin with ``#`` are passed over. Numbers are those of the file to the last bit; an empty cell is NaN.
    """
    found = None if pandas is False else _pandas(required=pandas is True)
    table: Any = _array(path) if found is None else _frame(path, found)
    about = described(path.name, kind)
    table.attrs["file"] = str(path)
    # columns that the table does not have are left out
    names = set(table.columns if found is not None else table.dtype.names or ())
    table.attrs["units"] = {name: unit for name, (unit, _) in about.items() if name in names}
    table.attrs["meanings"] = {name: what for name, (_, what) in about.items() if name in names}
    return table


def described(file: str, kind: str) -> dict[str, tuple[str, str]]:
    """Unit and meaning of each column that the table ``file`` of a run of this kind can have; ``-`` is the unit of what has none."""
    for files, columns in _comminute.columns(kind):
        if any(fnmatch(file, name) for name in files):
            return {name: (unit, what) for name, unit, what in columns}
    return {}


def _pandas(*, required: bool) -> Any:
    try:
        import pandas
    except ImportError:
        if required:
            raise
        return None
    return pandas


def _frame(path: Path, pandas: Any) -> Any:
    # from 3.1 on every number is read to the last bit, and saying so is deprecated
    exact = {} if _version(pandas) >= (3, 1) else {"float_precision": "round_trip"}
    # only an empty cell is missing: `None` and `NA` are names that a material may have
    return pandas.read_csv(path, comment="#", keep_default_na=False, na_values=[""], **exact)


def _version(package: Any) -> tuple[int, int]:
    major, minor = str(package.__version__).split(".")[:2]
    return int(major), int(minor)


def _array(path: Path) -> Table:
    with path.open(newline="", encoding="utf-8") as file:
        rows = csv.reader(line for line in file if not line.startswith("#"))
        names = next(rows, [])
        cells = list(zip(*rows, strict=True)) or [() for _ in names]
    columns = [_column(texts) for texts in cells]
    array = np.empty(len(columns[0]) if columns else 0, dtype=[(n, c.dtype) for n, c in zip(names, columns, strict=True)])
    for name, column in zip(names, columns, strict=True):
        array[name] = column
    return array.view(Table)


def _column(texts: tuple[str, ...]) -> np.ndarray:
    for convert in (int, lambda text: float(text) if text else float("nan")):
        try:
            values = [convert(text) for text in texts]
        except ValueError:
            continue
        return np.array(values, dtype=int if convert is int else float)
    return np.array(texts, dtype=str)


def of_rows(rows: list[dict[str, Any]], file: str, kind: str) -> Any:
    """Rows that a simulation tells, as the table ``file`` of a run of this kind: a pandas frame, or a structured array."""
    about = described(file, kind)
    names = list(rows[0]) if rows else list(about)
    found = _pandas(required=False)
    table: Any
    if found is not None:
        table = found.DataFrame(rows, columns=names)
    else:
        columns = [np.array([row[name] for row in rows]) for name in names]
        array = np.empty(len(rows), dtype=[(name, column.dtype) for name, column in zip(names, columns, strict=True)])
        for name, column in zip(names, columns, strict=True):
            array[name] = column
        table = array.view(Table)
    table.attrs["units"] = {name: about[name][0] for name in names if name in about}
    table.attrs["meanings"] = {name: about[name][1] for name in names if name in about}
    return table


def csv_text(columns: Any) -> str:
    """Columns (a pandas frame, a dict, a structured array) as the text of a CSV file; missing values are empty, numbers whole."""
    names = list(columns.dtype.names) if isinstance(columns, np.ndarray) else list(columns)
    cells = [np.asarray(columns[name]).tolist() for name in names]
    lengths = {len(column) for column in cells}
    if len(lengths) > 1:
        raise ValueError("columns of a table must have one length")
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    # what is not equal to itself is missing
    writer.writerows([("" if cell is None or cell != cell else cell) for cell in row] for row in zip(*cells, strict=True))
    return text.getvalue()
