//! The error for a name that nothing has, with the nearest names.

use quadratura_base::error::{Error, Message, Remedy};
use quadratura_document::names::without_extension;

/// The number of names that a message lists; a longer list would not be read.
const NAMED: usize = 4;

/// Returns the error for a `name` that no `what` (such as "photo") has. It lists the nearest of the `known` names, or
/// the first ones where none is near; `remedy` lists all of them.
pub fn no_such<'a>(
    what: &str,
    name: &str,
    known: impl IntoIterator<Item = &'a str>,
    remedy: Option<Remedy>,
) -> Error {
    let known: Vec<&str> = known.into_iter().collect();
    let near = nearest(name, &known);
    let others = match (&near[..], known.len()) {
        ([], 0) => "there are none".to_owned(),
        ([], count) => match count.saturating_sub(NAMED) {
            0 => format!("there are {}", quoted(&known)),
            more => format!("there are {} and {more} more", quoted(&known[..NAMED])),
        },
        ([one], _) => format!("the nearest name is {}", quoted(&[one])),
        (near, _) => format!("the nearest names are {}", quoted(near)),
    };
    let text = Message::from(format!("there is no {what} {name:?}; {others}"));
    match remedy {
        Some(remedy) => Error::missing(text.and(("; ", remedy, " lists all"))),
        None => Error::missing(text),
    }
}

fn quoted(names: &[&str]) -> String {
    names.iter().map(|name| format!("{name:?}")).collect::<Vec<_>>().join(", ")
}

/// Returns the known names near to a name, the nearest first: those that contain it or are contained in it, and those
/// that differ in at most a third of its letters.
fn nearest<'a>(name: &str, known: &[&'a str]) -> Vec<&'a str> {
    let name = name.trim_end_matches('*').to_lowercase();
    let most = 1 + name.chars().count() / 3;
    let distance = |other: &str| {
        let whole = other.to_lowercase();
        let file = whole.rsplit('/').next().unwrap_or(&whole);
        let forms = [&whole, file, without_extension(file)];
        forms.into_iter().map(|form| differing(&name, form)).min().unwrap_or(usize::MAX)
    };
    let mut near: Vec<(usize, &str)> = known.iter().map(|other| (distance(other), *other)).collect();
    near.retain(|(distance, _)| *distance <= most);
    // Equally near names stay in their order.
    near.sort_by_key(|(distance, _)| *distance);
    near.truncate(NAMED);
    near.into_iter().map(|(_, name)| name).collect()
}

/// Returns the number of letters to insert, remove or replace between two names (Levenshtein's distance); 1 at most where
/// one of them contains the other.
fn differing(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    if a.is_empty() || b.is_empty() {
        return a.len().max(b.len());
    }
    let contains = |long: &[char], short: &[char]| long.windows(short.len()).any(|part| part == short);
    // Few letters are in most names, but at the beginning of few.
    let within = a.len().min(b.len()) > 2 && (contains(&a, &b) || contains(&b, &a));
    if a != b && (within || b.starts_with(&a)) {
        return 1;
    }
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, letter) in a.iter().enumerate() {
        let mut before = std::mem::replace(&mut row[0], i + 1);
        for (j, other) in b.iter().enumerate() {
            let replaced = before + usize::from(letter != other);
            before = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(before + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(name: &str, known: &[&str]) -> String {
        no_such("object", name, known.iter().copied(), Some(Remedy::ListObjects)).to_string()
    }

    #[test]
    fn a_name_with_a_slip_is_answered_with_the_name_that_was_meant() {
        let known = ["tower", "wall", "west wall", "roof", "gate"];
        assert_eq!(
            message("twoer", &known),
            "there is no object \"twoer\"; the nearest name is \"tower\"; “list objects” lists all"
        );
        assert!(message("Wall", &known).contains("the nearest names are \"wall\", \"west wall\""));
        assert!(message("wal*", &known).contains("\"wall\""));
        assert!(message("ga", &known).contains("the nearest name is \"gate\""));
    }

    #[test]
    fn where_no_name_is_near_the_first_ones_are_listed() {
        let known = ["a1", "b2", "c3", "d4", "e5", "f6"];
        assert!(message("sky", &known).contains("there are \"a1\", \"b2\", \"c3\", \"d4\" and 2 more"));
        assert!(message("sky", &known[..1]).contains("there are \"a1\";"));
        assert!(message("sky", &[]).contains("there are none"));
    }

    #[test]
    fn a_photo_is_near_without_its_folder_and_extension_too() {
        let message = no_such("photo", "0O1", ["north/001.jpg", "south/117.jpg"], None).to_string();
        assert_eq!(message, "there is no photo \"0O1\"; the nearest name is \"north/001.jpg\"");
    }
}
