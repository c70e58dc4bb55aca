//! Friction along coarse grains in fine ones, from tables of the contacts in tests of mixtures between platens (`records.contacts`): the friction that fine grains, which
//! roll, pass on to a coarse grain along its meridians, for `continuum.interface_friction` of the points that replace them.
//!
//! Soil that is shortened along z and widens across it flows along a coarse grain from its poles to its equator. At an angle θ from the axis of compression full
//! slip would give the friction T = μ N along the meridian. The slip vanishes at poles and equator, so that T = μ N sin 2θ is fitted by least squares, weighted with N, over
//! the contacts of coarse grains with fine ones, or with points: μ = Σ T sin 2θ / Σ N sin² 2θ. In a mixture with points whose friction is 0.1 the same measure gives
//! 0.1 to 0.08 with 20 % of coarse grains and 0.08 to 0.07 with 40 %, as not all of their contacts slip (experiments/mixture/twin_points.toml).
//!
//! The friction falls as the fines are sheared, so μ(e) = μ_r + (μ_0 − μ_r) exp(−H e) is fitted as well ([`engine::material::InterfaceFriction`]). e is the mean plastic
//! strain of the fines: that of the specimen, less its elastic strain with the moduli of the fines, over the share of its volume that is not coarse grains, which deform
//! little. Points that touch coarse grains have 1.1 to 1.3 times that mean in the same tests.

use super::columns::Columns;
use super::fines::Test;
use engine::grains::sphere_volume;
use engine::material::InterfaceFriction;
use engine::math::vector::dot;
use laboratory::error::{Error, Result};
use serde::Serialize;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Number of rates H that are tried.
const PLACES: u32 = 400;
/// Largest of them times the largest plastic strain.
const MOST_DECAY: f64 = 40.0;
/// Friction falls where that leaves less than this share of the misfit of a constant one.
const FALLS: f64 = 0.8;

/// Friction along coarse grains at one instant of a test.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Instant {
    /// Axial strain, compression positive.
    pub axial_strain: f64,
    /// Mean plastic strain of the fines, -.
    pub plastic_strain: f64,
    /// Friction μ along meridians, -.
    pub friction: f64,
    /// Number of contacts of coarse grains with fine ones or with points.
    pub contacts: usize,
    /// The sums Σ T sin 2θ and Σ N sin² 2θ, N.
    #[serde(skip)]
    sums: [f64; 2],
    /// Whether the contacts are with points.
    #[serde(skip)]
    of_points: bool,
}

/// Friction along coarse grains, of one or more tests.
#[derive(Clone, Debug, Serialize)]
pub struct Interface {
    /// Folders of the tests, and what each of their tables gives.
    pub tests: Vec<(PathBuf, Vec<Instant>)>,
    /// Friction over all tables, -.
    pub friction: f64,
    /// Friction that falls with plastic strain; `None`: the tables do not show it.
    pub falling: Option<InterfaceFriction>,
    /// Root mean square difference between the tables and `friction`, weighted with the normal forces, -.
    pub misfit: f64,
    /// The same with `falling`.
    pub falling_misfit: Option<f64>,
    /// Standard deviation between tests of the friction over the tables of a test; `None`: one test.
    pub spread: Option<f64>,
}

/// Friction of the sums over some instants.
fn over<'a>(instants: impl Iterator<Item = &'a Instant>) -> f64 {
    let [t, n] = instants.fold([0.0; 2], |[t, n], i| [t + i.sums[0], n + i.sums[1]]);
    t / n
}

/// Square root of the mean square difference between the frictions of instants and those at their plastic strains, weighted as the fits are.
fn misfit(all: &[Instant], friction: &InterfaceFriction) -> f64 {
    let [square, weight] = all.iter().fold([0.0; 2], |[square, weight], i| {
        [square + i.sums[1] * (i.friction - friction.at(i.plastic_strain)).powi(2), weight + i.sums[1]]
    });
    (square / weight).sqrt()
}

