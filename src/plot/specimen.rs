//! The specimen before and after, side by side at one scale: grains as shaded spheres, walls as thin lines
//! (Ciantia et al. 2015, Fig. 10 g-i).

use super::axis::{count, significant};
use super::balls::{Ball, Balls};
use super::canvas::{Canvas, Point, WIDTH};
use super::colour::{self, Colour, GENERATION_COLOURS, GREY, INK};
use super::error::{FigureError, Result};
use super::plot::fit;
use super::run::Run;
use super::table::Table;
use super::text::{self, Anchor, Line};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Direction of view: height of the eye above the horizon and turn about the vertical axis,
/// degrees.
const ELEVATION: f64 = 27.0;
const AZIMUTH: f64 = 25.0;
pub(super) const MARGIN: f64 = 36.0;
const GUTTER: f64 = 56.0;
const TALLEST: f64 = 1250.0;
pub(super) const SIZE: f64 = 42.0;
const WALL: f64 = 2.5;
/// Grains and cylinders with a coordinate or size beyond this are left out, m.
const FAR: f64 = 1e6;
/// Number of tones of a coloured field.
pub(super) const TONES: usize = 48;

/// What the colour of a grain means.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Colouring {
    /// 0 = initial grain, 1 = its daughters, and so on.
    Generation,
    /// Any numeric column of the specimen files, on a colour bar; the name carries the unit.
    Field(String),
}

struct Grain {
    at: [f64; 3],
    r: f64,
    generation: u64,
    field: f64,
}

struct Specimen {
    grains: Vec<Grain>,
    /// Cylinder radius, bottom and height, m; `None` without a cylinder.
    cylinder: Option<[f64; 3]>,
}

impl Specimen {
    fn read(path: &Path, colouring: &Colouring) -> Result<Option<Self>> {
        let Some(table) = Table::read_if_there(path)? else {
            return Ok(None);
        };
        // of a mixture, with the fines that became points
        if table.note("coarse_grains").is_some() {
            return Ok(None);
        }
        let column = |name: &str| table.numbers(name);
        let (x, y, z, r) = (column("x_m")?, column("y_m")?, column("z_m")?, column("r_m")?);
        let generation = if table.has("generation") { column("generation")? } else { vec![0.0; x.len()] };
        let field = match colouring {
            Colouring::Field(name) => column(name)?,
            Colouring::Generation => generation.clone(),
        };
        let grains: Vec<Grain> = (0..x.len())
            .map(|i| Grain { at: [x[i], y[i], z[i]], r: r[i], generation: generation[i].clamp(0.0, 1e6) as u64, field: field[i] })
            .filter(|g| g.at.iter().all(|v| v.abs() < FAR) && g.r > 0.0 && g.r < FAR)
            .collect();
        let lowest = grains.iter().map(|g| g.at[2] - g.r).fold(f64::INFINITY, f64::min);
        let note = |key| table.note(key).filter(|v: &f64| v.abs() < FAR);
        let cylinder = note("cylinder_radius_m")
            .zip(note("height_m"))
            .map(|(radius, height)| [radius, note("bottom_m").unwrap_or(lowest), height])
            .filter(|c| c[0] > 0.0 && c[2] > 0.0);
        let any = !grains.is_empty();
        Ok(any.then_some(Self { grains, cylinder }))
    }

    /// Bounds of the projection: left, right, bottom, top (positive upwards), m.
    fn bounds(&self) -> [f64; 4] {
        let view = View::new();
        let mut b = [f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY];
        let mut add = |u: f64, v: f64, r: f64| {
            b[0] = b[0].min(u - r);
            b[1] = b[1].max(u + r);
            b[2] = b[2].min(v - r);
            b[3] = b[3].max(v + r);
        };
        for g in &self.grains {
            let p = view.project(g.at);
            add(p[0], p[1], g.r);
        }
        if let Some([radius, bottom, height]) = self.cylinder {
            for k in 0..72 {
                for z in [bottom, bottom + height] {
                    let p = view.project(ring(radius, z, f64::from(k) * 5.0));
                    add(p[0], p[1], 0.0);
                }
            }
        }
        b
    }
}

fn ring(radius: f64, z: f64, degrees: f64) -> [f64; 3] {
    let a = degrees.to_radians();
    [radius * a.cos(), radius * a.sin(), z]
}

/// Orthographic view from above the horizon; `turn` and `lift` are sine and cosine of the azimuth
/// and of the elevation.
struct View {
    turn: (f64, f64),
    lift: (f64, f64),
}

