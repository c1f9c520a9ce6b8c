//! Paint of single photos that is laid over the others: who has painted, which of it is laid, what contradicts it.

use std::collections::BTreeMap;
use std::path::Path;

use crate::document::Stack;
use crate::document::stack::SpreadPaint;
use crate::error::Result;
use crate::io::paint_store::PaintStore;
use crate::layers::fill::FillOptions;

/// All photos, as [`FillOptions::propagate`] has it.
const ALL: &str = "*";

/// A photo that somebody has painted on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Painter {
    /// Its name.
    pub photo: String,
    /// Pixels that were painted.
    pub pixels: u64,
}

/// The photos that somebody has painted on, by name.
///
/// # Errors
/// When the book of paint cannot be read.
pub fn painters(project: &Path) -> Result<Vec<Painter>> {
    let mut pixels: BTreeMap<String, u64> = BTreeMap::new();
    for entry in PaintStore::new(project).read()?.entries {
        *pixels.entry(entry.photo).or_default() += entry.pixels;
    }
    let painted = pixels.into_iter().filter(|(_, pixels)| *pixels > 0);
    Ok(painted.map(|(photo, pixels)| Painter { photo, pixels }).collect())
}

/// The options with the paint of all photos laid over the others, or of none.
pub fn with_all(options: &FillOptions, on: bool) -> FillOptions {
    let propagate = if on { vec![ALL.to_owned()] } else { Vec::new() };
    FillOptions { propagate, ..options.clone() }
}

/// The options with the paint of one photo laid over the others, or not; `all` are those that have paint.
pub fn with_one(options: &FillOptions, photo: &str, on: bool, all: &[Painter]) -> FillOptions {
    let names = all.iter().map(|painter| painter.photo.as_str());
    let wanted = |name: &&str| if *name == photo { on } else { options.propagates(name) };
    let wanted: Vec<String> = names.filter(wanted).map(str::to_owned).collect();
    match wanted.len() == all.len() {
        true => with_all(options, true),
        false => FillOptions { propagate: wanted, ..options.clone() },
    }
}

/// Paint that belongs on a photo.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SpreadOn {
    /// The photo's place in the site.
    pub photo: usize,
    /// What, and what stands against it.
    pub paint: SpreadPaint,
}

impl SpreadOn {
    /// Texels where something clearly says something else.
    pub fn disputed(&self) -> u64 {
        self.paint.conflicts + self.paint.dissents
    }
}

/// What was laid over the photos when they were filled; `stacks` in the site's order.
pub fn laid_over(stacks: &[Option<&Stack>]) -> Vec<SpreadOn> {
    let fills =
        stacks.iter().enumerate().filter_map(|(photo, stack)| Some((photo, stack.as_ref()?.fill.as_ref()?)));
    let laid = fills.flat_map(|(photo, fill)| fill.spread.iter().map(move |paint| (photo, paint.clone())));
    most_disputed_first(laid.map(|(photo, paint)| SpreadOn { photo, paint }).collect())
}

/// What contradicts most comes first, then what is laid over most; ties by photo, face and painter.
pub fn most_disputed_first(mut spread: Vec<SpreadOn>) -> Vec<SpreadOn> {
    spread.sort_by(|a, b| {
        let rank = |it: &SpreadOn| (std::cmp::Reverse(it.disputed()), std::cmp::Reverse(it.paint.texels));
        rank(a).cmp(&rank(b)).then_with(|| (a.photo, &a.paint).cmp(&(b.photo, &b.paint)))
    });
    spread
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> Vec<Painter> {
        ["a.jpg", "b.jpg", "c.jpg"].map(|photo| Painter { photo: photo.into(), pixels: 9 }).to_vec()
    }

    #[test]
    fn single_photos_are_taken_out_of_all_and_put_back() {
        let everyone = with_all(&FillOptions::default(), true);
        let some = with_one(&everyone, "b.jpg", false, &all());
        assert_eq!(some.propagate, ["a.jpg", "c.jpg"]);
        assert_eq!(with_one(&some, "b.jpg", true, &all()), everyone);
        let none = with_one(&with_one(&some, "a.jpg", false, &all()), "c.jpg", false, &all());
        assert_eq!(none, with_all(&everyone, false));
        assert!(none.propagate.is_empty());
    }

    #[test]
    fn what_contradicts_most_comes_first() {
        let spread = |photo, face: &str, texels, conflicts, dissents| SpreadOn {
            photo,
            paint: SpreadPaint {
                face: face.into(),
                from: "a.jpg".into(),
                texels,
                own: conflicts,
                conflicts,
                dissents,
            },
        };
        let sorted = most_disputed_first(vec![
            spread(1, "wall[0]", 900, 0, 0),
            spread(2, "wall[1]", 10, 3, 0),
            spread(0, "wall[2]", 10, 2, 9),
            spread(1, "door[0]", 900, 0, 0),
        ]);
        let order: Vec<_> = sorted.iter().map(|it| (it.photo, it.paint.face.as_str())).collect();
        assert_eq!(order, [(0, "wall[2]"), (2, "wall[1]"), (1, "door[0]"), (1, "wall[0]")]);
    }
}
