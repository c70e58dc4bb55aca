//! The snapshots of a run for a view in three dimensions: grains, points, surfaces of bodies and walls, with the quantities that colour them.

use super::blob::Blob;
use super::contacts;
use laboratory::error::Result;
use laboratory::record::snapshot::{Array, Snapshot, list};
use laboratory::run::{BLOCKS, COLLECTION, FINES, GRAINS, WALLS};
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

/// Quantities of snapshots: name of the array, meaning, unit, name that all arrays of this meaning have on the page. Of vectors the length is shown.
const QUANTITIES: [(&str, &str, &str, &str); 17] = [
    ("generation", "generation", "", "generation"),
    ("force", "largest contact force", "N", "force"),
    ("velocity", "speed", "m/s", "speed"),
    ("velocity_m_s", "speed", "m/s", "speed"),
    ("speed_m_s", "speed", "m/s", "speed"),
    ("mean_stress_Pa", "mean stress", "Pa", "mean_stress"),
    ("strength", "limit strength", "Pa", "strength"),
    ("strength_Pa", "limit strength", "Pa", "strength"),
    ("radius", "radius", "m", "radius"),
    ("radius_m", "radius", "m", "radius"),
    ("plastic_strain", "plastic strain", "–", "plastic_strain"),
    ("p_Pa", "mean stress p", "Pa", "p"),
    ("q_Pa", "deviatoric stress q", "Pa", "q"),
    ("porosity", "porosity", "–", "porosity"),
    ("spin_rad_s", "spin", "rad/s", "spin"),
    ("material", "material (number)", "", "material"),
    ("normal_force_N", "normal force", "N", "normal_force"),
];

/// What is noted of an instant: name, meaning, unit.
const FACTS: [(&str, &str, &str); 4] = [
    ("sigma_v_kPa", "vertical stress", "kPa"),
    ("axial_strain", "axial strain", "–"),
    ("time_s", "time", "s"),
    ("step", "step", ""),
];

/// The snapshots of a run.
pub struct Frames {
    /// What there is and in which blob, at which place.
    pub value: Value,
    /// Numbers of four bytes, little-endian, in base 64: a text for each layer of each snapshot.
    pub blobs: Vec<String>,
}

/// The least and largest value of a quantity over all snapshots.
struct Span {
    name: &'static str,
    what: &'static str,
    unit: &'static str,
    low: f64,
    high: f64,
    least_positive: f64,
}

/// Reads at most `most` of the snapshots that the run in `dir` has left, the first and the last among them. In `plane` strain volumes are those of a metre
/// across the plane.
///
/// # Errors
/// A list or a snapshot that is damaged, by name.
pub fn frames(dir: &Path, most: usize, plane: bool) -> Result<Frames> {
    let lists = [COLLECTION, GRAINS, FINES, BLOCKS, WALLS].map(|name| list(&dir.join(name)));
    let lists: Vec<Vec<(f64, PathBuf)>> = lists.into_iter().collect::<Result<_>>()?;
    let mut times: Vec<f64> = lists.iter().flatten().map(|(at, _)| *at).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let kept: Vec<f64> = spread(times.len(), most).into_iter().map(|i| times[i]).collect();
    let mut blobs = Vec::new();
    let mut spans: Vec<Span> = Vec::new();
    let mut instants = Vec::new();
    let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    let mut heights = [f64::INFINITY, f64::NEG_INFINITY];
    for &time in &kept {
        let mut layers = Vec::new();
        let mut facts = Vec::new();
        for (list, walls) in lists.iter().zip([false, false, false, false, true]) {
            // a run that is going on may have listed a snapshot that is not written yet
            let Some((_, path)) = list.iter().find(|(at, path)| *at == time && path.is_file()) else { continue };
            let snapshot = Snapshot::read(path)?;
            if facts.is_empty() {
                facts = noted(&snapshot);
            }
            if !snapshot.position.is_empty() {
                let (number, radii) = (numbers(&snapshot), radii(&snapshot, plane));
                let this = layer(&snapshot, walls, number.as_deref(), radii.as_deref(), &mut spans, &mut blobs);
                let grains = number.filter(|_| this["kind"] == "grains");
                layers.push(this);
                if let Some(numbers) = grains {
                    layers.extend(contacts::layers(path, &numbers, &mut blobs)?);
                }
                // walls may reach far beyond what they hold
                if !walls || bounds[0][0] > bounds[1][0] {
                    for (i, place) in snapshot.position.iter().enumerate() {
                        let radius = radii.as_ref().map_or(0.0, |radii| radii[i]);
                        for (a, x) in place.iter().enumerate() {
                            bounds[0][a] = bounds[0][a].min(x - radius);
                            bounds[1][a] = bounds[1][a].max(x + radius);
                        }
                        heights = [heights[0].min(place[2]), heights[1].max(place[2])];
                    }
                }
            }
        }
        instants.push(json!({ "facts": facts, "layers": layers }));
    }
    let flat = heights[0] == heights[1];
    let fields: Vec<Value> = spans
        .iter()
        .map(|s| json!({ "name": s.name, "what": s.what, "unit": s.unit, "low": s.low, "high": s.high, "leastPositive": s.least_positive }))
        .collect();
    let value = json!({ "all": times.len(), "fields": fields, "flat": flat, "bounds": bounds, "list": instants });
    Ok(Frames { value, blobs })
}

