//! The report: tables and figures; beside each figure, what the paper says and what the runs show.

use super::plan::{Content, Plan};
use laboratory::error::{Error, Result};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Writes `README.md`, the file that hosts of repositories show for a folder, and returns its path. `compared`: the part that the comparison of the runs gives.
///
/// # Errors
/// A file that cannot be written.
pub fn write(plan: &Plan, compared: &str, drawn: &[Vec<PathBuf>], dir: &Path) -> Result<PathBuf> {
    let mut text = format!("# {}\n\n{}\n\n", plan.title, plan.source);
    text += compared;
    for note in &plan.notes {
        let _ = writeln!(text, "- {note}");
    }
    text += "\nThe same numbers with spread: [comparison.csv](comparison.csv); every run: [runs.csv](runs.csv). Each figure has the CSV of what it shows beside it.\n";
    for (figure, files) in plan.figures.iter().zip(drawn) {
        let _ = write!(text, "\n## {}\n\n| in the paper | here |\n|---|---|\n", figure.title);
        // sections and points among bodies are so many coloured places that as lines they would take megabytes
        let kind = if matches!(figure.draw, Content::Section { .. } | Content::Bodies { .. }) { "png" } else { "svg" };
        let images: Vec<&PathBuf> = files.iter().filter(|f| f.extension().is_some_and(|e| e == kind)).collect();
        let first = if images.is_empty() { "its runs are not done".into() } else { figure.here.clone() };
        let _ = writeln!(text, "| {} | {} |", cell(&figure.paper), cell(&first));
        text.push('\n');
        for image in images {
            let path = image.strip_prefix(dir).unwrap_or(image).display().to_string();
            let name = image.file_stem().map_or_else(String::new, |s| s.to_string_lossy().replace('_', " "));
            let _ = writeln!(text, "<img src=\"{path}\" alt=\"{}: {name}\" width=\"430\">", figure.title);
        }
    }
    let path = dir.join("README.md");
    std::fs::write(&path, text).map_err(Error::write(&path))?;
    Ok(path)
}

/// Text made fit for a cell of a Markdown table.
pub fn cell(text: &str) -> String {
    text.trim().replace('|', "\\|").replace('\n', " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_holds_a_line_without_bars() {
        assert_eq!(cell("a|b\nc "), "a\\|b c");
    }
}
