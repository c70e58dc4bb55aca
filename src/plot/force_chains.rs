//! Force chains: every contact is a line between the centres of the two bodies (for a grain and a
//! material point, only the part near the point), with a width in proportion to the normal force.
//! Of many contacts only those in a vertical section through the middle are drawn. Two snapshots
//! stand side by side: the first with contacts, and that with the largest stress.

use super::axis::{count, significant};
use super::canvas::{Canvas, Point, WIDTH};
use super::colour::{self, Colour, INK};
use super::error::{FigureError, Result};
use super::plot::fit;
use super::run::Run;
use super::specimen::{MARGIN, SIZE, label, scale_bar};
use super::table::Table;
use super::text::{Anchor, Line};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const GUTTER: f64 = 72.0;
const TALLEST: f64 = 1000.0;
/// Width of the widest line, page units.
const WIDEST: f64 = 26.0;
/// Smallest width of a line, page units; a line is pale where its force would make it narrower.
const NARROW: f64 = 1.0;
/// Share of the contacts whose force is at most that of the widest line; larger forces have the
/// same width.
const MOST: f64 = 0.995;
/// With more contacts than this, only a section is drawn.
const MANY: usize = 700;
/// Thickness of the section over the median distance of two grains in contact.
const THICK: f64 = 2.0;

/// Kind of a contact: what a grain touches.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Grains,
    Wall,
    Point,
}

/// One contact: its line, from the centre of the first body to that of the second (of a wall, to
/// the point of contact), m, and the normal force, N.
struct Link {
    kind: Kind,
    ends: [[f64; 3]; 2],
    force: f64,
}

/// Drawn share of the line of a contact between a grain and a material point, at the point's end.
/// Every grain has many such contacts.
const OUTER: f64 = 0.4;

impl Link {
    /// Ends of the line that is drawn for the contact, m.
    fn drawn(&self) -> [[f64; 3]; 2] {
        let [from, to] = self.ends;
        match self.kind {
            Kind::Point => [std::array::from_fn(|a| to[a] + OUTER * (from[a] - to[a])), to],
            Kind::Grains | Kind::Wall => self.ends,
        }
    }
}

/// The contacts of one snapshot.
struct Instant {
    links: Vec<Link>,
    /// Number of contacts before the section was taken.
    all: usize,
    /// Thickness of the section, m; `None` if all contacts are drawn.
    thick: Option<f64>,
    stress: Option<f64>,
    strain: Option<f64>,
}

impl Instant {
    fn read(path: &Path) -> Result<Option<Instant>> {
        let table = Table::read(path)?;
        let kinds = table.texts("kind_b")?;
        let [a, b, n] = [["a_x_m", "a_y_m", "a_z_m"], ["b_x_m", "b_y_m", "b_z_m"], ["normal_x_N", "normal_y_N", "normal_z_N"]];
        let vectors = |names: [&str; 3]| -> Result<Vec<[f64; 3]>> {
            let [x, y, z] = [table.numbers(names[0])?, table.numbers(names[1])?, table.numbers(names[2])?];
            Ok((0..table.len()).map(|i| [x[i], y[i], z[i]]).collect())
        };
        let (from, to, forces) = (vectors(a)?, vectors(b)?, vectors(n)?);
        let links: Vec<Link> = (0..table.len())
            .map(|i| Link {
                kind: match kinds[i] {
                    "grain" => Kind::Grains,
                    "point" => Kind::Point,
                    _ => Kind::Wall,
                },
                ends: [from[i], to[i]],
                force: length(forces[i]),
            })
            .filter(|l| l.ends.iter().flatten().all(|x| x.is_finite()) && l.force > 0.0 && l.force.is_finite())
            .collect();
        if links.is_empty() {
            return Ok(None);
        }
        let (all, stress, strain) = (links.len(), table.note("sigma_v_kPa"), table.note("axial_strain"));
        let (links, thick) = section(links);
        Ok(Some(Instant { links, all, thick, stress, strain }))
    }

    /// Left, right, bottom and top of the contacts, m.
    fn bounds(&self) -> [f64; 4] {
        self.links.iter().flat_map(|l| l.ends).fold([f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY], |b, p| {
            [b[0].min(p[0]), b[1].max(p[0]), b[2].min(p[2]), b[3].max(p[2])]
        })
    }

