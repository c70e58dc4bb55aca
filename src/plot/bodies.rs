//! Rigid bodies that are no spheres, at the start and at the end of a run: their surfaces seen from obliquely above, or in plane strain from the front with the
//! material points behind them.

use super::axis::significant;
use super::canvas::{Canvas, WIDTH};
use super::colour::{self, BLACK, Colour, INK, WHITE, mix};
use super::error::{FigureError, Result};
use super::flow::Flow;
use super::plot::fit;
use super::run::Run;
use super::specimen::{MARGIN, SIZE, scale_bar};
use super::table::Table;
use super::text::{Anchor, Line};
use engine::math::vector::{cross, dot, less};
use engine::rigid::Pose;
use engine::rigid::motion::axes;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const GUTTER: f64 = 72.0;
const HAIR: f64 = 0.8;
const TALLEST: f64 = 900.0;
/// Width over height beyond which the start stands above the end, not beside it.
const LONG: f64 = 1.4;
/// Sine and cosine of the angles by which the view is turned about the vertical, and looks down.
const TURNED: [f64; 2] = [0.5, 0.866_025_403_784_438_6];
const DOWN: [f64; 2] = [0.342_020_143_325_668_7, 0.939_692_620_785_908_4];
/// Direction to the light in the axes of the page: to the right, up, towards the reader.
const LIGHT: [f64; 3] = [-0.45, 0.65, 0.61];

/// A triangle as it is seen: corners to the right and up, m, how far it is towards the reader at least, m, brightness from −1 to 1, and its body.
struct Facet {
    corners: [[f64; 2]; 3],
    depth: f64,
    light: f64,
    body: usize,
}

/// Draws `out/bodies.{svg,png,csv}` of a run with rigid bodies that are no spheres; nothing without them.
pub fn draw(run: &Run, out: &Path) -> Result<Vec<PathBuf>> {
    let read = |file: &str| Table::read_if_there(&run.dir.join(file));
    let (Some(surfaces), Some(tracks)) = (read("block_surfaces.csv")?, read("blocks.csv")?) else { return Ok(Vec::new()) };
    let columns = |t: &Table, names: &[&str]| names.iter().map(|name| t.numbers(name)).collect::<Result<Vec<_>>>();
    let (own, bodies) = (columns(&surfaces, &["x_m", "y_m", "z_m"])?, surfaces.numbers("block")?);
    let (poses, of) = (columns(&tracks, &["x_m", "y_m", "z_m", "q_w", "q_x", "q_y", "q_z"])?, tracks.numbers("block")?);
    // where bodies break, a piece has its number and its generation
    let generation = |t: &Table| if t.has("generation") { t.numbers("generation") } else { Ok(vec![0.0; t.len()]) };
    let (born, at) = (generation(&surfaces)?, generation(&tracks)?);
    let sound = poses.iter().flatten().chain(own.iter().flatten()).chain(&bodies).chain(&of).all(|x| x.is_finite());
    // rows of one instant: as many as the numbers rise
    let first = of.windows(2).take_while(|w| w[1] > w[0]).count() + 1;
    let last = of.windows(2).rev().take_while(|w| w[1] > w[0]).count() + 1;
    if surfaces.len() < 3 || tracks.len() == 0 || !sound {
        return Ok(Vec::new());
    }
    let count = first.max(last);
    let flat = own[2].iter().chain(&poses[2]).all(|z| *z == 0.0);
    let view = |rows: std::ops::Range<usize>| -> Vec<Facet> {
        // the row of a body's place, if it has this surface then
        let place_of = |row: usize| {
            let body = bodies[row] as usize;
            Some(rows.start + body).filter(|k| rows.contains(k) && of[*k] == bodies[row] && at[*k] == born[row])
        };
        let placed = |k: usize, row: usize| {
            let of: [f64; 7] = std::array::from_fn(|c| poses[c][k]);
            let pose = Pose { centre: [of[0], of[1], of[2]], axes: axes([of[3], of[4], of[5], of[6]]) };
            seen(pose.place([own[0][row], own[1][row], own[2][row]]), flat)
        };
        let facets = (0..surfaces.len() / 3).filter_map(|k| {
            let place = place_of(3 * k)?;
            let [p, q, r] = [0, 1, 2].map(|c| placed(place, 3 * k + c));
            let normal = cross(less(q, p), less(r, p));
            let length = dot(normal, normal).sqrt();
            let light = if length > 0.0 && !flat { dot(normal, LIGHT) / length } else { 0.0 };
            let facet = Facet {
                corners: [p, q, r].map(|c| [c[0], c[1]]),
                depth: p[2].min(q[2]).min(r[2]),
                light,
                body: bodies[3 * k] as usize,
            };
            Some((facet, flat || normal[2] > 0.0))
        });
        // convex bodies one after the other, as far as each reaches away from the reader: what lies on a floor comes after it
        let facets: Vec<(Facet, bool)> = facets.collect();
        let mut furthest = vec![f64::INFINITY; count];
        for (facet, _) in &facets {
            furthest[facet.body] = furthest[facet.body].min(facet.depth);
        }
        let mut seen: Vec<Facet> = facets.into_iter().filter(|(_, faces)| *faces).map(|(facet, _)| facet).collect();
        seen.sort_by(|a, b| furthest[a.body].total_cmp(&furthest[b.body]));
        seen
    };
    let views = [("start", view(0..first)), ("end", view(tracks.len() - last..tracks.len()))];
    let points = if flat { [read("points_start.csv")?, read("points_final.csv")?] } else { [None, None] };
    let flows = points.iter().map(|t| Flow::read(t.as_ref())).collect::<Result<Vec<_>>>()?;
    let (canvas, csv) = picture(run, &views, &flows, flat);
    table::folder(out).map_err(|e| FigureError::io(out, e))?;
    let mut files = canvas.write(out, "bodies")?.to_vec();
    let path = out.join("bodies.csv");
    let table = format!("panel,block,right_1_m,up_1_m,right_2_m,up_2_m,right_3_m,up_3_m\n{csv}");
    table::write(&path, table).map_err(|e| FigureError::io(&path, e))?;
    files.push(path);
    Ok(files)
}

