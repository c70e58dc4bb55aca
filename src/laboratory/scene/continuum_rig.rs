//! From the keys of a continuum to its [`Model`].

use super::bodies::{number, porosity, vector};
use super::continuum_estimate::wave_step;
use super::material::Named;
use super::view::View;
use crate::model::continuum::{Drainage, Gate, MpmSpecimen, MpmTest, Test};
use crate::model::{Model, Rig, Seeds};
use engine::breakage::lost_mass::Fines;
use engine::contact::{ContactLaw, ContactModel, TangentialUnloading};
use engine::dem::physics::Physics;
use engine::dem::physics::Stepping;
use engine::material::Material;
use engine::mpm::law::Law;
use engine::mpm::{Dimension, GridWall, Points, Settings, ShapeFunctions, Transfer};

/// E* of platens over the continuum's oedometric modulus, where no grain says it.
const STIFF: f64 = 50.0;
/// Room around the specimen of a triaxial test over its size, and in cells.
const ROOM: f64 = 0.25;
const CELLS: f64 = 2.0;

impl View<'_> {
    /// Everything, or `None` with the reasons noted.
    pub fn continuum_model(&self, named: &[Named]) -> Option<Model> {
        let rig = self.continuum_rig(named, f64::NAN, |_, _, _| Some(()))?;
        let (settings, dt) = (&rig.settings, self.number("stepping.dt_s"));
        let records = self.records()?;
        let materials = named.iter().map(|n| plain(self.text(&n.key("name")), self.si(&n.key("grain.density_kg_m3")))).collect();
        Some(Model {
            name: self.text("name").into(),
            seeds: Seeds { packing: 1, strength: 1 },
            physics: Physics {
                materials,
                contact: ContactModel {
                    law: ContactLaw::Hertz,
                    unloading: TangentialUnloading::Keep,
                    rolling: false,
                    turning: true,
                },
                crush: None,
                damping: settings.damping,
                gravity: settings.gravity,
                stepping: Stepping { safety: self.si("stepping.safety"), inertia_scaling: false, dt, slow: false, skin: 0.0 },
            },
            fines: Fines { alpha: 2.6, d_min: 1e-9 },
            scale: 1.0,
            rig: Rig::Continuum(Box::new(rig)),
            records,
            accuracy: self.level(),
        })
    }

    /// Points and what is done with them. `smallest`: size of the smallest grain or rigid body, m, in place of a cell where there are no points: lists of
    /// neighbours are kept for ways of some tenths of it. `shape` may change the points once they are known, with the test.
    pub fn continuum_rig(
        &self,
        named: &[Named],
        smallest: f64,
        shape: impl FnOnce(&mut Points, &Settings, &Test) -> Option<()>,
    ) -> Option<MpmTest> {
        let laws: Vec<Option<Law>> = named.iter().map(|n| self.continuum(n)).collect();
        let laws: Vec<Law> = laws.into_iter().collect::<Option<_>>()?;
        let rig = self.text("test.rig");
        let per = self.whole("grid.points_per_edge")? as u32;
        let dimension = if self.flag("grid.plane_strain") { Dimension::PlaneStrain } else { Dimension::Space };
        self.meaningless(rig, dimension);
        self.inertia_is_left_out(rig);
        let pressure = if rig == "triaxial" { self.number("test.cell_pressure_kPa").unwrap_or(0.0) } else { 0.0 };
        let (settings, (mut points, left_out, axis)) = if self.is_without_points() {
            (self.settings(dimension, smallest, self.no_grid()?)?, (Points::default(), 0, [0.0; 3]))
        } else {
            let grid = if rig == "free" { self.asked_grid(dimension) } else { self.own_grid(dimension, rig) };
            let settings = self.settings(dimension, self.cell()?, grid?)?;
            let made = self.bodies(named, &settings, per, pressure)?;
            (settings, made)
        };
        let test = self.test(rig, named, &laws, &settings, per, pressure)?;
        shape(&mut points, &settings, &test)?;
        let rig = MpmTest {
            settings,
            laws,
            points,
            left_out: [left_out, 0],
            per_edge: per,
            axis,
            test,
            coarse: None,
            growth: None,
            points_inertia: self.si("stepping.points_inertia"),
            above_bound: self.flag("stepping.above_bound"),
            rows: self.whole("records.rows")? as u32,
            frames: self.whole("records.frames")? as u32,
            gate: self.gate(rig)?,
        };
        let bound = wave_step(&rig);
        self.check(
            rig.above_bound || self.number("stepping.dt_s").is_none_or(|dt| dt <= bound),
            "stepping.dt_s",
            format!("must be at most {bound:.4e} s, the time a compression wave takes through a cell, or \"auto\""),
        );
        Some(rig)
    }

    /// The plane behind which mass is recorded, if the scene asks for one; `None`, with the reason noted, where it is refused.
    fn gate(&self, rig: &str) -> Option<Option<Gate>> {
        let keys = ["records.gate_mm", "records.gate_direction"];
        if !keys.iter().any(|key| self.has(key)) {
            return Some(None);
        }
        let [at, direction] = keys.map(|key| <[f64; 3]>::try_from(self.numbers(key)).ok());
        for (key, value) in keys.into_iter().zip([at, direction]) {
            self.check(value.is_some(), key, format!("is missing: {} go together", keys.join(" and ")));
            self.check(rig == "free", key, format!("has no meaning with test.rig = \"{rig}\""));
        }
        self.check(direction != Some([0.0; 3]), keys[1], "must not be zero");
        Some(Some(Gate { at: at?, direction: direction? }))
    }

    /// Keys that this test does not look at.
    fn meaningless(&self, rig: &str, dimension: Dimension) {
        let own: &[&str] = match rig {
            "free" => &["test.cell_pressure_kPa", "test.axial_strain"],
            "oedometer" => &["test.cell_pressure_kPa", "duration_s", "steps", "grid.min_mm", "grid.max_mm"],
            _ => &["duration_s", "steps", "grid.min_mm", "grid.max_mm"],
        };
        for key in own {
            self.check(!self.has(key), key, format!("has no meaning with test.rig = \"{rig}\""));
        }
        let drained = self.text("test.drainage") == "drained";
        self.check(drained || rig == "triaxial", "test.drainage", format!("has no meaning with test.rig = \"{rig}\""));
        for side in SIDES {
            let key = format!("grid.{side}");
            let open = self.text(&key) == "open";
            self.check(open || rig == "free", &key, format!("must be left out: test.rig = \"{rig}\" sets its own sides"));
            let there = !side.starts_with('z') || dimension == Dimension::Space;
            self.check(open || there, &key, "has no meaning in plane strain");
        }
        let blend = self.text("grid.transfer") == "flip_pic";
        self.check(blend || self.si("grid.pic") == 0.0, "grid.pic", "has no meaning with grid.transfer = \"apic\"");
        let affine_gimp = !blend && self.text("grid.shape_functions") == "gimp";
        self.check(!affine_gimp, "grid.transfer", "must be \"flip_pic\" with grid.shape_functions = \"gimp\"");
        let level = dimension == Dimension::Space || self.gravity()[2] == 0.0;
        self.check(level, "gravity_m_s2", "must lie in the plane, its third entry 0, in plane strain");
    }

    /// Refuses another inertia of the points than that of their mass where results would depend on it.
    fn inertia_is_left_out(&self, rig: &str) {
        let key = "stepping.points_inertia";
        if self.si(key) == 1.0 {
            return;
        }
        self.check(
            rig != "free",
            key,
            "must be 1, the real inertia, with test.rig = \"free\": only in a quasi-static test between platens (\"oedometer\", \"triaxial\") does the result not depend on it",
        );
        self.check(
            self.text("crushing.lost_mass") != "points",
            key,
            "must be 1 with crushing.lost_mass = \"points\": such points take over mass and motion of grains",
        );
        self.check(self.text("growth.fines") != "grains", key, "must be 1 with growth.fines = \"grains\": there are no points");
    }

    /// Whether the scene is one of rigid bodies and grains alone: a mixture without a [[body]].
    pub fn is_without_points(&self) -> bool {
        self.list("body").is_empty() && self.has_blocks()
    }

    /// Whether the scene has rigid bodies that are no spheres.
    pub fn has_blocks(&self) -> bool {
        !(self.list("block").is_empty() && self.list("block_set").is_empty())
    }

    /// The grid where there are no points: one cell that nothing is in.
    fn no_grid(&self) -> Option<Grid> {
        let sizes = ["cell_mm", "min_mm", "max_mm", "fines_diameter_mm", "grains_per_point"].map(|key| format!("grid.{key}"));
        let sides = SIDES.map(|side| format!("grid.{side}"));
        let given = sizes.iter().filter(|key| self.has(key)).chain(sides.iter().filter(|key| self.text(key) != "open"));
        given.for_each(|key| self.refuse(key, "has no meaning without a [[body]] of points"));
        let grid = ([0.0; 3], [1; 3], [GridWall::Open; 6]);
        if self.text("test.rig") != "free" {
            return Some(grid);
        }
        let (steps, duration) = (self.whole("steps"), self.number("duration_s"));
        self.check(steps.is_some() != duration.is_some(), "duration_s", "must be given, or `steps`, one of them");
        (steps.is_some() != duration.is_some()).then_some(grid)
    }

    fn settings(&self, dimension: Dimension, cell: f64, (lower, cells, walls): Grid) -> Option<Settings> {
        let gimp = self.text("grid.shape_functions") == "gimp";
        let per = self.whole("grid.points_per_edge")? as f64;
        Some(Settings {
            dimension,
            cell,
            lower,
            cells,
            walls,
            gravity: self.gravity(),
            shape: if gimp { ShapeFunctions::Gimp { half_width: 0.5 / per } } else { ShapeFunctions::BSpline },
            transfer: match self.text("grid.transfer") {
                "apic" => Transfer::Affine,
                _ => Transfer::Blend { pic: self.si("grid.pic") },
            },
            damping: self.si("damping.local"),
        })
    }

    /// Edge of a cell, m: as written; or that with which a point stands for so many grains of the fines, (1 − n) s³ = N π d³/6 with the distance s of
    /// two points, and a whole number of which fill the first edge of a box (Li et al. 2023, section 4.2: the particle reduction 1:N).
    fn cell(&self) -> Option<f64> {
        let keys = ["grid.fines_diameter_mm", "grid.grains_per_point"];
        let [diameter, number_of] = keys.map(|k| self.number(k));
        if let Some(cell) = self.number("grid.cell_mm") {
            for key in keys.into_iter().filter(|k| self.has(k)) {
                self.refuse(key, "has no meaning beside grid.cell_mm: one of both says how large a point is");
            }
            return Some(cell);
        }
        let (Some(d), Some(n)) = (diameter, number_of) else {
            self.refuse("grid.cell_mm", format!("is missing: or give {} and {}", keys[0], keys[1]));
            return None;
        };
        let body = *self.list("body").first()?;
        let round = body.get("shape").and_then(toml::Value::as_str) == Some("cylinder");
        let solid = n * std::f64::consts::PI / 6.0 * d * d * d;
        let spacing = (solid / (1.0 - porosity(body))).cbrt();
        let per = self.whole("grid.points_per_edge")? as f64;
        let edge = match (vector(body, "min_mm"), vector(body, "max_mm")) {
            (Some(min), Some(max)) => max[0] - min[0],
            _ if round => number(body, "radius_mm")?,
            _ => return Some(per * spacing),
        };
        // sides of an oedometer stand on nodes
        let unit = if self.text("test.rig") == "oedometer" && !round { per * spacing } else { spacing };
        Some(per * spacing / unit * edge / (edge / unit).round().max(1.0))
    }

    /// The grid that a free scene asks for.
    fn asked_grid(&self, dimension: Dimension) -> Option<Grid> {
        let corner = |key: &str| <[f64; 3]>::try_from(self.numbers(key)).ok();
        let (Some(min), Some(max)) = (corner("grid.min_mm"), corner("grid.max_mm")) else {
            let key = if self.has("grid.min_mm") { "grid.max_mm" } else { "grid.min_mm" };
            self.refuse(key, "is missing: a free scene needs the corners of its grid, grid.min_mm and grid.max_mm");
            return None;
        };
        let cell = self.cell()?;
        let mut cells = [1; 3];
        for a in 0..if dimension == Dimension::Space { 3 } else { 2 } {
            let wanted = (max[a] - min[a]) / cell;
            let whole = wanted.round();
            if !(whole >= 1.0 && whole <= f64::from(1 << 19) && (wanted - whole).abs() < 1e-6 * whole) {
                let axis = ["x", "y", "z"][a];
                let message =
                    format!("must be a whole number of cells (1 to 524288) above grid.min_mm; along {axis} it is {wanted:.6}");
                self.refuse("grid.max_mm", message);
                return None;
            }
            cells[a] = whole as u32;
        }
        let (steps, duration) = (self.whole("steps"), self.number("duration_s"));
        self.check(steps.is_some() != duration.is_some(), "duration_s", "must be given, or `steps`, one of them");
        let friction = self.si("grid.friction");
        let walls = SIDES.map(|side| match self.text(&format!("grid.{side}")) {
            "symmetry" => GridWall::Symmetry,
            "stick" => GridWall::Stick,
            "slip" => GridWall::Friction { friction: 0.0 },
            "coulomb" => GridWall::Friction { friction },
            _ => GridWall::Open,
        });
        (steps.is_some() != duration.is_some()).then_some((min, cells, walls))
    }

    /// The box that a test needs, or that around its upright cylinder: lower corner and size, m.
    fn only_box(&self, dimension: Dimension, rig: &str) -> Option<([[f64; 3]; 2], bool)> {
        let bodies = self.list("body");
        let shape = bodies.first().and_then(|b| b.get("shape")).and_then(toml::Value::as_str);
        let round = shape == Some("cylinder");
        if bodies.len() != 1 || !(round || shape == Some("box")) {
            self.refuse("body", format!("must be one [[body]] with shape = \"box\" or \"cylinder\" for test.rig = \"{rig}\""));
            return None;
        }
        let corners = if round {
            let (base, radius) = (vector(bodies[0], "centre_mm"), number(bodies[0], "radius_mm"));
            base.zip(radius)
                .zip(number(bodies[0], "height_mm"))
                .map(|(([x, y, z], r), h)| [[x - r, y - r, z], [x + r, y + r, z + h]])
        } else {
            vector(bodies[0], "min_mm").zip(vector(bodies[0], "max_mm")).map(|(min, max)| [min, max])
        };
        let Some([min, max]) = corners else {
            self.refuse(
                "body[0]",
                if round {
                    "is missing centre_mm, radius_mm or height_mm"
                } else {
                    "is missing min_mm and max_mm, the corners of the box"
                },
            );
            return None;
        };
        if round && dimension == Dimension::PlaneStrain {
            self.refuse("body[0].shape", "must be \"box\" in plane strain");
            return None;
        }
        let cell = self.cell()?;
        let per = self.whole("grid.points_per_edge")? as f64;
        for a in 0..if dimension == Dimension::Space { 3 } else { 2 } {
            let points = (max[a] - min[a]) / cell * per;
            // sides of an oedometer stand on nodes, rings of points around the middle of a cylinder
            let (unit, what) = if round && a < 2 {
                (2.0, "times twice the distance of two points, grid.cell_mm over grid.points_per_edge, for the rings of a cylinder")
            } else if rig == "oedometer" {
                (per, "cells, grid.cell_mm")
            } else {
                (1.0, "distances of two points (2 at least), grid.cell_mm over grid.points_per_edge")
            };
            let whole = (points / unit).round();
            let least = if rig == "oedometer" { 1.0 } else { 2.0 };
            if !(whole >= least && (points / unit - whole).abs() < 1e-6 * whole) {
                let axis = ["x", "y", "z"][a];
                let (key, from) = match (round, a) {
                    (true, 2) => ("body[0].height_mm", ""),
                    (true, _) => ("body[0].radius_mm", ""),
                    _ => ("body[0].max_mm", ", above min_mm"),
                };
                self.refuse(key, format!("must be a whole number of {what}{from}; along {axis} it is {:.6}", points / unit));
                return None;
            }
        }
        let mut size = std::array::from_fn(|a| max[a] - min[a]);
        if dimension == Dimension::PlaneStrain {
            size[2] = 1.0;
        }
        Some(([min, size], round))
    }

    fn own_grid(&self, dimension: Dimension, rig: &str) -> Option<Grid> {
        let ([min, size], round) = self.only_box(dimension, rig)?;
        let cell = self.cell()?;
        let d = if dimension == Dimension::Space { 3 } else { 2 };
        let whole = |x: f64| (x / cell - 1e-6).ceil();
        let room = |a: usize| whole(ROOM * size[a]) + CELLS;
        if rig == "oedometer" && round {
            // the bottom alone is a side of the grid
            let lower = [min[0] - room(0) * cell, min[1] - room(1) * cell, min[2]];
            let cells = [0, 1, 2].map(|a| (whole(size[a]) + if a < 2 { 2.0 * room(a) } else { CELLS }) as u32);
            let mut walls = [GridWall::Open; 6];
            walls[4] = GridWall::Symmetry;
            return Some((lower, cells, walls));
        }
        if rig == "oedometer" {
            let cells = std::array::from_fn(|a| if a < d { whole(size[a]) as u32 + if a == d - 1 { 2 } else { 0 } } else { 1 });
            let mut walls = [GridWall::Open; 6];
            walls[..2 * d - 1].fill(GridWall::Symmetry);
            return Some((min, cells, walls));
        }
        let lower = std::array::from_fn(|a| if a < d { min[a] - room(a) * cell } else { min[a] });
        let cells = std::array::from_fn(|a| if a < d { (whole(size[a]) + 2.0 * room(a)) as u32 } else { 1 });
        Some((lower, cells, [GridWall::Open; 6]))
    }

    fn test(&self, rig: &str, named: &[Named], laws: &[Law], settings: &Settings, per: u32, pressure: f64) -> Option<Test> {
        if rig == "free" {
            return Some(Test::Free { duration: self.number("duration_s"), steps: self.whole("steps") });
        }
        let Some(axial_strain) = self.number("test.axial_strain") else {
            self.refuse("test.axial_strain", format!("is missing: test.rig = \"{rig}\" needs it"));
            return None;
        };
        let weightless = settings.gravity == [0.0; 3];
        self.check(weightless, "gravity_m_s2", format!("must be [0, 0, 0] with test.rig = \"{rig}\""));
        if rig == "triaxial" && pressure == 0.0 {
            self.refuse("test.cell_pressure_kPa", "is missing: test.rig = \"triaxial\" needs it");
            return None;
        }
        let of = |specimen: MpmSpecimen| {
            if rig == "oedometer" {
                return Test::Oedometer(specimen);
            }
            let drained = self.text("test.drainage") != "constant_volume";
            let drainage = if drained { Drainage::Drained } else { Drainage::ConstantVolume };
            Test::Triaxial { specimen, cell_pressure: pressure, drainage }
        };
        if self.is_without_points() {
            return Some(of(self.bed(settings.dimension, axial_strain)?));
        }
        let ([lower, size], round) = self.only_box(settings.dimension, rig)?;
        let body = self.list("body")[0];
        let still = vector(body, "velocity_m_s")? == [0.0; 3];
        self.check(still, "body[0].velocity_m_s", format!("must be [0, 0, 0] with test.rig = \"{rig}\""));
        let law =
            body.get("material").and_then(toml::Value::as_str).and_then(|m| named.iter().position(|n| n.name == m)).unwrap_or(0);
        let specimen = MpmSpecimen {
            lower,
            size,
            round,
            stress: number(body, "stress_kPa").unwrap_or(pressure),
            spacing: settings.cell / f64::from(per),
            porosity: porosity(body),
            law: law as u8,
            density: (1.0 - porosity(body)) * self.si(&named[law].key("grain.density_kg_m3")),
            lattice: true,
            modulus: self.contact_modulus(&named[law], &laws[law]),
            axial_strain,
            strain_per_wave: self.si("test.strain_per_wave"),
            gain: self.si("test.servo_gain"),
            bed: None,
        };
        Some(of(specimen))
    }

    /// E* of a grain on a rigid platen, Pa.
    fn contact_modulus(&self, of: &Named, law: &Law) -> f64 {
        if let Some(modulus) = self.number("test.contact_modulus_MPa") {
            return modulus;
        }
        let nu = self.si(&of.key("elastic.nu"));
        let young = match (self.number(&of.key("elastic.G_GPa")), self.number(&of.key("elastic.E_GPa"))) {
            (Some(g), None) => 2.0 * g * (1.0 + nu),
            (None, Some(e)) => e,
            _ => return STIFF * law.elastic().oedometric(),
        };
        young / (1.0 - nu * nu)
    }
}

type Grid = ([f64; 3], [u32; 3], [GridWall; 6]);
const SIDES: [&str; 6] = ["x_low", "x_high", "y_low", "y_high", "z_low", "z_high"];

/// A material of which only name and density are asked.
fn plain(name: &str, density: f64) -> Material {
    Material {
        name: name.into(),
        density,
        internal_porosity: 0.0,
        young: 0.0,
        poisson: 0.0,
        friction: 0.0,
        rolling_friction: 0.0,
        interface_friction: None,
        contact: Default::default(),
    }
}
