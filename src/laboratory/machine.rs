//! The machine: what it is, what it has left of memory and disk, and how fast it is.

mod pace;

pub use pace::Pace;

use std::path::Path;

/// Memory that programs may still take, bytes: what the system calls available, and no more than the control group of this process
/// leaves. `None` where the system does not say.
pub fn free_memory() -> Option<u64> {
    if !sysinfo::IS_SUPPORTED_SYSTEM {
        return None;
    }
    let mut system = sysinfo::System::new();
    system.refresh_memory();
    let available = system.available_memory();
    let group = system.cgroup_limits().map_or(u64::MAX, |group| group.free_memory);
    Some(available.min(group)).filter(|free| *free > 0)
}

/// Space that an ordinary user may still fill on the disk of `path`, bytes. The path need not exist: the nearest folder above that
/// does counts. `None` where the system does not say.
pub fn free_disk(path: &Path) -> Option<u64> {
    let here = path.ancestors().map(|p| if p.as_os_str().is_empty() { Path::new(".") } else { p });
    free_here(here.into_iter().find(|p| p.exists())?)
}

#[cfg(unix)]
#[allow(clippy::unnecessary_cast)] // the types differ between systems
fn free_here(path: &Path) -> Option<u64> {
    let disk = nix::sys::statvfs::statvfs(path).ok()?;
    (disk.blocks_available() as u64).checked_mul(disk.fragment_size() as u64)
}

/// The most memory that this process has had at any time, bytes; `None` where the system does not say.
#[cfg(unix)]
pub fn peak_memory() -> Option<f64> {
    use nix::sys::resource::{UsageWho, getrusage};
    // Linux counts in kB, macOS in bytes
    let unit = if cfg!(target_os = "macos") { 1.0 } else { 1024.0 };
    getrusage(UsageWho::RUSAGE_SELF).ok().map(|used| unit * used.max_rss() as f64)
}

/// The most memory that this process has had at any time, bytes; `None` where the system does not say.
#[cfg(not(unix))]
pub fn peak_memory() -> Option<f64> {
    None
}

#[cfg(not(unix))]
fn free_here(_: &Path) -> Option<u64> {
    None
}

/// Name of the processor where the system says it (Linux), else its architecture.
pub fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find_map(|l| l.strip_prefix("model name")).and_then(|l| l.split_once(':'));
    name.map_or_else(|| std::env::consts::ARCH.to_string(), |(_, name)| name.trim().to_string())
}

/// A size in bytes as text with three digits: `9.60 GB`, `6.1 MB`.
pub fn size(bytes: f64) -> String {
    let (value, unit) = match bytes {
        b if b >= 1e12 => (1e-12 * b, "TB"),
        b if b >= 1e9 => (1e-9 * b, "GB"),
        b => (1e-6 * b, "MB"),
    };
    let digits = if value < 10.0 { 2 } else { usize::from(value < 100.0) };
    format!("{value:.digits$} {unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_three_digits() {
        assert_eq!(size(9.6e9), "9.60 GB");
        assert_eq!(size(61.23e6), "61.2 MB");
        assert_eq!(size(1.5e15), "1500 TB");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn this_machine_says_what_it_has() {
        assert!(free_memory().is_some_and(|free| free > 10 << 20));
        let missing = Path::new("no folder/of this name");
        assert!(free_disk(missing).is_some_and(|free| free > 0), "the folder above counts");
    }
}
