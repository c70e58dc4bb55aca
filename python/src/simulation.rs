//! Tests that Python makes step by step. Arrays are bytes that Python owns: each number is written once, where numpy reads it.

use crate::error::raised;
use crate::scene::Scene;
use crate::watch::watched;
use comminute::Rig;
use comminute::boundary::{Drive, WallShape};
use comminute::grains::Grains;
use comminute::mpm::Points;
use comminute::record::contacts::{Other, mean_stress};
use comminute::run;
use comminute::table::Value;
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::time::Duration;

/// Time between two looks at signals.
const LOOK: Duration = Duration::from_millis(50);

/// A test at the instant when the forces are known and nothing has moved yet.
#[pyclass(module = "comminute._comminute")]
pub struct Simulation {
    inner: run::Simulation,
    /// Indices of the grains and of the points in the order of their ids; made when first asked for after a step.
    orders: [Option<Vec<u32>>; 2],
}

#[pymethods]
impl Simulation {
    /// The simulation of a scene at its first instant.
    #[staticmethod]
    fn of(py: Python<'_>, scene: &Scene, threads: Option<usize>) -> PyResult<Simulation> {
        let inner = watched(py, None, |_| run::Simulation::of(&scene.0, threads))?;
        Ok(Simulation { inner, orders: [None, None] })
    }

    /// Makes this many steps. After Ctrl-C the steps that were made stay made.
    fn step(&mut self, py: Python<'_>, steps: u64) -> PyResult<()> {
        self.orders = [None, None];
        let mut left = steps;
        while left > 0 {
            let inner = &mut self.inner;
            left -= raised(py, py.detach(|| inner.step(left, LOOK)))?;
            py.check_signals()?;
        }
        Ok(())
    }

    #[getter]
    fn steps(&self) -> u64 {
        self.inner.steps()
    }

    #[getter]
    fn time(&self) -> f64 {
        self.inner.time()
    }

    #[getter]
    fn dt(&self) -> f64 {
        self.inner.dt()
    }

    #[getter]
    fn is_over(&self) -> bool {
        self.inner.is_over()
    }

