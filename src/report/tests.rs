//! The page of a run that is made up: its numbers, that it loads nothing, what it refuses.

use super::*;
use serde_json::Value;

/// A folder with a run of two records, a breakage and no snapshots.
fn run(seed: u64) -> tempfile::TempDir {
    let dir = tempfile::tempdir().expect("folder");
    let write = |name: &str, text: &str| std::fs::write(dir.path().join(name), text).expect("written");
    write("scene.resolved.toml", "kind = \"oedometer\"\nname = \"</script><b>\"\n");
    write("history.csv", "step,stage,sigma_v_kPa,porosity\n1,load,10,0.42\n2,load,1000,0.3333333333333333\n");
    write("breakage.csv", "event,lineage,force_N\n1,00ff,2.398565e-3\n");
    let summary =
        format!("{{\"scene\":\"a</script><b>\",\"seed\":{seed},\"energy_rises\":3,\"figure_seconds\":0,\"warnings\":[\"w <i>\"]}}");
    write("summary.json", &summary);
    dir
}

/// What the page holds as data.
fn data(page: &Path) -> Value {
    let text = std::fs::read_to_string(page).expect("page");
    let start = text.split("id=\"data\">").nth(1).expect("data");
    serde_json::from_str(start.split("</script>").next().expect("end")).expect("json")
}

#[test]
fn a_page_has_the_numbers_of_the_tables_and_loads_nothing() {
    let dir = run(1);
    let written = write_run(dir.path()).expect("written");
    let text = std::fs::read_to_string(&written.path).expect("page");
    assert!(text.starts_with(page::HEAD) && text.len() == written.bytes && written.bytes < 2_000_000);
    // the browser itself refuses whatever is not in the page
    assert!(text.contains("default-src 'none'"));
    for load in ["src=\"http", "href=\"http", "src=\"//", "@import", "<link", "<img"] {
        assert!(!text.split("id=\"data\">").next().expect("head").contains(load), "{load}");
    }
    let data = data(&written.path);
    let series = &data["charts"][0]["series"][0];
    assert_eq!(series["x"], serde_json::json!([0.01, 1.0]));
    assert_eq!(series["y"], serde_json::json!([0.42, 0.3333333333333333]));
    let run = &data["runs"][0];
    assert_eq!(run["logs"][0]["rows"][0], serde_json::json!([1.0, "00ff", 2.398565e-3]));
    let warnings = run["warnings"].as_array().expect("warnings");
    assert_eq!(warnings[0], "w <i>");
    assert!(warnings[1].as_str().expect("text").contains("after 3 breakages"), "as the command says it");
    assert!(run["note"].is_null());
    // texts of a scene stay texts
    assert!(!text.contains("</script><b>"));
}

#[test]
fn an_unfinished_run_is_shown_and_said() {
    let dir = run(1);
    std::fs::remove_file(dir.path().join("summary.json")).expect("removed");
    let written = write_run(dir.path()).expect("written");
    assert!(written.notes[0].contains("not finished and has no checkpoint"), "{:?}", written.notes);
    std::fs::write(dir.path().join("checkpoint.bin"), "").expect("written");
    let written = write_run(dir.path()).expect("a report is overwritten");
    assert!(written.notes[0].contains("comminute resume goes on"));
    assert_eq!(data(&written.path)["charts"][0]["series"][0]["x"][1], 1.0);
}

#[test]
fn several_runs_stand_in_one_page() {
    let (a, b) = (run(1), run(2));
    let out = a.path().join("both.html");
    write(&[a.path().into(), b.path().into()], &out, &Options::default()).expect("written");
    let data = data(&out);
    assert_eq!(data["runs"].as_array().map(Vec::len), Some(2));
    let kinds: Vec<_> = data["charts"][0]["series"].as_array().expect("series").iter().map(|s| s["kind"].clone()).collect();
    assert_eq!(kinds, ["line", "line", "band"]);
    assert!(data["runs"][1]["files"]["scene"].as_str().expect("link").starts_with("../"));
}

#[test]
fn a_run_without_snapshots_shows_its_figures_as_they_were_drawn() {
    let dir = run(1);
    std::fs::create_dir(dir.path().join("figures")).expect("folder");
    let drawn = |name: &str, text: &str| std::fs::write(dir.path().join("figures").join(name), text).expect("written");
    drawn("section.svg", "<svg/>");
    drawn("compression.svg", "<svg/>");
    let written = write_run(dir.path()).expect("written");
    let pictures = data(&written.path)["runs"][0]["pictures"].clone();
    let want = serde_json::json!([{ "name": "section", "title": "Section", "address": "data:image/svg+xml;base64,PHN2Zy8+" }]);
    assert_eq!(pictures, want, "charts show the others");
}

#[test]
fn what_is_damaged_or_of_others_is_named() {
    let dir = run(1);
    let says = |out: &Path| write(&[dir.path().into()], out, &Options::default()).expect_err("refused").to_string();
    let other = dir.path().join("notes.html");
    std::fs::write(&other, "mine").expect("written");
    assert!(says(&other).contains("notes.html: is no report"));
    assert_eq!(std::fs::read_to_string(&other).expect("kept"), "mine");
    assert!(says(dir.path()).contains("is a folder"));
    assert!(write(&[dir.path().into()], &other, &Options { force: true, ..Options::default() }).is_ok());
    let out = dir.path().join("new.html");
    std::fs::write(dir.path().join("snapshots.pvd"), "<DataSet timestep=\"0\" file=\"snapshots/step_0.vtp\"/>").expect("written");
    std::fs::create_dir(dir.path().join("snapshots")).expect("folder");
    std::fs::write(dir.path().join("snapshots/step_0.vtp"), "<VTKFile>").expect("written");
    assert!(says(&out).contains("step_0.vtp: is no whole snapshot"));
    std::fs::write(dir.path().join("summary.json"), "{").expect("written");
    assert!(says(&out).contains("summary.json"));
    std::fs::write(dir.path().join("history.csv"), "sigma_v_kPa,porosity\n1,x\n").expect("written");
    std::fs::write(dir.path().join("summary.json"), "{}").expect("written");
    assert!(says(&out).contains("history.csv: line 2, column `porosity`"));
    assert!(!out.exists());
}
