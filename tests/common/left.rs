//! What runs leave, without what depends on the machine or on estimates: files that can be compared byte by byte.
#![allow(dead_code)] // each test binary uses its part

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Entries of tables and summaries that say how long something took or was expected to take, and on what.
pub const OF_THE_MACHINE: [&str; 9] =
    ["second", "predicted_", "peak_memory", "minutes", "bytes_", "threads", "host", "simd", "version"];

/// Whether a name is one of these.
fn of_the_machine(name: &str) -> bool {
    OF_THE_MACHINE.iter().any(|word| name.contains(word))
}

/// JSON without what depends on the machine.
fn plain(value: &mut serde_json::Value) {
    if let Some(object) = value.as_object_mut() {
        object.retain(|key, _| !of_the_machine(key));
        object.values_mut().for_each(plain);
    }
}

/// All files below `dir` by their names: without what depends on the machine, and without logs of runs.
pub fn files(dir: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![dir.to_path_buf()];
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(&folder).expect("a folder").flatten() {
            let path = entry.path();
            if path.is_dir() {
                open.push(path);
                continue;
            }
            let name = path.strip_prefix(dir).expect("inside").display().to_string();
            let mut bytes = fs::read(&path).expect("a file");
            if name.ends_with(".json") {
                let mut value = serde_json::from_slice(&bytes).expect("JSON");
                plain(&mut value);
                bytes = value.to_string().into_bytes();
            } else if name.ends_with("README.md") {
                // of a plan: run times stand in lines and in the last column of a table
                let text = String::from_utf8(bytes).expect("text");
                let kept = text.lines().filter(|line| !line.contains(" min")).map(|line| match line.strip_suffix(" |") {
                    Some(row) if line.matches(" | ").count() > 9 => row.rsplit_once('|').map_or(row, |(rest, _)| rest),
                    _ => line,
                });
                bytes = kept.collect::<Vec<_>>().join("\n").into_bytes();
            } else if ["sweep.csv", "runs.csv", "comparison.csv"].iter().any(|table| name.ends_with(table)) {
                let mut reader = csv::Reader::from_reader(&bytes[..]);
                let kept: Vec<bool> = reader.headers().expect("header").iter().map(|name| !of_the_machine(name)).collect();
                let row = |row: csv::StringRecord| {
                    row.iter().zip(&kept).filter(|(_, k)| **k).map(|(x, _)| x.to_string()).collect::<Vec<_>>()
                };
                bytes = format!("{:?}", reader.records().map(|r| row(r.expect("row"))).collect::<Vec<_>>()).into_bytes();
            } else if name.ends_with(".log") {
                continue;
            }
            found.insert(name, bytes);
        }
    }
    found
}

/// Asserts that two folders hold the same files with the same bytes.
#[track_caller]
pub fn assert_same(a: &BTreeMap<String, Vec<u8>>, b: &BTreeMap<String, Vec<u8>>, what: &str) {
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>(), "{what}");
    for (name, bytes) in a {
        assert!(*bytes == b[name], "{what}: {name} differs");
    }
}
