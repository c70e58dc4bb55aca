//! Disks and folders that refuse: a limit on the size of files, folders that cannot be written, that vanish or that are files. What a
//! user types, what is said, and what is left for `comminute resume`.

use assert_cmd::cargo::cargo_bin;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

fn scene() -> PathBuf {
    Path::new(ROOT).join("experiments/free/box_settling.toml")
}

/// The arguments of a run of a small free scene without figures.
fn arguments(out: &Path) -> Vec<String> {
    let mut arguments = vec!["run".into(), scene().display().to_string(), "--quiet".into(), "--threads".into(), "1".into()];
    for set in
        ["steps=6000", "records.every=10", "records.tracks=\"all\"", "records.figures=false", "records.checkpoint_seconds=0.05"]
    {
        arguments.extend(["--set".into(), set.to_string()]);
    }
    arguments.extend(["--out".into(), out.display().to_string()]);
    arguments
}

fn call(arguments: &[String]) -> Output {
    Command::new(cargo_bin("comminute")).args(arguments).output().expect("starts")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Files of a folder that a finished run leaves and that have no times in them.
fn records(out: &Path) -> Vec<Vec<u8>> {
    ["history.csv", "tracks.csv", "grains_final.csv"].map(|name| std::fs::read(out.join(name)).expect(name)).to_vec()
}

/// A table reaches the largest size that a file may have: the run ends with that reason instead of being killed, and goes on where
/// it was once there is room.
#[test]
#[cfg(unix)]
fn a_limit_on_the_size_of_files_is_an_error_and_no_end() {
    let dir = tempfile::tempdir().expect("folder");
    let (whole, out) = (dir.path().join("whole"), dir.path().join("limited"));
    assert!(call(&arguments(&whole)).status.success());
    let largest = std::fs::metadata(whole.join("tracks.csv")).expect("tracks").len();
    assert!(largest > 1 << 20, "{largest}");
    let program = cargo_bin("comminute").display().to_string();
    let quoted: Vec<String> = std::iter::once(program).chain(arguments(&out)).map(|a| format!("'{a}'")).collect();
    // blocks of 512 bytes in sh
    let script = format!("ulimit -f {}; exec {}", largest / 2 / 512, quoted.join(" "));
    let limited = Command::new("sh").args(["-c", &script]).output().expect("starts");
    let told = said(&limited);
    assert_eq!(limited.status.code(), Some(1), "no signal ends the run: {told}");
    assert!(told.contains("cannot write") && told.contains("tracks.csv"), "{told}");
    let resumed = call(&["resume".into(), out.display().to_string(), "--quiet".into()]);
    assert!(resumed.status.success(), "{}", said(&resumed));
    assert!(records(&out) == records(&whole), "the same bytes as without the limit");
}

/// A file stands where the folder is to be, or in the way to it.
#[test]
fn a_file_in_place_of_the_folder_is_told() {
    let dir = tempfile::tempdir().expect("folder");
    let file = dir.path().join("file");
    std::fs::write(&file, "of somebody else").expect("written");
    for out in [file.clone(), file.join("run")] {
        let refused = call(&arguments(&out));
        let told = said(&refused);
        assert!(matches!(refused.status.code(), Some(1 | 2)), "{told}");
        assert!(told.starts_with("error: ") && told.contains("file"), "{told}");
        assert_eq!(std::fs::read_to_string(&file).expect("kept"), "of somebody else");
    }
}

/// A folder stands where a file is to be written at the end: what is there stays, and the rest is done once it is gone.
#[test]
fn a_file_that_cannot_be_written_is_told_and_the_rest_stays() {
    let dir = tempfile::tempdir().expect("folder");
    let (whole, out) = (dir.path().join("whole"), dir.path().join("run"));
    assert!(call(&arguments(&whole)).status.success());
    let mut first = arguments(&out);
    first.extend(["--stop-after".into(), "3000".into()]);
    assert_eq!(call(&first).status.code(), Some(130));
    let resume = ["resume".into(), out.display().to_string(), "--quiet".into()];
    let summary = out.join("summary.tmp");
    std::fs::create_dir(&summary).expect("made");
    let refused = call(&resume);
    let told = said(&refused);
    assert_eq!(refused.status.code(), Some(1), "{told}");
    assert!(told.contains("cannot write") && told.contains("summary"), "{told}");
    std::fs::remove_dir(&summary).expect("removed");
    let resumed = call(&resume);
    assert!(resumed.status.success(), "{}", said(&resumed));
    assert!(records(&out) == records(&whole), "the same bytes as of a run that was not held up");
}

/// What other programs are to read goes to a device that is always full.
#[test]
#[cfg(target_os = "linux")]
fn a_full_device_is_told() {
    let full = std::fs::File::options().write(true).open("/dev/full").expect("a device");
    let output =
        Command::new(cargo_bin("comminute")).arg("check").arg(scene()).arg("--json").stdout(full).output().expect("starts");
    let told = said(&output);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains("standard output: cannot write: No space left on device"), "{told}");
}