/// The friction that falls with plastic strain and is nearest to these instants: of those tried, the rate H with which the least squares, for μ_0 and μ_r, are smallest.
/// `None` where the best one does not fall, or leaves more than [`FALLS`] of the `constant` misfit.
fn falling(all: &[Instant], constant: f64) -> Option<InterfaceFriction> {
    let furthest = all.iter().map(|i| i.plastic_strain).fold(0.0, f64::max);
    let fit = |decay: f64| {
        // μ = a + b x with x = exp(−H e)
        let weighted =
            |f: &dyn Fn(f64, &Instant) -> f64| all.iter().map(|i| i.sums[1] * f((-decay * i.plastic_strain).exp(), i)).sum::<f64>();
        let [w, x, y] = [weighted(&|_, _| 1.0), weighted(&|x, _| x), weighted(&|_, i| i.friction)];
        let [xx, xy] = [weighted(&|x, _| x * x), weighted(&|x, i| x * i.friction)];
        let b = (w * xy - x * y) / (w * xx - x * x);
        let residual = (y - b * x) / w;
        InterfaceFriction { initial: residual + b, residual, decay }
    };
    let tried = (1..=PLACES).map(|k| fit(f64::from(k) * MOST_DECAY / (f64::from(PLACES) * furthest)));
    let usable = tried.filter(|f| f.residual >= 0.0 && f.initial > f.residual);
    let best = usable.map(|f| (misfit(all, &f), f)).min_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 < FALLS * constant).then_some(best.1)
}

/// Reads the contact tables in the folders of these runs, those after the start of loading, and finds the friction along coarse grains. `elastic`: Young's modulus,
/// Pa, and Poisson's ratio of the fines.
///
/// # Errors
/// A folder without such tables, or without contacts between grains of two materials and without points, or without the history of a triaxial test.
pub fn interface(folders: &[PathBuf], elastic: [f64; 2]) -> Result<Interface> {
    let tests: Vec<(PathBuf, Vec<Instant>)> =
        folders.iter().map(|folder| Ok((folder.clone(), test(folder, elastic)?))).collect::<Result<_>>()?;
    let all: Vec<Instant> = tests.iter().flat_map(|(_, instants)| instants).copied().collect();
    let friction = over(all.iter());
    let constant = misfit(&all, &InterfaceFriction::constant(friction));
    let falling = falling(&all, constant);
    let falling_misfit = falling.map(|falling| misfit(&all, &falling));
    let each: Vec<f64> = tests.iter().map(|(_, instants)| over(instants.iter())).collect();
    let count = each.len() as f64;
    let mean = each.iter().sum::<f64>() / count;
    let spread = (each.len() > 1).then(|| (each.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0)).sqrt());
    Ok(Interface { tests, friction, falling, misfit: constant, falling_misfit, spread })
}

fn test(folder: &Path, elastic: [f64; 2]) -> Result<Vec<Instant>> {
    let missing = |what: &str| Error::input(folder.display(), "", None, what);
    let snapshots = folder.join("snapshots");
    let entries =
        std::fs::read_dir(&snapshots).map_err(|_| missing("has no tables of contacts: run it with --set records.contacts=true"))?;
    let is_table = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with("contacts_") && name.ends_with(".csv")
    };
    let mut paths: Vec<PathBuf> = entries.filter_map(|e| e.ok().map(|e| e.path())).filter(is_table).collect();
    paths.sort();
    let grains = grains(folder)?;
    let tables = paths.iter().map(|path| instant(path, &grains.sizes)).collect::<Result<Vec<_>>>()?;
    let mut instants: Vec<Instant> = tables.into_iter().flatten().collect();
    if instants.is_empty() {
        return Err(missing(
            "has no contacts of coarse grains with fine ones or points under load: it must be a triaxial test of a mixture, run with --set records.contacts=true",
        ));
    }
    let history = Test::read(folder)?;
    let rows = history.plastic(elastic);
    let fines = fines_share(folder, &grains, instants.iter().any(|i| i.of_points))?;
    for i in &mut instants {
        i.plastic_strain = history.plastic_strain_at(&rows, i.axial_strain) / fines;
    }
    Ok(instants)
}

/// Share of the specimen's volume that is not coarse grains, at the start: from the grains and the void ratio, or where the fines are points
/// (`of_points`), from these.
fn fines_share(folder: &Path, Grains { radii, sizes }: &Grains, of_points: bool) -> Result<f64> {
    let all: f64 = radii.iter().copied().map(sphere_volume).sum();
    if of_points {
        let points = Columns::read(&folder.join("points_start.csv"))?.complete("volume_m3", "a mixture")?;
        let fines: f64 = points.iter().sum();
        return Ok(fines / (all + fines));
    }
    let history = Columns::read(&folder.join("history.csv"))?;
    let void_ratio = history.complete("void_ratio", "a triaxial test of grains")?[0];
    let most = sizes.iter().max();
    let coarse: f64 = radii.iter().zip(sizes).filter(|(_, size)| Some(*size) == most).map(|(r, _)| sphere_volume(*r)).sum();
    Ok(1.0 - coarse / (all * (1.0 + void_ratio)))
}