/// At most `most` of the numbers below `count`, at equal distances, the first and the last among them.
fn spread(count: usize, most: usize) -> Vec<usize> {
    match (count, most.max(1)) {
        (count, most) if count <= most => (0..count).collect(),
        (count, 1) => vec![count - 1],
        (count, most) => (0..most).map(|i| i * (count - 1) / (most - 1)).collect(),
    }
}

/// What is noted of the instant, for a reader: meaning, value, unit.
fn noted(snapshot: &Snapshot) -> Vec<Value> {
    FACTS.iter().filter_map(|(name, what, unit)| Some(json!([what, snapshot.fact(name)?, unit]))).collect()
}

/// The numbers of the grains or points, or of the body of each triangle; `None` where the snapshot has none.
fn numbers(snapshot: &Snapshot) -> Option<Vec<u32>> {
    let array = snapshot.array("id").or_else(|| snapshot.array("block"))?;
    Some(array.values.iter().map(|x| *x as u32).collect())
}

/// Radii of grains, m; of points those of balls as wide as a cube of their volume, in `plane` strain as a square of their area. `None` where the snapshot
/// has neither.
fn radii(snapshot: &Snapshot, plane: bool) -> Option<Vec<f64>> {
    let edge = if plane { f64::sqrt } else { f64::cbrt };
    let known = snapshot.array("radius").or_else(|| snapshot.array("radius_m")).map(|radius| radius.values.clone());
    known.or_else(|| Some(snapshot.array("volume_m3")?.values.iter().map(|v| 0.5 * edge(v.max(0.0))).collect()))
}

/// Packs a snapshot, whose grains, points or triangles have these numbers and radii, into one blob and says where in it, counted in numbers, each array begins.
fn layer(
    snapshot: &Snapshot,
    walls: bool,
    number: Option<&[u32]>,
    radii: Option<&[f64]>,
    spans: &mut Vec<Span>,
    blobs: &mut Vec<String>,
) -> Value {
    let mut blob = Blob::default();
    let surface = !snapshot.triangles.is_empty();
    let grown = snapshot.array("radius").or_else(|| snapshot.array("radius_m")).is_some();
    let (kind, count) = match surface {
        true => (if walls { "walls" } else { "surface" }, snapshot.triangles.len()),
        false => (if grown { "grains" } else { "points" }, snapshot.position.len()),
    };
    if surface {
        blob.real(snapshot.triangles.iter().flatten().flat_map(|&corner| snapshot.position[corner as usize]));
    } else {
        blob.real(snapshot.position.iter().flatten().copied());
    }
    let mut places = Map::new();
    if let Some(number) = number.filter(|_| !walls) {
        places.insert("number".into(), json!(blob.whole(number.iter().copied())));
    }
    if !surface {
        let radius = match radii {
            Some(radii) => blob.real(radii.iter().copied()),
            None => blob.real(std::iter::repeat_n(f64::NAN, count)),
        };
        places.insert("radius".into(), json!(radius));
    }
    let mut fields = Map::new();
    for (array, what, unit, name) in QUANTITIES.iter().filter(|_| !walls) {
        let Some(values) = snapshot.array(array).and_then(scalars).filter(|_| !fields.contains_key(*name)) else { continue };
        widen(spans, (name, what, unit), &values);
        fields.insert((*name).into(), json!(blob.real(values.into_iter())));
    }
    blobs.push(blob.text());
    json!({ "kind": kind, "count": count, "blob": blobs.len() - 1, "places": places, "fields": fields })
}

