//! Contact of points with polygons at the nodes that both reach (`contact.on_points = "mutual_nodes"`).

use crate::typed::{refused, resumes, run};

/// A rod of points hits a block of the same mass (Jiang et al. 2020, section 5.4).
fn rod() -> String {
    include_str!("../../experiments/jiang2020/rod.toml")
        .replace("law = \"spring\"", "law = \"spring\"\non_points = \"mutual_nodes\"")
        .replace("frames = 4", "figures = false")
}

/// Rod and block keep their momentum, the block leaves with about the share of the rod's speed that the theory of waves has, and a run that was stopped goes on to the same bytes.
#[test]
fn a_rod_hits_a_block_at_the_nodes() {
    let folder = tempfile::tempdir().expect("folder");
    let whole = run(folder.path(), &rod(), "whole", &["--threads", "1"]);
    let read = |name: &str| csv::Reader::from_path(whole.join(name)).expect(name);
    let mut table = read("blocks.csv");
    let column = |name: &str, table: &mut csv::Reader<std::fs::File>| {
        table.headers().expect("headers").iter().position(|h| h == name).unwrap_or_else(|| panic!("{name}"))
    };
    let [speed, pressed] = ["vx_m_s", "points_x_N"].map(|name| column(name, &mut table));
    let rows: Vec<[f64; 2]> = table
        .records()
        .map(|row| row.expect("a row"))
        .map(|row| [speed, pressed].map(|k| row[k].parse().expect("a number")))
        .collect();
    let last = rows.last().expect("a row")[0];
    let theory = 0.02 * (1.0 - (-2.0_f64).exp());
    assert!((last / theory - 1.0).abs() < 0.05, "{last} {theory}");
    // what presses on the block is in the records
    assert!(rows.iter().any(|row| row[1] > 0.0), "{rows:?}");
    resumes(&whole, &folder.path().join("rocks.toml").to_string_lossy(), &[40], &["blocks.csv", "history.csv"]);
}

#[test]
fn what_cannot_touch_at_nodes_is_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let bodies = "may be mutual_nodes only where points touch polygons that do not break";
    for (from, to, says) in [
        ("position_mm = [87.55, 5.0, 0.0]", "position_mm = [87.55, 5.0, 0.0]\nheld = [\"y\"]", bodies),
        ("[records]", "[crushing]\nenabled = true\n[records]", bodies),
        ("plane_strain = true", "", "needs grid.plane_strain = true"),
    ] {
        refused(folder.path(), &rod(), from, to, says);
    }
    let without = rod();
    let (start, end) = (without.find("[[block]]").expect("a block"), without.find("[materials.rod]").expect("materials"));
    refused(folder.path(), &without, &without[start..end], "", bodies);
}
