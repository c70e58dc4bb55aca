"""Crushable grains in laboratory tests.

>>> import comminute
>>> scene = comminute.Scene.load("experiments/petroleum_coke/h-c-2.toml")
>>> scene["loading.max_stress_kPa"] = 2000
>>> run = scene.run(out="runs/coke", progress=True)
>>> run.history[["sigma_v_kPa", "void_ratio"]]

The same as the command ``comminute`` does, byte for byte; see the page on Python in the book.
"""

import sys

from . import _comminute, errors
from ._campaign import Calibration, Ensemble, Results, Study, calibrate_curve, calibrate_grains, ensemble, study
from ._comminute import __version__, key_reference
from ._figures import Figure, Figures
from ._run import Run, plot, resume
from ._scene import Scene
from ._simulation import Bodies, Body, Points, Simulation, Wall, Walls
from .errors import Error, RunWarning

# runs of a campaign are processes: this Python, which must not find a folder `comminute` where it is started instead of the package
if sys.executable:
    _comminute.runs_by(sys.executable, ["-P", "-m", "comminute"])

__all__ = [
    "Bodies",
    "Body",
    "Calibration",
    "Ensemble",
    "Error",
    "Figure",
    "Figures",
    "Points",
    "Results",
    "Run",
    "RunWarning",
    "Scene",
    "Simulation",
    "Study",
    "Wall",
    "Walls",
    "__version__",
    "calibrate_curve",
    "calibrate_grains",
    "ensemble",
    "errors",
    "key_reference",
    "plot",
    "resume",
    "study",
]