    #[getter]
    fn stage(&self) -> &'static str {
        self.inner.stage()
    }

    #[getter]
    fn driven(&self) -> bool {
        self.inner.driven()
    }

    #[getter]
    fn volume(&self) -> Option<f64> {
        self.inner.volume()
    }

    #[getter]
    fn crush_events(&self) -> u64 {
        self.inner.crush_events()
    }

    /// Numbers of the grains, in the order of their ids: eight bytes each, so many to a grain as `name` says.
    fn array<'py>(&mut self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyBytes>> {
        let Simulation { inner, orders: [order, _] } = self;
        let none = Grains::default();
        let g = inner.grains().map_or(&none, |state| &state.grains);
        let order = order.get_or_insert_with(|| g.by_id());
        let three = |v: [f64; 4]| [v[0], v[1], v[2]];
        match name {
            "ids" => written(py, order, |i| [i64::from(g.id[i]).to_ne_bytes()]),
            "generations" => written(py, order, |i| [i64::from(g.generation[i]).to_ne_bytes()]),
            "materials" => written(py, order, |i| [i64::from(g.material[i]).to_ne_bytes()]),
            "positions" => numbers(py, order, |i| three(g.pos[i])),
            "velocities" => numbers(py, order, |i| three(g.vel[i])),
            "spins" => numbers(py, order, |i| three(g.spin[i])),
            "radii" => numbers(py, order, |i| [g.radius(i)]),
            "masses" => numbers(py, order, |i| [g.mass[i]]),
            "inertial_masses" => numbers(py, order, |i| [g.inertia(i)]),
            "strengths" => numbers(py, order, |i| [g.strength[i]]),
            "forces" => numbers(py, order, |i| inner.force(i)),
            _ => Err(PyValueError::new_err(format!("there is no array {name}"))),
        }
    }

    /// Numbers of the material points, as [`Self::array`] gives those of grains.
    fn point_array<'py>(&mut self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyBytes>> {
        let Simulation { inner, orders: [_, order] } = self;
        let none = Points::default();
        let p = inner.points().unwrap_or(&none);
        let order = order.get_or_insert_with(|| p.by_id());
        let three = |v: [f64; 4]| [v[0], v[1], v[2]];
        match name {
            "ids" => written(py, order, |i| [i64::from(p.id[i]).to_ne_bytes()]),
            "laws" => written(py, order, |i| [i64::from(p.law[i]).to_ne_bytes()]),
            "positions" => numbers(py, order, |i| three(p.position[i])),
            "velocities" => numbers(py, order, |i| three(p.velocity[i])),
            "masses" => numbers(py, order, |i| [p.velocity[i][3]]),
            "volumes" => numbers(py, order, |i| [p.position[i][3]]),
            "porosities" => numbers(py, order, |i| [p.porosity(i)]),
            "plastic_strains" => numbers(py, order, |i| [p.memory[i].plastic]),
            // tension is positive in the engine, compression here
            "stresses" => numbers(py, order, |i| {
                let [xx, yy, zz, xy, yz, zx] = p.stress[i].map(|s| -s);
                [xx, xy, zx, xy, yy, yz, zx, yz, zz]
            }),
            _ => Err(PyValueError::new_err(format!("there is no array {name}"))),
        }
    }

    /// Number of rigid bodies.
    #[getter]
    fn body_count(&self) -> usize {
        self.inner.bodies().map_or(0, |bodies| bodies.blocks.len())
    }

    /// What a rigid body is now.
    fn body<'py>(&self, py: Python<'py>, number: usize) -> PyResult<Bound<'py, PyDict>> {
        let about = PyDict::new(py);
        let Some(bodies) = self.inner.bodies() else { return Ok(about) };
        let body = &bodies.blocks[number];
        about.set_item("shape", body.shape.name())?;
        about.set_item("driven", body.driven)?;
        about.set_item("mass", body.mass)?;
        about.set_item("material", body.material)?;
        about.set_item("position", body.centre)?;
        about.set_item("orientation", body.turn)?;
        about.set_item("velocity", body.velocity)?;
        about.set_item("spin", body.spin())?;
        about.set_item("kinetic_energy", body.kinetic())?;
        Ok(about)
    }

    /// Forces on a rigid body, N, of points, grains, walls, other bodies and joints, and the torque of all of them, N m.
    fn body_forces(&self, number: usize) -> ([[f64; 3]; 5], [f64; 3]) {
        let Some(bodies) = self.inner.bodies() else { return ([[0.0; 3]; 5], [0.0; 3]) };
        let [points, grains, walls, others] = bodies.forces(number);
        ([points, grains, walls, others, bodies.joint_force(number)], bodies.torque(number))
    }

    /// The surface of a rigid body: corners in space, three numbers each, and triangles, three indices of eight bytes each.
    fn body_surface<'py>(&self, py: Python<'py>, number: usize) -> PyResult<[Bound<'py, PyBytes>; 2]> {
        let Some(bodies) = self.inner.bodies() else { return Ok([PyBytes::new(py, &[]), PyBytes::new(py, &[])]) };
        let body = &bodies.blocks[number];
        let (pose, mesh) = (body.pose(0.0), body.solid().surface());
        let every = |n: usize| (0..n as u32).collect::<Vec<u32>>();
        let corners = numbers(py, &every(mesh.corners.len()), |i| pose.place(mesh.corners[i]))?;
        let triangles = written(py, &every(mesh.triangles.len()), |i| mesh.triangles[i].map(|k| i64::from(k).to_ne_bytes()))?;
        Ok([corners, triangles])
    }

    /// Lets a driven rigid body move at a velocity, m/s, and a spin, rad/s.
    fn drive_body(&mut self, py: Python<'_>, body: usize, velocity: [f64; 3], spin: [f64; 3]) -> PyResult<()> {
        raised(py, self.inner.drive_body(body, velocity, spin))
    }

    /// The contacts of grains as packed records: id of the grain, id of the other grain or point or number of the wall (eight bytes each), whether it is a
    /// wall and whether it is a point (one byte each), then numbers: point, normal, force on the grain (three each), normal force, overlap.
    fn contacts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        const RECORD: usize = 8 + 8 + 2 + 11 * 8;
        let none = Grains::default();
        let g = self.inner.grains().map_or(&none, |state| &state.grains);
        let all = self.inner.contacts();
        PyBytes::new_with(py, RECORD * all.len(), |bytes| {
            for (place, c) in bytes.chunks_exact_mut(RECORD).zip(&all) {
                let (other, wall, of_point) = match c.other {
                    Other::Grain(j) => (i64::from(g.id[j]), false, false),
                    Other::Wall(k) => (k as i64, true, false),
                    Other::Point(id) => (i64::from(id), false, true),
                };
                place[..8].copy_from_slice(&i64::from(g.id[c.grain]).to_ne_bytes());
                place[8..16].copy_from_slice(&other.to_ne_bytes());
                (place[16], place[17]) = (u8::from(wall), u8::from(of_point));
                let vectors = [c.point, c.touch.normal, c.touch.force()].into_iter().flatten();
                let numbers = vectors.chain([c.touch.normal_force, c.touch.overlap]);
                for (slot, x) in place[18..].chunks_exact_mut(8).zip(numbers) {
                    slot.copy_from_slice(&x.to_ne_bytes());
                }
            }
            Ok(())
        })
    }

    /// Love and Weber's mean stress in a volume, m³; in that of the specimen if none is given.
    #[pyo3(signature = (volume))]
    fn mean_stress(&self, volume: Option<f64>) -> PyResult<[[f64; 3]; 3]> {
        // fines from crushing in an oedometer are points, and the grains' stress is known all the same
        let mixed =
            matches!(self.inner.model().rig, Rig::Continuum(_)) && (self.inner.points().is_some() || self.inner.bodies().is_some());
        let Some(state) = self.inner.grains().filter(|_| !mixed) else {
            let message =
                "stress is that of grains alone: points have `points.stresses`, and `row()` tells who bears how much in a mixture";
            return Err(PyValueError::new_err(message));
        };
        let volume = volume
            .or_else(|| self.inner.volume())
            .ok_or_else(|| PyValueError::new_err("volume: is missing: a free scene has no volume of its own"))?;
        if !(volume > 0.0 && volume.is_finite()) {
            return Err(PyValueError::new_err(format!("volume = {volume}: must be above 0")));
        }
        Ok(mean_stress(&state.grains, &self.inner.contacts(), volume))
    }

    /// Time scale of grain rearrangement at a pressure, s.
    fn inertial_time(&self, pressure: f64) -> f64 {
        self.inner.inertial_time(pressure)
    }

    /// Names of the walls.
    fn wall_names(&self) -> Vec<String> {
        self.inner.wall_names()
    }

    /// What a wall is now.
    fn wall<'py>(&self, py: Python<'py>, number: usize) -> PyResult<Bound<'py, PyDict>> {
        let wall = self.inner.wall(number);
        let about = PyDict::new(py);
        match wall.shape {
            WallShape::Plane { point, normal } => {
                about.set_item("position", point)?;
                about.set_item("normal", normal)?;
            }
            WallShape::Cylinder { centre, radius } => {
                about.set_item("position", centre)?;
                about.set_item("radius", radius)?;
            }
        }
        about.set_item("displacement", wall.displacement)?;
        about.set_item("velocity", wall.velocity)?;
        about.set_item("force", wall.force)?;
        about.set_item("shear_z", wall.shear_z)?;
        about.set_item("work", wall.work)?;
        about.set_item("area", wall.area)?;
        Ok(about)
    }

    /// Lets a wall move at a velocity, m/s, towards the grains.
    fn drive(&mut self, py: Python<'_>, wall: usize, velocity: f64) -> PyResult<()> {
        raised(py, self.inner.drive(wall, Drive::Velocity(velocity)))
    }

    /// Lets a wall hold a stress, Pa.
    #[pyo3(signature = (wall, stress, area, gain, fastest))]
    fn hold(
        &mut self,
        py: Python<'_>,
        wall: usize,
        stress: f64,
        area: Option<f64>,
        gain: Option<f64>,
        fastest: Option<f64>,
    ) -> PyResult<()> {
        let drive = Drive::Stress { stress, area: area.unwrap_or(0.0), gain: gain.unwrap_or(0.0), fastest };
        raised(py, self.inner.drive(wall, drive))
    }

    /// The row of `history.csv` for this instant.
    fn row<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let row = raised(py, self.inner.row())?;
        dict(py, row)
    }

    /// The rows of `breakage.csv` so far.
    fn breakages<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        self.inner.breakages().into_iter().map(|row| dict(py, row)).collect()
    }

    /// The rows of `block_breakage.csv` so far.
    fn body_breakages<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        self.inner.body_breakages().into_iter().map(|row| dict(py, row)).collect()
    }
}

