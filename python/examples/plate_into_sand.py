"""A plate is driven into sand by a programme of its own: down, a little up, down again. The force on it against its depth is printed, and drawn where matplotlib is installed.

    python plate_into_sand.py [figure.png]

The sand is a continuum of material points in plane strain (Mohr-Coulomb, 34 degrees), the plate a driven ``[[block]]``. Its velocity changes while the simulation runs, by what the plate has reached.
"""

import sys

import numpy as np

import comminute

SCENE = {
    "kind": "mixture",
    "duration_s": 1.0,
    "gravity_m_s2": [0.0, -9.81, 0.0],
    "damping.local": 0.5,
    "contact.law": "spring",
    "grid": {
        "plane_strain": True,
        "cell_mm": 5.0,
        "min_mm": [-80.0, -60.0, 0.0],
        "max_mm": [80.0, 40.0, 0.0],
        "x_low": "symmetry",
        "x_high": "symmetry",
        "y_low": "stick",
    },
    "body": [{"shape": "box", "min_mm": [-80.0, -60.0, 0.0], "max_mm": [80.0, 0.0, 0.0], "porosity": 0.4}],
    # corners are those inside of what is round: the plate is 40 mm wide and 10 mm high
    "block": [
        {
            "shape": "polygon",
            "points_mm": [-18.0, -3.0, 18.0, -3.0, 18.0, 3.0, -18.0, 3.0],
            "rounding_mm": 2.0,
            "position_mm": [0.0, 5.5, 0.0],
            "driven": True,
        }
    ],
    "material": {
        "name": "sand",
        "grain": {"density_kg_m3": 2650.0},
        "contact": {"friction": 0.4},
        "spring": {"k_n_N_m": 5e6, "k_t_N_m": 4e6},
        "continuum": {"law": "mohr_coulomb", "E_MPa": 5.0, "nu": 0.3, "friction_angle_deg": 34.0, "dilation_angle_deg": 4.0, "cohesion_kPa": 0.1},
    },
}


def press(simulation: comminute.Simulation, to: float, speed: float) -> list[list[float]]:
    """Moves the plate at a speed, m/s, until it has this depth, m. Gives depth and upward force, N per metre, every 20 steps."""
    plate = simulation.bodies[0]
    start = depth(simulation)
    plate.velocity = [0.0, -speed if to > start else speed, 0.0]
    found = []
    while (depth(simulation) < to) == (start < to):
        simulation.step(20)
        found.append([depth(simulation), plate.forces["points"][1]])
    return found


def depth(simulation: comminute.Simulation) -> float:
    """Depth of the lower side of the plate below the surface of the sand at the start, m."""
    corners, _ = simulation.bodies[0].surface
    return -float(corners[:, 1].min())


def main(args: list[str]) -> np.ndarray:
    """Depth, m, and force, N per metre, of the whole programme."""
    simulation = comminute.Simulation(comminute.Scene(SCENE))
    curve = press(simulation, 3e-3, 0.02) + press(simulation, 2.8e-3, 0.02) + press(simulation, 5e-3, 0.02)
    table = np.array(curve)
    for mm, newton in table[:: len(table) // 20] * [1e3, 1.0]:
        print(f"{mm:6.2f} mm  {newton:9.1f} N/m")
    if args:
        from matplotlib import pyplot

        pyplot.plot(1e3 * table[:, 0], table[:, 1])
        pyplot.xlabel("depth / mm")
        pyplot.ylabel("force on the plate / N/m")
        pyplot.savefig(args[0])
    return table


if __name__ == "__main__":
    main(sys.argv[1:])