impl View {
    fn new() -> Self {
        Self { turn: AZIMUTH.to_radians().sin_cos(), lift: ELEVATION.to_radians().sin_cos() }
    }

    /// Projection of a place: distances rightwards, upwards and towards the reader, m.
    fn project(&self, p: [f64; 3]) -> [f64; 3] {
        let (s, c) = self.turn;
        let (along, away) = (c * p[0] + s * p[1], -s * p[0] + c * p[1]);
        let (s, c) = self.lift;
        [along, p[2] * c + away * s, p[2] * s - away * c]
    }
}

/// Place of one specimen on the page: page position of its origin, and page units for a metre.
struct Panel {
    centre: f64,
    base: f64,
    scale: f64,
    /// Projection of the middle of the specimen's bottom, m; drawn at (`centre`, `base`).
    origin: [f64; 2],
}

impl Panel {
    fn place(&self, p: [f64; 3]) -> (Point, f64) {
        let v = View::new().project(p);
        let at = (self.centre + (v[0] - self.origin[0]) * self.scale, self.base - (v[1] - self.origin[1]) * self.scale);
        (at, v[2] * self.scale)
    }

    /// Part of a horizontal circle of the cylinder between two angles, degrees, counted from the
    /// right through the far side (0 to 180) and the near side (180 to 360).
    fn arc(&self, radius: f64, z: f64, from: f64, to: f64) -> Vec<Point> {
        (0..=60).map(|i| from + (to - from) * f64::from(i) / 60.0).map(|a| self.place(ring(radius, z, a + AZIMUTH)).0).collect()
    }
}

/// Draws the views of a run's specimen into `out`: `specimen.{svg,png,csv}`, or `specimen_FIELD`
/// with a field as colour. Draws nothing if the run left no specimen.
pub fn draw(run: &Run, colouring: &Colouring, out: &Path) -> Result<Vec<PathBuf>> {
    let read = |name: &str| Specimen::read(&run.dir.join(name), colouring);
    let mut specimens = Vec::new();
    for (name, file) in [("start", "specimen.csv"), ("end", "grains_final.csv")] {
        if let Some(s) = read(file)? {
            specimens.push((name, s));
        }
    }
    if specimens.is_empty() {
        return Ok(Vec::new());
    }
    let name = match colouring {
        Colouring::Generation => "specimen".to_string(),
        Colouring::Field(field) => format!("specimen_{}", field.replace(|c: char| !c.is_alphanumeric(), "_")),
    };
    let tones = Tones::of(&specimens, colouring);
    let (canvas, csv) = picture(run, &specimens, &tones)?;
    table::folder(out).map_err(|e| FigureError::io(out, e))?;
    let mut files = canvas.write(out, &name)?.to_vec();
    let path = out.join(format!("{name}.csv"));
    table::write(&path, csv).map_err(|e| FigureError::io(&path, e))?;
    files.push(path);
    Ok(files)
}

fn picture(run: &Run, specimens: &[(&str, Specimen)], tones: &Tones) -> Result<(Canvas, String)> {
    let bounds: Vec<[f64; 4]> = specimens.iter().map(|s| s.1.bounds()).collect();
    let widest = bounds.iter().map(|b| b[1] - b[0]).fold(0.0, f64::max);
    let n = specimens.len() as f64;
    let room = (WIDTH - 2.0 * MARGIN - (n - 1.0) * GUTTER) / n;
    let view = View::new();
    let origins: Vec<[f64; 2]> = specimens
        .iter()
        .zip(&bounds)
        .map(|((_, s), b)| match s.cylinder {
            Some([_, bottom, _]) => {
                let p = view.project([0.0, 0.0, bottom]);
                [p[0], p[1]]
            }
            None => [(b[0] + b[1]) / 2.0, b[2]],
        })
        .collect();
    let over = |i: usize| bounds[i][3] - origins[i][1];
    let under = |i: usize| origins[i][1] - bounds[i][2];
    let most = |f: &dyn Fn(usize) -> f64| (0..specimens.len()).map(f).fold(0.0, f64::max);
    let (up, down) = (most(&over), most(&under));
    let scale = (room / widest).min(TALLEST / (up + down)).min(1e9);
    let top = 150.0;
    let base = top + up * scale;
    let foot = base + down * scale;
    let mut canvas = Canvas::new((foot + 150.0).round());
    let mut csv = String::from("panel,x_m,y_m,z_m,r_m,generation,value\n");
    let start = specimens[0].1.cylinder;
    for (i, (name, specimen)) in specimens.iter().enumerate() {
        let panel = Panel { centre: MARGIN + room / 2.0 + (room + GUTTER) * i as f64, base, scale, origin: origins[i] };
        let ghost = start.filter(|_| i > 0);
        grains(&mut canvas, &mut csv, &panel, name, specimen, tones, ghost);
        let label = caption(run, name, specimen)?;
        canvas.text(Line {
            at: (panel.centre, 104.0),
            size: fit(&label, SIZE, room + GUTTER / 2.0),
            text: label,
            colour: INK,
            anchor: Anchor::Middle,
            upwards: false,
        });
    }
    heading(run, &mut canvas);
    scale_bar(&mut canvas, widest, scale, foot + 58.0);
    tones.legend(&mut canvas, foot + 58.0);
    Ok((canvas, csv))
}