/// A row as a dict; numbers that are not finite are NaN.
fn dict(py: Python<'_>, row: comminute::table::Row) -> PyResult<Bound<'_, PyDict>> {
    let dict = PyDict::new(py);
    for (name, value) in row {
        let value = match value {
            Value::Count(n) => n.into_py_any(py)?,
            Value::Number(x) if x.is_finite() => x.into_py_any(py)?,
            Value::Number(_) => f64::NAN.into_py_any(py)?,
            Value::Text(text) => text.into_py_any(py)?,
        };
        dict.set_item(name, value)?;
    }
    Ok(dict)
}

/// `K` numbers of each grain or point, in this order of their indices.
fn numbers<'py, const K: usize>(py: Python<'py>, order: &[u32], of: impl Fn(usize) -> [f64; K]) -> PyResult<Bound<'py, PyBytes>> {
    written(py, order, |i| of(i).map(f64::to_ne_bytes))
}

/// `K` numbers of eight bytes of each grain or point, in this order of their indices.
fn written<'py, const K: usize>(
    py: Python<'py>,
    order: &[u32],
    of: impl Fn(usize) -> [[u8; 8]; K],
) -> PyResult<Bound<'py, PyBytes>> {
    PyBytes::new_with(py, 8 * K * order.len(), |bytes| {
        for (place, i) in bytes.chunks_exact_mut(8 * K).zip(order) {
            place.copy_from_slice(of(*i as usize).as_flattened());
        }
        Ok(())
    })
}
