"""What Yade runs: reads task.json, steps the case, writes told.json.

Yade gives a script its names (O, FrictMat, sphere, ...) as globals.
"""

import json
import math
import os
import sys
import time

sys.path.insert(0, os.environ["PYTHONPATH"].split(os.pathsep)[0])
from common import DENSITY, FRICTION, PLATEN_SPEED, POISSON, RESTITUTION, SKIN, TIME_STEP, WARM_UP, YOUNG


def material(radius_share, friction):
    """On a wall Yade takes a share (1/2 on a plane, 2/3 on a facet) of the radius for the effective one; Young's modulus makes up for
    it, so that the force is that of Hertz on a wall of the grains' own material."""
    young = YOUNG / (2.0 * math.sqrt(radius_share) - 1.0)
    return O.materials.append(FrictMat(young=young, poisson=POISSON, density=DENSITY, frictionAngle=math.atan(friction)))


def stress_sum():
    """Force times length, vertical, over the contacts of grains."""
    total = 0.0
    for contact in O.interactions:
        a, b = O.bodies[contact.id1], O.bodies[contact.id2]
        if contact.isReal and isinstance(a.shape, Sphere) and isinstance(b.shape, Sphere):
            force = contact.phys.normalForce + contact.phys.shearForce
            total += force[2] * (b.state.pos[2] - a.state.pos[2])
    return total


with open("task.json") as file:
    task = json.load(file)
stuff, plane, side = material(1.0, FRICTION), material(0.5, 0.0), material(2.0 / 3.0, 0.0)
for x, y, z, r in task["grains"]:
    O.bodies.append(sphere((x, y, z), r, material=stuff))
for corners in task["sides"]:
    O.bodies.append(facet(corners, material=side))
O.bodies.append(wall(task["bottom"], 2, sense=1, material=plane))
top = O.bodies.append(wall(task["top"], 2, sense=-1, material=plane))
O.bodies[top].state.vel = (0.0, 0.0, -PLATEN_SPEED)
# damping as a share of the critical one, of the normal and of the tangential spring
log = math.log(1.0 / RESTITUTION)
share = math.sqrt(5.0 / 6.0) * log / math.hypot(math.pi, log)
O.engines = [
    ForceResetter(),
    # boxes grow by half of the skin on either side
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Facet_Aabb(), Bo1_Wall_Aabb()], verletDist=0.5 * SKIN),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom(), Ig2_Facet_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()],
        [Ip2_FrictMat_FrictMat_MindlinPhys(betan=share, betas=share)],
        [Law2_ScGeom_MindlinPhys_Mindlin()],
    ),
    NewtonIntegrator(damping=0.0),
]
O.dt = TIME_STEP
O.run(WARM_UP, True)
since = time.perf_counter()
O.run(task["steps"], True)
seconds = time.perf_counter() - since
told = {"seconds": seconds, "step": O.iter, "force_times_length": stress_sum()}
with open("told.json", "w") as file:
    json.dump(told, file)
sys.stdout.flush()
# an ordinary exit waits for Yade's own threads
os._exit(0)
