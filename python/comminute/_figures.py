"""Figures, shown by notebooks as they are."""

from __future__ import annotations

import base64
import html
from collections.abc import Iterator, Mapping
from pathlib import Path


class Figure:
    """A figure in SVG. Notebooks show it."""

    def __init__(self, path: Path) -> None:
        self.path = path
        """The SVG file."""

    @property
    def name(self) -> str:
        """Name of the figure, as of its file."""
        return self.path.stem

    @property
    def svg(self) -> str:
        """The drawing."""
        return self.path.read_text(encoding="utf-8")

    @property
    def png(self) -> Path:
        """The same in pixels."""
        return self.path.with_suffix(".png")

    @property
    def data(self) -> Path:
        """The numbers that are drawn (CSV)."""
        return self.path.with_suffix(".csv")

    def _repr_svg_(self) -> str:
        return self.svg

    def __repr__(self) -> str:
        return f"Figure({str(self.path)!r})"


class Figures(Mapping[str, Figure]):
    """Figures by their names. Notebooks show all of them."""

    def __init__(self, files: list[Path]) -> None:
        self._figures = {path.stem: Figure(path) for path in sorted(files) if path.suffix == ".svg"}

    def __getitem__(self, name: str) -> Figure:
        if name not in self._figures:
            raise KeyError(f"there is no figure {name}; there are {', '.join(self._figures)}")
        return self._figures[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._figures)

    def __len__(self) -> int:
        return len(self._figures)

    def _repr_html_(self) -> str:
        # as pictures: names inside of one drawing mean nothing in the others
        shown = (
            f'<img alt="{html.escape(figure.name)}" src="data:image/svg+xml;base64,{base64.b64encode(figure.svg.encode()).decode()}"/>'
            for figure in self.values()
        )
        return "\n".join(shown)

    def __repr__(self) -> str:
        return f"Figures({', '.join(self)})"
