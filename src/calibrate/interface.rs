//! Friction along coarse grains in fine ones, from tables of the contacts in tests of mixtures between platens (`records.contacts`): the friction that fine grains, which
//! roll, pass on to a coarse grain along its meridians, for `continuum.interface_friction` of the points that replace them.
//!
//! Soil that is shortened along z and widens across it flows along a coarse grain from its poles to its equator. At an angle θ from the axis of compression full
//! slip would give the friction T = μ N along the meridian. The slip vanishes at poles and equator, so that T = μ N sin 2θ is fitted by least squares, weighted with N, over
//! the contacts of coarse grains with fine ones, or with points: μ = Σ T sin 2θ / Σ N sin² 2θ. In a mixture with points whose friction is μ the same measure gives
//! 0.9 to 1.0 of it (experiments/mixture/twin_points.toml).

use super::columns::Columns;
use engine::math::vector::dot;
use laboratory::error::{Error, Result};
use serde::Serialize;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Friction along coarse grains at one instant of a test.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Instant {
    /// Axial strain, compression positive.
    pub axial_strain: f64,
    /// Friction μ along meridians, -.
    pub friction: f64,
    /// Number of contacts of coarse grains with fine ones or with points.
    pub contacts: usize,
    /// The sums Σ T sin 2θ and Σ N sin² 2θ, N.
    #[serde(skip)]
    sums: [f64; 2],
}

/// Friction along coarse grains, of one or more tests.
#[derive(Clone, Debug, Serialize)]
pub struct Interface {
    /// Folders of the tests, and what each of their tables gives.
    pub tests: Vec<(PathBuf, Vec<Instant>)>,
    /// Friction over all tables, -.
    pub friction: f64,
    /// Standard deviation between tests of the friction over the tables of a test; `None`: one test.
    pub spread: Option<f64>,
}

/// Friction of the sums over some instants.
fn over<'a>(instants: impl Iterator<Item = &'a Instant>) -> f64 {
    let [t, n] = instants.fold([0.0; 2], |[t, n], i| [t + i.sums[0], n + i.sums[1]]);
    t / n
}

/// Reads the contact tables in the folders of these runs, those after the start of loading, and finds the friction along coarse grains.
///
/// # Errors
/// A folder without such tables, or without contacts between grains of two materials and without points.
pub fn interface(folders: &[PathBuf]) -> Result<Interface> {
    let tests: Vec<(PathBuf, Vec<Instant>)> =
        folders.iter().map(|folder| Ok((folder.clone(), test(folder)?))).collect::<Result<_>>()?;
    let each: Vec<f64> = tests.iter().map(|(_, instants)| over(instants.iter())).collect();
    let count = each.len() as f64;
    let mean = each.iter().sum::<f64>() / count;
    let spread = (each.len() > 1).then(|| (each.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0)).sqrt());
    Ok(Interface { friction: over(tests.iter().flat_map(|(_, instants)| instants)), tests, spread })
}

fn test(folder: &Path) -> Result<Vec<Instant>> {
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
    let sizes = sizes(folder)?;
    let tables = paths.iter().map(|path| instant(path, &sizes)).collect::<Result<Vec<_>>>()?;
    let instants: Vec<Instant> = tables.into_iter().flatten().collect();
    if instants.is_empty() {
        return Err(missing(
            "has no contacts of coarse grains with fine ones or points under load: it must be a triaxial test or an oedometer of a mixture, run with --set records.contacts=true",
        ));
    }
    Ok(instants)
}

/// Material of each grain, as a number, with the larger grains' material above the smaller ones'.
fn sizes(folder: &Path) -> Result<Vec<usize>> {
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
    Ok(names.iter().map(|name| order.iter().position(|o| o.0 == *name).unwrap_or(0)).collect())
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
    let (mut sums, mut contacts) = ([0.0; 2], 0);
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
    Ok((sums[1] > 0.0).then(|| Instant { axial_strain, friction: sums[0] / sums[1], contacts, sums }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Contacts that pass on 0.2 N sin 2θ along meridians, and as much around the axis, give 0.2, whichever of the two grains stands first; contacts of equal grains and of walls
    /// count for nothing.
    #[test]
    fn friction_along_meridians_comes_back() {
        let folder = tempfile::tempdir().expect("folder");
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
        std::fs::create_dir(folder.path().join("snapshots")).expect("folder");
        write(
            "grains_start.csv",
            "# hash = 1\nx_m,y_m,z_m,r_m,generation,material\n0,0,0,1,0,coarse\n0,0,0,0.1,0,fine\n0,0,0,0.1,0,fine\n",
        );
        let mut text = String::from(
            "# axial_strain = 0.02\na,kind_b,b,normal_x_N,normal_y_N,normal_z_N,tangential_x_N,tangential_y_N,tangential_z_N\n",
        );
        for k in 0..12 {
            let (theta, phi, force) = (0.2 + 0.23 * f64::from(k), f64::from(k), 1.0 + f64::from(k % 3));
            let (s, c) = theta.sin_cos();
            let place = [s * phi.cos(), s * phi.sin(), c];
            let meridian = [c * phi.cos(), c * phi.sin(), -s];
            let around = [-phi.sin(), phi.cos(), 0.0];
            let along = 0.2 * force * (2.0 * theta).sin();
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
        write("snapshots/contacts_1.csv", &text);
        write("snapshots/contacts_0.csv", &text.replace("= 0.02", "= 0"));
        let found = interface(&[folder.path().into(), folder.path().into()]).expect("friction");
        assert!((found.friction - 0.2).abs() < 1e-12, "{found:?}");
        assert_eq!((found.tests[0].1.len(), found.tests[0].1[0].contacts, found.spread), (1, 12, Some(0.0)));
        write("snapshots/contacts_1.csv", &text.replace("normal_y_N", "normal"));
        let message = interface(&[folder.path().into()]).expect_err("a column is missing").to_string();
        assert!(message.contains("normal_y_N"), "{message}");
        write("snapshots/contacts_1.csv", &text.replace("0.02", "0"));
        let message = interface(&[folder.path().into()]).expect_err("no table under load").to_string();
        assert!(message.contains("records.contacts=true"), "{message}");
    }
}
