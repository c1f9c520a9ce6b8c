//! The pages say what is true: links lead somewhere, commands and options exist, files are described
//! field by field.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const PAGES: &[&str] = &["README.md", "CHANGELOG.md", "docs", "projects/piazza/README.md"];

/// Types that are written to files: every field is described in `docs/formats.md`.
const FILE_TYPES: &[&str] = &[
    "src/document/stack.rs",
    "src/document/colour.rs",
    "src/document/project.rs",
    "src/document/frame.rs",
    "src/document/export_record.rs",
    "src/document/paint/mod.rs",
    "src/document/camera_path.rs",
    "src/document/stroke.rs",
    "src/document/tree_paint.rs",
    "src/views/colour.rs",
    "src/views/written_exposure.rs",
    "src/views/score/report.rs",
    "src/views/ortho/report.rs",
    "src/layers/options.rs",
    "src/ldi/file/header.rs",
    "src/ldi/report.rs",
    "src/foliage/species.rs",
    "src/handover/blender/scene.rs",
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The Markdown pages, relative to the project.
fn pages() -> Vec<PathBuf> {
    let mut pages = Vec::new();
    for page in PAGES.iter().map(PathBuf::from) {
        if !root().join(&page).is_dir() {
            pages.push(page);
            continue;
        }
        let entries =
            fs::read_dir(root().join(&page)).unwrap().map(|entry| page.join(entry.unwrap().file_name()));
        pages.extend(entries.filter(|path| path.extension().is_some_and(|e| e == "md")));
    }
    pages
}

/// What stands in the parentheses of `[text](target)`.
fn link_targets(text: &str) -> Vec<&str> {
    let ends = text.split("](").skip(1);
    ends.filter_map(|rest| rest.split(')').next()).collect()
}

/// The anchor that a heading gets: lower case, blanks to hyphens, other signs dropped.
fn anchor(heading: &str) -> String {
    let kept = heading.to_lowercase().replace(' ', "-");
    kept.chars().filter(|c| c.is_alphanumeric() || matches!(c, '-' | '_')).collect()
}

fn has_heading(text: &str, wanted: &str) -> bool {
    let headings = text.lines().filter(|line| line.starts_with('#'));
    headings.map(|line| anchor(line.trim_start_matches('#').trim())).any(|anchor| anchor == wanted)
}

#[test]
fn every_link_leads_somewhere() {
    let mut broken = Vec::new();
    for page in pages() {
        let text = read(&page);
        for target in link_targets(&text).into_iter().filter(|t| !t.starts_with("http")) {
            let (file, heading) = target.split_once('#').unwrap_or((target, ""));
            let file = if file.is_empty() { page.clone() } else { page.with_file_name("").join(file) };
            let leads =
                root().join(&file).exists() && (heading.is_empty() || has_heading(&read(&file), heading));
            if !leads {
                broken.push(format!("{}: {target}", page.display()));
            }
        }
    }
    assert!(broken.is_empty(), "links that lead nowhere:\n{}", broken.join("\n"));
}

/// The command lines of a page or script: what follows `quadratura` at the beginning of a line of
/// code, or `step` in the demo.
fn command_lines(text: &str) -> Vec<Vec<&str>> {
    let lines = text.lines().filter_map(|line| {
        line.strip_prefix("    quadratura ")
            .or_else(|| line.strip_prefix("step ").filter(|l| !l.contains("()")))
    });
    lines.map(|line| line.split_whitespace().collect()).collect()
}

/// The help of a command, which has two words where the first has commands of its own.
fn help_of(words: &[&str]) -> String {
    let names = if ["ldi", "model", "text", "tree"].contains(&words[0]) { &words[..2] } else { &words[..1] };
    let output = Command::new(env!("CARGO_BIN_EXE_quadratura")).args(names).arg("--help").output().unwrap();
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn every_command_and_option_that_a_page_shows_exists() {
    let mut unknown = Vec::new();
    for page in pages().into_iter().chain(["examples/demo.sh".into()]) {
        for words in command_lines(&read(&page)) {
            let help = help_of(&words);
            let options = words.iter().filter(|word| word.starts_with("--"));
            let missing: Vec<_> = options.filter(|option| !help.contains(**option)).collect();
            if help.is_empty() || !missing.is_empty() {
                unknown.push(format!("{}: quadratura {} {missing:?}", page.display(), words.join(" ")));
            }
        }
    }
    assert!(unknown.is_empty(), "not what the program takes:\n{}", unknown.join("\n"));
}

/// The names of public fields, as they are written in files.
fn fields(source: &str) -> Vec<String> {
    let code = source.split("#[cfg(test)]\nmod").next().unwrap_or_default();
    // Those that are not written are not described.
    let written = code.replace("#[serde(skip)]\n    pub ", "");
    let renamed = |line: &str| Some(line.split_once("rename = \"")?.1.split_once('"')?.0.to_owned());
    let mut other_name = None;
    let mut names = Vec::new();
    for line in written.lines() {
        if let Some((name, _)) = line.strip_prefix("    pub ").and_then(|field| field.split_once(": ")) {
            names.push(other_name.take().unwrap_or_else(|| name.to_owned()));
        } else if line.trim_start().starts_with("#[serde(") {
            other_name = renamed(line).or(other_name);
        }
    }
    names.retain(|name| !name.contains(['(', ' ']));
    names
}

#[test]
fn every_field_of_a_file_is_described() {
    let page = read("docs/formats.md");
    let mut missing = Vec::new();
    for file in FILE_TYPES {
        let source = read(file);
        let fields = fields(&source);
        assert!(fields.len() > 3, "{file}: no fields found, so this test tests nothing");
        let silent = fields.into_iter().filter(|field| !page.contains(&format!("`{field}`")));
        missing.extend(silent.map(|field| format!("{file}: {field}")));
    }
    assert!(missing.is_empty(), "docs/formats.md does not describe:\n{}", missing.join("\n"));
}
