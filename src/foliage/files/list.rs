//! Reads lists of trees as CSV (RFC 4180): a header line, and a tree in each line after it.

use std::path::Path;

use csv::{ReaderBuilder, Trim};

use quadratura_base::error::{Error, Result};
use quadratura_files::text::{line_ends, lines_of, not_utf16};

/// The largest list that is read, in bytes: some million trees.
const LARGEST_LIST: u64 = 256 << 20;
const REMEDY: &str = "correct it; docs/trees.md describes lists of trees";
/// Coordinates and lengths beyond this are mistakes.
const LARGEST_NUMBER: f64 = 1e15;
/// The names of the columns that are read, in the order of [`Column`].
const NAMES: [&str; 7] = ["name", "species", "x", "y", "height", "crown", "casts"];

/// A column of a list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Column {
    /// The tree's name.
    Name,
    /// The species.
    Species,
    /// The first level coordinate of the foot, in world units.
    X,
    /// The second level coordinate of the foot, in world units.
    Y,
    /// The height above the foot, in world units.
    Height,
    /// The width of the crown, in world units.
    Crown,
    /// Whether the tree's sun shadow darkens faces: `yes` or `no`.
    Casts,
}

/// A tree of a list.
#[derive(Debug, Clone, PartialEq)]
pub struct ListedPlace {
    /// The line in the file, from 1.
    pub line: usize,
    /// The numbers of the columns in the file, from 1, in the order of [`Column`]; `None` for those that the list lacks.
    columns: [Option<usize>; 7],
    /// The name; `None` where the field is empty, as for all that follow.
    pub name: Option<String>,
    /// The species.
    pub species: Option<String>,
    /// The two level coordinates of the foot, in world units.
    pub at: [f64; 2],
    /// The height above the foot, in world units, above 0.
    pub height: Option<f64>,
    /// The width of the crown, in world units, above 0.
    pub crown: Option<f64>,
    /// Whether the tree's sun shadow darkens faces.
    pub casts: Option<bool>,
}

/// A list of trees.
#[derive(Debug, Default)]
pub struct TreeList {
    /// The trees that can be read, in the order of the file.
    pub places: Vec<ListedPlace>,
    /// What is wrong with the other lines, each with its line in the file, from 1.
    pub problems: Vec<(usize, Error)>,
    /// The columns that are not read, by their names.
    pub ignored: Vec<String>,
}

impl ListedPlace {
    /// Returns the error for what was found in a column of this tree.
    pub fn error(&self, file: &Path, column: Column, found: impl Into<String>) -> Error {
        Error::input(file, place(self.line, self.columns[column as usize], column), found, REMEDY)
    }
}

/// Reads a list of trees. Fields are separated by commas, or by semicolons where the header line has more of these; with
/// semicolons the decimal sign may be a comma. A line that cannot be used is a problem, and the others are read, so
/// that all problems of a list are told at once.
///
/// # Errors
/// [`Error::Io`]; [`Error::Input`] with line and column where the file is no such list.
pub fn read_tree_list(file: &Path) -> Result<TreeList> {
    let size = std::fs::metadata(file).map_err(Error::io(file, "read it"))?.len();
    if size > LARGEST_LIST {
        let found = format!("{size} bytes, expected at most {LARGEST_LIST}");
        return Err(Error::input(file, "", found, "give the trees of this site alone"));
    }
    let bytes = std::fs::read(file).map_err(Error::io(file, "read it"))?;
    if let Some((found, _)) = not_utf16(&bytes) {
        return Err(Error::input(file, "", found, "save it as CSV in UTF-8"));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let before = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + before.iter().filter(|byte| **byte == b'\n').count();
        Error::input(file, format!("line {line}"), "it is not UTF-8 text", "save it as CSV in UTF-8")
    })?;
    list_of(file, text.trim_start_matches('\u{feff}'))
}

fn list_of(file: &Path, text: &str) -> Result<TreeList> {
    let header = lines_of(text).find(|line| !line.trim().is_empty()).unwrap_or_default();
    let count = |sign: char| header.matches(sign).count();
    let separator = if count(';') > count(',') { ';' } else { ',' };
    let mut records = records(file, text, separator)?.into_iter();
    let Some(head) = records.next() else {
        let found = "an empty file, expected a header line with the columns name, species, x, y, height, crown, casts";
        return Err(Error::input(file, "", found, REMEDY));
    };
    let columns = columns_of(file, &head)?;
    let is_read = |number: usize| columns.contains(&Some(number));
    let ignored = head.fields.iter().zip(1..).filter(|(name, number)| !name.is_empty() && !is_read(*number));
    let ignored = ignored.map(|(name, _)| name.clone()).collect();
    let mut list = TreeList { ignored, ..TreeList::default() };
    for record in records {
        match place_of(file, &record, head.fields.len(), columns, separator) {
            Ok(place) => list.places.push(place),
            Err(error) => list.problems.push((record.line, error)),
        }
    }
    if list.places.is_empty() && list.problems.is_empty() {
        let found = "a header line alone: the list has no rows, expected a tree in each line after it";
        return Err(Error::input(file, "", found, REMEDY));
    }
    Ok(list)
}

