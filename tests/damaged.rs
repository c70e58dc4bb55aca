//! Checkpoints that are damaged, and forged ones whose hashes are right and whose content no run has written: `comminute resume` refuses them, goes on
//! from the checkpoint before or goes on from what is there; it never panics, never hangs and never takes all memory.
#![cfg(unix)]

mod common;

#[cfg(feature = "gpu")]
#[path = "../src/engine/gpu/tests/adapter.rs"]
mod adapter;

#[cfg(feature = "gpu")]
use comminute::gpu;

use assert_cmd::cargo::cargo_bin;
use common::ROOT;
use rand::seq::IndexedRandom;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// A run that is stopped twice, so that it leaves two checkpoints.
struct Kind {
    name: &'static str,
    /// A scene of the repository, or a text that begins with `base`.
    scene: &'static str,
    sets: &'static [&'static str],
    /// Steps after which it is stopped.
    stops: [u64; 2],
    /// What computes its steps.
    backend: &'static str,
}

const KINDS: &[Kind] = &[
    Kind {
        name: "preparation with a stated friction",
        scene: "experiments/petroleum_coke/h-c-2.toml",
        sets: &[
            "specimen.scale=4",
            "specimen.grains=60",
            "specimen.porosity=0.53",
            "preparation.growth_friction=0.4",
            "preparation.growth_steps=600",
            "preparation.porosity_tolerance=0.05",
            "loading.max_stress_kPa=60",
            "records.at_kPa=[]",
        ],
        stops: [400, 500],
        backend: "cpu",
    },
    Kind {
        name: "preparation on the way",
        scene: "experiments/petroleum_coke/h-c-2.toml",
        sets: &[
            "specimen.grains=60",
            "specimen.diameter_mm=80",
            "specimen.porosity=0.49",
            "preparation.growth_friction=auto",
            "preparation.porosity_tolerance=0.005",
            "loading.max_stress_kPa=60",
            "records.at_kPa=[]",
        ],
        stops: [12_000, 24_000],
        backend: "cpu",
    },
    Kind {
        name: "oedometer with crushing",
        scene: "experiments/petroleum_coke/h-c-2.toml",
        sets: &[
            "specimen.scale=4",
            "specimen.grains=60",
            "specimen.porosity=0.53",
            "preparation.growth_friction=0.4",
            "preparation.growth_steps=600",
            "preparation.porosity_tolerance=0.05",
            "loading.max_stress_kPa=150",
            "records.at_kPa=[50.0]",
            "records.contacts=true",
            "material.strength.fixed_angle.sigma_lim0_MPa=60",
            "crushing.birth=gradual",
            "crushing.lost_mass=grow",
        ],
        stops: [4761 + 15_000, 4761 + 19_640],
        backend: "cpu",
    },
    Kind {
        name: "fines as points in an oedometer",
        scene: "tests/golden/sand_oedometer.toml",
        sets: &[
            "specimen.grains=60",
            "specimen.diameter_mm=2.0",
            "specimen.void_ratio=0.9",
            "loading.max_stress_kPa=7000",
            "loading.stages_kPa=[]",
        ],
        stops: [32_000, 34_000],
        backend: "cpu",
    },
    Kind {
        name: "triaxial test",
        scene: "experiments/fontainebleau/triaxial-h.toml",
        sets: &[
            "specimen.grains=100",
            "specimen.diameter_mm=7.2",
            "crushing.enabled=true",
            "loading.axial_strain=0.02",
            "specimen.isotropic_stress_kPa=2000",
            "loading.inertial_number=0.003",
            "preparation.growth_friction=0.4",
            "preparation.porosity_tolerance=0.05",
            "specimen.porosity=0.42",
        ],
        stops: [28_000, 28_500],
        backend: "cpu",
    },
    Kind {
        name: "isotropic compression",
        scene: "experiments/isotropic/petroleum_coke.toml",
        sets: &[
            "specimen.grains=50",
            "specimen.diameter_mm=90",
            "specimen.porosity=0.47",
            "preparation.porosity_tolerance=0.05",
            "loading.max_stress_kPa=600",
            "loading.stages_kPa=[60, 700]",
            "records.at_kPa=[]",
        ],
        stops: [31_018 + 10_000, 31_018 + 15_000],
        backend: "cpu",
    },
    Kind { name: "free scene", scene: "tests/golden/two_materials.toml", sets: &[], stops: [2000, 3000], backend: "cpu" },
    Kind {
        name: "continuum",
        scene: "experiments/mpm/triaxial_fine_small.toml",
        sets: &["test.axial_strain=0.001"],
        stops: [100, 200],
        backend: "cpu",
    },
    Kind {
        name: "continuum with APIC",
        scene: "experiments/mpm/column_collapse_2d.toml",
        sets: &["duration_s=0.05", "grid.cell_mm=10", "grid.pic=0", "grid.transfer=apic"],
        stops: [200, 300],
        backend: "cpu",
    },
    Kind {
        name: "mixture with rigid bodies",
        scene: "tests/golden/blocks.toml",
        sets: &["duration_s=0.003"],
        stops: [150, 160],
        backend: "cpu",
    },
    Kind {
        name: "mixture with fines",
        scene: "base = \"ROOT/experiments/mixture/coke_in_fines.toml\"\n[[body]]\nshape = \"box\"\nmaterial = \"fines\"\nmin_mm = [0.0, 0.0, 0.0]\nmax_mm = [18.0, 18.0, 12.0]\nporosity = 0.42\nstress_kPa = 50.0\n",
        sets: &["growth.steps=400", "growth.fines_diameter_mm=[1.9, 2.1]", "test.axial_strain=0.08", "records.rows=40"],
        stops: [12_500, 12_700],
        backend: "cpu",
    },
    Kind {
        name: "growing continuum",
        scene: "experiments/mixture/twin_points.toml",
        sets: &["growth.fines_diameter_mm=[5.4, 5.6]", "grid.cell_mm=9.375", "growth.friction=0.1", "test.axial_strain=0.0005"],
        stops: [1000, 1500],
        backend: "cpu",
    },
    // the last, so that it is left out where there is no device
    Kind {
        name: "continuum on a graphics device",
        scene: "experiments/mpm/triaxial_fine_small.toml",
        sets: &["test.axial_strain=0.001"],
        stops: [100, 200],
        backend: "gpu",
    },
];

