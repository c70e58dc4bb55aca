"""Many runs, and parameters from measurements: what ``comminute ensemble``, ``study`` and ``calibrate`` do, with the same files."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

from . import _comminute, _tables
from ._figures import Figures
from ._progress import Progress, Teller
from ._run import Run
from ._scene import Scene

File = str | os.PathLike[str]


class Results:
    """The folder of an ensemble, a study or a calibration."""

    def __init__(self, folder: File) -> None:
        self.folder = Path(folder)
        """The folder."""

    @property
    def _papers(self) -> Path:
        """The folder of report, tables and figures."""
        return self.folder

    @property
    def tables(self) -> list[str]:
        """Names of the tables."""
        return sorted(path.name for path in self._papers.glob("*.csv"))

    def table(self, name: str, *, pandas: bool | None = None) -> Any:
        """The table ``name``; as :meth:`Run.table`."""
        path = self._papers / (name if name.endswith(".csv") else f"{name}.csv")
        if not path.is_file():
            raise FileNotFoundError(f"{self._papers}: has no table {path.name}; it has {', '.join(self.tables) or 'none'}")
        return _tables.read(path, "", pandas=pandas)

    @property
    def figures(self) -> Figures:
        """The figures by name."""
        return Figures([*self._papers.glob("*.svg"), *self._papers.glob("figures/*.svg")])

    def _repr_html_(self) -> str:
        return self.figures._repr_html_()

    def __repr__(self) -> str:
        return f"{type(self).__name__}({str(self.folder)!r})"


class Ensemble(Results):
    """Runs of a scene with several seeds, and the mean and the band of every curve."""

    @cached_property
    def runs(self) -> list[Run]:
        """The runs, in the order of their seeds."""
        seeds = sorted(int(path.name.removeprefix("seed-")) for path in self.folder.glob("seed-*") if path.is_dir())
        return [Run(self.folder / f"seed-{seed}") for seed in seeds]


    @property
    def mean(self) -> Any:
        """``mean.csv``: mean, standard deviation and band of every curve at common stresses."""
        return self.table("mean")


class Study(Results):
    """What choices cost: runs with other levels of factors against a reference."""

    @property
    def _papers(self) -> Path:
        return self.folder / "report"

    @property
    def report(self) -> str:
        """The report (``report/README.md``): what was asked, what was found."""
        return (self._papers / "README.md").read_text(encoding="utf-8")


class Calibration(Results):
    """Parameters from measurements."""

    @property
    def report(self) -> str:
        """``report.md``: what was found, and how far it can be trusted."""
        return (self.folder / "report.md").read_text(encoding="utf-8")

    @cached_property
    def result(self) -> dict[str, Any]:
        """``calibration.json``: every estimate with its interval, and how good it is."""
        found: dict[str, Any] = json.loads((self.folder / "calibration.json").read_text(encoding="utf-8"))
        return found

    @property
    def material(self) -> Path | None:
        """``material.toml`` for scenes; ``None`` where the measurements leave it open."""
        path = self.folder / "material.toml"
        return path if path.is_file() else None


def ensemble(
    scene: Scene | File,
    out: File,
    *,
    seeds: Iterable[int] = range(1, 9),
    vary: str = "both",
    jobs: int | None = None,
    threads: int | None = None,
    backend: str | None = None,
    specimen: File | None = None,
    data: Sequence[File] = (),
    force: bool = False,
    executor: str | None = None,
    executor_command: str | None = None,
    executor_options: str | None = None,
    progress: Progress = None,
) -> Ensemble:
    """Runs a scene with several seeds, each in a process of its own, and draws mean and band of every curve: ``comminute ensemble``.

    ``vary``: what the seeds choose, ``"both"``, ``"packing"`` or ``"strength"``. ``jobs``: runs at a time; one for each core if not
    given. A second call does only what is left. Runs that fail raise :class:`~comminute.errors.CampaignError` when the others are done.
    ``executor``: who starts the runs, ``"local"``, ``"slurm"`` or ``"hyperqueue"`` (with ``executor_options`` of ``sbatch`` or
    ``hq submit``) or ``"command"`` (by the shell command ``executor_command``, such as ``"ssh node {word}"``).
    """
    words = ["ensemble", *_scene(scene, out), "--seeds", ",".join(str(seed) for seed in seeds), "--vary", vary]
    words += _files("--data", data)
    _call(
        words,
        out,
        progress,
        jobs=jobs,
        threads=threads,
        backend=backend,
        specimen=specimen,
        force=force,
        executor=executor,
        executor_command=executor_command,
        executor_options=executor_options,
    )
    return Ensemble(out)


def study(
    plan: File,
    out: File,
    *,
    jobs: int | None = None,
    threads: int | None = None,
    backend: str | None = None,
    force: bool = False,
    executor: str | None = None,
    executor_command: str | None = None,
    executor_options: str | None = None,
    progress: Progress = None,
) -> Study:
    """Measures what the choices of a plan (TOML) cost against its reference: ``comminute study``. Arguments as of :func:`ensemble`."""
    _call(
        ["study", os.fspath(plan)],
        out,
        progress,
        jobs=jobs,
        threads=threads,
        backend=backend,
        force=force,
        executor=executor,
        executor_command=executor_command,
        executor_options=executor_options,
    )
    return Study(out)


def calibrate_grains(
    tests: Any,
    out: File,
    *,
    theta0: float | None = None,
    grain_E_GPa: float | None = None,
    grain_nu: float | None = None,
    platen_E_GPa: float | None = None,
    platen_nu: float | None = None,
    d0_mm: float | None = None,
    material: File | None = None,
    area_model: str | None = None,
    intervals: str | None = None,
    bootstrap: int | None = None,
    samples: int | None = None,
    seed: int | None = None,
    force: bool = False,
    progress: Progress = None,
) -> Calibration:
    """Strength of grains from the forces that crushed them between platens: ``comminute calibrate grains``, whose options these are.

    ``tests``: a CSV file, a pandas frame or a dict of columns, with ``diameter_mm`` and ``force_N``, and ``censored`` (1: it did not
    break) and ``series`` where there are. Frames are written beside the folder first, as ``out`` with ``.csv``.
    """
    _call(
        ["calibrate", "grains", _data(tests, out)],
        out,
        progress,
        theta0=theta0,
        grain_E_GPa=grain_E_GPa,
        grain_nu=grain_nu,
        platen_E_GPa=platen_E_GPa,
        platen_nu=platen_nu,
        d0_mm=d0_mm,
        material=material,
        area_model=area_model,
        intervals=intervals,
        bootstrap=bootstrap,
        samples=samples,
        seed=seed,
        force=force,
    )
    return Calibration(out)


def calibrate_curve(
    curve: Any,
    scene: Scene | File,
    out: File,
    *,
    parameters: Mapping[str, tuple[float, float] | str] | None = None,
    k0: File | None = None,
    gsd: File | None = None,
    budget: int | None = None,
    design: int | None = None,
    batch: int | None = None,
    check: int | None = None,
    specimens: int | None = None,
    seed: int | None = None,
    jobs: int | None = None,
    threads: int | None = None,
    force: bool = False,
    executor: str | None = None,
    executor_command: str | None = None,
    executor_options: str | None = None,
    progress: Progress = None,
) -> Calibration:
    """Parameters of a scene from an oedometer curve, with what the curve leaves open: ``comminute calibrate curve``, whose options these are.

    ``curve``: a CSV file, a pandas frame or a dict of columns (written beside the folder first, as ``out`` with ``.csv``).
    ``parameters``: bounds of each key, ``{"material.contact.friction": (0.1, 0.6)}``, or a text with the prior, ``"0.1..0.6:log"``;
    the ``[[calibrate]]`` tables of the scene if not given. A call with a larger ``budget`` goes on.
    """
    words = ["calibrate", "curve", _data(curve, out)]
    path, *sets = _scene(scene, out)
    words += ["--scene", path, *sets]
    for key, bounds in (parameters or {}).items():
        text = bounds if isinstance(bounds, str) else f"{float(bounds[0])!r}..{float(bounds[1])!r}"
        words += ["--parameter", f"{key}={text}"]
    _call(
        words,
        out,
        progress,
        k0=k0,
        gsd=gsd,
        budget=budget,
        design=design,
        batch=batch,
        check=check,
        specimens=specimens,
        seed=seed,
        jobs=jobs,
        threads=threads,
        force=force,
        executor=executor,
        executor_command=executor_command,
        executor_options=executor_options,
    )
    return Calibration(out)


def _call(words: list[str], out: File, progress: Progress, **options: Any) -> None:
    """Calls a verb of the command with these options; those that are ``None`` or ``False`` are left out."""
    for name, value in options.items():
        if value is not None and value is not False:
            option = f"--{name.replace('_', '-')}"
            # as one word, so that a negative number is no option
            words.append(option if value is True else f"{option}={os.fspath(value) if isinstance(value, os.PathLike) else value}")
    with Teller(progress) as tell:
        _comminute.call([*words, "--out", os.fspath(out), "--quiet"], tell)
        tell.finish({})


def _scene(scene: Scene | File, out: File) -> list[str]:
    """Words for a scene: its file, and what is laid over it. A scene without a file is written beside the folder ``out`` first."""
    if not isinstance(scene, Scene):
        return [os.fspath(scene)]
    path, _, _ = scene._source
    sets = scene._sets
    if path is None:
        path, sets = _beside(out, ".toml", scene.to_toml()), []
    return [path, *(word for text in sets for word in ("--set", text))]


def _data(data: Any, out: File) -> str:
    """The file of measurements. Columns are written beside the folder ``out`` first."""
    if isinstance(data, (str, os.PathLike)):
        return os.fspath(data)
    return _beside(out, ".csv", _tables.csv_text(data))


def _beside(out: File, end: str, text: str) -> str:
    folder = Path(out)
    folder.parent.mkdir(parents=True, exist_ok=True)
    path = folder.with_name(folder.name + end)
    path.write_text(text, encoding="utf-8", newline="\n")
    return os.fspath(path)


def _files(option: str, files: Sequence[File]) -> list[str]:
    return [word for file in files for word in (option, os.fspath(file))]
