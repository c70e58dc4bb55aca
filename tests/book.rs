//! The book against the program: links point to files and headings, every page is in the table of contents, scenes are accepted, commands
//! exist, and the pages of keys and columns are what the program says (`COMMINUTE_BOOK=write cargo test --test book` writes both anew).

use assert_cmd::Command;
use comminute::record::dictionary::SHEETS;
use comminute::scene::{KEYS, LIST_TABLES};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::{Component, Path, PathBuf};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// A page: its path below the repository's root, and its text.
struct Page {
    path: PathBuf,
    text: String,
}

/// A fenced block: the words behind the opening fence, the text without the fence's indentation, and the line of the fence.
struct Block {
    words: String,
    text: String,
    line: usize,
}

impl Page {
    fn read(path: PathBuf) -> Page {
        let text = fs::read_to_string(Path::new(ROOT).join(&path)).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        Page { path, text }
    }

    fn name(&self) -> String {
        self.path.display().to_string()
    }

    /// The lines of prose (with the rest blanked, so that numbers stay), and the fenced blocks.
    fn split(&self) -> (Vec<&str>, Vec<Block>) {
        let (mut prose, mut blocks) = (Vec::new(), Vec::new());
        let mut open: Option<(String, usize, Block)> = None;
        for (i, line) in self.text.lines().enumerate() {
            let bare = line.trim_start();
            let indent = line.len() - bare.len();
            let ticks = bare.chars().take_while(|&c| c == '`').count();
            match &mut open {
                None if ticks >= 3 => {
                    let block = Block { words: bare[ticks..].trim().into(), text: String::new(), line: i + 1 };
                    open = Some(("`".repeat(ticks), indent, block));
                    prose.push("");
                }
                None => prose.push(line),
                Some((fence, _, _)) if bare.trim_end() == fence => {
                    blocks.extend(open.take().map(|(_, _, block)| block));
                    prose.push("");
                }
                Some((_, indent, block)) => {
                    block.text += line.get(*indent..).unwrap_or(bare);
                    block.text.push('\n');
                    prose.push("");
                }
            }
        }
        assert!(open.is_none(), "{}: a fence is not closed", self.name());
        (prose, blocks)
    }

    /// Anchors of the headings, by GitHub's rule, those of the same text with -1, -2 and so on.
    fn anchors(&self) -> Vec<String> {
        let mut seen: BTreeMap<String, usize> = BTreeMap::new();
        let heading = |line: &&str| {
            let level = line.chars().take_while(|&c| c == '#').count();
            (1..=6).contains(&level) && line[level..].starts_with(' ')
        };
        let anchor = |line: &str| {
            let slug = slug(line.trim_start_matches('#'));
            let count = seen.entry(slug.clone()).and_modify(|n| *n += 1).or_insert(0);
            if *count == 0 { slug } else { format!("{slug}-{count}") }
        };
        self.split().0.into_iter().filter(heading).map(anchor).collect()
    }
}

/// Lower case without punctuation, blanks as hyphens.
fn slug(heading: &str) -> String {
    let mut text = heading.trim().to_string();
    // of a link in a heading only its text counts
    while let Some((open, close)) = text.find("](").and_then(|at| Some((text[..at].rfind('[')?, at + text[at..].find(')')?))) {
        let shown = text[open + 1..].split("](").next().unwrap_or_default().to_string();
        text.replace_range(open..=close, &shown);
    }
    let kept = |c: char| c.is_alphabetic() || c.is_ascii_digit() || "_- ".contains(c);
    text.chars().filter(|&c| kept(c)).flat_map(char::to_lowercase).map(|c| if c == ' ' { '-' } else { c }).collect()
}

/// Every page whose links are checked.
fn pages() -> Vec<Page> {
    let mut paths: Vec<PathBuf> = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md"].map(PathBuf::from).into();
    let mut folders = vec![PathBuf::from("docs"), PathBuf::from("figures")];
    while let Some(folder) = folders.pop() {
        let everything = folder.starts_with("docs");
        for entry in fs::read_dir(Path::new(ROOT).join(&folder)).expect("a folder").map(|e| e.expect("an entry")) {
            let (path, name) = (folder.join(entry.file_name()), entry.file_name());
            if entry.file_type().expect("a type").is_dir() {
                folders.push(path);
            } else if name == "README.md" || everything && path.extension().is_some_and(|e| e == "md") {
                paths.push(path);
            }
        }
    }
    paths.sort();
    paths.into_iter().map(Page::read).collect()
}

