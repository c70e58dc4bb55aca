//! What is read from users, from bytes that nobody would write: a seeded mutator changes the files of this repository byte by byte, value
//! by value and line by line, and everything is read in this process. Nothing may panic, take more than two seconds or a gigabyte.
//!
//! The short form runs with the other tests. The long form runs until its time is over and writes a row for each target into
//! docs/validation/hard_to_break/fuzz.csv:
//!
//! ```sh
//! COMMINUTE_FUZZ_SECONDS=600 COMMINUTE_FUZZ_TARGETS=scene,set cargo test --release --test fuzz -- --ignored --nocapture
//! ```
//!
//! `COMMINUTE_FUZZ_SEED` begins with another seed. An input that fails is kept in tests/fuzz, which is part of the corpus from then on.

#![allow(unsafe_code)] // the allocator that counts

use comminute::calibrate::{curve::target, grains};
use comminute::campaign::{grid_points, grid_table, parse_seeds};
use comminute::error::Result;
use comminute::material::Material;
use comminute::{columns, exchange, record, reproduce, scene, study};
use std::alloc::{GlobalAlloc, Layout, System};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// Counts the memory that is in use.
struct Counting;

static USED: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

fn taken(size: usize) {
    let used = USED.fetch_add(size, Relaxed).wrapping_add(size);
    PEAK.fetch_max(used, Relaxed);
}

// SAFETY: hands everything to the system's allocator
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        taken(layout.size());
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        USED.fetch_sub(layout.size(), Relaxed);
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
/// Longest time and largest memory of one input. Time is a guard: the test shares its machine.
const SLOW: Duration = Duration::from_secs(2);
const LARGE: usize = 1_000_000_000;

/// Random numbers: xorshift64*.
struct Rng(u64);

impl Rng {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    /// A number below `n`, which is not 0.
    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    fn of<'a, T: ?Sized>(&mut self, list: &[&'a T]) -> &'a T {
        list[self.below(list.len())]
    }
}

/// Values that are at the edge of something.
const VALUES: [&str; 42] = [
    "0",
    "-0.0",
    "1",
    "-1",
    "2",
    "3",
    "0.5",
    "0.999999",
    "1.000001",
    "1e-15",
    "1e-16",
    "1e-300",
    "5e-324",
    "1e15",
    "1e16",
    "1e300",
    "nan",
    "inf",
    "-inf",
    "9223372036854775807",
    "-9223372036854775808",
    "9223372036854775808",
    "1000000000000",
    "1000000",
    "65536",
    "4294967295",
    "true",
    "false",
    "\"\"",
    "\"auto\"",
    "\"x\"",
    "[]",
    "[0]",
    "[1, 2]",
    "[0.0, 0.0, 0.0]",
    "[1e300, 1e300, 1e300]",
    "[[0.1, 0.0], [0.2, 1.0]]",
    "{}",
    "{ a = 1 }",
    "1979-05-27",
    "'''\n'''",
    "0x7fffffffffffffff",
];

/// An input changed in one to eight places; `words` are keys or columns, `others` the rest of the corpus.
fn mutated(rng: &mut Rng, from: &[u8], words: &[&str], others: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = from.to_vec();
    for _ in 0..=rng.below(3) * rng.below(4) {
        change(rng, &mut bytes, words, others);
    }
    bytes.truncate(1 << 20);
    bytes
}

