//! How far a stage is, in words: its photos, files or pictures where it counts those, else a percentage.

/// Returns what a stage counts, as a noun without its plural's ending; `None` where its units mean nothing to users: bytes,
/// texels, rows.
fn counted(stage: &str) -> Option<&'static str> {
    Some(match stage {
        "build layers"
        | "fill"
        | "check stacks"
        | "check fillings"
        | "check views"
        | "compare photos"
        | "compare surroundings"
        | "export"
        | "find photos"
        | "import photos"
        | "mask objects"
        | "mask trees"
        | "provenance"
        | "read sizes"
        | "read stacks"
        | "score"
        | "shared points"
        | "thumbnails" => "photo",
        "depth images" | "layered depth images" => "image",
        "import" => "file",
        "render" => "picture",
        _ => return None,
    })
}

/// Returns whether a stage has other stages as its parts; such a stage reports its end.
pub fn has_parts(stage: &str) -> bool {
    matches!(
        stage,
        "build layers" | "export" | "fill" | "import" | "layered depth images" | "render" | "score"
    )
}

/// Says how much of a stage is done: `3 of 9 photos`, or `34 %`.
pub fn in_words(stage: &str, done: u64, total: u64) -> String {
    match counted(stage) {
        Some(noun) => format!("{done} of {total} {noun}{}", if total == 1 { "" } else { "s" }),
        None => format!("{} %", (100 * done.min(total)).checked_div(total).unwrap_or(100)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_photos_are_called_photos() {
        assert_eq!(in_words("build layers", 3, 9), "3 of 9 photos");
        assert_eq!(in_words("import", 0, 1), "0 of 1 file");
        assert_eq!(in_words("load layers", 47_217, 749_070), "6 %");
        assert_eq!(in_words("read the model", 0, 0), "100 %");
    }
}
