"""GrainLearning's Bayesian calibration drives scenes of comminute.

GrainLearning (Cheng et al. 2019, doi 10.1016/j.cma.2019.01.027) is a package of its own, under the GPL: ``pip install grainlearning``. Its
iterative Bayesian filter asks for what a model shows at some parameters; :func:`callback` answers with runs of a scene.

Here it has to find the shear modulus of petroleum coke and the friction between its grains again from a curve that was made with known
ones: the axial strain and the stress ratio of an oedometer up to 400 kPa, without breakages. From the folder of the repository::

    pip install grainlearning "./python[pandas]"
    python -P python/examples/grainlearning_oedometer.py

It takes a minute or two. Prints the estimates of each iteration, and fails unless the truth lies within three standard deviations of
the last ones, and the standard deviation of the modulus within 10 % of it.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from grainlearning import BayesianCalibration
from grainlearning.dynamic_systems import DynamicSystem

import comminute

# what is to be found: key, least and largest value, and the truth
PARAMETERS = {
    "material.elastic.G_GPa": (0.1, 0.8, 0.33),
    "material.contact.friction_angle_rad": (0.15, 0.7, 0.4),
}
# vertical stresses at which the curves are compared, kPa
STRESSES = np.geomspace(20.0, 380.0, 12)

SMALL = {
    "crushing.enabled": False,
    "loading.max_stress_kPa": 400,
    "records.figures": False,
    "records.snapshots": False,
}


def callback(
    scene: comminute.Scene, out: Path, observe: Callable[[comminute.Run], np.ndarray], specimen: Path, jobs: int | None = None
) -> Callable[[BayesianCalibration], None]:
    """The function that GrainLearning calls in each iteration: a run of ``scene`` for each sample, with the sample's values at the keys
    ``param_names``, and what ``observe`` reads from it, an array of shape (observables, steps)."""

    def run_samples(calibration: BayesianCalibration) -> None:
        system = calibration.system

        def sample(number: int) -> np.ndarray:
            values = dict(zip(system.param_names, map(float, system.param_data[number]), strict=True))
            folder = out / f"iteration-{calibration.curr_iter}" / f"sample-{number}"
            return observe(scene.copy(values).run(folder, threads=1, specimen=specimen))

        # runs leave the interpreter free for each other
        with ThreadPoolExecutor(jobs or os.cpu_count()) as pool:
            system.set_sim_data(list(pool.map(sample, range(len(system.param_data)))))

    return run_samples


def observe(run: comminute.Run) -> np.ndarray:
    """Axial strain, %, and stress ratio at the stresses ``STRESSES``."""
    history = run.history
    sigma_v = history["sigma_v_kPa"]
    strain = np.interp(STRESSES, sigma_v, 100.0 * history["axial_strain"])
    return np.array([strain, np.interp(STRESSES, sigma_v, history["sigma_h_kPa"] / sigma_v)])


def main() -> None:
    """Makes the curve, calibrates against it, and says what was found."""
    root = Path(__file__).parents[2]
    scene = comminute.Scene.load(root / "experiments/calibration/coke_small.toml", SMALL)
    truth = {key: value for key, (_, _, value) in PARAMETERS.items()}
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        reference = scene.copy(truth).run(out / "truth")
        settings: dict[str, Any] = {
            "num_iter": 4,
            "callback": callback(scene, out, observe, reference.folder / "specimen.csv"),
            "system": {
                "system_type": DynamicSystem,
                "param_names": list(PARAMETERS),
                "param_min": [low for low, _, _ in PARAMETERS.values()],
                "param_max": [high for _, high, _ in PARAMETERS.values()],
                "num_samples": 24,
                "obs_data": observe(reference),
                "obs_names": ["axial strain (%)", "stress ratio (-)"],
                "ctrl_name": "vertical stress (kPa)",
                "ctrl_data": STRESSES,
                "sim_name": "coke",
                "sigma_tol": 0.005,
            },
            "inference": {
                "Bayes_filter": {"ess_target": 0.3},
                "sampling": {"max_num_components": 2, "random_state": 0},
                "initial_sampling": "halton",
            },
            "save_fig": -1,
        }
        calibration = BayesianCalibration.from_dict(settings)
        calibration.run()
        means, spreads = calibration.system.estimated_params[-1], calibration.system.estimated_params_cv[-1]
        for key, mean, spread in zip(PARAMETERS, means, spreads, strict=True):
            print(f"{key}: {mean:.4f} ± {mean * spread:.4f} (truth {truth[key]})")
        for key, mean, spread in zip(PARAMETERS, means, spreads, strict=True):
            assert abs(mean - truth[key]) < 3.0 * mean * spread, key
        assert spreads[0] < 0.1, "the modulus is left open"


if __name__ == "__main__":
    main()
