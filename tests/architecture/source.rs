//! Rust source as the architecture test sees it: without comments, strings and tests, as tokens.

/// A file below `src/`.
#[derive(Clone)]
pub struct Source {
    /// Below `src/`, with `/`: `layers/runs.rs`.
    pub path: String,
    /// As it is in the file.
    pub text: String,
    /// The text with comments, literals and `#[cfg(test)]` items blanked out, line by line as long.
    pub code: String,
}

/// A word or a sign of the code. `::` is one token.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Token<'a> {
    pub text: &'a str,
    /// From 1.
    pub line: usize,
}

/// A path that the code names, with its room: in `layers`, `crate::runs::Runs` is `["layers", "runs", "Runs"]`, and in all rooms
/// `quadratura_layers::Options` is `["layers", "Options"]`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UsedPath {
    pub segments: Vec<String>,
    pub line: usize,
}

impl Source {
    /// A file called `tests.rs`, one in a folder `tests`, and one with `#![cfg(test)]` holds tests and is blank as code.
    pub fn new(path: &str, text: &str) -> Self {
        let code = without_tests(&without_literals(text));
        let says_so = text.lines().any(|line| line == "#![cfg(test)]");
        let is_test = has_path_of_tests(path) || says_so;
        let code = if is_test { "\n".repeat(text.lines().count()) } else { code };
        Self { path: path.into(), text: text.into(), code }
    }

    /// Returns true for a file of tests by its path.
    pub fn is_test(&self) -> bool {
        has_path_of_tests(&self.path)
    }

    /// The file's own place, with its room: `layers/runs.rs` is `["layers", "runs"]`.
    pub fn module_path(&self) -> Vec<String> {
        let stem = self.path.trim_end_matches(".rs");
        let mut path: Vec<String> = stem.split('/').map(String::from).collect();
        if path.last().is_some_and(|last| last == "mod" || last == "lib" || last == "main") {
            path.pop();
        }
        path
    }

    /// The package that the file belongs to: the first part of every path in it. Files beside the rooms are of the root.
    fn room(&self) -> Vec<String> {
        self.path.split_once('/').map(|(room, _)| room.into()).into_iter().collect()
    }

    /// Everything that the file names through `crate::`, `super::`, `self::` or a package of the workspace.
    pub fn used_paths(&self) -> Vec<UsedPath> {
        let tokens = tokens(&self.code);
        let (room, here) = (self.room(), self.module_path());
        let mut found = Vec::new();
        for at in 0..tokens.len() {
            let continues = at > 0 && tokens[at - 1].text == "::";
            let starts =
                matches!(tokens[at].text, "crate" | "super" | "self") || member(tokens[at].text).is_some();
            if starts && !continues && tokens.get(at + 1).is_some_and(|next| next.text == "::") {
                let base = if tokens[at].text == "crate" { &room } else { &here };
                read_path(&tokens, at, &mut base.clone(), &mut found);
            }
        }
        found
    }

    /// The paths of what the file takes from its own modules, without its own place: `pub use error::{Error, Result};` names
    /// `["error", "Error"]` and `["error", "Result"]`.
    pub fn shown_names(&self) -> Vec<Vec<String>> {
        let tokens = tokens(&self.code);
        let mut found = Vec::new();
        for at in (1..tokens.len()).filter(|at| tokens[at - 1].text == "use") {
            let first = tokens[at].text;
            if !matches!(first, "crate" | "super" | "self") && member(first).is_none() {
                read_path(&tokens, at, &mut Vec::new(), &mut found);
            }
        }
        found.into_iter().map(|used| used.segments).collect()
    }

    /// The lines that name package `name` as the root of a path.
    pub fn lines_naming_package(&self, name: &str) -> Vec<usize> {
        let tokens = tokens(&self.code);
        let is_root = |at: usize| {
            let before = at.checked_sub(1).map_or("", |i| tokens[i].text);
            let after = tokens.get(at + 1).map_or("", |t| t.text);
            tokens[at].text == name
                && before != "::"
                && before != "."
                && (after == "::" || (before == "use" && matches!(after, ";" | "as")))
        };
        (0..tokens.len()).filter(|&at| is_root(at)).map(|at| tokens[at].line).collect()
    }
}

fn has_path_of_tests(path: &str) -> bool {
    path.ends_with("/tests.rs") || path.contains("/tests/")
}

/// The room whose package the code calls so: `quadratura_layers` is `layers`.
fn member(word: &str) -> Option<&str> {
    word.strip_prefix("quadratura_")
}

/// Reads the path or the tree of paths that starts at token `at`; `base` is the module it starts
/// from. Returns the position behind it.
fn read_path(tokens: &[Token], mut at: usize, base: &mut Vec<String>, found: &mut Vec<UsedPath>) -> usize {
    let line = tokens[at].line;
    loop {
        match tokens.get(at).map_or("", |t| t.text) {
            "{" => return read_group(tokens, at, base, found),
            "super" => drop(base.pop()),
            "crate" | "self" => {}
            word => match member(word) {
                Some(room) => *base = vec![room.into()],
                None => base.push(word.into()),
            },
        }
        at += 1;
        if tokens.get(at).is_none_or(|t| t.text != "::") {
            found.push(UsedPath { segments: base.clone(), line });
            return at;
        }
        at += 1;
    }
}