/// Targets of links and pictures in a line: `](target)`, `[label]: target`, `src="target"`, `href="target"`; not in `code`.
fn targets(line: &str) -> Vec<String> {
    let prose: String = line.split('`').step_by(2).collect::<Vec<_>>().join("``");
    let mut found = Vec::new();
    for (start, end) in [("](", ')'), ("src=\"", '"'), ("href=\"", '"')] {
        for rest in prose.split(start).skip(1) {
            let target = rest.split(end).next().unwrap_or_default();
            found.push(target.split(" \"").next().unwrap_or_default().trim_matches(['<', '>']).to_string());
        }
    }
    if let Some((_, target)) = prose.trim_start().strip_prefix('[').and_then(|rest| rest.split_once("]: ")) {
        found.push(target.trim().to_string());
    }
    found
}

/// The path with `..` and `.` resolved; none if it leaves the repository.
fn inside(path: &Path) -> Option<PathBuf> {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::Normal(name) => out.push(name),
            Component::CurDir => {}
            Component::ParentDir if out.pop() => {}
            _ => return None,
        }
    }
    Some(out)
}

fn none(wrong: &[String]) {
    assert!(wrong.is_empty(), "\n{}\n", wrong.join("\n"));
}

#[test]
fn anchors_follow_githubs_rule() {
    assert_eq!(slug("`[material.strength]`, eq. (7): σ_lim"), "materialstrength-eq-7-σ_lim");
    assert_eq!(slug("See [the page](a/b.md#c) of k₀ – again"), "see-the-page-of-k--again");
    assert_eq!(targets("[a](b.md#c), `[no](no)` and ![d](<e f.svg>)"), ["b.md#c", "e f.svg"]);
}

#[test]
fn every_link_points_to_a_file_and_a_heading() {
    let mut wrong = Vec::new();
    for page in pages() {
        for (i, line) in page.split().0.into_iter().enumerate() {
            for target in targets(line) {
                if target.contains("://") || target.starts_with("mailto:") {
                    continue;
                }
                let place = format!("{}:{}: {target}", page.name(), i + 1);
                let (path, anchor) = target.split_once('#').map_or((target.as_str(), None), |(p, a)| (p, Some(a)));
                let path = path.replace("%20", " ");
                let folder = page.path.parent().expect("a folder");
                let Some(file) = (if path.is_empty() { Some(page.path.clone()) } else { inside(&folder.join(path)) }) else {
                    wrong.push(format!("{place}: leaves the repository"));
                    continue;
                };
                if !Path::new(ROOT).join(&file).exists() {
                    wrong.push(format!("{place}: there is no {}", file.display()));
                } else if let Some(anchor) = anchor {
                    let heading = file.extension().is_some_and(|e| e == "md")
                        && Page::read(file.clone()).anchors().iter().any(|a| a == anchor);
                    if !heading {
                        wrong.push(format!("{place}: {} has no such heading", file.display()));
                    }
                }
            }
        }
    }
    none(&wrong);
}

#[test]
fn every_page_is_in_the_table_of_contents() {
    let contents = Page::read("docs/SUMMARY.md".into());
    let listed: Vec<PathBuf> =
        contents.text.lines().flat_map(targets).filter_map(|target| inside(&Path::new("docs").join(target))).collect();
    let missing = |page: &Page| page.path.starts_with("docs") && page.path != contents.path && !listed.contains(&page.path);
    none(&pages().iter().filter(|p| missing(p)).map(|p| format!("{} is not in docs/SUMMARY.md", p.name())).collect::<Vec<_>>());
}

fn comminute(args: &[&str]) -> assert_cmd::assert::Assert {
    Command::cargo_bin("comminute").expect("the binary").current_dir(ROOT).args(args).assert()
}

/// What a run of the program prints.
fn printed(args: &[&str]) -> String {
    String::from_utf8(comminute(args).success().get_output().stdout.clone()).expect("text")
}

/// Paths of all values of a table; entries of a list of tables have that of the list.
fn paths(value: &toml::Value, path: &str, into: &mut Vec<String>) {
    match value {
        toml::Value::Table(table) => table.iter().for_each(|(name, value)| {
            let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
            paths(value, &path, into);
        }),
        toml::Value::Array(list) if list.iter().any(toml::Value::is_table) => {
            list.iter().for_each(|entry| paths(entry, path, into))
        }
        _ => into.push(path.to_string()),
    }
}

