//! Names that are too long for their place: what they share with the names beside them is left out, so that one sees in what
//! they differ.

use std::ops::Range;

use eframe::egui::{TextStyle, Ui};

/// The number of names on either side that a name in a list is compared with: those that are seen together.
const BESIDE: usize = 5;

/// Returns the names beside the one at `index` in a list.
pub fn beside<'a>(index: usize, name: impl Fn(usize) -> Option<&'a str>) -> Vec<&'a str> {
    let places = index.saturating_sub(BESIDE)..=index + BESIDE;
    places.filter(|place| *place != index).filter_map(name).collect()
}

/// Returns as much of a name as fits into `width` points, in this style.
pub fn elided(ui: &Ui, name: &str, others: &[&str], width: f32, style: &TextStyle) -> String {
    let (font, color) = (style.resolve(ui.style()), ui.visuals().text_color());
    let fits = |text: &str| {
        // A point more is room beside the text.
        ui.painter().layout_no_wrap(text.to_owned(), font.clone(), color).size().x <= width + 1.0
    };
    fitted(name, others, fits)
}

/// Returns the longest shortening of a name that fits.
fn fitted(name: &str, others: &[&str], fits: impl Fn(&str) -> bool) -> String {
    if fits(name) {
        return name.to_owned();
    }
    let letters: Vec<char> = name.chars().collect();
    let own = own_part(&letters, others);
    let with = |kept: usize| shortened(&letters, own.clone(), kept);
    let (mut low, mut high) = (0, letters.len().saturating_sub(1));
    while low < high {
        let kept = (low + high).div_ceil(2);
        if fits(&with(kept)) { low = kept } else { high = kept - 1 }
    }
    with(low)
}

/// Returns the letters in which a name differs from the other ones, with the digits around them; nothing in the middle where
/// it shares nothing with them.
fn own_part(letters: &[char], others: &[&str]) -> Range<usize> {
    let (mut same_start, mut same_end) = (0, 0);
    for other in
        others.iter().map(|other| other.chars().collect::<Vec<char>>()).filter(|other| other != letters)
    {
        let same = letters.iter().zip(&other).take_while(|(a, b)| a == b).count();
        let left = letters.len().min(other.len()) - same;
        let from_behind = letters.iter().rev().zip(other.iter().rev()).take(left);
        same_start = same_start.max(same);
        same_end = same_end.max(from_behind.take_while(|(a, b)| a == b).count());
    }
    if same_start == 0 && same_end == 0 {
        let middle = letters.len() / 2;
        return middle..middle;
    }
    // What is shared with one name at the start may be shared with another one at the end.
    let end = letters.len() - same_end;
    let (mut start, mut end) = (same_start.min(end), same_start.max(end));
    let is_digit = |place: usize| letters.get(place).is_some_and(char::is_ascii_digit);
    while start > 0 && is_digit(start - 1) && (start == end || is_digit(start)) {
        start -= 1;
    }
    while is_digit(end) && (start == end || is_digit(end - 1)) {
        end += 1;
    }
    start..end
}

/// Returns a name with `kept` of its letters: those of its own part first, then as many of its beginning and its end.
fn shortened(letters: &[char], own: Range<usize>, kept: usize) -> String {
    let text = |range: Range<usize>| letters[range].iter().collect::<String>();
    if own.len() > kept {
        // No other name goes on like this.
        let before = if own.start > 0 { "…" } else { "" };
        return format!("{before}{}…", text(own.start..own.start + kept));
    }
    let (before, after) = (own.start, letters.len() - own.end);
    let rest = kept - own.len();
    let last = (rest / 2).max(rest.saturating_sub(before)).min(after);
    let first = (rest - last).min(before);
    let gap = |is_cut: bool| if is_cut { "…" } else { "" };
    // Without an own part there is one gap.
    let (one, other) = (first < before, last < after && (own.start < own.end || first == before));
    let (beginning, end) = (text(0..first), text(letters.len() - last..letters.len()));
    format!("{beginning}{}{}{}{end}", gap(one), text(own), gap(other))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(name: &str, others: &[&str], room: usize) -> String {
        fitted(name, others, |text| text.chars().count() <= room)
    }

    #[test]
    fn of_a_long_name_both_ends_are_shown() {
        assert_eq!(shown("wall_left", &[], 9), "wall_left");
        assert_eq!(shown("building_east_window_12", &[], 10), "build…w_12");
        assert_eq!(shown("abc", &[], 0), "…");
    }

    #[test]
    fn names_that_differ_in_the_middle_are_told_apart() {
        let names = ["chateau_2021_0012_undistorted.jpg", "chateau_2021_0013_undistorted.jpg"];
        let [one, other] = [0, 1].map(|index| shown(names[index], &[names[1 - index]], 15));
        assert!(one != other && one.chars().count() <= 15, "{one} and {other}");
        assert_eq!(one, "chate…0012….jpg");
    }

    #[test]
    fn what_is_its_own_is_kept_before_the_ends() {
        let others = ["palazzo_west.facade_arches_upper", "palazzo_west.facade_eaves_upper"];
        let name = "palazzo_west.facade_windows_upper";
        let shown = shown(name, &others, 13);
        assert!(shown.contains("window"), "{shown}");
    }

    #[test]
    fn of_a_long_part_of_its_own_the_beginning_is_shown() {
        let names = ["01_church.jpg", "02_from_southwest.jpg", "03_from_southeast.jpg"];
        assert_eq!(shown(names[1], &[names[0], names[2]], 6), "02_fr…");
        assert_eq!(shown("site/02_from_southwest.jpg", &["site/03_from_southeast.jpg"], 6), "…02_f…");
    }

    #[test]
    fn a_number_that_another_name_ends_with_is_told_apart() {
        let names = ["south_tree_1.billboard", "south_tree_2.billboard", "south_tree_12.billboard"];
        let shown = [0, 1, 2].map(|index| {
            let others: Vec<&str> = beside(index, |place| names.get(place).copied());
            shown(names[index], &others, 9)
        });
        assert!(
            shown[0].contains("…1…") && shown[1].contains("…2…") && shown[2].contains("…12…"),
            "{shown:?}"
        );
    }

    #[test]
    fn names_at_the_ends_of_a_list_have_fewer_beside_them() {
        let names = ["a", "b", "c"];
        assert_eq!(beside(0, |place| names.get(place).copied()), ["b", "c"]);
        assert_eq!(beside(2, |place| names.get(place).copied()), ["a", "b"]);
    }

    #[test]
    fn every_shortening_fits_and_none_is_longer_than_the_name() {
        let others = ["tree_1.billboard", "tree_12.billboard"];
        for room in 1..=16 {
            let shown = shown("tree_2.billboard", &others, room);
            assert!(shown.chars().count() <= room.max(3), "{shown} in {room}");
        }
    }
}