fn change(rng: &mut Rng, bytes: &mut Vec<u8>, words: &[&str], others: &[Vec<u8>]) {
    let at = rng.below(bytes.len() + 1);
    match rng.below(14) {
        0 if at < bytes.len() => bytes[at] ^= 1 << rng.below(8),
        1 => bytes.insert(at, rng.next() as u8),
        2 => {
            let end = (at + rng.below(40)).min(bytes.len());
            bytes.drain(at..end);
        }
        3 => {
            let end = (at + rng.below(400)).min(bytes.len());
            let again = bytes[at..end].to_vec();
            let to = rng.below(bytes.len() + 1);
            bytes.splice(to..to, again);
        }
        4 => {
            let other = &others[rng.below(others.len())];
            let from = rng.below(other.len() + 1);
            let end = (from + rng.below(300)).min(other.len());
            bytes.splice(at..at, other[from..end].iter().copied());
        }
        5 => bytes.truncate(at),
        // lines: one that is repeated, or a new key
        6 | 7 => {
            let start = line(bytes, at).0;
            let text = format!("{} = {}\n", rng.of(words), rng.of(&VALUES));
            bytes.splice(start..start, text.into_bytes());
        }
        8 => {
            let (start, end) = line(bytes, at);
            let copy = bytes[start..end].to_vec();
            let to = line(bytes, rng.below(bytes.len() + 1)).0;
            bytes.splice(to..to, copy);
        }
        9 => {
            let (start, end) = line(bytes, at);
            bytes.drain(start..end);
        }
        // a word for a word
        10 => {
            let (start, end) = token(bytes, at, |b| b.is_ascii_alphanumeric() || b == b'_' || b == b'.');
            let word = rng.of(words).rsplit('.').next().unwrap_or("").to_string();
            bytes.splice(start..end, word.into_bytes());
        }
        // a number for a number, most often
        _ => {
            let from = bytes[at..].iter().position(u8::is_ascii_digit).map_or(at, |more| at + more);
            let (start, end) = token(bytes, from, |b| b.is_ascii_digit() || b"+-.eE".contains(&b));
            let value = match rng.below(3) {
                0 => rng.of(&VALUES).to_string(),
                1 => format!("{:e}", f64::from_bits(rng.next())),
                _ => {
                    let old = std::str::from_utf8(&bytes[start..end]).ok().and_then(|t| t.parse::<f64>().ok()).unwrap_or(1.0);
                    let by = [0.0, -1.0, 0.1, 0.5, 1.01, 2.0, 10.0, 1e3, 1e6, 1e12][rng.below(10)];
                    format!("{:?}", old * by)
                }
            };
            bytes.splice(start..end, value.into_bytes());
        }
    }
}

/// First byte of the line at `at`, and of the next one.
fn line(bytes: &[u8], at: usize) -> (usize, usize) {
    let start = bytes[..at].iter().rposition(|b| *b == b'\n').map_or(0, |n| n + 1);
    let end = bytes[at..].iter().position(|b| *b == b'\n').map_or(bytes.len(), |n| at + n + 1);
    (start, end)
}

/// The bytes around `at` that are of a kind.
fn token(bytes: &[u8], at: usize, of: impl Fn(u8) -> bool) -> (usize, usize) {
    let start = bytes[..at].iter().rposition(|b| !of(*b)).map_or(0, |n| n + 1);
    let end = bytes[at..].iter().position(|b| !of(*b)).map_or(bytes.len(), |n| at + n);
    (start, end)
}

/// Files below a folder whose names end so, in order.
fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut entries: Vec<PathBuf> = folder.read_dir().into_iter().flatten().flatten().map(|e| e.path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            found.extend(files(&path, ending));
        } else if path.to_string_lossy().ends_with(ending) {
            found.push(path);
        }
    }
    found
}

/// A kind of input: its corpus, the words that are put into it, and what reads it.
struct Target {
    name: &'static str,
    /// Executions of the short form.
    short: u64,
    corpus: Vec<(PathBuf, Vec<u8>)>,
    words: Vec<&'static str>,
    read: fn(&Fixture, &Path, &[u8]) -> Result<()>,
}

/// A folder for files that are read from disk.
struct Fixture {
    folder: tempfile::TempDir,
    materials: Vec<Material>,
}

impl Fixture {
    fn new() -> Fixture {
        let materials = scene::load(format!("{ROOT}/experiments/petroleum_coke/h-c-2.toml"), &[]).and_then(|s| scene::model(&s));
        Fixture { folder: tempfile::tempdir().expect("a folder"), materials: materials.expect("a model").physics.materials }
    }

    fn file(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.folder.path().join(name);
        std::fs::write(&path, bytes).expect("written");
        path
    }
}