/// Whether a value with this path may stand in a scene or a material.
fn is_known(path: &str) -> bool {
    let names: Vec<&str> = path.split('.').collect();
    let key = |path: &str| KEYS.iter().any(|k| k.path == path || k.path.strip_prefix("material.") == Some(path));
    let of_materials = names[0] == "materials" && (names.len() == 2 || key(&names[2..].join(".")));
    ["base", "material"].contains(&path) || names.contains(&"source") || names.last() == Some(&"base") || of_materials || key(path)
}

/// A block marked `toml` is TOML and has the keys of scenes and materials only, unless it is marked `toml other`, or `toml study`, a plan of a study. A block marked `toml scene`
/// is a scene that `comminute check` accepts: as a file in a folder beside `experiments/`, or one folder deeper where its paths begin with
/// `../../`. A block marked `toml file=NAME` lies beside the scenes of its page under this name.
#[test]
fn every_scene_is_accepted() {
    let mut wrong = Vec::new();
    for page in pages() {
        let blocks: Vec<Block> = page.split().1.into_iter().filter(|b| b.words.split(' ').next() == Some("toml")).collect();
        for block in &blocks {
            let mut found = Vec::new();
            match block.text.parse::<toml::Table>() {
                Ok(table) => paths(&table.into(), "", &mut found),
                Err(e) => wrong.push(format!("{}:{}: not TOML: {e}", page.name(), block.line)),
            }
            let marked = |word: &str| block.words.split(' ').any(|w| w == word);
            if marked("study") {
                let folder = tempfile::tempdir().expect("folder");
                let path = folder.path().join("plan.toml");
                fs::write(&path, &block.text).expect("plan");
                wrong.extend(comminute::study::Plan::read(&path).err().map(|e| format!("{}:{}: {e}", page.name(), block.line)));
            }
            let other = marked("other") || marked("study");
            for path in found.iter().filter(|path| !other && !is_known(path)) {
                wrong.push(format!("{}:{}: there is no key {path}", page.name(), block.line));
            }
        }
        for block in blocks.iter().filter(|b| b.words.split(' ').any(|w| w == "scene")) {
            let folder = tempfile::Builder::new().prefix(".book-").tempdir_in(ROOT).expect("a folder");
            let deep = if block.text.contains("\"../../") { folder.path().join("scenes") } else { folder.path().to_path_buf() };
            fs::create_dir_all(&deep).expect("a folder");
            for (other, name) in blocks.iter().filter_map(|b| Some((b, b.words.split(' ').find_map(|w| w.strip_prefix("file="))?)))
            {
                fs::write(deep.join(name), &other.text).expect("written");
            }
            let scene = deep.join("scene.toml");
            fs::write(&scene, &block.text).expect("written");
            let output = comminute(&["check", "--quiet", &scene.display().to_string()]).get_output().clone();
            if !output.status.success() {
                let said = String::from_utf8_lossy(&output.stderr).replace(&folder.path().display().to_string(), "");
                wrong.push(format!("{}:{}: {said}", page.name(), block.line));
            }
        }
    }
    none(&wrong);
}

/// Help texts, each asked for once.
#[derive(Default)]
struct Helps(BTreeMap<Vec<String>, String>);

impl Helps {
    fn of(&mut self, verbs: &[String]) -> &str {
        self.0.entry(verbs.to_vec()).or_insert_with(|| {
            let args: Vec<&str> = verbs.iter().map(String::as_str).chain(["--help"]).collect();
            printed(&args)
        })
    }

    /// Names that a help text lists: of its commands, or of its options.
    fn lists(&mut self, verbs: &[String], name: &str) -> bool {
        let indented = |line: &str| line.starts_with("  ") && line.trim_start().split([' ', ',', '=']).any(|w| w == name);
        let help = self.of(verbs);
        match name.starts_with('-') {
            true => help.lines().any(|line| line.trim_start().starts_with('-') && indented(line)),
            false => help
                .lines()
                .skip_while(|l| *l != "Commands:")
                .take_while(|l| !l.is_empty())
                .any(|line| line.starts_with("  ") && line.split_whitespace().next() == Some(name)),
        }
    }

