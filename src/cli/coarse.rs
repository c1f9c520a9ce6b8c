//! Reports paint that is too coarse for another photo, for `update` and `import`.

use super::table::{Table, counted};
use super::words::command_for_project;
use quadratura_stacks::fill::propagation::CoarsePaint;

/// Maximum number of rows; JSON has all.
const MOST_ROWS: usize = 12;

/// Returns the list of photos that keep pixels because paint is too coarse for them, with what to do; empty where there
/// are none. `keep` is the verb: photos keep pixels, or will keep them.
pub fn coarse_text(coarse: &[CoarsePaint], keep: &str) -> String {
    if coarse.is_empty() {
        return String::new();
    }
    let mut table = Table::new(&["photo", "surface", "painted in", "pixels"]);
    for CoarsePaint { photo, face, from, pixels } in coarse.iter().take(MOST_ROWS) {
        table.row([photo.clone(), face.clone(), from.clone(), pixels.to_string()]);
    }
    let more = match coarse.len().saturating_sub(MOST_ROWS) {
        0 => String::new(),
        more => format!("and {} more (--json lists all)\n", counted(more, "surface")),
    };
    format!(
        "\nthese photos {keep} their own pixels, because the paint is less than half as fine as they are; views blend \
         both:\n{}{more}paint there in these photos, too; or mask it in them ({}), because masked pixels take paint of \
         any resolution; or leave a photo out for a surface ({})\n",
        table.render(),
        command_for_project("mask --photo PHOTO --add MASK.png"),
        command_for_project("decide --photo PHOTO --exclude SURFACE"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_list_is_cut_and_names_the_rest() {
        let paint = |number: u64| CoarsePaint {
            photo: format!("{number}.jpg"),
            face: "wall[0]".into(),
            from: "far.jpg".into(),
            pixels: 100 - number,
        };
        let coarse: Vec<CoarsePaint> = (0..14).map(paint).collect();
        let text = coarse_text(&coarse, "keep");
        assert!(text.contains("11.jpg  wall[0]  far.jpg") && !text.contains("12.jpg"), "{text}");
        assert!(text.contains("and 2 surfaces more"), "{text}");
        assert_eq!(coarse_text(&[], "keep"), "");
    }
}