fn heading(run: &Run, canvas: &mut Canvas) {
    let mut parts = vec![run.label()];
    parts.extend(run.facts());
    if let Some(events) = run.events.filter(|n| *n > 0) {
        parts.push(format!("{} events", count(events)));
    }
    let title = parts.join(" · ");
    canvas.text(Line {
        at: (WIDTH / 2.0, 40.0),
        size: fit(&title, SIZE, WIDTH - 2.0 * MARGIN),
        text: title,
        colour: INK,
        anchor: Anchor::Middle,
        upwards: false,
    });
}

/// Caption such as `start: σ_{v} = 5 kPa, 680 grains`.
fn caption(run: &Run, name: &str, specimen: &Specimen) -> Result<String> {
    let grains = count(specimen.grains.len() as u64);
    let branches = run.branches(("sigma_v_kPa", 1.0), ("sigma_v_kPa", 1.0))?;
    let mut points = branches.iter().flat_map(|b| &b.points);
    let stress = if name == "start" { points.next() } else { points.next_back() };
    Ok(match stress {
        Some((kpa, _)) => format!("{name}: σ_{{v}} = {}, {grains} grains", with_unit(*kpa)),
        None => format!("{name}: {grains} grains"),
    })
}

fn with_unit(kpa: f64) -> String {
    if kpa.abs() < 100.0 { format!("{} kPa", significant(kpa, 2)) } else { format!("{} MPa", significant(kpa * 1e-3, 2)) }
}

/// Draws the far walls, the height at the start (`ghost`) as a dashed line, the grains, and the
/// near walls, in this order.
fn grains(
    canvas: &mut Canvas,
    csv: &mut String,
    panel: &Panel,
    name: &str,
    specimen: &Specimen,
    tones: &Tones,
    ghost: Option<[f64; 3]>,
) {
    const DASH: &[f64] = &[16.0, 12.0];
    if let Some([radius, bottom, height]) = specimen.cylinder {
        canvas.line(&panel.arc(radius, bottom, 0.0, 180.0), GREY, WALL, &[]);
        canvas.line(&panel.arc(radius, bottom + height, 0.0, 180.0), GREY, WALL, &[]);
        if let Some([_, from, tall]) = ghost.filter(|g| g[2] > 1.01 * height) {
            let z = bottom + tall.max(from - bottom);
            canvas.line(&panel.arc(radius, z, 0.0, 360.0), GREY, WALL, DASH);
            for side in [0.0, 180.0] {
                let ends = [bottom + height, z].map(|z| panel.arc(radius, z, side, side)[0]);
                canvas.line(&ends, GREY, WALL, DASH);
            }
        }
    }
    let balls = Balls {
        palette: tones.palette.clone(),
        items: specimen
            .grains
            .iter()
            .map(|g| {
                let ((x, y), depth) = panel.place(g.at);
                Ball { x, y, depth, r: g.r * panel.scale, colour: tones.index(g) }
            })
            .collect(),
    };
    for i in balls.visible_order() {
        let g = &specimen.grains[i];
        let [x, y, z] = g.at;
        let _ = writeln!(csv, "{name},{x:.6},{y:.6},{z:.6},{:.6},{},{}", g.r, g.generation, g.field);
    }
    canvas.balls(balls);
    if let Some([radius, bottom, height]) = specimen.cylinder {
        canvas.line(&panel.arc(radius, bottom, 180.0, 360.0), INK, WALL, &[]);
        canvas.line(&panel.arc(radius, bottom + height, 180.0, 360.0), INK, WALL, &[]);
        for side in [0.0, 180.0] {
            let ends = [bottom, bottom + height].map(|z| panel.arc(radius, z, side, side)[0]);
            canvas.line(&ends, INK, WALL, &[]);
        }
    }
}