    /// What is wrong with a command line that begins behind `comminute`.
    fn doubt(&mut self, line: &str) -> Option<String> {
        let words: Vec<String> = line.split_whitespace().map(|w| w.trim_matches(['"', '\'']).to_string()).collect();
        // what a shell does with the rest is not the program's
        let end = words.iter().position(|w| ["|", ">", "2>", "&&", ";", "#", "&"].contains(&w.as_str())).unwrap_or(words.len());
        let mut verbs = Vec::new();
        for word in &words[..end] {
            if word.starts_with('-') || !self.of(&verbs).contains("Commands:") {
                break;
            }
            if !self.lists(&verbs, word) {
                return Some(format!("there is no command {word}"));
            }
            verbs.push(word.clone());
        }
        for (i, word) in words[..end].iter().enumerate().skip(verbs.len()) {
            let name = word.split('=').next().unwrap_or_default();
            let option = name.strip_prefix('-').is_some_and(|rest| rest.starts_with(|c: char| c == '-' || c.is_alphabetic()));
            if option && !self.lists(&verbs, name) {
                return Some(format!("`comminute {}` has no option {name}", verbs.join(" ")));
            }
            if i > 0 && ["--set", "--grid"].contains(&words[i - 1].as_str()) {
                let known =
                    ["KEY", "material"].contains(&name) || name.starts_with("materials.") || KEYS.iter().any(|k| k.path == name);
                if !known {
                    return Some(format!("there is no key {name}"));
                }
            }
            let ours = ["experiments/", "materials/", "figures/", "docs/"].iter().any(|folder| word.starts_with(folder));
            if ours && !word.contains(['*', '…']) && !Path::new(ROOT).join(word).exists() {
                return Some(format!("there is no {word}"));
            }
        }
        None
    }
}

/// Commands as typed (`$ comminute …` or `$ cargo run --release -- …` in a console block, where a backslash continues a line), and commands
/// named in `code`.
#[test]
fn every_command_exists() {
    let (mut helps, mut wrong) = (Helps::default(), Vec::new());
    for page in pages() {
        let (prose, blocks) = page.split();
        let mut commands: Vec<(usize, String)> = Vec::new();
        for block in blocks.iter().filter(|b| b.words == "console") {
            let text = block.text.replace("\\\n", "  ");
            let typed = text.lines().filter_map(|l| l.strip_prefix("$ "));
            let ours = typed.filter_map(|l| l.strip_prefix("comminute ").or_else(|| l.strip_prefix("cargo run --release -- ")));
            commands.extend(ours.map(|l| (block.line, l.to_string())));
        }
        for (i, line) in prose.into_iter().enumerate() {
            let code = line.split('`').skip(1).step_by(2).filter_map(|c| c.strip_prefix("comminute "));
            // `comminute run … --continue`: what stands for something else says nothing
            commands.extend(code.map(|c| (i + 1, c.replace('…', " "))));
        }
        for (line, command) in commands {
            if let Some(why) = helps.doubt(&command) {
                wrong.push(format!("{}:{line}: comminute {command}: {why}", page.name()));
            }
        }
    }
    none(&wrong);
}

/// A cell of a Markdown table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('*', "\\*").replace('<', "&lt;").replace('>', "&gt;")
}

/// The page of keys.
fn keys() -> String {
    let mut page = String::from(
        "# Keys of scenes and materials\n\n\
         This page is made by the program; `comminute check --keys` prints the same. A scene is a TOML file that says what is done to a\n\
         specimen, a material one that says what is true of the grains: see [scenes](scenes.md) and [materials](materials.md). A file of a\n\
         material holds what stands under `material.` here, without that word. A key that holds a dimension ends in its unit; any other holds\n\
         a number without dimension, a word, a list or a flag. Unknown keys, wrong types and values out of range are refused before anything\n\
         is started. A key may stand in every kind of scene unless the last column names the kinds.\n",
    );
    let mut table = None;
    for key in KEYS.iter() {
        let (parent, name) = key.split();
        if table != Some(parent) {
            table = Some(parent);
            let heading = match parent {
                "" => "Top of a scene".to_string(),
                _ if LIST_TABLES.contains(&parent) => format!("`[[{parent}]]`"),
                _ => format!("`[{parent}]`"),
            };
            let _ = writeln!(
                page,
                "\n## {heading}\n\n| key | allowed | default | unit | meaning | scenes |\n|---|---|---|---|---|---|"
            );
        }
        let default = key.default_text();
        let default = default.strip_prefix("default ").unwrap_or(&default);
        let (allowed, meaning) = (cell(&key.shape.text()), cell(key.what));
        let _ = writeln!(page, "| `{name}` | {allowed} | {} | {} | {meaning} | {} |", cell(default), unit(name), key.scenes());
    }
    page
}