    /// The force of the widest line, N.
    fn large(&self) -> f64 {
        let mut forces: Vec<f64> = self.links.iter().map(|l| l.force).collect();
        forces.sort_by(f64::total_cmp);
        forces[(MOST * (forces.len() - 1) as f64).round() as usize]
    }

    fn caption(&self, name: &str) -> String {
        let stress = self.stress.map(|s| {
            if s.abs() < 100.0 {
                format!("σ_{{v}} = {} kPa", significant(s, 2))
            } else {
                format!("σ_{{v}} = {} MPa", significant(1e-3 * s, 2))
            }
        });
        let strain = self.strain.map(|e| format!("ε_{{a}} = {} %", significant(100.0 * e, 2)));
        let parts: Vec<String> = stress.into_iter().chain(strain).collect();
        if parts.is_empty() { name.into() } else { format!("{name}: {}", parts.join(", ")) }
    }
}

fn length(v: [f64; 3]) -> f64 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}

/// The contacts near the vertical plane through the middle, and the thickness of this section, m;
/// all contacts and `None` if there are at most [`MANY`], or none between grains.
fn section(links: Vec<Link>) -> (Vec<Link>, Option<f64>) {
    let across = |l: &Link| l.ends.map(|p| p[1]);
    let (low, high) = links.iter().flat_map(across).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), y| (a.min(y), b.max(y)));
    let mut distances: Vec<f64> = links
        .iter()
        .filter(|l| l.kind == Kind::Grains)
        .map(|l| length(std::array::from_fn(|a| l.ends[1][a] - l.ends[0][a])))
        .collect();
    if links.len() <= MANY || distances.is_empty() {
        return (links, None);
    }
    distances.sort_by(f64::total_cmp);
    let (thick, middle) = (THICK * distances[distances.len() / 2], 0.5 * (low + high));
    let near = |l: &Link| (0.5 * (l.ends[0][1] + l.ends[1][1]) - middle).abs() <= 0.5 * thick;
    (links.into_iter().filter(near).collect(), Some(thick))
}

/// The snapshots to draw, with their names: the first one, and the later one with the largest
/// stress, or the last one if no snapshot has a stress.
fn instants(run: &Run) -> Result<Vec<(&'static str, Instant)>> {
    let mut files: Vec<PathBuf> = match std::fs::read_dir(run.dir.join("snapshots")) {
        Ok(entries) => entries.flatten().map(|e| e.path()).collect(),
        Err(_) => Vec::new(),
    };
    let name = |p: &Path| p.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    files.retain(|p| name(p).starts_with("contacts_") && name(p).ends_with(".csv"));
    files.sort();
    let mut all: Vec<Instant> = Vec::new();
    for file in &files {
        all.extend(Instant::read(file)?);
    }
    if all.len() < 2 {
        return Ok(all.pop().map(|one| ("contacts", one)).into_iter().collect());
    }
    let stressed = all.iter().any(|i| i.stress.is_some());
    let most = |i: usize| all[i].stress.unwrap_or(if stressed { f64::NEG_INFINITY } else { i as f64 });
    let later = (1..all.len()).fold(1, |best, i| if most(i) >= most(best) { i } else { best });
    let (late, first) = (all.swap_remove(later), all.swap_remove(0));
    Ok(vec![("start", first), (if stressed { "largest stress" } else { "end" }, late)])
}

/// Draws `out/force_chains.{svg,png,csv}`; nothing without files of contacts.
pub fn draw(run: &Run, out: &Path) -> Result<Vec<PathBuf>> {
    let instants = instants(run)?;
    if instants.iter().all(|(_, i)| i.links.is_empty()) {
        return Ok(Vec::new());
    }
    let (canvas, csv) = picture(run, &instants);
    table::folder(out).map_err(|e| FigureError::io(out, e))?;
    let mut files = canvas.write(out, "force_chains")?.to_vec();
    let path = out.join("force_chains.csv");
    table::write(&path, csv).map_err(|e| FigureError::io(&path, e))?;
    files.push(path);
    Ok(files)
}

