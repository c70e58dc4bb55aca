//! A section through a mixture: the vertical plane y = const through the middle, at the start and
//! at the end. Each place of the plane has the colour of the nearest material point; grains are
//! drawn as the circles in which the plane cuts them.

use super::axis::significant;
use super::canvas::{Canvas, Point, WIDTH};
use super::colour::{self, INK, WHITE};
use super::continuum::high_of;
use super::error::{FigureError, Result};
use super::plot::fit;
use super::run::Run;
use super::specimen::{Key, MARGIN, SIZE, TONES, Tones, scale_bar};
use super::table::Table;
use super::text::{Anchor, Line};
use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const GUTTER: f64 = 72.0;
const TALLEST: f64 = 1000.0;
/// Edge of a tile over the mean edge of the points, and the largest number of tiles along the
/// width.
const FINE: f64 = 1.0 / 3.0;
const ACROSS: f64 = 150.0;
/// A place is empty if the distance to every point is larger than this many mean edges of the
/// points.
const FAR: f64 = 1.0;
/// Corners of a drawn circle, and the width of its line.
const CORNERS: usize = 48;
const RIM: f64 = 3.0;

/// What is drawn of the plane: square tiles of one edge, m, each with the x and z of its centre, m,
/// and its value; circles, each with its centre and radius, m.
struct Cut {
    name: &'static str,
    edge: f64,
    tiles: Vec<([f64; 2], f64)>,
    circles: Vec<([f64; 2], f64)>,
}

/// A material point: centre and edge (cube root of the volume), m, and the value that colours it.
type Coloured = ([f64; 3], f64, f64);

/// Material points and grains at one instant; a grain is its centre and its radius, m.
struct Bodies {
    points: Vec<Coloured>,
    grains: Vec<([f64; 3], f64)>,
}

impl Bodies {
    fn read(run: &Run, [points, grains]: [&str; 2], column: &str) -> Result<Option<Bodies>> {
        let read = |file: &str| Table::read_if_there(&run.dir.join(file));
        let (Some(points), Some(grains)) = (read(points)?, read(grains)?) else { return Ok(None) };
        let places = |t: &Table| -> Result<Vec<[f64; 3]>> {
            let [x, y, z] = [t.numbers("x_m")?, t.numbers("y_m")?, t.numbers("z_m")?];
            Ok((0..t.len()).map(|i| [x[i], y[i], z[i]]).collect())
        };
        let edges = points.numbers("volume_m3")?.into_iter().map(f64::cbrt);
        let points: Vec<_> = places(&points)?
            .into_iter()
            .zip(edges)
            .zip(points.numbers(column)?)
            .map(|((p, edge), value)| (p, edge, value))
            .collect();
        let grains: Vec<_> = places(&grains)?.into_iter().zip(grains.numbers("r_m")?).collect();
        let sound = points.iter().all(|(p, edge, _)| p.iter().chain([edge]).all(|x| x.is_finite()));
        Ok((sound && !points.is_empty() && !grains.is_empty()).then_some(Bodies { points, grains }))
    }

    /// The middle of all bodies along y, m.
    fn middle(&self) -> f64 {
        let across = self.points.iter().map(|(p, edge, _)| [p[1] - 0.5 * edge, p[1] + 0.5 * edge]);
        let across = across.chain(self.grains.iter().map(|(p, r)| [p[1] - r, p[1] + r]));
        let [low, high] = across.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], [low, high]| [a.min(low), b.max(high)]);
        0.5 * (low + high)
    }

    fn cut(&self, name: &'static str, y: f64) -> Cut {
        let edge = self.points.iter().map(|p| p.1).sum::<f64>() / self.points.len() as f64;
        let reach = FAR * edge;
        // points near the plane, sorted by columns as wide as the distance at which a place can see
        // a point
        let column = |x: f64, z: f64| [(x / reach).floor() as i64, (z / reach).floor() as i64];
        let mut near: HashMap<[i64; 2], Vec<&Coloured>> = HashMap::new();
        for point in self.points.iter().filter(|p| (p.0[1] - y).abs() <= reach) {
            near.entry(column(point.0[0], point.0[2])).or_default().push(point);
        }
        let nearest = |x: f64, z: f64| {
            let [i, k] = column(x, z);
            let around = (-1..=1).flat_map(|di| (-1..=1).map(move |dk| [i + di, k + dk]));
            let square = |p: &[f64; 3]| (p[0] - x).powi(2) + (p[1] - y).powi(2) + (p[2] - z).powi(2);
            let all = around.filter_map(|c| near.get(&c)).flatten().map(|p| (square(&p.0), p.2));
            all.filter(|(d, _)| *d <= reach * reach).min_by(|a, b| a.0.total_cmp(&b.0)).map(|p| p.1)
        };
        // tiles cover the region of these points
        let [left, right, low, high] = bounds(near.values().flatten().map(|(p, edge, _)| ([p[0], p[2]], 0.5 * edge)));
        let tile = (FINE * edge).max((right - left) / ACROSS);
        let count = |from: f64, to: f64| ((to - from) / tile).round().max(0.0) as usize;
        let place = |i: usize, k: usize| [left + (i as f64 + 0.5) * tile, low + (k as f64 + 0.5) * tile];
        let places = (0..count(left, right)).flat_map(|i| (0..count(low, high)).map(move |k| place(i, k)));
        let circle = |(p, r): &([f64; 3], f64)| {
            let square = r * r - (p[1] - y) * (p[1] - y);
            (square > 0.0).then(|| ([p[0], p[2]], square.sqrt()))
        };
        Cut {
            name,
            edge: tile,
            tiles: places.filter_map(|p| Some((p, nearest(p[0], p[1])?))).collect(),
            circles: self.grains.iter().filter_map(circle).collect(),
        }
    }
}

