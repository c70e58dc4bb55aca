"""Crushable grains in laboratory tests.

>>> import comminute
>>> scene = comminute.Scene.load("experiments/petroleum_coke/h-c-2.toml")
>>> scene["loading.max_stress_kPa"] = 2000
>>> run = scene.run(out="runs/coke", progress=True)
>>> run.history[["sigma_v_kPa", "void_ratio"]]

The same as the command ``comminute`` does, byte for byte; see the page on Python in the book.
"""

from . import errors
from ._comminute import __version__, key_reference
from ._figures import Figure, Figures
from ._run import Run, plot, resume
from ._scene import Scene
from .errors import Error, RunWarning

__all__ = [
    "Error",
    "Figure",
    "Figures",
    "Run",
    "RunWarning",
    "Scene",
    "__version__",
    "errors",
    "key_reference",
    "plot",
    "resume",
]