/// Steps that a run may make from a forged checkpoint before it is stopped.
const MORE: u64 = 40;
/// Memory that a run may ask for, kB: some ten times what the largest of these scenes needs.
const MEMORY: u64 = 2_000_000;
/// A run that takes longer hangs: the longest of these takes some seconds.
const PATIENCE: Duration = Duration::from_secs(60);
/// Where the parts of a checkpoint begin: hash of itself, hash of its scene, length of the content, length of the compressed content, content.
const HEAD: [usize; 5] = [0, 32, 64, 72, 80];

/// What came of a damaged or forged checkpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Outcome {
    /// Exit code 2.
    Refused,
    /// The run went on from the checkpoint before.
    Recovered,
    /// The run went on.
    WentOn,
    /// Exit code 3: the run's own watch found the state meaningless.
    Watchdog,
    /// Exit code 1: the run could not reach what the scene asks for, or a table lacks rows.
    Failed,
    /// A panic, a signal, or more memory than allowed.
    Panic,
    Hang,
}

const OUTCOMES: [(Outcome, &str); 7] = [
    (Outcome::Refused, "refused"),
    (Outcome::Recovered, "recovered"),
    (Outcome::WentOn, "went_on"),
    (Outcome::Watchdog, "watchdog"),
    (Outcome::Failed, "failed"),
    (Outcome::Panic, "panics"),
    (Outcome::Hang, "hangs"),
];

