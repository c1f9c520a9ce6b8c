//! Words that the code has given up (`tests/retired_words.txt`) in identifiers.

use super::source::{Source, tokens};

/// Identifiers of more words are sentences: names of tests.
const SENTENCE: usize = 5;

/// The words of a list, one a line before a tab; lines that begin with `#` are comments.
pub fn words_of(list: &str) -> Vec<&str> {
    let lines = list.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
    lines.filter_map(|line| line.split('\t').next()).collect()
}

/// The words of an identifier in lower case: `LayerTexture` and `layer_texture` are two words.
fn words_in(identifier: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut before = '_';
    for letter in identifier.chars() {
        let begins = before == '_' || (letter.is_uppercase() && !before.is_uppercase());
        if letter != '_' {
            if begins {
                words.push(String::new());
            }
            words.last_mut().expect("the first letter begins a word").extend(letter.to_lowercase());
        }
        before = letter;
    }
    words
}

/// Identifiers of a source that hold a retired word, as `path: identifier`.
pub fn retired_in(source: &Source, retired: &[&str]) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for token in tokens(&source.code) {
        let words = words_in(token.text);
        if words.len() < SENTENCE && words.iter().any(|word| retired.contains(&word.as_str())) {
            found.push(format!("src/{}: {}", source.path, token.text));
        }
    }
    found.dedup();
    found
}

#[test]
fn a_retired_word_is_found_in_every_kind_of_identifier_and_not_in_sentences() {
    let retired = words_of("# a comment\ntold\tmessage\nsheet\tlayer texture\n");
    assert_eq!(retired, ["told", "sheet"]);
    let found = |code: &str| retired_in(&Source::new("io/a.rs", code), &retired).len();
    assert_eq!(found("fn told_of(x: u8) {}"), 1);
    assert_eq!(found("struct NoSheet; const SHEET_WORDS: u8 = 1;"), 2);
    assert_eq!(found("fn it_is_told_to_all() {} let toldo = stylesheet;"), 0);
    assert_eq!(found("// told\nlet a = \"told\";"), 0);
}