pub(super) fn scale_bar(canvas: &mut Canvas, widest: f64, scale: f64, y: f64) {
    let Some(length) = round_length(widest / 4.0) else {
        return;
    };
    let (a, b) = (MARGIN + 6.0, MARGIN + 6.0 + length * scale);
    canvas.line(&[(a, y), (b, y)], INK, 6.0, &[]);
    for x in [a, b] {
        canvas.line(&[(x, y - 12.0), (x, y + 12.0)], INK, 4.0, &[]);
    }
    canvas.text(Line {
        at: ((a + b) / 2.0, y + 44.0),
        text: format!("{} mm", significant(length * 1e3, 3)),
        size: SIZE,
        colour: INK,
        anchor: Anchor::Middle,
        upwards: false,
    });
}

/// The largest of 1, 2 and 5 times a power of ten that is at most `most`; `None` if there is none.
fn round_length(most: f64) -> Option<f64> {
    if !(most > 0.0 && most.is_finite()) {
        return None;
    }
    let unit = 10f64.powf(most.log10().floor());
    [5.0, 2.0, 1.0].into_iter().map(|m| m * unit).find(|v| *v <= most * (1.0 + 1e-9))
}

/// Colours of grains, and the key that explains them.
pub(super) struct Tones {
    pub(super) palette: Vec<Colour>,
    /// Number of generations, or name and range of the field.
    pub(super) key: Key,
}

pub(super) enum Key {
    Generations(usize),
    Field { name: String, lo: f64, hi: f64 },
}

impl Tones {
    fn of(specimens: &[(&str, Specimen)], colouring: &Colouring) -> Self {
        let grains = || specimens.iter().flat_map(|s| &s.1.grains);
        match colouring {
            Colouring::Generation => {
                let most = grains().map(|g| g.generation).max().unwrap_or(0) as usize;
                let n = (most + 1).min(GENERATION_COLOURS);
                Self {
                    palette: (0..n).map(colour::generation).collect(),
                    key: Key::Generations(n + usize::from(most >= GENERATION_COLOURS)),
                }
            }
            Colouring::Field(name) => {
                let values = grains().map(|g| g.field).filter(|v| v.is_finite());
                let (lo, hi) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
                let tone = |i: usize| colour::sequence(i as f64 / (TONES - 1) as f64);
                Self { palette: (0..TONES).map(tone).collect(), key: Key::Field { name: name.clone(), lo, hi } }
            }
        }
    }

    fn index(&self, g: &Grain) -> usize {
        match &self.key {
            Key::Generations(_) => (g.generation as usize).min(self.palette.len() - 1),
            Key::Field { lo, hi, .. } if hi > lo && g.field.is_finite() => {
                ((g.field - lo) / (hi - lo) * (TONES - 1) as f64).round() as usize
            }
            Key::Field { .. } => 0,
        }
    }

    pub(super) fn legend(&self, canvas: &mut Canvas, y: f64) {
        match &self.key {
            Key::Generations(n) => self.swatches(canvas, *n, y),
            Key::Field { name, lo, hi } => self.bar(canvas, name, *lo, *hi, y),
        }
    }

    /// Draws a legend such as `generation ● 0 ● 1 ● 2`, right-aligned.
    fn swatches(&self, canvas: &mut Canvas, n: usize, y: f64) {
        let colours = self.palette.len();
        let name = |i: usize| match i + 1 {
            k if k == colours && n > colours => format!("{i}+"),
            _ => i.to_string(),
        };
        let mut x = WIDTH - MARGIN;
        for i in (0..colours).rev() {
            x -= text::room(&name(i), SIZE);
            label(canvas, (x, y + 14.0), name(i), Anchor::Start);
            x -= 34.0;
            disc(canvas, (x, y + 14.0), 20.0, self.palette[i]);
            x -= 58.0;
        }
        label(canvas, (x + 18.0, y + 14.0), "generation".into(), Anchor::End);
    }