/// A small disk of its own, in memory; it is taken away when this is dropped.
#[cfg(target_os = "linux")]
struct Disk(tempfile::TempDir);

#[cfg(target_os = "linux")]
impl Disk {
    /// `None`, said loudly, where this user may not mount.
    fn mounted(megabytes: u32) -> Option<Disk> {
        let dir = tempfile::tempdir().expect("folder");
        let size = format!("size={megabytes}m");
        let mounted = Command::new("mount").args(["-t", "tmpfs", "-o", &size, "tmpfs"]).arg(dir.path()).output();
        if mounted.is_ok_and(|output| output.status.success()) {
            return Some(Disk(dir));
        }
        eprintln!("SKIPPED: a full disk, as this user may not mount one");
        None
    }

    /// Fills the disk with a file until `left` bytes are free.
    fn fill(&self, left: u64) -> PathBuf {
        let filler = self.0.path().join("filler");
        let mut file = std::fs::File::create(&filler).expect("a file");
        while std::io::Write::write_all(&mut file, &[0; 1 << 16]).is_ok() {}
        let length = file.metadata().expect("a file").len();
        file.set_len(length - left).expect("shorter");
        filler
    }
}

#[cfg(target_os = "linux")]
impl Drop for Disk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(self.0.path()).status();
    }
}

/// Others fill the disk while a run is on it: the run ends with that reason, what it has recorded stays, and it goes on to the same bytes once there is room.
#[test]
#[cfg(target_os = "linux")]
fn a_disk_that_is_full_is_told_and_the_run_goes_on_when_there_is_room() {
    let Some(disk) = Disk::mounted(24) else { return };
    let dir = tempfile::tempdir().expect("folder");
    let (whole, out) = (dir.path().join("whole"), disk.0.path().join("run"));
    assert!(call(&arguments(&whole)).status.success());
    let mut first = arguments(&out);
    first.extend(["--stop-after".into(), "1000".into()]);
    let stopped = call(&first);
    assert_eq!(stopped.status.code(), Some(130), "{}", said(&stopped));
    let recorded = std::fs::read(out.join("tracks.csv")).expect("tracks");
    let filler = disk.fill(1 << 20);
    let resume = ["resume".into(), out.display().to_string(), "--quiet".into()];
    let full = call(&resume);
    assert_eq!(full.status.code(), Some(1), "{}", said(&full));
    assert!(said(&full).contains("cannot write: No space left on device"), "{}", said(&full));
    assert!(std::fs::read(out.join("tracks.csv")).expect("tracks").starts_with(&recorded), "what was recorded stays");
    std::fs::remove_file(filler).expect("removed");
    let resumed = call(&resume);
    assert!(resumed.status.success(), "{}", said(&resumed));
    assert!(records(&out) == records(&whole), "the same bytes as on a disk with room");
}