/// Returns the numbers of the columns, from 1, in the order of [`Column`].
fn columns_of(file: &Path, head: &CsvRecord) -> Result<[Option<usize>; 7]> {
    let mut columns = [None; 7];
    for (name, number) in head.fields.iter().zip(1..) {
        let Some(column) = NAMES.iter().position(|known| name.eq_ignore_ascii_case(known)) else { continue };
        if columns[column].replace(number).is_some() {
            let found = format!("a second column called {name:?}");
            let place = format!("line {}, column {number}", head.line);
            return Err(Error::input(file, place, found, REMEDY));
        }
    }
    for column in [Column::X, Column::Y] {
        if columns[column as usize].is_none() {
            let name = NAMES[column as usize];
            let found = format!(
                "no column {name:?} among {:?}, expected a header line with the columns name, species, x, y, height, crown, casts \
                 (x and y are needed)",
                head.fields
            );
            return Err(Error::input(file, format!("line {}", head.line), found, REMEDY));
        }
    }
    Ok(columns)
}

fn place_of(
    file: &Path,
    record: &CsvRecord,
    most: usize,
    columns: [Option<usize>; 7],
    separator: char,
) -> Result<ListedPlace> {
    if record.fields.len() > most {
        let found =
            format!("{} fields, expected at most {most}, as the header line has", record.fields.len());
        return Err(Error::input(file, format!("line {}", record.line), found, REMEDY));
    }
    let text = |column: Column| {
        let field = record.fields.get(columns[column as usize]? - 1)?;
        (!field.is_empty()).then_some(field.as_str())
    };
    let error = |column: Column, found: String| {
        Error::input(file, place(record.line, columns[column as usize], column), found, REMEDY)
    };
    let number = |column: Column| -> Result<Option<f64>> {
        let Some(text) = text(column) else { return Ok(None) };
        let point = if separator == ';' { text.replace(',', ".") } else { text.to_owned() };
        let number = point.parse().ok().filter(|number: &f64| number.is_finite());
        let number = number.ok_or_else(|| error(column, format!("{text:?}, expected a number")))?;
        if number.abs() > LARGEST_NUMBER {
            let found = format!("{text}, expected a number from -{LARGEST_NUMBER:e} to {LARGEST_NUMBER:e}");
            return Err(error(column, found));
        }
        Ok(Some(number))
    };
    let needed = |column: Column| {
        let nothing = || error(column, "nothing, expected a number".into());
        number(column)?.ok_or_else(nothing)
    };
    let length = |column: Column| match number(column)? {
        Some(length) if length <= 0.0 => Err(error(column, format!("{length}, expected a length above 0"))),
        length => Ok(length),
    };
    let casts = |text: &str| match &text.to_lowercase()[..] {
        "yes" => Ok(true),
        "no" => Ok(false),
        _ => Err(error(Column::Casts, format!("{text:?}, expected yes or no"))),
    };
    Ok(ListedPlace {
        line: record.line,
        columns,
        name: text(Column::Name).map(str::to_owned),
        species: text(Column::Species).map(str::to_owned),
        at: [needed(Column::X)?, needed(Column::Y)?],
        height: length(Column::Height)?,
        crown: length(Column::Crown)?,
        casts: text(Column::Casts).map(casts).transpose()?,
    })
}

fn place(line: usize, number: Option<usize>, column: Column) -> String {
    let name = NAMES[column as usize];
    match number {
        Some(number) => format!("line {line}, column {number} ({name})"),
        None => format!("line {line} (it has no column {name:?})"),
    }
}

/// The fields between separators, up to the end of a line outside of quotes.
struct CsvRecord {
    /// The line on which it begins, from 1.
    line: usize,
    fields: Vec<String>,
}

/// Returns the records of a text that are not empty. White space around a field does not belong to it.
fn records(file: &Path, text: &str, separator: char) -> Result<Vec<CsvRecord>> {
    if let Some(line) = unclosed_quote(text) {
        return Err(Error::input(file, format!("line {line}"), "a quote that is not closed", REMEDY));
    }
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(Trim::All)
        .delimiter(separator as u8)
        .from_reader(text.as_bytes());
    let (mut records, mut counted, mut line) = (Vec::new(), 0, 1);
    for record in reader.records() {
        let record = record.map_err(|error| Error::input(file, "", error.to_string(), REMEDY))?;
        // The reader's own count of lines is that before the empty lines which it skips.
        let from = record.position().map_or(counted, |position| position.byte() as usize);
        let begin = from + text[from..].find(|sign| !matches!(sign, '\r' | '\n')).unwrap_or(0);
        line += line_ends(&text[counted..begin]);
        counted = begin;
        let fields: Vec<String> = record.iter().map(str::to_owned).collect();
        if fields.iter().any(|field| !field.is_empty()) {
            records.push(CsvRecord { line, fields });
        }
    }
    Ok(records)
}

