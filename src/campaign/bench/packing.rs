//! Packings of the bench: made once by this program (radius growth, scaled inertia, isotropic
//! servo), then kept as specimen files. A tenth of the mass in fines does not fill the pores
//! between the large grains; the fines are placed in the pores at random, without contacts, as most
//! fragments of a crushed specimen are.

use super::{Case, model, skeleton};
use engine::boundary::CylinderSpace;
use engine::contact::ContactLaw;
use engine::dem::{State, Workspace};
use engine::grains::Grains;
use engine::math::vector::dot;
use laboratory::error::{Error, Result};
use laboratory::model::{Model, Rig};
use laboratory::packing as sampling;
use laboratory::record::specimen;
use laboratory::rig::cylinder::{BOTTOM, TOP, space};
use laboratory::rig::preparation::{self, Preparation};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A packing at rest.
pub struct Packing {
    /// The case.
    pub case: Case,
    /// The grains at rest.
    pub grains: Grains,
    /// The cylinder around them.
    pub walls: CylinderSpace,
    /// File of the packing.
    pub path: PathBuf,
    /// Seconds that making the packing took; `None` if its file was there already.
    pub seconds: Option<f64>,
}

impl Packing {
    /// Porosity of the packing.
    pub fn porosity(&self) -> f64 {
        1.0 - self.grains.mass_and_volume().1 / self.walls.volume()
    }
}

/// Steps between two reports of progress.
const REPORT: u64 = 256;

/// Reads the packing of `grains` grains from the folder; a packing that is not there is made and
/// written first. `progress` is called with messages.
///
/// # Errors
/// A file that cannot be read or written or is not this packing, or a preparation that fails.
pub fn packing(case: Case, grains: usize, folder: &Path, mut progress: impl FnMut(&str)) -> Result<Packing> {
    let model = model(case, grains, ContactLaw::Hertz, 0.1);
    let path = folder.join(format!("{}-{grains}.csv", case.stem()));
    let seconds = if path.exists() { None } else { Some(make(case, &model, &path, &mut progress)?) };
    let (found, walls) = specimen::read(&path, &model.physics.materials)?;
    let (low, high) = case.radii();
    if found.len() != grains || found.pos.iter().any(|p| p[3] < 0.999 * low || p[3] > 1.001 * high) {
        let message = format!("is not the bench's packing of {grains} grains: delete it to have it made anew");
        return Err(Error::input(path.display(), "", None, message));
    }
    Ok(Packing { case, grains: found, walls, path, seconds })
}

/// Makes a packing and writes its file in one piece; returns the seconds that this took.
fn make(case: Case, model: &Model, path: &Path, progress: &mut impl FnMut(&str)) -> Result<f64> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(Error::write(folder))?;
    }
    let since = Instant::now();
    let state = match case {
        Case::Uniform => at_rest(model, progress)?,
        Case::Wide => {
            let Rig::Oedometer(rig) = &model.rig else { unreachable!("the bench is an oedometer") };
            let (large, fines): (Vec<f64>, Vec<f64>) =
                sampling::radii(&rig.specimen, model.seeds.packing).into_iter().partition(|&r| case.is_large(r));
            let mut state = at_rest(&skeleton(large.len()), progress)?;
            strew(&mut state, &fines, model);
            state
        }
    };
    let unfinished = path.with_extension("tmp");
    specimen::write(&unfinished, &state.grains, &model.physics.materials, Some(space(&state)))?;
    std::fs::rename(&unfinished, path).map_err(Error::write(path))?;
    Ok(since.elapsed().as_secs_f64())
}

/// The model's specimen, prepared with scaled inertia.
fn at_rest(model: &Model, progress: &mut impl FnMut(&str)) -> Result<State> {
    let scaled = scaled(model);
    let Rig::Oedometer(rig) = &scaled.rig else { unreachable!("the bench is an oedometer") };
    let since = Instant::now();
    let (mut preparation, mut state) = Preparation::start(&scaled, &rig.specimen);
    for wall in &mut state.walls {
        wall.material = Some(0);
    }
    let mut work = Workspace::new(&scaled.physics, &mut state);
    while !preparation.advance(&scaled, &rig.specimen, &mut state, &mut work)? {
        if preparation.steps().is_multiple_of(REPORT) {
            let area = space(&state).platen_area();
            progress(&format!(
                "packing of {} grains: {}, step {}, porosity {:.4}, stress {:.1} kPa, {:.0} s",
                state.grains.len(),
                preparation.stage(),
                preparation.steps(),
                preparation::porosity(&state),
                0.5e-3 * (state.walls[TOP].reaction + state.walls[BOTTOM].reaction) / area,
                since.elapsed().as_secs_f64(),
            ));
        }
    }
    Ok(state)
}

/// Adds small grains at random places where they touch no other grain.
fn strew(state: &mut State, radii: &[f64], model: &Model) {
    let walls = space(state);
    let large = state.grains.pos.clone();
    let cell = 2.0 * radii.iter().copied().fold(0.0, f64::max);
    let place = |p: [f64; 3]| p.map(|x| (x / cell).floor() as i64);
    let mut cells: HashMap<[i64; 3], Vec<[f64; 4]>> = HashMap::new();
    let apart = |p: [f64; 3], r: f64, q: &[f64; 4]| {
        let d: [f64; 3] = std::array::from_fn(|a| p[a] - q[a]);
        dot(d, d) > (r + q[3]) * (r + q[3])
    };
    let mut seed = model.seeds.packing;
    for &r in radii {
        loop {
            seed += 1;
            let [x, y, z] = sampling::random_points(walls.radius, walls.height, &[r], seed)[0];
            let p = [x, y, z + walls.bottom];
            let [i, j, k] = place(p);
            let near = (0..27).filter_map(|n| cells.get(&[i + n % 3 - 1, j + n / 3 % 3 - 1, k + n / 9 - 1]));
            if large.iter().chain(near.flatten()).all(|q| apart(p, r, q)) {
                cells.entry(place(p)).or_default().push([p[0], p[1], p[2], r]);
                state.grains.add(p, r, 0, &model.physics.materials);
                break;
            }
        }
    }
}

/// The model with scaled inertia, for making the packing.
fn scaled(model: &Model) -> Model {
    let mut scaled = model.clone();
    scaled.physics.stepping.inertia_scaling = true;
    scaled.physics.stepping.dt = None;
    scaled.physics.stepping.skin = 0.15;
    scaled
}