fn picture(run: &Run, views: &[(&str, Vec<Facet>); 2], flows: &[Flow], flat: bool) -> (Canvas, String) {
    let corners = views.iter().flat_map(|(_, facets)| facets).flat_map(|f| f.corners);
    let [left, right, low, high] = corners
        .chain(flows.iter().flat_map(Flow::bounds))
        .fold([f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY], |b, [x, y]| {
            [b[0].min(x), b[1].max(x), b[2].min(y), b[3].max(y)]
        });
    let (wide, tall) = ((right - left).max(f64::MIN_POSITIVE), (high - low).max(f64::MIN_POSITIVE));
    let long = wide > LONG * tall;
    let room = if long { WIDTH - 2.0 * MARGIN } else { (WIDTH - 2.0 * MARGIN - GUTTER) / 2.0 };
    let scale = (room / wide).min(TALLEST / tall);
    let panel = |k: usize| if long { (150.0 + tall * scale) * (k + 1) as f64 } else { 150.0 + tall * scale };
    let foot = panel(1);
    let mut canvas = Canvas::new((foot + 120.0).round());
    let mut text = |at, text: String, room: f64| {
        let size = fit(&text, SIZE, room);
        canvas.text(Line { at, text, size, colour: INK, anchor: Anchor::Middle, upwards: false });
    };
    let from = if flat { "rigid bodies" } else { "rigid bodies from obliquely above" };
    text((WIDTH / 2.0, 44.0), format!("{} · {from}", run.label()), WIDTH - 2.0 * MARGIN);
    let time = run.column("time_s").ok().flatten().and_then(|all| all.last().copied()).filter(|t| t.is_finite());
    let centre = |k: usize| if long { WIDTH / 2.0 } else { MARGIN + room / 2.0 + (room + GUTTER) * k as f64 };
    for (k, (name, _)) in views.iter().enumerate() {
        let caption = match time.filter(|_| *name == "end") {
            Some(time) => format!("end: t = {} s", significant(time, 3)),
            None => (*name).into(),
        };
        text((centre(k), panel(k) - tall * scale - 40.0), caption, room);
    }
    let mut csv = String::new();
    let tones = Flow::tones(flows);
    for (k, (name, facets)) in views.iter().enumerate() {
        let start = centre(k) - 0.5 * wide * scale;
        let place = |[x, y]: [f64; 2]| (start + (x - left) * scale, panel(k) - (y - low) * scale);
        if let (Some(flow), Some(tones)) = (flows.get(k), &tones) {
            for ([x, y], width, tone) in flow.runs(tones) {
                // a hair higher, so that no line of light stands between two rows
                let ((a, b), (c, d)) = (place([x, y]), place([x + width, y + flow.edge]));
                canvas.rect((a, b), (c + HAIR, d - HAIR), tones.palette[tone], 1.0);
            }
        }
        for f in facets {
            let points = f.corners.map(place).to_vec();
            let tone = shade(colour::kind(f.body), f.light);
            canvas.area(points.clone(), tone, 1.0);
            // closes the hair between neighbours
            canvas.line(&[points[0], points[1], points[2], points[0]], tone, HAIR, &[]);
            let [a, b, c] = f.corners;
            let _ = writeln!(csv, "{name},{},{:.6},{:.6},{:.6},{:.6},{:.6},{:.6}", f.body, a[0], a[1], b[0], b[1], c[0], c[1]);
        }
    }
    scale_bar(&mut canvas, room / scale, scale, foot + 58.0);
    if let Some(tones) = tones {
        tones.legend(&mut canvas, foot + 58.0);
    }
    (canvas, csv)
}

/// A colour in the light: darker where it falls from behind.
fn shade(colour: Colour, light: f64) -> Colour {
    if light < 0.0 { mix(colour, BLACK, -0.7 * light) } else { mix(colour, WHITE, 0.55 * light) }
}

/// A position as the reader sees it: to the right, up, and towards the reader.
fn seen([x, y, z]: [f64; 3], flat: bool) -> [f64; 3] {
    if flat {
        return [x, y, 0.0];
    }
    let ([s, c], [down, level]) = (TURNED, DOWN);
    let (right, away) = (c * x + s * y, c * y - s * x);
    [right, level * z + down * away, down * z - level * away]
}
