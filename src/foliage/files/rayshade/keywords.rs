//! The words that begin statements, and those that are passed over.

/// Primitives that are left out: their notes, and true where a file is named.
const LEFT_OUT: [(&str, &str, bool); 4] = [
    ("plane", "a plane is left out, because it has no end", false),
    ("blob", "a blob is left out", false),
    ("torus", "a torus is left out", false),
    ("heightfield", "a height field is left out", true),
];

/// Statements about views, light, atmosphere and the program itself. True where a word follows that may be any word.
const PASSED_OVER: [(&str, bool); 35] = [
    ("aperture", false),
    ("atmosphere", false),
    ("background", false),
    ("contrast", false),
    ("crop", false),
    ("cutoff", false),
    ("eyep", false),
    ("eyesep", false),
    ("filter", true),
    ("focaldist", false),
    ("fog", false),
    ("fogdeck", false),
    ("fov", false),
    ("framelength", false),
    ("frames", false),
    ("jitter", false),
    ("light", false),
    ("lookp", false),
    ("maxdepth", false),
    ("mist", false),
    ("nojitter", false),
    ("noshadow", false),
    ("opacity", false),
    ("outfile", true),
    ("report", false),
    ("resolution", false),
    ("sample", false),
    ("samples", false),
    ("screen", false),
    ("shadowtransp", false),
    ("shutter", false),
    ("starttime", false),
    ("threshold", false),
    ("up", false),
    ("window", false),
];

/// Statements that are read.
const READ: [&str; 20] = [
    "name",
    "object",
    "list",
    "grid",
    "union",
    "intersect",
    "difference",
    "end",
    "poly",
    "polygon",
    "triangle",
    "triangleuv",
    "cone",
    "cylinder",
    "disc",
    "sphere",
    "box",
    "surface",
    "applysurf",
    "define",
];

/// Returns true for words that begin a statement.
pub fn begins_statement(word: &str) -> bool {
    READ.contains(&word)
        || PASSED_OVER.iter().any(|(known, _)| *known == word)
        || LEFT_OUT.iter().any(|(known, ..)| *known == word)
}

/// Returns the note of a primitive that is left out, and true where a file is named.
pub fn left_out(word: &str) -> Option<(&'static str, bool)> {
    LEFT_OUT.iter().find(|(known, ..)| *known == word).map(|(_, note, file)| (*note, *file))
}

/// Returns whether any word follows a statement that has no effect; `None` for words that begin no such statement.
pub fn passed_over(word: &str) -> Option<bool> {
    PASSED_OVER.iter().find(|(known, _)| *known == word).map(|(_, any_word)| *any_word)
}