/// A number for each entry: the values of a scalar, the lengths of vectors; `None` for tensors.
fn scalars(array: &Array) -> Option<Vec<f64>> {
    match array.components {
        1 => Some(array.values.clone()),
        3 => Some(array.values.as_chunks::<3>().0.iter().map(|[x, y, z]| (x * x + y * y + z * z).sqrt()).collect()),
        _ => None,
    }
}

/// Adds finite values to the span of their quantity.
fn widen(spans: &mut Vec<Span>, (name, what, unit): (&'static str, &'static str, &'static str), values: &[f64]) {
    let at = spans.iter().position(|span| span.name == name).unwrap_or_else(|| {
        spans.push(Span { name, what, unit, low: f64::INFINITY, high: f64::NEG_INFINITY, least_positive: f64::INFINITY });
        spans.len() - 1
    });
    let span = &mut spans[at];
    for &x in values.iter().filter(|x| x.is_finite()) {
        span.low = span.low.min(x);
        span.high = span.high.max(x);
        if x > 0.0 {
            span.least_positive = span.least_positive.min(x);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_and_last_are_always_kept() {
        assert_eq!(spread(3, 12), [0, 1, 2]);
        assert_eq!(spread(41, 5), [0, 10, 20, 30, 40]);
        assert_eq!(spread(41, 1), [40]);
        assert!(spread(0, 4).is_empty());
    }

    #[test]
    fn numbers_stand_where_the_layer_says() {
        let array = |name: &str, components, values: &[f64]| Array { name: name.into(), components, values: values.to_vec() };
        let snapshot = Snapshot {
            position: vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]],
            arrays: vec![
                array("radius", 1, &[0.5, 0.25]),
                array("velocity", 3, &[3.0, 4.0, 0.0, 0.0, 0.0, 1.0]),
                array("strength", 1, &[f64::INFINITY, 7.0]),
                array("id", 1, &[9.0, 8.0]),
            ],
            ..Snapshot::default()
        };
        let (mut spans, mut blobs) = (Vec::new(), Vec::new());
        let layer =
            layer(&snapshot, false, numbers(&snapshot).as_deref(), radii(&snapshot, false).as_deref(), &mut spans, &mut blobs);
        let words = super::super::blob::tests::words(&blobs[0]);
        let numbers: Vec<f32> = words.iter().map(|x| f32::from_bits(*x)).collect();
        let at = |place: &Value| place.as_u64().expect("place") as usize;
        assert_eq!((layer["kind"].as_str(), layer["count"].as_u64()), (Some("grains"), Some(2)));
        assert_eq!(numbers[..6], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(numbers[at(&layer["places"]["radius"])..][..2], [0.5, 0.25]);
        assert_eq!(numbers[at(&layer["fields"]["speed"])..][..2], [5.0, 1.0]);
        assert_eq!(words[at(&layer["places"]["number"])..][..2], [9, 8]);
        assert!(layer["fields"].get("id").is_none());
        let strength = spans.iter().find(|s| s.name == "strength").expect("span");
        assert_eq!((strength.low, strength.high), (7.0, 7.0), "what cannot break has no place on the scale");
    }
}