/// How a file is damaged: its bytes, or the scene beside it.
const DAMAGES: [&str; 6] = ["bits", "cut", "longer", "zeros", "of another run", "scene changed"];
/// How a content is changed before its hashes are computed anew.
const FORGERIES: [&str; 7] = ["bits", "number", "length", "words exchanged", "bytes lost", "bytes added", "piece of another run"];

fn folder() -> &'static Path {
    static DIR: OnceLock<tempfile::TempDir> = OnceLock::new();
    DIR.get_or_init(|| tempfile::tempdir().expect("folder")).path()
}

/// `comminute` on one thread with bounded memory, from the root of the repository.
fn comminute(verb: &str, what: &Path, more: &[&str]) -> Command {
    let mut command = Command::new("sh");
    command.current_dir(ROOT).env("COMMINUTE_CACHE", folder().join("cache"));
    command.arg("-c").arg(format!("ulimit -v {MEMORY}; exec \"$0\" \"$@\"")).arg(cargo_bin("comminute"));
    command.arg(verb).arg(what).args(["--threads", "1", "--quiet"]).args(more);
    command
}

/// Output of a command; `None` if it hangs.
fn output(command: &mut Command) -> Option<Output> {
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("starts");
    let begun = Instant::now();
    while child.try_wait().expect("a child").is_none() {
        if begun.elapsed() > PATIENCE {
            return stopped(child);
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    Some(child.wait_with_output().expect("output"))
}

fn stopped(mut child: Child) -> Option<Output> {
    child.kill().expect("stopped");
    child.wait().expect("ended");
    None
}

/// The runs of a kind, each made once: stopped with two checkpoints, and whole.
struct Base {
    stopped: PathBuf,
    whole: PathBuf,
}

impl Kind {
    fn number(&self) -> usize {
        KINDS.iter().position(|kind| kind.name == self.name).expect("a kind of the list")
    }

    fn base(&self) -> &'static Base {
        static BASES: [OnceLock<Base>; KINDS.len()] = [const { OnceLock::new() }; KINDS.len()];
        BASES[self.number()].get_or_init(|| {
            let at = |what: &str| folder().join(format!("{}_{what}", self.number()));
            let base = Base { stopped: at("stopped"), whole: at("whole") };
            let scene = if self.scene.ends_with(".toml") { Path::new(ROOT).join(self.scene) } else { at("scene.toml") };
            let mut sets = vec!["--set", "records.figures=false"];
            if !self.scene.ends_with(".toml") {
                fs::write(&scene, self.scene.replace("ROOT", ROOT)).expect("scene");
            }
            sets.extend(self.sets.iter().flat_map(|set| ["--set", *set]));
            let run = |out: &Path, more: &[&str], code: i32| {
                let own = ["--backend", self.backend, "--out", out.to_str().expect("a path")];
                let done = output(&mut comminute("run", &scene, &[&sets, &own[..], more].concat())).expect("no hang");
                assert_eq!(done.status.code(), Some(code), "{}: {}", self.name, String::from_utf8_lossy(&done.stderr));
            };
            run(&base.whole, &[], 0);
            run(&base.stopped, &["--stop-after", &self.stops[0].to_string()], 130);
            let again =
                output(&mut comminute("resume", &base.stopped, &["--stop-after", &self.stops[1].to_string()])).expect("no hang");
            assert_eq!(again.status.code(), Some(130), "{}: {}", self.name, String::from_utf8_lossy(&again.stderr));
            base
        })
    }

    /// The newest checkpoint of the stopped run.
    fn checkpoint(&self) -> Vec<u8> {
        fs::read(self.base().stopped.join("checkpoint.bin")).expect("a checkpoint")
    }

    /// A kind by chance, another one than this, that needs no device.
    fn other(&self, rng: &mut ChaCha8Rng) -> &'static Kind {
        let others: Vec<&Kind> = KINDS.iter().filter(|kind| kind.name != self.name && kind.backend == "cpu").collect();
        others.choose(rng).expect("others")
    }
}