fn picture(run: &Run, instants: &[(&str, Instant)]) -> (Canvas, String) {
    let all = instants
        .iter()
        .map(|(_, i)| i.bounds())
        .fold([f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY], |a, b| {
            [a[0].min(b[0]), a[1].max(b[1]), a[2].min(b[2]), a[3].max(b[3])]
        });
    let n = instants.len() as f64;
    let room = (WIDTH - 2.0 * MARGIN - (n - 1.0) * GUTTER) / n;
    let (wide, tall) = (all[1] - all[0], all[3] - all[2]);
    let scale = ((room - WIDEST) / wide).min(TALLEST / tall);
    let (top, height) = (206.0, tall * scale);
    let foot = top + height + WIDEST;
    let mut canvas = Canvas::new((foot + 380.0).round());
    let mut text = |at: Point, text: String, room: f64| {
        let size = fit(&text, SIZE, room);
        canvas.text(Line { at, text, size, colour: INK, anchor: Anchor::Middle, upwards: false });
    };
    let heading = format!("{} · normal forces F_{{n}} of contacts, seen from the side", run.label());
    text((WIDTH / 2.0, 44.0), heading, WIDTH - 2.0 * MARGIN);
    let middle = |k: usize| MARGIN + room / 2.0 + (room + GUTTER) * k as f64;
    for (k, (name, instant)) in instants.iter().enumerate() {
        text((middle(k), 110.0), instant.caption(name), room + GUTTER / 2.0);
        text((middle(k), 166.0), extent(instant), room + GUTTER / 2.0);
    }
    let mut csv = String::from("panel,kind,x1_m,z1_m,x2_m,z2_m,normal_force_N\n");
    for (k, (name, instant)) in instants.iter().enumerate() {
        let centre = middle(k);
        let left = centre - 0.5 * wide * scale;
        let place = |p: [f64; 3]| (left + (p[0] - all[0]) * scale, top + height - (p[2] - all[2]) * scale);
        let large = instant.large();
        let mut order: Vec<&Link> = instant.links.iter().collect();
        order.sort_by(|a, b| a.force.total_cmp(&b.force));
        for link in order {
            let [(x1, y1), (x2, y2)] = link.drawn().map(place);
            let (tone, width) = look(link.kind, link.force, large);
            canvas.line(&[(x1, y1), (x2, y2)], tone, width, &[]);
            let kind = ["grains", "wall", "point"][link.kind as usize];
            let [p, q] = link.ends;
            let _ = writeln!(csv, "{name},{kind},{:.6},{:.6},{:.6},{:.6},{:.6e}", p[0], p[2], q[0], q[2], link.force);
        }
        widths(&mut canvas, (centre - 0.5 * room + 20.0, foot + 70.0), large);
    }
    scale_bar(&mut canvas, wide, scale, foot + 280.0);
    kinds(&mut canvas, instants, foot + 294.0);
    (canvas, csv)
}

/// Colour and width of a line.
fn look(kind: Kind, force: f64, large: f64) -> (Colour, f64) {
    let width = (WIDEST * force / large).min(WIDEST);
    let tone = tone(kind);
    if width < NARROW { (colour::mix(tone, colour::WHITE, 0.6), NARROW) } else { (tone, width) }
}

fn tone(kind: Kind) -> Colour {
    match kind {
        Kind::Grains => INK,
        Kind::Wall => colour::kind(1),
        Kind::Point => colour::kind(0),
    }
}

/// How many contacts are drawn, and the thickness of the section.
fn extent(instant: &Instant) -> String {
    let (drawn, all) = (count(instant.links.len() as u64), count(instant.all as u64));
    match instant.thick {
        Some(thick) => format!("{drawn} of {all} contacts, {} mm thick", significant(1e3 * thick, 2)),
        None => format!("all {all} contacts"),
    }
}

/// Draws the key to the widths: lines of three round forces, and the force below which lines are
/// pale.
fn widths(canvas: &mut Canvas, at: Point, large: f64) {
    label(canvas, at, "width of a line in proportion to F_{n}:".into(), Anchor::Start);
    let mut x = at.0;
    for share in [1.0, 0.5, 0.2] {
        let force = rounded(share * large);
        let y = at.1 + 62.0;
        canvas.line(&[(x, y - 14.0), (x + 70.0, y - 14.0)], INK, WIDEST * force / large, &[]);
        let text = in_newtons(force);
        let wide = super::text::room(&text, SIZE);
        label(canvas, (x + 84.0, y), text, Anchor::Start);
        x += 110.0 + wide;
    }
    let thinnest = in_newtons(rounded(NARROW / WIDEST * large));
    label(canvas, (at.0, at.1 + 122.0), format!("pale: below about {thinnest}"), Anchor::Start);
}

