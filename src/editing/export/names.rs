//! Names of layers and groups, which are all that every editor preserves of a layer besides its pixels.

use quadratura_layered_files::document::LONGEST_NAME;
pub use quadratura_layered_files::document::{TREE_GUIDE, guide_name};

/// The name of the photo's layer at the bottom.
pub const REFERENCE: &str = "photo - reference, do not paint here";

/// Returns `readable object name [token]`, at most 63 characters. The token is the image layer's id, so that names
/// are unique and identify the layer; editors that append to names do so after it.
pub fn layer_name(readable: &str, id: &str) -> String {
    ended(readable, &format!(" [{id}]"))
}

/// Returns `readable object name - number`, which is unique and does not identify a layer.
pub fn numbered_name(readable: &str, number: usize) -> String {
    ended(readable, &format!(" - {number}"))
}

/// Appends the ending, and shortens the name to 63 characters in all.
fn ended(readable: &str, ending: &str) -> String {
    let room = LONGEST_NAME.saturating_sub(ending.chars().count());
    let plain: String = plain(readable).chars().take(room).collect();
    let plain = if plain.is_empty() { "layer" } else { plain.trim_end() };
    plain.to_owned() + ending
}

/// Returns the name without characters that could confuse editors or readers: square brackets, which mark the
/// token, control characters, and symbols of no script. Consecutive spaces become one.
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

/// Returns the name of the group of all image layers of one `order`; `last` is the highest order.
pub fn group_name(order: u32, last: u32) -> String {
    match order {
        0 => "order 0 - nearest".into(),
        _ if order == last => format!("order {order} - farthest"),
        _ => format!("order {order}"),
    }
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