/// First line and content of a checkpoint.
fn opened(bytes: &[u8]) -> (&[u8], Vec<u8>) {
    let line = bytes.iter().position(|b| *b == b'\n').expect("a first line") + 1;
    let length: [u8; 8] = bytes[line + HEAD[2]..line + HEAD[3]].try_into().expect("a length");
    let content = lz4_flex::block::decompress(&bytes[line + HEAD[4]..], u64::from_le_bytes(length) as usize).expect("a content");
    (&bytes[..line], content)
}

/// A checkpoint with right hashes for the scene in `dir`.
fn closed(line: &[u8], content: &[u8], dir: &Path) -> Vec<u8> {
    let compressed = lz4_flex::block::compress(content);
    let mut rest = Sha256::digest(fs::read(dir.join("scene.resolved.toml")).expect("scene")).to_vec();
    rest.extend((content.len() as u64).to_le_bytes());
    rest.extend((compressed.len() as u64).to_le_bytes());
    rest.extend(compressed);
    [line, &Sha256::digest(&rest)[..], &rest].concat()
}

/// A copy of a folder, as far as files stand in it and in its folder of snapshots.
fn copy(from: &Path, to: &Path) {
    let _ = fs::remove_dir_all(to);
    fs::create_dir_all(to).expect("folder");
    for entry in fs::read_dir(from).expect("folder") {
        let (path, name) = entry.map(|e| (e.path(), e.file_name())).expect("entry");
        if path.is_dir() { copy(&path, &to.join(name)) } else { fs::copy(&path, to.join(name)).map(|_| ()).expect("copied") }
    }
}

/// A place in the content: anywhere, or among the first or last, where the single values stand between the long lists.
fn place(content: &[u8], rng: &mut ChaCha8Rng) -> usize {
    let (n, few) = (content.len(), content.len().min(600));
    match rng.random_range(0..4) {
        0 => rng.random_range(0..few),
        1 => n - 1 - rng.random_range(0..few),
        _ => rng.random_range(0..n),
    }
}

/// Numbers that computations do not bear.
const NUMBERS: [f64; 16] =
    [0.0, -0.0, 1.0, -1.0, 0.5, 1e-310, 5e-324, 1e-150, 1e30, -1e30, 1e150, 1e300, -1e300, f64::MAX, f64::INFINITY, f64::NAN];
/// Lengths, indices and counters that no list bears, as postcard writes them.
const LENGTHS: [u64; 10] = [0, 1, 2, 127, 255, 65_535, 0xffff_fffe, 0xffff_ffff, 1 << 62, u64::MAX];

/// `n` as postcard writes it.
fn varint(mut n: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    while n > 127 {
        bytes.push(n as u8 | 128);
        n >>= 7;
    }
    bytes.push(n as u8);
    bytes
}

/// Changes the content of a checkpoint in the way `how`.
fn forge(how: &str, content: &mut Vec<u8>, kind: &Kind, rng: &mut ChaCha8Rng) {
    let at = place(content, rng);
    let end = (at + 8).min(content.len());
    match how {
        "bits" => (0..rng.random_range(1..4)).for_each(|_| {
            let at = place(content, rng);
            content[at] ^= 1 << rng.random_range(0..8);
        }),
        "number" => {
            let number = NUMBERS.choose(rng).expect("some").to_le_bytes();
            content[at..end].copy_from_slice(&number[..end - at]);
        }
        "length" => {
            let was = content[at..].iter().position(|b| *b < 128).map_or(content.len(), |k| at + k + 1).min(at + 10);
            content.splice(at..was, varint(*LENGTHS.choose(rng).expect("some")));
        }
        "words exchanged" => {
            let other = place(content, rng).min(content.len().saturating_sub(8));
            if end - at == 8 && other.abs_diff(at) >= 8 {
                (0..8).for_each(|k| content.swap(at + k, other + k));
            }
        }
        "bytes lost" => drop(content.drain(at..(at + rng.random_range(1..17)).min(content.len()))),
        "bytes added" => {
            let more: Vec<u8> = (0..rng.random_range(1..17)).map(|_| rng.next_u32() as u8).collect();
            content.splice(at..at, more);
        }
        _ => {
            let theirs = opened(&kind.other(rng).checkpoint()).1;
            let from = place(&theirs, rng);
            let piece = &theirs[from..(from + rng.random_range(1..200)).min(theirs.len())];
            let end = (at + piece.len()).min(content.len());
            content[at..end].copy_from_slice(&piece[..end - at]);
        }
    }
}