/// All that `comminute check` does with a scene. What is accepted must be accepted again as it was resolved.
fn check(text: &str, folder: &Path, sets: &[String]) -> Result<()> {
    let scene = scene::from_text(text, folder, sets)?;
    let model = scene::outline(&scene)?;
    let estimate = scene::estimate(&model, None);
    let reach = scene::reach(&model);
    let _ =
        (reach.and_then(|r| scene::doubt(&model, &r)), scene::assumptions(&scene), scene::decisions(&scene), scene.calibrated());
    assert!(
        !estimate.seconds.is_nan() && !estimate.memory_mb.is_nan() && !estimate.output.total_mb.is_nan(),
        "an estimate is no number"
    );
    let again = scene::resolved(&scene);
    if scene.specimen().is_none() && again.len() < 1 << 20 {
        let second = scene::from_text(&again, folder, &[]).unwrap_or_else(|e| panic!("resolved, it is refused: {e}"));
        assert!(scene::resolved(&second) == again, "resolved twice, it differs");
    }
    Ok(())
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Lines as overrides of a scene.
fn lines(bytes: &[u8]) -> Vec<String> {
    text(bytes).lines().take(8).map(str::to_string).collect()
}

const COLUMNS: [&str; 30] = [
    "x_m",
    "y_m",
    "z_m",
    "r_m",
    "x_mm",
    "d_mm",
    "volume_m3",
    "material",
    "vx_m_s",
    "wx_rad_s",
    "diameter_mm",
    "force_N",
    "censored",
    "series",
    "sigma_v_kPa",
    "sigma_v_MPa",
    "void_ratio",
    "porosity",
    "axial_strain",
    "k0",
    "sd",
    "k0_sd",
    "generation",
    "id",
    "# hash",
    "# height_m",
    "# cylinder_radius_m",
    "# bottom_m",
    "\"",
    ",",
];

fn targets() -> Vec<Target> {
    let keys: Vec<&'static str> = scene::KEYS.iter().map(|key| key.path).collect();
    let own = |name: &str| -> Vec<(PathBuf, Vec<u8>)> {
        files(&Path::new(ROOT).join("tests/fuzz"), "")
            .into_iter()
            .filter(|p| p.file_name().is_some_and(|n| n.to_string_lossy().starts_with(name)))
            .map(read)
            .collect()
    };
    let of = |folder: &str, ending: &str, name: &str| {
        let mut all: Vec<_> =
            files(&Path::new(ROOT).join(folder), ending).into_iter().map(read).filter(|(_, b)| b.len() < 1 << 16).collect();
        all.extend(own(name));
        all
    };
    let kind = |all: Vec<(PathBuf, Vec<u8>)>, scenes: bool| -> Vec<(PathBuf, Vec<u8>)> {
        all.into_iter()
            .filter(|(p, b)| {
                let plans = ["[[run]]", "[[factor]]"].map(|part| text(b).contains(part));
                p.starts_with(Path::new(ROOT).join("tests")) || if scenes { plans == [false; 2] } else { plans[0] }
            })
            .collect()
    };
    let target = |name, short, corpus: Vec<(PathBuf, Vec<u8>)>, words: &[&'static str], read| {
        assert!(!corpus.is_empty(), "{name} has no corpus");
        Target { name, short, corpus, words: words.to_vec(), read }
    };
    vec![
        target("scene", 800, kind(of("experiments", ".toml", "scene"), true), &keys, |_, at, bytes| {
            check(&text(bytes), at.parent().expect("a folder"), &[])
        }),
        target("set", 1500, own("set"), &keys, |_, _, bytes| {
            let scenes = [
                "petroleum_coke/h-c-2",
                "mpm/oedometer",
                "mixture/triaxial_small",
                "platen/silica",
                "free/hertz_impact",
                "fontainebleau/triaxial-h",
            ];
            let sets = lines(bytes);
            let which = scenes[bytes.iter().map(|b| usize::from(*b)).sum::<usize>() % scenes.len()];
            let path = PathBuf::from(format!("{ROOT}/experiments/{which}.toml"));
            check(&std::fs::read_to_string(&path).expect("a scene"), path.parent().expect("a folder"), &sets)
        }),
        target("material", 1500, of("materials", ".toml", "material"), &keys, |f, _, bytes| {
            let path = f.file("m.toml", bytes);
            let _ = scene::continuum(&path, &[]);
            let coke = std::fs::read_to_string(format!("{ROOT}/experiments/petroleum_coke/h-c-2.toml")).expect("a scene");
            check(&coke, &Path::new(ROOT).join("experiments/petroleum_coke"), &[format!("material={}", path.display())])
        }),
        target("plan", 1500, kind(of("experiments", ".toml", "plan"), false), &keys, |f, _, bytes| {
            let plan = reproduce::Plan::read(&f.file("plan.toml", bytes).display().to_string())?;
            plan.runs.iter().try_for_each(|run| plan.jobs(run, Path::new("out")).map(|_| ()))
        }),
        target("study", 1000, of("experiments/studies", ".toml", "study"), &keys, |f, _, bytes| {
            let plan = study::Plan::read(&f.file("study.toml", bytes))?;
            plan.settings().iter().try_for_each(|setting| plan.jobs(setting, Path::new("out")).map(|_| ()))
        }),
        target("crushing", 1500, own("crushing"), &COLUMNS, |f, _, bytes| {
            grains::data::read(&f.file("crushing.csv", bytes)).map(|_| ())
        }),
        target("curve", 1500, of("experiments/calibration/targets", ".csv", "curve"), &COLUMNS, |f, _, bytes| {
            let curve = f.file("curve.csv", bytes);
            let files = target::Files { curve: curve.clone(), k0: None, gradations: None };
            let with = target::Files { gradations: Some(curve), ..files.clone() };
            let _ = target::Target::read(&with, 5.0);
            target::Target::read(&files, 5.0).map(|_| ())
        }),
        target("grains", 1000, of("experiments/free", ".csv", "grains"), &COLUMNS, |f, _, bytes| {
            let scene = PathBuf::from(format!("{ROOT}/experiments/free/imported_packing.toml"));
            let set = format!("grains_csv={:?}", f.file("grains.csv", bytes).display().to_string());
            check(&std::fs::read_to_string(&scene).expect("a scene"), scene.parent().expect("a folder"), &[set])
        }),
        target("points", 1000, own("points"), &COLUMNS, |f, at, bytes| {
            f.file("points.csv", bytes);
            let scene = std::fs::read_to_string(at.parent().expect("a folder").join("with_points.toml")).expect("a scene");
            check(&scene, f.folder.path(), &[])
        }),
        target(
            "mesh",
            1500,
            own("mesh"),
            &["solid", "facet", "endfacet", "endsolid", "vertex", "v", "f", "f -1 -2 -3"],
            |f, at, bytes| {
                let ending = if bytes.starts_with(b"solid") || bytes.contains(&0) { "stl" } else { "obj" };
                let name = f.file(&format!("mesh.{ending}"), bytes).display().to_string();
                let scene = std::fs::read_to_string(at.parent().expect("a folder").join("with_mesh.toml")).expect("a scene");
                check(&scene.replace("mesh.stl", &name), f.folder.path(), &[])
            },
        ),
        target("exchange", 1500, own("exchange"), &["Atoms", "Velocities", "atoms", "atom types", "#"], |f, at, bytes| {
            let path = f.file("grains", bytes);
            match at.extension().is_some_and(|e| e == "data") {
                true => exchange::read_lammps(&path, 1.0).map(|_| ()),
                false => exchange::read_yade(&path, 1.0).map(|_| ()),
            }
        }),
        target("columns", 1500, own("columns"), &COLUMNS, |f, _, bytes| {
            f.file("test.columns.toml", bytes);
            let table = "Oedometer;;\n# label = Sand 7\nSig_v [MPa];e;Versuch\nMPa;-;-\n0,5;0,81;A, dicht\n\n1;;B\n";
            columns::mapped(&f.folder.path().join("test.csv"), table).map(|_| ())
        }),
        target(
            "snapshot",
            1500,
            own("snapshot"),
            &["<DataArray", "offset=\"0\"", "type=\"Float32\"", "</Piece>"],
            |f, _, bytes| record::snapshot::Snapshot::read(&f.file("step.vtp", bytes)).map(|_| ()),
        ),
        target("specimen", 1500, own("specimen"), &COLUMNS, |f, _, bytes| {
            record::specimen::read(&f.file("specimen.csv", bytes), &f.materials).map(|_| ())
        }),
        target("list", 20_000, own("list"), &keys, |f, _, bytes| {
            let lines = lines(bytes);
            let seeds = lines.first().map_or(Ok(Vec::new()), |line| parse_seeds(line));
            let points = grid_points(&lines[lines.len().min(1)..], Vec::new());
            if bytes.len() % 16 == 0 {
                let _ = grid_table(&f.file("table.csv", bytes));
            }
            seeds.and(points).map(|_| ())
        }),
    ]
}

fn read(path: PathBuf) -> (PathBuf, Vec<u8>) {
    let bytes = std::fs::read(&path).expect("a file");
    (path, bytes)
}

/// What came of the executions of a target.
#[derive(Default)]
struct Found {
    executions: u64,
    accepted: u64,
    panics: u64,
    slowest: f64,
    largest: f64,
    failed: Vec<String>,
}

/// Reads mutated inputs until `enough` says so; everything that fails is kept.
fn fuzz(target: &Target, seed: u64, slow: Duration, enough: impl Fn(u64) -> bool) -> Found {
    let fixture = Fixture::new();
    let mut rng = Rng(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
    let others: Vec<Vec<u8>> = target.corpus.iter().map(|(_, bytes)| bytes.clone()).collect();
    let mut found = Found::default();
    while !enough(found.executions) {
        let k = found.executions as usize;
        // the corpus itself first
        let (path, bytes) = match target.corpus.get(k) {
            Some((path, bytes)) => (path, bytes.clone()),
            None => {
                let (path, from) = &target.corpus[rng.below(target.corpus.len())];
                (path, mutated(&mut rng, from, &target.words, &others))
            }
        };
        PEAK.store(USED.load(Relaxed), Relaxed);
        let (before, began) = (USED.load(Relaxed), Instant::now());
        let outcome = catch_unwind(AssertUnwindSafe(|| (target.read)(&fixture, path, &bytes)));
        let (seconds, memory) = (began.elapsed(), PEAK.load(Relaxed).saturating_sub(before));
        found.executions += 1;
        found.slowest = found.slowest.max(seconds.as_secs_f64());
        found.largest = found.largest.max(1e-6 * memory as f64);
        let why = match outcome {
            Err(panic) => {
                found.panics += 1;
                let said = panic.downcast_ref::<String>().cloned().or_else(|| panic.downcast_ref::<&str>().map(|s| s.to_string()));
                Some(format!("panics: {}", said.unwrap_or_default()))
            }
            Ok(outcome) => {
                found.accepted += u64::from(outcome.is_ok());
                match outcome {
                    _ if seconds > slow => Some(format!("takes {:.1} s", seconds.as_secs_f64())),
                    _ if memory > LARGE => Some(format!("takes {} MB", memory / 1_000_000)),
                    Err(e) if e.to_string().trim().is_empty() => Some("is refused without a word".into()),
                    _ => None,
                }
            }
        };
        if let Some(why) = why {
            let name = format!(
                "{ROOT}/tests/fuzz/{}-{:08x}",
                target.name,
                bytes.iter().fold(0_u32, |h, b| h.wrapping_mul(31) ^ u32::from(*b))
            );
            if found.failed.len() < 20 {
                std::fs::write(&name, &bytes).expect("kept");
                println!("{}: {why}\n  kept as {name}, from {}", target.name, path.display());
            }
            found.failed.push(why);
        }
    }
    found
}

/// Every target for a second or so.
/// In two processes, with the targets that take half of the time each: the memory of one input is counted for all of a process.
#[test]
fn nothing_that_is_read_panics() {
    const PART: &str = "COMMINUTE_FUZZ_PART";
    if let Ok(part) = std::env::var(PART) {
        let targets = targets();
        let (scenes, others) = targets.split_at(2);
        return short(if part == "0" { scenes } else { others });
    }
    let start = |part: &str| {
        let mut command = Command::new(std::env::current_exe().expect("this program"));
        command.args(["nothing_that_is_read_panics", "--exact", "--nocapture"]).env(PART, part);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("starts")
    };
    for part in [start("0"), start("1")] {
        let output = part.wait_with_output().expect("ended");
        let told = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat();
        println!("{told}");
        assert!(output.status.success(), "{told}");
    }
}

/// The short form of these targets.
fn short(targets: &[Target]) {
    let mut failed = Vec::new();
    for target in targets {
        let began = Instant::now();
        // a busy machine is no hang
        let found = fuzz(target, 7, 10 * SLOW, |n| n >= target.short);
        println!(
            "{}: {} executions, {} accepted, {:.1} s, slowest {:.3} s, largest {:.0} MB",
            target.name,
            found.executions,
            found.accepted,
            began.elapsed().as_secs_f64(),
            found.slowest,
            found.largest
        );
        assert!(found.accepted > 0, "{}: not even the corpus is accepted", target.name);
        failed.extend(found.failed);
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

/// The long form; see the head of this file.
#[test]
#[ignore = "runs for as long as it is told"]
fn long() {
    let told = |name: &str| std::env::var(name).ok();
    let seconds = told("COMMINUTE_FUZZ_SECONDS").and_then(|s| s.parse().ok()).unwrap_or(60);
    let seed = told("COMMINUTE_FUZZ_SEED").and_then(|s| s.parse().ok()).unwrap_or(1);
    let only = told("COMMINUTE_FUZZ_TARGETS");
    std::panic::set_hook(Box::new(|_| ()));
    let mut failed = 0;
    for target in targets().iter().filter(|t| only.as_ref().is_none_or(|o| o.split(',').any(|n| n == t.name))) {
        let until = Instant::now() + Duration::from_secs(seconds);
        let found = fuzz(target, seed, SLOW, |_| Instant::now() > until);
        failed += found.failed.len();
        write_row(target.name, &found);
    }
    assert_eq!(failed, 0);
}

/// Adds to the row of a target in the table of the documentation.
fn write_row(name: &str, found: &Found) {
    const HEAD: &str = "target,executions,refused,accepted,panics,slowest_s,largest_MB";
    let path = Path::new(ROOT).join("docs/validation/hard_to_break/fuzz.csv");
    std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
    let old = std::fs::read_to_string(&path).unwrap_or_default();
    let mut rows: Vec<Vec<String>> = old.lines().skip(1).map(|l| l.split(',').map(str::to_string).collect()).collect();
    let refused = found.executions - found.accepted - found.panics;
    let mut row =
        [found.executions as f64, refused as f64, found.accepted as f64, found.panics as f64, found.slowest, found.largest];
    if let Some(at) = rows.iter().position(|r| r[0] == name) {
        let before: Vec<f64> = rows.remove(at)[1..].iter().filter_map(|x| x.parse().ok()).collect();
        for (k, (now, old)) in row.iter_mut().zip(before).enumerate() {
            *now = if k < 4 { *now + old } else { now.max(old) };
        }
    }
    let [executions, refused, accepted, panics, slowest, largest] = row;
    rows.push(vec![
        name.into(),
        executions.to_string(),
        refused.to_string(),
        accepted.to_string(),
        panics.to_string(),
        format!("{slowest:.3}"),
        format!("{largest:.0}"),
    ]);
    rows.sort();
    let body: String = rows.iter().map(|r| r.join(",") + "\n").collect();
    std::fs::write(&path, format!("{HEAD}\n{body}")).expect("written");
    println!("{name}: {executions} executions, {accepted} accepted, {panics} panics, {slowest:.3} s, {largest:.0} MB");
}