/// Left, right, bottom and top of discs.
fn bounds(discs: impl Iterator<Item = ([f64; 2], f64)>) -> [f64; 4] {
    discs.fold([f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY], |b, (p, r)| {
        [b[0].min(p[0] - r), b[1].max(p[0] + r), b[2].min(p[1] - r), b[3].max(p[1] + r)]
    })
}

impl Cut {
    fn bounds(&self) -> [f64; 4] {
        bounds(self.tiles.iter().map(|(p, _)| (*p, 0.5 * self.edge)).chain(self.circles.iter().copied()))
    }
}

/// Draws `out/section.{svg,png,csv}` of a mixture, coloured by plastic strain if any point has
/// some, else by mean stress; draws nothing without both points and grains.
pub fn draw(run: &Run, out: &Path) -> Result<Vec<PathBuf>> {
    let read = |files, column| Bodies::read(run, files, column);
    let (starts, ends) = (["points_start.csv", "grains_start.csv"], ["points_final.csv", "grains_final.csv"]);
    let Some(end) = read(ends, "plastic_strain")? else { return Ok(Vec::new()) };
    let plastic = end.points.iter().any(|p| p.2 > 0.0);
    let (column, what) = if plastic { ("plastic_strain", "plastic strain (–)") } else { ("p_kPa", "mean stress p (kPa)") };
    let (start, Some(end)) = (read(starts, column)?, read(ends, column)?) else { return Ok(Vec::new()) };
    let y = start.as_ref().unwrap_or(&end).middle();
    let cuts: Vec<Cut> = [start.map(|s| s.cut("start", y)), Some(end.cut("end", y))].into_iter().flatten().collect();
    if cuts.iter().any(|c| c.tiles.is_empty() && c.circles.is_empty()) {
        return Ok(Vec::new());
    }
    let hi = high_of(cuts.iter().flat_map(|c| &c.tiles).map(|t| t.1).filter(|v| v.is_finite()).collect());
    let tones = Tones {
        palette: (0..TONES).map(|i| colour::sequence(i as f64 / (TONES - 1) as f64)).collect(),
        key: Key::Field { name: what.into(), lo: 0.0, hi },
    };
    let (canvas, csv) = picture(run, &cuts, &tones, (y, hi))?;
    table::folder(out).map_err(|e| FigureError::io(out, e))?;
    let mut files = canvas.write(out, "section")?.to_vec();
    let path = out.join("section.csv");
    table::write(&path, format!("panel,body,x_m,z_m,edge_or_radius_m,{column}\n{csv}")).map_err(|e| FigureError::io(&path, e))?;
    files.push(path);
    Ok(files)
}