/// Damages the newest checkpoint of `dir` in the way `how`.
fn damage(how: &str, dir: &Path, kind: &Kind, rng: &mut ChaCha8Rng) {
    let (path, scene) = (dir.join("checkpoint.bin"), dir.join("scene.resolved.toml"));
    let mut bytes = fs::read(&path).expect("a checkpoint");
    match how {
        "bits" => (0..rng.random_range(1..9)).for_each(|_| {
            let at = rng.random_range(0..bytes.len());
            bytes[at] ^= 1 << rng.random_range(0..8);
        }),
        "cut" => bytes.truncate(rng.random_range(0..bytes.len())),
        "longer" => bytes.extend((0..rng.random_range(1..5000)).map(|_| rng.next_u32() as u8)),
        "zeros" => {
            let page = rng.random_range(0..bytes.len()) / 4096 * 4096;
            let end = (page + 4096).min(bytes.len());
            bytes[page..end].fill(0);
        }
        "of another run" => bytes = kind.other(rng).checkpoint(),
        _ => {
            let mut text = fs::read(&scene).expect("scene");
            let digits: Vec<usize> = (0..text.len()).filter(|k| text[*k].is_ascii_digit()).collect();
            let at = *digits.choose(rng).expect("a digit");
            text[at] = if text[at] == b'9' { b'1' } else { text[at] + 1 };
            fs::write(scene, text).expect("changed");
        }
    }
    fs::write(path, bytes).expect("damaged");
}

/// What a call of `resume` came to, and what it said.
fn outcome(out: Option<Output>) -> (Outcome, String) {
    let Some(out) = out else { return (Outcome::Hang, String::new()) };
    let said = String::from_utf8_lossy(&out.stderr).into_owned();
    let outcome = match out.status.code() {
        _ if said.contains("panicked at") || out.status.signal().is_some() => Outcome::Panic,
        Some(0 | 130) if said.contains("goes on from the checkpoint before it") => Outcome::Recovered,
        Some(0 | 130) => Outcome::WentOn,
        Some(1) => Outcome::Failed,
        Some(2) => Outcome::Refused,
        Some(3) => Outcome::Watchdog,
        _ => Outcome::Panic,
    };
    (outcome, said)
}

/// All files of a run but what clocks say.
fn files(dir: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(dir).expect("folder") {
        let path = entry.expect("entry").path();
        if path.is_file() && path.file_name().is_some_and(|name| name != "summary.json") {
            found.insert(path.display().to_string().replace(&dir.display().to_string(), ""), fs::read(&path).expect("file"));
        }
    }
    found
}