/// Returns the line of the last quote where their number is odd: all that follows would be one field.
fn unclosed_quote(text: &str) -> Option<usize> {
    let quotes = text.matches('"').count();
    let last = text.rfind('"').filter(|_| !quotes.is_multiple_of(2))?;
    Some(1 + line_ends(&text[..last]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<TreeList> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("trees.csv");
        std::fs::write(&file, text).unwrap();
        read_tree_list(&file)
    }

    #[test]
    fn columns_go_by_their_names_whatever_their_order_and_sign() {
        let comma = "\u{feff}name,species,x,y,height,crown\r\nold oak,oak,1.5,-2,6,4\r\n\r\n,,3,4,,\r\n";
        let list = read(comma).unwrap();
        assert!(list.problems.is_empty() && list.ignored.is_empty());
        let [first, second] = &list.places[..] else { panic!("{list:?}") };
        assert_eq!((first.name.as_deref(), first.species.as_deref()), (Some("old oak"), Some("oak")));
        assert_eq!((first.at, first.height, first.crown), ([1.5, -2.0], Some(6.0), Some(4.0)));
        assert_eq!((second.line, &second.name, second.at, second.height), (4, &None, [3.0, 4.0], None));
        let semicolon = "Y; X ;Girth;Name\n-2,25; 1,5;80;\"Elm \"\"B\"\"; gate\"\n";
        let list = read(semicolon).unwrap();
        assert_eq!(list.ignored, ["Girth"]);
        assert_eq!(list.places[0].name.as_deref(), Some("Elm \"B\"; gate"));
        assert_eq!((list.places[0].at, list.places[0].line), ([1.5, -2.25], 2));
    }

    #[test]
    fn a_line_that_cannot_be_used_is_told_with_its_column_and_the_others_are_read() {
        let text = "name,x,y,height\na,1,2,3\nb,one,2,3\nc,1,,3\nd,1,2,-3\ne,1,inf,3\nf,1,2,3,4\nj,1e300,2,3\n\"g\nh\",1,2,3\ni,1,2\n";
        let list = read(text).unwrap();
        let names: Vec<&str> = list.places.iter().filter_map(|place| place.name.as_deref()).collect();
        assert_eq!(names, ["a", "g\nh", "i"]);
        assert_eq!(list.places[2].line, 11, "a line break within quotes is counted");
        let problems: Vec<String> = list.problems.iter().map(|(_, error)| error.to_string()).collect();
        for (problem, words) in problems.iter().zip([
            ["line 3, column 2 (x)", "\"one\", expected a number"],
            ["line 4, column 3 (y)", "nothing, expected a number"],
            ["line 5, column 4 (height)", "-3, expected a length above 0"],
            ["line 6, column 3 (y)", "\"inf\", expected a number"],
            ["line 7", "5 fields, expected at most 4"],
            ["line 8, column 2 (x)", "1e300, expected a number from -1e15 to 1e15"],
        ]) {
            assert!(words.iter().all(|word| problem.contains(word)), "{problem}");
        }
        assert_eq!(problems.len(), 6);
    }

    #[test]
    fn a_tree_casts_a_shadow_or_not_as_the_list_says() {
        let list = read("x,y,casts\n1,2,yes\n1,3,No\n1,4,\n1,5,maybe\n").unwrap();
        let casts: Vec<_> = list.places.iter().map(|place| place.casts).collect();
        assert_eq!(casts, [Some(true), Some(false), None]);
        let problem = list.problems[0].1.to_string();
        assert!(problem.contains("line 5, column 3 (casts): \"maybe\", expected yes or no"), "{problem}");
    }

    #[test]
    fn what_is_no_list_is_refused_with_line_and_remedy() {
        let refused = |text: &str, words: &[&str]| {
            let error = read(text).unwrap_err().to_string();
            assert!(
                error.contains("docs/trees.md") && words.iter().all(|word| error.contains(word)),
                "{error}"
            );
        };
        refused("", &["an empty file", "name, species, x, y"]);
        refused("1,2,3\n4,5,6\n", &["line 1", "no column \"x\""]);
        refused("x,y,X\n", &["line 1, column 3", "a second column called \"X\""]);
        refused("name,x,y\n\n", &["the list has no rows"]);
        refused("x,y\n\"1,2\n", &["line 2", "not closed"]);
    }

    #[test]
    fn text_of_another_encoding_is_refused_with_its_line() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("trees.csv");
        std::fs::write(&file, b"name,x,y\nB\xe4rlauch,1,2\n").unwrap();
        let error = read_tree_list(&file).unwrap_err().to_string();
        assert!(error.contains("line 2") && error.contains("UTF-8"), "{error}");
        std::fs::write(&file, b"x\0,\0y\0\n\0").unwrap();
        assert!(read_tree_list(&file).unwrap_err().to_string().contains("it is text in UTF-16"));
    }

    #[test]
    fn lines_that_end_as_on_an_old_macintosh_are_counted() {
        let list = read("x;y\r1,5;2\r\r\"a\r\";nan\rb;-1.#IND\r").unwrap();
        assert_eq!(list.places[0].at, [1.5, 2.0]);
        assert_eq!(list.problems.iter().map(|(line, _)| *line).collect::<Vec<_>>(), [4, 6]);
    }
}
