//! Checks names of photos.

/// The longest name in bytes; no file system has longer paths.
pub(super) const LONGEST_NAME: usize = 4096;

/// Returns why `name` cannot be a file below the photo folder (the finding and what to do); `None` if it can.
pub(super) fn objection(name: &str) -> Option<(String, &'static str)> {
    let rename = "rename the photo in the cameras' file and on disk";
    let inside = "photos are named by their path below the photo folder, such as nord/0001.jpg";
    let quoted = short(name);
    if name.is_empty() {
        Some(("a photo without a name".into(), inside))
    } else if name.len() > LONGEST_NAME {
        Some((format!("the name {quoted} has {} bytes", name.len()), rename))
    } else if name.contains(char::REPLACEMENT_CHARACTER) {
        Some((format!("the name {quoted} is not UTF-8"), rename))
    } else if name.chars().any(char::is_control) {
        Some((format!("the name {quoted} contains control characters"), rename))
    } else if name.contains('\\') {
        Some((format!("the name {quoted} contains a backslash"), "write sub-folders with /"))
    } else if name.starts_with('/') || has_drive_letter(name) {
        Some((format!("the name {quoted} is absolute"), inside))
    } else if name.split('/').any(|part| part == "..") {
        Some((format!("the name {quoted} leaves the photo folder"), inside))
    } else if name.split('/').any(|part| part.is_empty() || part == ".") {
        Some((format!("the name {quoted} has an empty part"), inside))
    } else {
        None
    }
}

fn has_drive_letter(name: &str) -> bool {
    let bytes = name.as_bytes();
    bytes.len() >= 2 && bytes[0].is_ascii_alphabetic() && bytes[1] == b':'
}

/// Quotes a name for messages: escaped, and cut after 80 characters.
pub(super) fn short(name: &str) -> String {
    let mut quoted: String = name.chars().take(80).collect();
    if quoted.len() < name.len() {
        quoted.push('…');
    }
    format!("{quoted:?}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_in_sub_folders_with_spaces_and_umlauts_are_fine() {
        for name in ["0001.jpg", "nord/tür 1 (b).JPG", "a..b/c...png", "…"] {
            assert_eq!(objection(name), None, "{name}");
        }
    }

    #[test]
    fn names_that_lead_elsewhere_are_refused() {
        let leading_away = [
            "",
            "../a.jpg",
            "a/../../b.jpg",
            "/etc/passwd",
            "C:/a.jpg",
            "c:a.jpg",
            "a\\b.jpg",
            "a//b",
            "./a",
            "a\0b",
        ];
        for name in leading_away {
            assert!(objection(name).is_some(), "{name}");
        }
        assert!(objection(&"x".repeat(LONGEST_NAME + 1)).is_some());
    }
}