/// One damaged checkpoint. With the one before it the run goes on from there and ends with the bytes of the whole run (where `to_end`); without it, or with
/// another scene, it is refused.
fn damaged(kind: &Kind, how: &str, dir: &Path, to_end: bool, rng: &mut ChaCha8Rng) -> (Outcome, String) {
    let base = kind.base();
    copy(&base.stopped, dir);
    let alone = rng.random_bool(0.3);
    if alone {
        fs::remove_file(dir.join("checkpoint.previous.bin")).expect("removed");
    }
    damage(how, dir, kind, rng);
    let before = files(dir);
    let stop = (kind.stops[1] + 1).to_string();
    let stop: &[&str] = if to_end { &[] } else { &["--stop-after", &stop] };
    let (outcome, said) = outcome(output(&mut comminute("resume", dir, stop)));
    let refused = alone || how == "scene changed";
    let expected = if refused { Outcome::Refused } else { Outcome::Recovered };
    // damage of a page of zeros that was one is none
    if files(dir) != before || outcome != Outcome::WentOn || how != "zeros" {
        assert_eq!(outcome, expected, "{}, {how}: {said}", kind.name);
    }
    if outcome == Outcome::Refused {
        assert!(files(dir) == before, "{}, {how}: a refused run has changed something", kind.name);
    } else if to_end {
        assert!(files(dir) == files(&base.whole), "{}, {how}: another end than that of the whole run", kind.name);
    }
    (outcome, said)
}

/// One forged checkpoint, alone or with a whole one before it.
fn forged(kind: &Kind, how: &str, dir: &Path, rng: &mut ChaCha8Rng) -> (Outcome, String) {
    copy(&kind.base().stopped, dir);
    if rng.random_bool(0.8) {
        fs::remove_file(dir.join("checkpoint.previous.bin")).expect("removed");
    }
    let bytes = kind.checkpoint();
    let (line, mut content) = opened(&bytes);
    forge(how, &mut content, kind, rng);
    fs::write(dir.join("checkpoint.bin"), closed(line, &content, dir)).expect("forged");
    let stop = (kind.stops[1] + MORE).to_string();
    outcome(output(&mut comminute("resume", dir, &["--stop-after", &stop])))
}

/// A checkpoint that states a length of a table which falls into a row is passed over: the table stays as it is.
#[test]
fn a_table_is_not_cut_inside_of_a_row() {
    let kind = &KINDS[6];
    let dir = folder().join("row");
    copy(&kind.base().stopped, &dir);
    let bytes = kind.checkpoint();
    let (line, mut content) = opened(&bytes);
    let table = fs::read(dir.join("history.csv")).expect("a table");
    let (whole, shorter) = (varint(table.len() as u64), varint(table.len() as u64 - 1));
    let places = content.windows(whole.len()).filter(|w| *w == whole).count();
    assert!(whole.len() == shorter.len() && places == 1, "{places} places hold {} bytes", table.len());
    let at = content.windows(whole.len()).position(|w| w == whole).expect("the length");
    content[at..at + whole.len()].copy_from_slice(&shorter);
    fs::write(dir.join("checkpoint.bin"), closed(line, &content, &dir)).expect("forged");
    let stop = (kind.stops[0] + 1).to_string();
    let (outcome, said) = outcome(output(&mut comminute("resume", &dir, &["--stop-after", &stop])));
    assert_eq!(outcome, Outcome::Recovered, "{said}");
    assert!(said.contains("history.csv would be cut inside of a row"), "{said}");
}

/// Numbers of outcomes by kind of run and way of damage.
type Counts = BTreeMap<(usize, &'static str, &'static str), BTreeMap<Outcome, u64>>;

/// So many damaged and forged checkpoints of each way for a kind of run; `each` hears of every one. Panics and hangs are told with the seed that makes them
/// again.
fn try_all(kind: &Kind, seed: u64, number: u64, each: &mut dyn FnMut(&'static str, &'static str, Outcome)) -> Vec<String> {
    let dir = folder().join(format!("{}_trial", kind.number()));
    let mut wrong = Vec::new();
    let mut tell = |class: &'static str, how: &'static str, seed: u64, (outcome, said): (Outcome, String)| {
        each(class, how, outcome);
        if matches!(outcome, Outcome::Panic | Outcome::Hang) {
            wrong.push(format!("{}, {class}, {how}, seed {seed}: {outcome:?} {said}", kind.name));
        }
    };
    for k in 0..number {
        for (w, how) in DAMAGES.into_iter().enumerate() {
            let own = seed + 100 * k + w as u64;
            tell("damaged", how, own, damaged(kind, how, &dir, k == 0, &mut ChaCha8Rng::seed_from_u64(own)));
        }
        for (w, how) in FORGERIES.into_iter().enumerate() {
            let own = seed + 100 * k + 50 + w as u64;
            tell("forged", how, own, forged(kind, how, &dir, &mut ChaCha8Rng::seed_from_u64(own)));
        }
    }
    wrong
}

