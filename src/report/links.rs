//! Links from a page to files beside it.

use std::path::Path;

/// The address of `file` as a page at `page` names it: relative, with `/`, and with every byte that an address cannot have as `%xx`.
pub fn link(page: &Path, file: &Path) -> String {
    let whole = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    // folders through their real paths: `..` is not the folder above where a link leads elsewhere
    let real = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    let folder = whole(page).parent().map(real).unwrap_or_default();
    let file = whole(file);
    let target = match (file.parent(), file.file_name()) {
        (Some(parent), Some(name)) => real(parent).join(name),
        _ => file,
    };
    let relative = pathdiff::diff_paths(&target, folder).unwrap_or(target);
    let parts: Vec<String> = relative.components().map(|part| escaped(&part.as_os_str().to_string_lossy())).collect();
    parts.join("/")
}

fn escaped(part: &str) -> String {
    part.bytes()
        .map(|b| if b.is_ascii_alphanumeric() || b"-._~".contains(&b) { char::from(b).to_string() } else { format!("%{b:02X}") })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_are_relative_to_the_page() {
        let dir = tempfile::tempdir().expect("folder");
        let at = |name: &str| dir.path().join(name);
        std::fs::create_dir_all(at("runs/a b")).expect("folder");
        assert_eq!(link(&at("runs/report.html"), &at("runs/a b/history.csv")), "a%20b/history.csv");
        assert_eq!(link(&at("runs/a b/report.html"), &at("runs/a b/history.csv")), "history.csv");
        assert_eq!(link(&at("pages/report.html"), &at("runs/a b/x%\"é.csv")), "../runs/a%20b/x%25%22%C3%A9.csv");
    }
}