/// The folder is taken away while the run goes on.
#[test]
#[cfg(unix)]
fn a_folder_that_vanishes_ends_the_run_with_its_name() {
    let dir = tempfile::tempdir().expect("folder");
    let out = dir.path().join("run");
    let mut arguments = arguments(&out);
    for (short, long) in [("steps=6000", "steps=100000000"), ("records.every=10", "records.every=1000000")] {
        let at = arguments.iter().position(|a| a == short).expect(short);
        arguments[at] = long.into();
    }
    let mut child =
        Command::new(cargo_bin("comminute")).args(&arguments).stderr(std::process::Stdio::piped()).spawn().expect("starts");
    // once it has a checkpoint it is under way
    for _ in 0..3000 {
        if out.join("checkpoint.bin").exists() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    std::fs::rename(&out, dir.path().join("elsewhere")).expect("moved");
    let mut told = String::new();
    std::io::Read::read_to_string(&mut child.stderr.take().expect("piped"), &mut told).expect("text");
    let status = child.wait().expect("ends");
    assert_eq!(status.code(), Some(1), "{told}");
    assert!(told.contains("cannot write") && told.contains("checkpoint"), "{told}");
    let moved = ["resume".into(), dir.path().join("elsewhere").display().to_string(), "--quiet".into()];
    let again = call(&[&moved[..], &["--stop-after".into(), "1".into()]].concat());
    assert_eq!(again.status.code(), Some(130), "what was kept goes on: {}", said(&again));
}

/// More memory and more disk than there is, and more threads than anybody has, are refused with numbers before anything is made.
#[test]
fn what_cannot_fit_is_refused_with_numbers() {
    let dir = tempfile::tempdir().expect("folder");
    let out = dir.path().join("run").display().to_string();
    let continuum = Path::new(ROOT).join("experiments/mpm/oedometer.toml").display().to_string();
    let run = |sets: &[&str]| {
        let mut arguments = vec!["run".to_string(), continuum.clone(), "--out".into(), out.clone()];
        sets.iter().for_each(|set| arguments.extend(["--set".into(), (*set).to_string()]));
        let output = call(&arguments);
        (output.status.code(), said(&output))
    };
    // 96 million points, which a large machine holds
    if comminute::machine::free_memory().is_some_and(|free| free < 60_000_000_000) {
        let (code, told) = run(&["grid.cell_mm=0.2"]);
        assert_eq!(code, Some(2), "{told}");
        assert!(told.contains("grid.cell_mm") && told.contains("million points") && told.contains("are free"), "{told}");
    }
    if comminute::machine::free_disk(dir.path()).is_some_and(|free| free < 1_000_000_000_000) {
        let (code, told) = run(&["records.frames=10000", "grid.cell_mm=1"]);
        assert!(code == Some(2) && told.contains("records.frames") && told.contains("are free"), "{told}");
    }
    assert!(!Path::new(&out).exists());
    let mut many = arguments(Path::new(&out));
    many.extend(["--threads".into(), "60000".into()]);
    let at = many.iter().position(|a| a == "--threads").expect("threads");
    many.drain(at..at + 2);
    let told = said(&call(&many));
    assert!(told.contains("60000 is not in 1..=1024"), "{told}");
}

/// Whatever a scene asks for, `check` answers without making it.
#[test]
fn check_makes_nothing_of_what_it_estimates() {
    for (scene, sets, says) in [
        ("mpm/oedometer.toml", "grid.cell_mm=0.5", "memory"),
        ("mpm/oedometer.toml", "grid.cell_mm=1e-9", "at most 200000000 are made"),
        ("mpm/oedometer_cylinder.toml", "grid.cell_mm=0.00001", "at most 200000000 are made"),
        ("petroleum_coke/h-c-2.toml", "specimen.grains=100000000", "memory"),
        ("petroleum_coke/h-c-2.toml", "specimen.grains=1000000000", "must be >= 1 and <= 100000000"),
        ("mixture/triaxial_20_50kPa.toml", "coarse.diameter_mm=[0.0001, 0.0002]", "at most 100000000 are made"),
        ("platen/silica.toml", "batch.grains=1000000000", "must be >= 1 and <= 1000000"),
        ("mpm/oedometer.toml", "records.rows=1000000000000", "must be >= 1 and <= 100000"),
    ] {
        let path = Path::new(ROOT).join("experiments").join(scene).display().to_string();
        let output = call(&["check".into(), path, "--set".into(), sets.into()]);
        assert!(said(&output).contains(says), "{scene} {sets}: {}", said(&output));
    }
}

/// Links that stand in a run's folder under the names of files which are still to be written lead to no other place: each is refused by its name, and once
/// it is gone the run goes on.
#[test]
#[cfg(unix)]
fn no_file_is_written_through_a_link() {
    let dir = tempfile::tempdir().expect("folder");
    let (whole, out, victim) = (dir.path().join("whole"), dir.path().join("run"), dir.path().join("victim"));
    let more = ["--set", "records.contacts=true", "--set", "steps=600"].map(String::from);
    assert!(call(&[&arguments(&whole)[..], &more].concat()).status.success());
    let first = [&arguments(&out)[..], &more, &["--stop-after".to_string(), "300".into()]].concat();
    assert_eq!(call(&first).status.code(), Some(130));
    let of = |folder: &Path| -> Vec<String> {
        let names = folder.read_dir().expect("folder").map(|e| e.expect("entry").file_name().into_string().expect("a name"));
        names.collect()
    };
    let already = of(&out.join("snapshots"));
    let snapshots = of(&whole.join("snapshots")).into_iter().filter(|name| !already.contains(name));
    let mut names: Vec<String> = snapshots.map(|name| format!("snapshots/{name}")).collect();
    assert!(names.len() >= 3, "contacts, grains and walls: {names:?}");
    names.push("grains_final.csv".into());
    let resume = ["resume".into(), out.display().to_string(), "--quiet".into()];
    std::fs::write(&victim, "of somebody else").expect("written");
    for name in names {
        let link = out.join(&name);
        // a call that was refused later may have written it
        let _ = std::fs::remove_file(&link);
        std::os::unix::fs::symlink(&victim, &link).expect("link");
        let refused = call(&resume);
        let told = said(&refused);
        assert_eq!(refused.status.code(), Some(1), "{name}: {told}");
        assert!(told.contains(&name) && told.contains("symbolic link"), "{name}: {told}");
        assert_eq!(std::fs::read_to_string(&victim).expect("kept"), "of somebody else");
        std::fs::remove_file(&link).expect("removed");
    }
    // nor through a folder
    let (elsewhere, snapshots) = (dir.path().join("elsewhere"), out.join("snapshots"));
    std::fs::rename(&snapshots, &elsewhere).expect("moved");
    std::os::unix::fs::symlink(&elsewhere, &snapshots).expect("link");
    assert!(said(&call(&resume)).contains("symbolic link"));
    std::fs::remove_file(&snapshots).expect("removed");
    std::fs::rename(&elsewhere, &snapshots).expect("back");
    let resumed = call(&resume);
    assert!(resumed.status.success(), "{}", said(&resumed));
    assert!(records(&out) == records(&whole));
}