    fn bar(&self, canvas: &mut Canvas, name: &str, lo: f64, hi: f64, y: f64) {
        if lo > hi {
            return;
        }
        let (left, right) = (WIDTH - MARGIN - 620.0, WIDTH - MARGIN - 60.0);
        let step = (right - left) / TONES as f64;
        for (i, tone) in self.palette.iter().enumerate() {
            let x = left + step * i as f64;
            canvas.rect((x, y - 22.0), (x + step + 0.6, y + 10.0), *tone, 1.0);
        }
        for (x, v) in [(left, lo), (right, hi)] {
            label(canvas, (x, y + 44.0), significant(v, 3), Anchor::Middle);
        }
        canvas.text(Line {
            at: ((left + right) / 2.0, y + 44.0),
            text: name.into(),
            size: fit(name, SIZE, 300.0),
            colour: INK,
            anchor: Anchor::Middle,
            upwards: false,
        });
    }
}

pub(super) fn label(canvas: &mut Canvas, at: Point, text: String, anchor: Anchor) {
    canvas.text(Line { at, text, size: SIZE, colour: INK, anchor, upwards: false });
}

fn disc(canvas: &mut Canvas, at: Point, r: f64, fill: Colour) {
    let corners: Vec<Point> =
        (0..38).map(|i| f64::from(i) * std::f64::consts::TAU / 36.0).map(|a| (at.0 + r * a.cos(), at.1 + r * a.sin())).collect();
    canvas.area(corners.clone(), fill, 1.0);
    canvas.line(&corners, INK, 2.0, &[]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn higher_is_up_and_nearer_is_towards_the_reader() {
        let v = View::new();
        let (o, up) = (v.project([0.0; 3]), v.project([0.0, 0.0, 1.0]));
        assert!(up[1] > o[1] && up[2] > o[2]);
        let (s, c) = AZIMUTH.to_radians().sin_cos();
        let away = v.project([-s, c, 0.0]);
        assert!(away[2] < o[2] && away[1] > o[1], "the far rim stands higher on the page");
        let length = v.project([0.3, 0.4, 0.5]).map(|x| x * x).iter().sum::<f64>();
        assert!((length - 0.5).abs() < 1e-12, "a rotation keeps lengths");
    }

    #[test]
    fn scale_bars_are_round() {
        let close = |most, want: f64| (round_length(most).expect("length") - want).abs() < 1e-9;
        assert!(close(0.05, 0.05) && close(0.049, 0.02) && close(0.00199, 0.001));
        assert_eq!(round_length(f64::NAN), None);
    }

    #[test]
    fn absurd_grains_are_left_out_and_absurd_generations_drawn() {
        let dir = tempfile::tempdir().expect("folder");
        let rows = "x_m,y_m,z_m,r_m,generation,material\n0,0,0,0.1,1e300,0\n1e300,0,0,0.1,0,0\n0,0,0,-1,0,0\nnan,0,0,1,0,0\n";
        std::fs::write(dir.path().join("specimen.csv"), rows).expect("written");
        let run = Run::read(dir.path()).expect("run");
        let files = draw(&run, &Colouring::Generation, dir.path()).expect("drawn");
        let svg = std::fs::read_to_string(&files[0]).expect("svg");
        assert_eq!(svg.matches("<circle").count(), 1);
    }

    #[test]
    fn both_ends_are_drawn_at_one_scale() {
        let dir = tempfile::tempdir().expect("folder");
        let head = "# cylinder_radius_m = 0.1\n# bottom_m = 0\n# height_m = ";
        let rows = "x_m,y_m,z_m,r_m,generation,material\n0,0,0.02,0.02,0,0\n0.05,0,0.01,0.01,2,0\n";
        let write = |name: &str, h: &str| std::fs::write(dir.path().join(name), format!("{head}{h}\n{rows}"));
        write("specimen.csv", "0.05").expect("start");
        write("grains_final.csv", "0.04").expect("end");
        let run = Run::read(dir.path()).expect("run");
        let files = draw(&run, &Colouring::Generation, dir.path()).expect("drawn");
        assert_eq!(files.len(), 3);
        let svg = std::fs::read_to_string(&files[0]).expect("svg");
        let radii: Vec<&str> = svg.split("<circle ").skip(1).filter_map(|c| c.split(" r=\"").nth(1)?.split('"').next()).collect();
        assert_eq!(radii.len(), 4);
        let big = radii.iter().filter(|r| **r == radii[0]).count();
        assert_eq!(big, 2, "the same grain has the same size in both: {radii:?}");
        let field = Colouring::Field("strength_Pa".into());
        let error = draw(&run, &field, dir.path()).expect_err("no such column");
        assert!(error.to_string().contains("specimen.csv: no column `strength_Pa`"));
    }
}
