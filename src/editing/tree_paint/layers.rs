//! The layers of a species' file: where they are on the canvas, and what they are called.

use quadratura_base::geometry::PixelRect;
use quadratura_files::hash::hash_bytes;
use quadratura_foliage::DIRECTION_NAMES;

/// The name of the locked layer behind the six views.
pub const BACKDROP: &str = "background - do not paint here";
/// The number of characters of a layer's token.
const TOKEN_DIGITS: usize = 10;

/// Returns the name of a species' file and of its record: the species', with the sub-object where it is not the whole plant.
pub fn title(species: &str, part: Option<&str>) -> String {
    part.map_or_else(|| species.to_owned(), |part| format!("{species}, {part}"))
}

/// Returns the place of a direction's view on the canvas: above each other those along one axis.
pub fn cell(direction: usize, side: u32) -> PixelRect {
    let (column, row) = (direction as u32 / 2, direction as u32 % 2);
    PixelRect { x: (column * side) as i32, y: (row * side) as i32, w: side, h: side }
}

/// Returns the size of the canvas.
pub fn canvas(side: u32) -> PixelRect {
    PixelRect::of_size(3 * side, 2 * side)
}

/// Returns the token of a layer. It is the same in all exports of a sub-object.
pub fn token(species: &str, part: Option<&str>, direction: usize, slab: usize) -> String {
    let text = format!("{species}\n{part:?}\n{}\n{slab}", DIRECTION_NAMES[direction]);
    hash_bytes(text.as_bytes())[..TOKEN_DIGITS].to_owned()
}

/// Returns the name of a direction's group.
pub fn group_name(direction: usize) -> String {
    format!("from {}", DIRECTION_NAMES[direction])
}

/// Returns what a layer is called before its token.
pub fn readable(direction: usize, slab: usize, slabs: usize) -> String {
    let name = DIRECTION_NAMES[direction];
    match slab {
        0 => format!("{name} slab 1, nearest"),
        slab if slab + 1 == slabs => format!("{name} slab {}, farthest", slab + 1),
        slab => format!("{name} slab {}", slab + 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_layers_of_two_species_have_one_token_and_no_two_views_one_place() {
        let mut tokens = std::collections::BTreeSet::new();
        for (species, part) in
            [("maple", None), ("oak", None), ("maple", Some("branch")), ("maple", Some("oak"))]
        {
            for (direction, slab) in (0..6).flat_map(|direction| (0..6).map(move |slab| (direction, slab))) {
                assert!(tokens.insert(token(species, part, direction, slab)));
            }
        }
        for (a, b) in (0..6).flat_map(|a| (0..a).map(move |b| (a, b))) {
            assert!(cell(a, 40).intersection(&cell(b, 40)).is_empty());
            assert_eq!(cell(a, 40).intersection(&canvas(40)), cell(a, 40));
        }
    }
}
