//! The list that names the photos of a Bundler file: where it is, and what is in it.
//!
//! Bundler reads `list.txt` and writes `bundle.out`; programs that correct its lenses write `listX.txt` for `bundleX.out`, COLMAP
//! writes `X.list.txt` beside `X.bundle.out`, and RealityCapture `imagelist.lst`.

use std::path::{Path, PathBuf};

use super::lines::LineReader;
use super::recognise::beginning;
use super::reconstruction::ReconstructionFiles;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::alike;
use quadratura_base::task::Task;
use quadratura_files::text::lines_of;

/// The endings of files that may be lists.
const ENDINGS: [&str; 3] = ["txt", "lst", "list"];
/// The most files beside a Bundler file that are looked into.
const LOOKED_INTO: usize = 32;
/// The number of files that a message names.
const NAMED: usize = 4;
const PUT: &str = "put the list of photos there that belongs to this file, and call it list.txt";

/// A list with the names in it.
struct List {
    file: PathBuf,
    names: Vec<String>,
}

/// Finds the list of a Bundler file: the one of a usual name, beside the file or in the folder above, and of several the one with
/// as many lines as the file has cameras; else the only other one beside it with as many.
///
/// # Errors
/// [`Error::Input`] where there is none, with what is there instead.
pub(super) fn with_list(file: &Path) -> Result<ReconstructionFiles> {
    let cameras = camera_count(&beginning(file));
    let folder = file.parent().unwrap_or(Path::new("")).to_path_buf();
    let (beside, above) = (files_in(&folder), files_in(&folder.join("..")));
    let usual = usual_names(&file.file_name().unwrap_or_default().to_string_lossy());
    let named = usual.iter().flat_map(|usual| [&beside, &above].map(|files| named(files, usual)));
    let named: Vec<PathBuf> = named.flatten().collect();
    let fits =
        |list: &&PathBuf| read_list(list, cameras, &Task::silent()).is_ok_and(|names| fits(&names, cameras));
    let found = |list: &PathBuf, notes| ReconstructionFiles {
        others: vec![list.clone()],
        notes,
        ..ReconstructionFiles::one(file)
    };
    if let Some(list) = named.iter().find(fits).or(named.first()) {
        let mut notes = Vec::new();
        if *list != named[0] {
            let (first, list) = (named[0].display(), list.display());
            notes.push(format!("{list}: it names the photos, because {first} has another number of lines"));
        }
        return Ok(found(list, notes));
    }
    let others = lists_among(&beside, file);
    let fitting: Vec<&List> =
        others.iter().filter(|list| cameras.is_some() && self::fits(&list.names, cameras)).collect();
    match fitting[..] {
        [list] => {
            let note = format!(
                "{}: it names the photos, because there is no list.txt and no other list beside {} has as many lines as that has cameras",
                list.file.display(),
                file.display()
            );
            Ok(found(&list.file, vec![note]))
        }
        _ => Err(Error::input(file, "", missing(&others, &fitting, cameras), PUT)),
    }
}

/// Returns the names that a list usually has, the likeliest first.
fn usual_names(file: &str) -> Vec<String> {
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    let mut names = Vec::new();
    names.extend(stem.strip_prefix("bundle").map(|rest| format!("list{rest}.txt")));
    names.extend(stem.strip_suffix(".bundle").map(|name| format!("{name}.list.txt")));
    names.extend(["list.txt", "imagelist.lst", "imagelist.txt", "list.lst"].map(str::to_owned));
    names.extend([format!("{stem}.list.txt"), format!("{stem}.lst")]);
    names
}

fn named(files: &[PathBuf], name: &str) -> Option<PathBuf> {
    let names = files.iter().map(|file| file.file_name().unwrap_or_default().to_string_lossy());
    alike::find(name, names).one().map(|index| files[index].clone())
}

fn files_in(folder: &Path) -> Vec<PathBuf> {
    let listed = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = std::fs::read_dir(listed).into_iter().flatten().flatten();
    let mut files: Vec<PathBuf> =
        entries.map(|entry| folder.join(entry.file_name())).filter(|file| file.is_file()).collect();
    files.sort_unstable();
    files
}

/// Reads the files beside a Bundler file that look like lists: each line ends like the name of a picture.
fn lists_among(beside: &[PathBuf], itself: &Path) -> Vec<List> {
    let may_be = |file: &&PathBuf| {
        let ending = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        ENDINGS.contains(&&*ending) && **file != itself
    };
    let read = |file: &PathBuf| {
        let names = read_list(file, None, &Task::silent()).ok()?;
        let are_photos = !names.is_empty() && names.iter().all(|name| ends_like_a_picture(name));
        are_photos.then(|| List { file: file.clone(), names })
    };
    beside.iter().filter(may_be).take(LOOKED_INTO).filter_map(read).collect()
}

fn ends_like_a_picture(name: &str) -> bool {
    let ending = name.rsplit_once('.').map_or("", |(_, ending)| ending);
    (2..=4).contains(&ending.len()) && ending.bytes().all(|byte| byte.is_ascii_alphanumeric())
}

/// Says that there is no list, and what there is.
fn missing(others: &[List], fitting: &[&List], cameras: Option<usize>) -> String {
    let lines = |list: &List| {
        let name = list.file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        format!("{name} with {} lines", list.names.len())
    };
    let of_cameras = cameras.map_or(String::new(), |count| format!(" of its {count} cameras"));
    let missing = format!("there is no list.txt beside it, which names the photos{of_cameras}");
    let listed = |lists: &mut dyn Iterator<Item = String>| lists.take(NAMED).collect::<Vec<_>>().join(", ");
    match (others.len(), fitting.len()) {
        (0, _) => missing,
        (_, 0) => format!("{missing}; other lists beside it: {}", listed(&mut others.iter().map(lines))),
        _ => format!(
            "{missing}, and several other lists have as many lines: {}",
            listed(&mut fitting.iter().map(|list| lines(list)))
        ),
    }
}