/// The force rounded down to one significant digit.
fn rounded(force: f64) -> f64 {
    let unit = 10f64.powf(force.log10().floor());
    (force / unit * (1.0 + 1e-9)).floor().max(1.0) * unit
}

fn in_newtons(force: f64) -> String {
    match force {
        f if f >= 1e3 => format!("{} kN", significant(1e-3 * f, 1)),
        f if f < 1e-1 => format!("{} mN", significant(1e3 * f, 1)),
        f => format!("{} N", significant(f, 1)),
    }
}

/// Draws the key to the colours, right-aligned, with the kinds of contact that are drawn.
fn kinds(canvas: &mut Canvas, instants: &[(&str, Instant)], y: f64) {
    let mut x = WIDTH - MARGIN;
    for (kind, name) in [(Kind::Point, "grain and point"), (Kind::Wall, "grain and wall"), (Kind::Grains, "two grains")] {
        if instants.iter().any(|(_, i)| i.links.iter().any(|l| l.kind == kind)) {
            x -= super::text::room(name, SIZE);
            label(canvas, (x, y), name.into(), Anchor::Start);
            x -= 84.0;
            canvas.line(&[(x, y - 14.0), (x + 66.0, y - 14.0)], tone(kind), 12.0, &[]);
            x -= 40.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "a,kind_b,b,a_x_m,a_y_m,a_z_m,b_x_m,b_y_m,b_z_m,normal_x_N,normal_y_N,normal_z_N\n";

    fn run(files: &[(&str, String)]) -> tempfile::TempDir {
        let dir = tempfile::tempdir().expect("folder");
        std::fs::create_dir(dir.path().join("snapshots")).expect("folder");
        for (name, text) in files {
            std::fs::write(dir.path().join("snapshots").join(name), text).expect("file");
        }
        dir
    }

    #[test]
    fn the_stressed_instant_stands_beside_the_first_and_widths_go_with_forces() {
        let rows = |large: f64| {
            format!("{HEAD}0,grain,1,0,0,0,0,0,0.01,0,0,-{large}\n1,wall,top,0,0,0.01,0.002,0,0.02,0,0,-{}\n", 0.5 * large)
        };
        let note = |stress: f64, large: f64| format!("# sigma_v_kPa = {stress}\n{}", rows(large));
        let dir = run(&[
            ("contacts_01.csv", note(5.0, 1.0)),
            ("contacts_02.csv", note(900.0, 80.0)),
            ("contacts_03.csv", note(20.0, 3.0)),
        ]);
        let files = draw(&Run::read(dir.path()).expect("run"), dir.path()).expect("drawn");
        let svg = std::fs::read_to_string(&files[0]).expect("svg");
        assert!(svg.contains("largest stress") && svg.contains("80 N") && !svg.contains("20 kPa"));
        let width = |w: f64| svg.matches(&format!("stroke-width=\"{w:.0}\"")).count();
        assert!(width(WIDEST) >= 2 && width(0.5 * WIDEST) >= 2, "{svg}");
        let csv = std::fs::read_to_string(&files[2]).expect("csv");
        assert_eq!(csv.lines().filter(|l| l.starts_with("largest stress,")).count(), 2);
        assert!(draw(&Run::read(run(&[]).path()).expect("run"), dir.path()).expect("nothing").is_empty());
    }

    #[test]
    fn many_contacts_are_drawn_as_a_section() {
        let link = |y: f64| Link { kind: Kind::Grains, ends: [[0.0, y, 0.0], [0.0, y, 0.01]], force: 1.0 };
        let (near, thick) = section((0..=1000).map(|k| link(1e-4 * f64::from(k))).collect());
        assert!((thick.expect("a section") - 0.02).abs() < 1e-12 && (195..=205).contains(&near.len()), "{}", near.len());
        assert!(near.iter().all(|l| (l.ends[0][1] - 0.05).abs() <= 0.0100001));
        assert_eq!((rounded(87.0), rounded(0.0345)), (80.0, 0.03));
    }
}