/// The grains at the start of a test: their radii, m, and the material of each as a number, with the larger grains' material above the smaller ones'.
struct Grains {
    radii: Vec<f64>,
    sizes: Vec<usize>,
}

fn grains(folder: &Path) -> Result<Grains> {
    let table = Columns::read(&folder.join("grains_start.csv"))?;
    let whose = "a mixture";
    let radii = table.complete("r_m", whose)?;
    table.require("material", whose)?;
    let names = table.texts("material");
    let mut largest: HashMap<&str, f64> = HashMap::new();
    for (name, r) in names.iter().zip(&radii) {
        let most = largest.entry(name).or_default();
        *most = most.max(*r);
    }
    let mut order: Vec<(&str, f64)> = largest.into_iter().collect();
    order.sort_by(|a, b| a.1.total_cmp(&b.1));
    let sizes = names.iter().map(|name| order.iter().position(|o| o.0 == *name).unwrap_or(0)).collect();
    Ok(Grains { radii, sizes })
}

/// Sums over one table; `None` before loading, or without such contacts.
fn instant(path: &Path, sizes: &[usize]) -> Result<Option<Instant>> {
    let table = Columns::read(path)?;
    let Some(axial_strain) = table.note("axial_strain").filter(|strain| *strain > 0.0) else { return Ok(None) };
    let whose = "a table of contacts";
    let vectors = |names: [&str; 3]| -> Result<Vec<[f64; 3]>> {
        let [x, y, z] = [table.complete(names[0], whose)?, table.complete(names[1], whose)?, table.complete(names[2], whose)?];
        Ok((0..x.len()).map(|i| [x[i], y[i], z[i]]).collect())
    };
    let normal = vectors(["normal_x_N", "normal_y_N", "normal_z_N"])?;
    let tangential = vectors(["tangential_x_N", "tangential_y_N", "tangential_z_N"])?;
    for name in ["a", "kind_b", "b"] {
        table.require(name, whose)?;
    }
    let (a, kinds, b) = (table.texts("a"), table.texts("kind_b"), table.texts("b"));
    let size = |id: &str| id.parse().ok().and_then(|id: usize| sizes.get(id)).copied();
    let (mut sums, mut contacts, of_points) = ([0.0; 2], 0, kinds.contains(&"point"));
    for i in 0..a.len() {
        // forces are those on `a`: on the coarse grain with this sign
        let sign = match kinds[i] {
            "point" => 1.0,
            "grain" => match (size(a[i]), size(b[i])) {
                (Some(a), Some(b)) if a > b => 1.0,
                (Some(a), Some(b)) if a < b => -1.0,
                _ => continue,
            },
            _ => continue,
        };
        let force = dot(normal[i], normal[i]).sqrt();
        if force == 0.0 {
            continue;
        }
        contacts += 1;
        // place of the contact on the unit sphere, and the unit vector along its meridian times sin θ
        let [x, y, z] = normal[i].map(|f| -sign * f / force);
        let square = x * x + y * y;
        let meridian = [x * z, y * z, -square];
        sums[0] += 2.0 * z * sign * dot(tangential[i], meridian);
        sums[1] += force * 4.0 * square * z * z;
    }
    Ok((sums[1] > 0.0).then(|| Instant {
        axial_strain,
        plastic_strain: 0.0,
        friction: sums[0] / sums[1],
        contacts,
        sums,
        of_points,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Moduli of fines that bear hardly any elastic strain.
    const STIFF: [f64; 2] = [1e15, 0.2];

    /// A coarse grain of radius 1 and two of radius 0.1 in a test at constant volume, where the plastic strain of the specimen is its axial strain.
    struct Folder(tempfile::TempDir);

    impl Folder {
        fn new() -> Folder {
            let folder = Folder(tempfile::tempdir().expect("folder"));
            std::fs::create_dir(folder.0.path().join("snapshots")).expect("folder");
            folder.write(
                "grains_start.csv",
                "# hash = 1\nx_m,y_m,z_m,r_m,generation,material\n0,0,0,1,0,coarse\n0,0,0,0.1,0,fine\n0,0,0,0.1,0,fine\n",
            );
            let row = |k: u32| format!("load,{},0,100,50,0.6\n", 0.003 * f64::from(k));
            let rows: String = (0..=40).map(row).collect();
            folder
                .write("history.csv", &format!("stage,axial_strain,volumetric_strain,sigma_1_kPa,sigma_3_kPa,void_ratio\n{rows}"));
            folder
        }

        fn write(&self, name: &str, text: &str) {
            std::fs::write(self.0.path().join(name), text).expect("written");
        }

        /// Contacts that pass on `friction` N sin 2θ along meridians, and as much around the axis, whichever of the two grains stands first; contacts of equal grains and of
        /// walls.
        fn contacts(&self, number: u32, axial_strain: f64, friction: f64) -> String {
            let mut text = format!(
                "# axial_strain = {axial_strain}\na,kind_b,b,normal_x_N,normal_y_N,normal_z_N,tangential_x_N,tangential_y_N,tangential_z_N\n"
            );
            for k in 0..12 {
                let (theta, phi, force) = (0.2 + 0.23 * f64::from(k), f64::from(k), 1.0 + f64::from(k % 3));
                let (s, c) = theta.sin_cos();
                let place = [s * phi.cos(), s * phi.sin(), c];
                let meridian = [c * phi.cos(), c * phi.sin(), -s];
                let around = [-phi.sin(), phi.cos(), 0.0];
                let along = friction * force * (2.0 * theta).sin();
                let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
                let row: Vec<String> = place
                    .map(|x| -sign * force * x)
                    .into_iter()
                    .chain((0..3).map(|a| sign * along * (meridian[a] + around[a])))
                    .map(|x| x.to_string())
                    .collect();
                let ends = if k % 2 == 0 { "0,grain,1" } else { "1,grain,0" };
                text += &format!("{ends},{}\n", row.join(","));
            }
            text += "1,grain,2,1,0,1,5,5,5\n0,wall,top,0,0,-1,7,0,0\n";
            self.write(&format!("snapshots/contacts_{number}.csv"), &text);
            text
        }

        fn read(&self) -> Result<Interface> {
            interface(&[self.0.path().into(), self.0.path().into()], STIFF)
        }
    }

    #[test]
    fn friction_along_meridians_comes_back() {
        let folder = Folder::new();
        folder.contacts(0, 0.0, 0.2);
        let text = folder.contacts(1, 0.03, 0.2);
        let found = folder.read().expect("friction");
        assert!((found.friction - 0.2).abs() < 1e-12, "{found:?}");
        let [instant] = found.tests[0].1[..] else { panic!("one table under load") };
        assert_eq!((instant.contacts, found.spread, found.falling), (12, Some(0.0), None));
        // fines take 1 - 1/(1.002 × 1.6) of the volume
        assert!((instant.plastic_strain / (0.03 / (1.0 - 1.0 / 1.6032)) - 1.0).abs() < 1e-9, "{instant:?}");
        folder.write("snapshots/contacts_1.csv", &text.replace("normal_y_N", "normal"));
        let message = folder.read().expect_err("a column is missing").to_string();
        assert!(message.contains("normal_y_N"), "{message}");
        folder.write("snapshots/contacts_1.csv", &text.replace("0.03", "0"));
        let message = folder.read().expect_err("no table under load").to_string();
        assert!(message.contains("records.contacts=true"), "{message}");
    }

    /// Friction that falls comes back with its rate; noise around a constant one stays constant.
    #[test]
    fn friction_that_falls_comes_back() {
        let folder = Folder::new();
        let law = InterfaceFriction { initial: 0.2, residual: 0.08, decay: 20.0 };
        let fines = 1.0 - 1.0 / 1.6032;
        for k in 1..=12 {
            let axial = 0.009 * f64::from(k);
            folder.contacts(k, axial, law.at(axial / fines));
        }
        let found = folder.read().expect("friction");
        let falling = found.falling.expect("it falls");
        let near = |a: f64, b: f64, by: f64| assert!((a / b - 1.0).abs() < by, "{found:?}");
        near(falling.initial, law.initial, 5e-3);
        near(falling.residual, law.residual, 5e-3);
        near(falling.decay, law.decay, 0.02);
        assert!(found.falling_misfit.expect("a misfit") < 0.02 * found.misfit);
        for k in 1..=12u32 {
            folder.contacts(k, 0.009 * f64::from(k), 0.1 + 0.01 * f64::from((7 * k) % 5));
        }
        assert_eq!(folder.read().expect("friction").falling, None);
    }
}