fn picture(run: &Run, cuts: &[Cut], tones: &Tones, (y, hi): (f64, f64)) -> Result<(Canvas, String)> {
    let all = cuts.iter().map(Cut::bounds).fold([f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY], |a, b| {
        [a[0].min(b[0]), a[1].max(b[1]), a[2].min(b[2]), a[3].max(b[3])]
    });
    let n = cuts.len() as f64;
    let room = (WIDTH - 2.0 * MARGIN - (n - 1.0) * GUTTER) / n;
    let (wide, tall) = (all[1] - all[0], all[3] - all[2]);
    let scale = (room / wide).min(TALLEST / tall);
    let foot = 150.0 + tall * scale;
    let mut canvas = Canvas::new((foot + 150.0).round());
    let mut text = |at: Point, text: String, room: f64| {
        let size = fit(&text, SIZE, room);
        canvas.text(Line { at, text, size, colour: INK, anchor: Anchor::Middle, upwards: false });
    };
    let heading = format!("{} · vertical section at y = {} mm, grains as circles", run.label(), significant(1e3 * y, 3));
    text((WIDTH / 2.0, 44.0), heading, WIDTH - 2.0 * MARGIN);
    let strain = run.column("axial_strain")?.and_then(|all| all.last().copied()).filter(|e| e.is_finite());
    let centre = |k: usize| MARGIN + room / 2.0 + (room + GUTTER) * k as f64;
    for (k, cut) in cuts.iter().enumerate() {
        let caption = match strain.filter(|_| cut.name == "end") {
            Some(strain) => format!("end: ε_{{a}} = {} %", significant(100.0 * strain, 2)),
            None => cut.name.into(),
        };
        text((centre(k), 110.0), caption, room);
    }
    let mut csv = String::new();
    for (k, cut) in cuts.iter().enumerate() {
        let left = centre(k) - 0.5 * wide * scale;
        let place = |p: &[f64; 2]| (left + (p[0] - all[0]) * scale, foot - (p[1] - all[2]) * scale);
        let tone =
            |v: f64| if hi > 0.0 { (v / hi * (TONES - 1) as f64).round().clamp(0.0, (TONES - 1) as f64) as usize } else { 0 };
        for (p, value) in &cut.tiles {
            let ((x, y), half) = (place(p), 0.5 * cut.edge * scale);
            canvas.rect((x - half, y - half), (x + half, y + half), tones.palette[tone(*value)], 1.0);
            let _ = writeln!(csv, "{},point,{:.6},{:.6},{:.6},{value:.6}", cut.name, p[0], p[1], cut.edge);
        }
        for (p, r) in &cut.circles {
            let (x, y) = place(p);
            let angle = |i: usize| i as f64 / CORNERS as f64 * std::f64::consts::TAU;
            let rim: Vec<Point> = (0..=CORNERS).map(|i| (x + r * scale * angle(i).cos(), y + r * scale * angle(i).sin())).collect();
            canvas.area(rim.clone(), WHITE, 1.0);
            canvas.line(&rim, INK, RIM, &[]);
            let _ = writeln!(csv, "{},grain,{:.6},{:.6},{r:.6},", cut.name, p[0], p[1]);
        }
    }
    scale_bar(&mut canvas, wide, scale, foot + 58.0);
    tones.legend(&mut canvas, foot + 58.0);
    Ok((canvas, csv))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plane_has_the_colour_of_the_nearest_points_and_cuts_grains_in_circles() {
        let dir = tempfile::tempdir().expect("folder");
        // two points at half an edge from the plane y = 0.05, and two out of its reach
        let points = "id,x_m,y_m,z_m,volume_m3,plastic_strain,p_kPa\n0,0,0.045,0,1e-6,0,10\n1,0,0.055,0.02,1e-6,0.1,20\n2,0,0.1,0,1e-6,0.9,30\n3,0,0,0,1e-6,0.9,1\n";
        let grains = "x_m,y_m,z_m,r_m\n0.03,0.053,0.01,0.005\n0.03,0.09,0.01,0.005\n";
        for (name, text) in [("points_final.csv", points), ("grains_final.csv", grains)] {
            std::fs::write(dir.path().join(name), text).expect("written");
        }
        let files = draw(&Run::read(dir.path()).expect("run"), dir.path()).expect("drawn");
        let csv = std::fs::read_to_string(&files[2]).expect("csv");
        let rows: Vec<Vec<&str>> = csv.lines().skip(1).map(|l| l.split(',').collect()).collect();
        let tiles = |low: f64, high: f64| -> Vec<&str> {
            let inside = |r: &&Vec<&str>| (low..high).contains(&r[3].parse::<f64>().expect("m"));
            rows.iter().filter(|r| r[1] == "point").filter(inside).map(|r| r[5]).collect()
        };
        let (below, above) = (tiles(-1.0, 0.01), tiles(0.01, 1.0));
        assert!(below.len() > 6 && below.iter().all(|v| *v == "0.000000"), "{below:?}");
        assert!(above.len() > 6 && above.iter().all(|v| *v == "0.100000"), "{above:?}");
        // the plane cuts the first grain in a circle of 4 mm radius and does not meet the second
        let circles: Vec<&Vec<&str>> = rows.iter().filter(|r| r[1] == "grain").collect();
        assert_eq!(circles, [&["end", "grain", "0.030000", "0.010000", "0.004000", ""]]);
        std::fs::remove_file(dir.path().join("grains_final.csv")).expect("removed");
        assert!(draw(&Run::read(dir.path()).expect("run"), dir.path()).expect("nothing").is_empty());
    }
}