/// The unit that a name ends in.
fn unit(name: &str) -> &'static str {
    const UNITS: [(&str, &str); 18] = [
        ("_kg_m3", "kg/m³"),
        ("_rad_s", "rad/s"),
        ("_m_s2", "m/s²"),
        ("_m_s", "m/s"),
        ("_mm3", "mm³"),
        ("_m3", "m³"),
        ("_m2", "m²"),
        ("_mm", "mm"),
        ("_m", "m"),
        ("_kPa", "kPa"),
        ("_MPa", "MPa"),
        ("_GPa", "GPa"),
        ("_rad", "rad"),
        ("_deg", "°"),
        ("_seconds", "s"),
        ("_s", "s"),
        ("_g", "g"),
        ("_N", "N"),
    ];
    UNITS.iter().find(|(suffix, _)| name.ends_with(suffix)).map_or("", |(_, unit)| unit)
}

/// The page of columns.
fn columns() -> String {
    let mut page = String::from(
        "# Columns of the tables that runs leave\n\n\
         This page is made by the program; `comminute check --columns` prints the same. Every table is a CSV file that begins with a line of\n\
         names; [records](records.md) says which run leaves which file. Lengths of grains are those of the model: of a scene with\n\
         `specimen.scale` they are larger by it, except sieves and d10 to d60. An empty cell has no value at this row. Figures have tables\n\
         of their own beside them.\n",
    );
    for sheet in SHEETS {
        let _ =
            writeln!(page, "\n## {} ({})\n\n| column | unit | meaning |\n|---|---|---|", sheet.files.replace('*', "\\*"), sheet.of);
        for column in sheet.columns {
            let _ = writeln!(
                page,
                "| `{}` | {} | {} |",
                column.name,
                if column.unit == "-" { "" } else { column.unit },
                cell(column.what)
            );
        }
    }
    page
}

/// A page with the rows of the tables that it names: what stands between `<!-- rows of FILE.csv -->` and `<!-- end -->` comes from the CSV file beside
/// the page.
fn with_rows(page: &str) -> String {
    let path = Path::new(ROOT).join(page);
    let text = fs::read_to_string(&path).expect("a page");
    let mut parts = text.split("<!-- rows of ");
    let mut made = parts.next().unwrap_or_default().to_string();
    for part in parts {
        let (name, rest) = part.split_once(" -->").expect("a name");
        let (_, after) = rest.split_once("<!-- end -->").expect("an end");
        let _ = write!(made, "<!-- rows of {name} -->\n\n");
        let mut reader = csv::Reader::from_path(path.with_file_name(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
        let row = |cells: &csv::StringRecord| format!("| {} |\n", cells.iter().map(cell).collect::<Vec<_>>().join(" | "));
        let header: csv::StringRecord = reader.headers().expect("a header").iter().map(|name| name.replace('_', " ")).collect();
        let _ = writeln!(made, "{}|{}", row(&header), "---|".repeat(header.len()));
        reader.records().for_each(|record| made.push_str(&row(&record.expect("a row"))));
        let _ = write!(made, "\n<!-- end -->{after}");
    }
    made
}

#[test]
fn the_reference_is_what_the_program_says() {
    let mut wrong = Vec::new();
    let hard = "docs/validation/hard_to_break.md";
    for (path, made) in [("docs/guide/keys.md", keys()), ("docs/guide/columns.md", columns()), (hard, with_rows(hard))] {
        let file = Path::new(ROOT).join(path);
        if std::env::var("COMMINUTE_BOOK").is_ok_and(|v| v == "write") {
            fs::write(&file, &made).expect("written");
        }
        if fs::read_to_string(&file).unwrap_or_default() != made {
            wrong.push(format!("{path} is not what the program says; COMMINUTE_BOOK=write cargo test --test book writes it anew"));
        }
    }
    none(&wrong);
}
