//! Names of layers and groups: all that every editor gives back of a layer, besides its pixels.

use crate::io::layered::document::LONGEST_NAME;

/// The photo at the bottom.
pub const REFERENCE: &str = "photo - reference, do not paint here";

/// `readable object name [token]`, at most 63 characters. The token is the image layer's id, so
/// names are unique and lead back; editors that append to names append behind it.
pub fn layer_name(readable: &str, id: &str) -> String {
    ended(readable, &format!(" [{id}]"))
}

/// `readable object name - number`: unique, and leads nowhere.
pub fn numbered_name(readable: &str, number: usize) -> String {
    ended(readable, &format!(" - {number}"))
}

/// At most 63 characters, the ending whole.
fn ended(readable: &str, ending: &str) -> String {
    let room = LONGEST_NAME.saturating_sub(ending.chars().count());
    let plain: String = plain(readable).chars().take(room).collect();
    let plain = if plain.is_empty() { "layer" } else { plain.trim_end() };
    plain.to_owned() + ending
}

/// Without what editors or readers of names could trip over: brackets, which mark the token,
/// control characters, signs of no script; spaces are joined.
fn plain(readable: &str) -> String {
    let harmless = |c: char| match c {
        '[' => '(',
        ']' => ')',
        c if c.is_alphanumeric() || c.is_ascii_graphic() => c,
        c if c.is_whitespace() || c.is_control() => ' ',
        _ => '_',
    };
    let words: String = readable.chars().map(harmless).collect();
    words.split(' ').filter(|word| !word.is_empty()).collect::<Vec<_>>().join(" ")
}

/// The group of all image layers of one `order`; `last` is the highest.
pub fn group_name(order: u32, last: u32) -> String {
    match order {
        0 => "order 0 - nearest".into(),
        _ if order == last => format!("order {order} - farthest"),
        _ => format!("order {order}"),
    }
}

/// The guide of a group.
pub fn guide_name(order: u32) -> String {
    format!("guide {order} - hatched parts are hidden: paint them")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_ends_with_its_token() {
        assert_eq!(layer_name("facade left", "k7q2m9"), "facade left [k7q2m9]");
    }

    #[test]
    fn a_long_name_is_cut_and_the_token_is_not() {
        let name = layer_name(&"Säule ".repeat(20), "k7q2m9");
        assert!(name.chars().count() <= LONGEST_NAME && name.ends_with("Säule [k7q2m9]"), "{name}");
    }

    #[test]
    fn letters_of_every_script_stay_and_brackets_and_control_characters_do_not() {
        assert_eq!(layer_name(" Öl[1]\tпортал\n 門\u{202e}", "x"), "Öl(1) портал 門_ [x]");
        assert_eq!(layer_name("\0\0", "x"), "layer [x]");
    }

    #[test]
    fn nearest_and_farthest_are_said() {
        let names = [0, 1, 2].map(|order| group_name(order, 2));
        assert_eq!(names, ["order 0 - nearest", "order 1", "order 2 - farthest"]);
        assert_eq!(group_name(0, 0), "order 0 - nearest");
    }
}
