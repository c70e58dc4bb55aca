"""Scenes."""

from __future__ import annotations

import json
import os
import tomllib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from . import _comminute
from ._progress import Progress, Teller

if TYPE_CHECKING:
    from ._run import Run

Path = str | os.PathLike[str]


class Scene:
    """What is tested: a scene file, a text or a dict, with values laid over it. Every value has passed its own check.

    ``Scene.load`` and ``Scene.from_text`` make one; ``Scene(dict)`` from a dict, in which ``{"loading": {"max_stress_kPa": 2000}}`` and
    ``{"loading.max_stress_kPa": 2000}`` mean the same. ``scene[key]`` is the value at a dotted key in the unit of the key, every default
    included; ``scene[key] = value`` replaces it as ``--set`` does for the command.
    """

    def __init__(self, content: Mapping[str, Any], folder: Path = ".") -> None:
        """A scene from a dict. Paths in it are relative to ``folder``."""
        self._begin((None, _comminute.toml_text(dict(content)), os.fspath(folder)), [])

    @classmethod
    def load(cls, path: Path, sets: Mapping[str, Any] | None = None) -> Scene:
        """The scene of a file, with the values of ``sets`` laid over it."""
        scene = cls.__new__(cls)
        scene._begin((os.fspath(path), "", ""), _overrides(sets or {}))
        return scene

    @classmethod
    def from_text(cls, text: str, folder: Path = ".", sets: Mapping[str, Any] | None = None) -> Scene:
        """The scene of a text in TOML. Paths in it are relative to ``folder``."""
        scene = cls.__new__(cls)
        scene._begin((None, text, os.fspath(folder)), _overrides(sets or {}))
        return scene

    def _begin(self, source: tuple[str | None, str, str], sets: list[str]) -> None:
        path, text, folder = source
        read = _comminute.Scene.load(path, sets) if path is not None else _comminute.Scene.of_text(text, folder, sets)
        self._source, self._sets, self._native = source, sets, read

    @property
    def name(self) -> str:
        """Name for legends and records."""
        return self._native.name

    @property
    def description(self) -> str:
        """One line about the scene."""
        return self._native.description

    @property
    def kind(self) -> str:
        """Kind of the test: oedometer, triaxial, isotropic, platen, assembly, continuum or mixture."""
        return str(self["kind"])

    def __getitem__(self, key: str) -> Any:
        value = self._native.get(key)
        if value is None:
            raise KeyError(f"{self.name} has no value {key}")
        return value

    def __contains__(self, key: object) -> bool:
        return isinstance(key, str) and self._native.get(key) is not None

    def get(self, key: str, default: Any = None) -> Any:
        """The value at a dotted key; ``default`` where there is none."""
        return self[key] if key in self else default

    def __setitem__(self, key: str, value: Any) -> None:
        self.update({key: value})

    def update(self, sets: Mapping[str, Any]) -> None:
        """Replaces several values at once; the scene is read anew with all of them. After an error it is as before."""
        self._begin(self._source, self._sets + _overrides(sets))

    def copy(self, sets: Mapping[str, Any] | None = None) -> Scene:
        """The same scene, with the values of ``sets`` replaced."""
        scene = type(self).__new__(type(self))
        scene._begin(self._source, self._sets + _overrides(sets or {}))
        return scene

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (self._source, self._sets)

    def to_toml(self) -> str:
        """The scene with every default, its material and its grains written out: running it repeats the run."""
        return self._native.resolved()

    def to_dict(self) -> dict[str, Any]:
        """The same as a dict."""
        return tomllib.loads(self.to_toml())

    def check(self, *, range: bool = False, measure: bool = False) -> dict[str, Any]:
        """Validates the scene and says what its run would be: what ``comminute check --json`` prints.

        ``range``: measure the range of void ratios that can be made of these grains (seconds to minutes). ``measure``: measure how fast
        this machine is (a second). Both are kept in the user's cache.
        """
        found: dict[str, Any] = json.loads(self._native.check(range, measure))
        return found

    def run(
        self,
        out: Path | None = None,
        *,
        threads: int | None = None,
        backend: str | None = None,
        specimen: Path | None = None,
        force: bool = False,
        resume: bool = False,
        stop_after: int | None = None,
        progress: Progress = None,
    ) -> Run:
        """Makes the run and draws its figures; gives the folder that it left. The records are those of the command, byte for byte.

        ``out``: the folder; ``runs/`` and the name of the scene if not given. ``threads``: one for each core if not given; results do
        not depend on it. ``backend``: ``"cpu"``, ``"gpu"`` or ``"auto"``. ``specimen``: ``specimen.csv`` of another run to begin with.
        ``force``: overwrite a run that the folder holds. ``resume``: do only what is left, nothing if the run is finished.
        ``stop_after``: stop with a checkpoint after so many steps; raises :class:`~comminute.errors.Interrupted`.
        ``progress``: ``True`` for a bar (tqdm), or a function of the share that is done and a line.

        Other threads of Python go on meanwhile. Ctrl-C stops the run with a checkpoint and raises ``KeyboardInterrupt``;
        ``comminute.resume(out)`` goes on from there. An exception of ``progress`` stops it in the same way.
        """
        from ._run import Run

        scene = self if specimen is None else self.copy({"specimen.file": specimen})
        with Teller(progress) as tell:
            folder, summary = scene._native.run(
                out=out, threads=threads, backend=backend, force=force, left=resume, stop_after=stop_after, tell=tell
            )
            tell.finish(json.loads(summary))
        return Run(folder)

    def __repr__(self) -> str:
        return f"<Scene {self.name}: {self.description}>" if self.description else f"<Scene {self.name}>"


def _overrides(sets: Mapping[str, Any]) -> list[str]:
    return [f"{key}={_comminute.literal(value)}" for key, value in sets.items()]


def _again(source: tuple[str | None, str, str], sets: list[str]) -> Scene:
    scene = Scene.__new__(Scene)
    scene._begin(source, sets)
    return scene