/// Returns the number of cameras that the beginning of a Bundler file says.
fn camera_count(beginning: &[u8]) -> Option<usize> {
    let text = String::from_utf8_lossy(beginning);
    let mut lines = lines_of(&text).map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    lines.next()?.split_ascii_whitespace().next()?.parse().ok()
}

fn fits(names: &[String], cameras: Option<usize>) -> bool {
    cameras.is_none_or(|cameras| cameras == names.len())
}

/// Reads a list: one photo per line, its path optionally followed by a 0 and an initial focal length. Lines that begin with `#` are
/// names where there are as many lines with these as `cameras`, and comments otherwise.
///
/// # Errors
/// [`Error::Io`]; [`Error::Input`] for text in UTF-16; [`Error::Cancelled`].
pub(super) fn read_list(list: &Path, cameras: Option<usize>, task: &Task) -> Result<Vec<String>> {
    let (mut lines, mut names) = (LineReader::open(list)?, Vec::new());
    while lines.next_line("read names", task)? {
        names.push(path_in(&lines.text()).to_owned());
    }
    if cameras != Some(names.len()) {
        names.retain(|name| !name.starts_with('#'));
    }
    Ok(names)
}

/// Returns the path in a line, which may be in quotation marks.
fn path_in(line: &str) -> &str {
    let last_word = |text: &str| text.rfind(char::is_whitespace).map(|at| at + 1);
    let focal = last_word(line).filter(|at| line[*at..].parse::<f64>().is_ok());
    let before = focal.map(|at| line[..at].trim_end());
    let zero = before
        .and_then(|before| last_word(before).filter(|at| &before[*at..] == "0").map(|at| &before[..at]));
    let path = zero.unwrap_or(line).trim();
    path.strip_prefix('"').and_then(|path| path.strip_suffix('"')).unwrap_or(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_may_hold_spaces_and_is_found_before_its_focal_length() {
        for (line, path) in [
            ("./a.jpg", "./a.jpg"),
            ("./a b.jpg 0 1200.5", "./a b.jpg"),
            ("a.jpg \t0   900", "a.jpg"),
            ("\"C:\\site 1\\a.jpg\"", "C:\\site 1\\a.jpg"),
            ("\"a 0.jpg\" 0 5e2", "a 0.jpg"),
            ("take 0 7.jpg", "take 0 7.jpg"),
            ("a.jpg 1 900", "a.jpg 1 900"),
            ("900", "900"),
        ] {
            assert_eq!(path_in(line), path, "{line}");
        }
    }

    /// Returns the name of the list that is found beside a file of two cameras, or the message.
    fn found(bundle: &str, files: &[(&str, &str)]) -> (String, Vec<String>) {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(bundle);
        std::fs::write(&file, "# Bundle file v0.3\r\n2 0\r\n").unwrap();
        files.iter().for_each(|(name, text)| std::fs::write(folder.path().join(name), text).unwrap());
        match with_list(&file) {
            Ok(files) => (files.others[0].file_name().unwrap().to_string_lossy().into_owned(), files.notes),
            Err(error) => (error.to_string(), Vec::new()),
        }
    }

    #[test]
    fn lists_are_found_under_the_names_that_programs_give_them() {
        const TWO: &str = "a.jpg\nb.jpg\n";
        for (bundle, list) in [
            ("bundle.out", "list.txt"),
            ("bundle.out", "List.TXT"),
            ("bundle.rd.out", "list.rd.txt"),
            ("bundle.out", "imagelist.lst"),
            ("north.bundle.out", "north.list.txt"),
            ("north.out", "north.lst"),
        ] {
            let others = [(list, TWO), ("notes.txt", "two lines\nof text\n"), ("photos.txt", TWO)];
            assert_eq!(found(bundle, &others), (list.to_owned(), vec![]), "{bundle}");
        }
        let (list, notes) = found("bundle.out", &[("list.txt", "a.jpg\n"), ("imagelist.lst", TWO)]);
        assert!(list == "imagelist.lst" && notes[0].contains("has another number of lines"), "{notes:?}");
        let (list, notes) =
            found("x.out", &[("names.txt", TWO), ("old.txt", "a.jpg\n"), ("read.txt", "Hello.\nYou.\n")]);
        assert!(list == "names.txt" && notes[0].contains("it names the photos"), "{notes:?}");
        let (said, _) = found("x.out", &[("names.txt", TWO), ("other.txt", "c.png\nd.png\n")]);
        assert!(
            said.contains("several other lists have as many lines: names.txt with 2 lines, other.txt"),
            "{said}"
        );
        let (said, _) = found("x.out", &[("names.txt", "a.jpg\n")]);
        assert!(
            said.contains("of its 2 cameras; other lists beside it: names.txt with 1 lines; put"),
            "{said}"
        );
        assert!(found("x.out", &[]).0.contains("there is no list.txt beside it"));
    }

    #[test]
    fn a_line_that_begins_with_a_number_sign_is_a_name_where_all_lines_are_needed() {
        let folder = tempfile::tempdir().unwrap();
        let list = folder.path().join("list.txt");
        std::fs::write(&list, "#1 gate.jpg\r\n\r\n#2.jpg 0 800\r\n").unwrap();
        assert_eq!(read_list(&list, Some(2), &Task::silent()).unwrap(), ["#1 gate.jpg", "#2.jpg"]);
        std::fs::write(&list, "# my photos\ra.jpg\rb.jpg\r").unwrap();
        assert_eq!(read_list(&list, Some(2), &Task::silent()).unwrap(), ["a.jpg", "b.jpg"]);
    }
}