/// Reads `{a, b::c, d::{e, f}}`, whose paths all start from `base`.
fn read_group(tokens: &[Token], mut at: usize, base: &[String], found: &mut Vec<UsedPath>) -> usize {
    at += 1;
    while tokens.get(at).is_some_and(|t| t.text != "}") {
        at = read_path(tokens, at, &mut base.to_vec(), found);
        while tokens.get(at).is_some_and(|t| t.text != "," && t.text != "}") {
            at += 1; // `as name`
        }
        at += usize::from(tokens.get(at).is_some_and(|t| t.text == ","));
    }
    at + 1
}

/// Splits code into words, `::` and single signs.
pub fn tokens(code: &str) -> Vec<Token<'_>> {
    let mut found = Vec::new();
    for (number, line) in code.lines().enumerate() {
        let mut rest = line.trim_start();
        while let Some(first) = rest.chars().next() {
            let word = rest.find(|c: char| !is_word(c)).unwrap_or(rest.len());
            let length = match word {
                0 if rest.starts_with("::") => 2,
                0 => first.len_utf8(),
                _ => word,
            };
            found.push(Token { text: &rest[..length], line: number + 1 });
            rest = rest[length..].trim_start();
        }
    }
    found
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Blanks out comments, strings and characters, so that only code is left to read.
pub fn without_literals(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let in_word = out.chars().next_back().is_some_and(is_word);
        let length = literal_length(rest, in_word);
        if length == 0 {
            out.push(first);
            rest = &rest[first.len_utf8()..];
        } else {
            out.extend(rest[..length].chars().map(|c| if c == '\n' { '\n' } else { ' ' }));
            rest = &rest[length..];
        }
    }
    out
}

/// The bytes of the comment or literal at the start of `rest`; 0 where none starts.
fn literal_length(rest: &str, in_word: bool) -> usize {
    if rest.starts_with("//") {
        return rest.find('\n').unwrap_or(rest.len());
    }
    if rest.starts_with("/*") {
        return block_comment_length(rest);
    }
    if let Some(inside) = rest.strip_prefix('"') {
        return 1 + quoted_length(inside, '"');
    }
    if rest.starts_with('\'') {
        return character_length(rest);
    }
    if in_word { 0 } else { prefixed_string_length(rest) }
}

/// `/* */` with the comments inside it.
fn block_comment_length(rest: &str) -> usize {
    let (mut depth, mut at) = (0_usize, 0);
    while at < rest.len() {
        let here = &rest[at..];
        if here.starts_with("/*") {
            depth += 1;
            at += 2;
        } else if here.starts_with("*/") {
            depth -= 1;
            at += 2;
            if depth == 0 {
                return at;
            }
        } else {
            at += here.chars().next().map_or(1, char::len_utf8);
        }
    }
    at
}

/// Up to and with the closing quote, past escapes.
fn quoted_length(rest: &str, quote: char) -> usize {
    let mut escaped = false;
    for (at, c) in rest.char_indices() {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            _ if c == quote => return at + 1,
            _ => {}
        }
    }
    rest.len()
}

/// `'x'`, `'\n'`; 0 for a lifetime.
fn character_length(rest: &str) -> usize {
    let mut inside = rest[1..].chars();
    match (inside.next(), inside.next()) {
        (Some('\\'), _) => 1 + quoted_length(&rest[1..], '\''),
        (Some(c), Some('\'')) => 2 + c.len_utf8(),
        _ => 0,
    }
}

/// `b"…"`, `r"…"`, `br#"…"#`, `c"…"`; 0 where none starts.
fn prefixed_string_length(rest: &str) -> usize {
    let prefix = rest.len() - rest.trim_start_matches(['b', 'c', 'r']).len();
    if prefix == 0 || prefix > 2 {
        return 0;
    }
    let raw = rest[..prefix].contains('r');
    let hashes = rest[prefix..].len() - rest[prefix..].trim_start_matches('#').len();
    let open = prefix + hashes;
    if !rest[open..].starts_with('"') || (hashes > 0 && !raw) {
        return 0;
    }
    if !raw {
        return open + 1 + quoted_length(&rest[open + 1..], '"');
    }
    let close = format!("\"{}", "#".repeat(hashes));
    rest[open + 1..].find(&close).map_or(rest.len(), |at| open + 1 + at + close.len())
}

/// Blanks out every item behind `#[cfg(test)]` (expects text without literals).
fn without_tests(code: &str) -> String {
    const MARK: &str = "#[cfg(test)]";
    let mut out = String::with_capacity(code.len());
    let mut rest = code;
    while let Some(at) = rest.find(MARK) {
        out.push_str(&rest[..at]);
        let length = MARK.len() + item_length(&rest[at + MARK.len()..]);
        out.extend(rest[at..at + length].chars().map(|c| if c == '\n' { '\n' } else { ' ' }));
        rest = &rest[at + length..];
    }
    out.push_str(rest);
    out
}

/// Up to and with the `;` or the block that ends the item.
fn item_length(code: &str) -> usize {
    let mut depth = 0_usize;
    for (at, c) in code.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => {
                depth = depth.saturating_sub(1);
                if depth == 0 {
                    return at + 1;
                }
            }
            ';' if depth == 0 => return at + 1,
            _ => {}
        }
    }
    code.len()
}