/// A few of every way, on a run of every kind.
fn some(kind: usize) {
    let wrong = try_all(&KINDS[kind], 1, 1, &mut |_, _, _| {});
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

macro_rules! kinds {
    ($($name:ident = $kind:literal;)*) => {
        $(#[test]
        fn $name() {
            some($kind);
        })*
    };
}

kinds! {
    preparation_with_a_stated_friction = 0;
    preparation_on_the_way = 1;
    oedometer_with_crushing = 2;
    fines_as_points_in_an_oedometer = 3;
    triaxial_test = 4;
    isotropic_compression = 5;
    free_scene = 6;
    continuum = 7;
    continuum_with_apic = 8;
    mixture_with_rigid_bodies = 9;
    mixture_with_fines = 10;
    growing_continuum = 11;
}

#[cfg(feature = "gpu")]
#[test]
fn continuum_on_a_graphics_device() {
    if adapter::adapter("damaged checkpoints of a graphics device") {
        some(12);
    }
}

/// Value of an environment variable, or else `usual`.
fn setting(name: &str, usual: u64) -> u64 {
    std::env::var(name).ok().map_or(usual, |text| text.parse().expect(name))
}

/// More than 10 000 over all kinds, with a table of what came of them. `COMMINUTE_DAMAGED` is the number of each way for each kind of run, `COMMINUTE_DAMAGED_SEED`
/// the seed, `COMMINUTE_DAMAGED_KIND` one kind alone, `COMMINUTE_DAMAGED_TABLE` a file for the table.
#[test]
#[ignore = "takes an hour"]
fn ten_thousand_checkpoints() {
    let (number, seed, only) =
        (setting("COMMINUTE_DAMAGED", 70), setting("COMMINUTE_DAMAGED_SEED", 1000), setting("COMMINUTE_DAMAGED_KIND", u64::MAX));
    #[cfg(feature = "gpu")]
    let device = adapter::adapter("damaged checkpoints of a graphics device");
    #[cfg(not(feature = "gpu"))]
    let device = false;
    let wanted = |kind: &&Kind| (only == u64::MAX || only == kind.number() as u64) && (device || kind.backend == "cpu");
    let kinds: Vec<&Kind> = KINDS.iter().filter(wanted).collect();
    let mut counts = Counts::new();
    let mut wrong = Vec::new();
    for kind in kinds {
        let mut note =
            |class, how, outcome| *counts.entry((kind.number(), class, how)).or_default().entry(outcome).or_default() += 1;
        let found = try_all(kind, seed + 1_000_000 * kind.number() as u64, number, &mut note);
        found.iter().for_each(|wrong| println!("{wrong}"));
        wrong.extend(found);
    }
    let mut table = format!("run,checkpoint,change,number,{}\n", OUTCOMES.map(|(_, name)| name).join(","));
    for ((kind, class, how), of) in &counts {
        let numbers = OUTCOMES.map(|(outcome, _)| of.get(&outcome).copied().unwrap_or(0));
        let cells = numbers.map(|n| n.to_string()).join(",");
        let _ = writeln!(table, "{},{class},{how},{},{cells}", KINDS[*kind].name, numbers.iter().sum::<u64>());
    }
    print!("{table}");
    if let Ok(path) = std::env::var("COMMINUTE_DAMAGED_TABLE") {
        fs::write(path, &table).expect("the table");
    }
    assert!(wrong.is_empty(), "{} panics and hangs", wrong.len());
}
