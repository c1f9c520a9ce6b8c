//! Suggestions: what stands in one photo alone, found by asking the others, kept in `cache/suggestions/` until somebody
//! accepts it.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use glam::DVec2;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::MaskEdit;
use crate::document::Stack;
use crate::document::masks::MaskFrom;
use crate::document::names::file_name_of_photo;
use crate::error::{Error, Result};
use crate::geometry::{PixelRect, Spans};
use crate::io::atomic::write_atomically;
use crate::io::json::{read_json, to_json};
use crate::io::mask_file::{mask_png, read_mask};
use crate::io::overlay::Overlay;
use crate::io::photo::{read_photo, read_shown};
use crate::io::reference::reference;
use crate::io::stack_store::StackStore;
use crate::layers::fill::{Donor, Surfaces};
use crate::layers::strangers::{Look, StrangerOptions, Suspect, Witnesses, disagreement, suspects};
use crate::projection::exposure::Optics;
use crate::projection::framing::scaled;
use crate::projection::{Gains, Projector};
use crate::recipe::budget::Budget;
use crate::recipe::gains::{self, photo_gains};
use crate::recipe::open::Opened;
use crate::recipe::relief::SiteRelief;
use crate::scene::{Photo, PhotoPixels, Samples};
use crate::task::Task;

/// What was found: large and different things first.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Suggestions {
    /// `VERSION`.
    pub version: u32,
    /// Numbered from 1.
    pub list: Vec<Suggestion>,
}

/// A region of a photo that shows something that the others do not.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Suggestion {
    /// What it is accepted by.
    pub number: u32,
    /// The photo's name.
    pub photo: String,
    /// The photo's, in pixels.
    pub size: [u32; 2],
    /// Around what would be masked, in pixels of the photo.
    pub rect: PixelRect,
    /// Pixels that would be masked.
    pub pixels: u64,
    /// Of the photo's pixels, 0 to 1.
    pub share: f64,
    /// How far it differs from what the others agree on, on average: a natural logarithm of light.
    pub score: f64,
    /// What would be masked: black in this PNG, beside `suggestions.json`.
    pub mask: String,
    /// The photo with all that is suggested of it, beside `suggestions.json`.
    pub picture: String,
}

const VERSION: u32 = 1;
const LARGEST: u64 = 64 << 20;
const FILE: &str = "suggestions.json";

/// Pixels a side of a picture.
const PICTURE_SIDE: u32 = 1600;

/// Where suggestions are kept.
pub fn suggestion_folder(project: &Path) -> PathBuf {
    project.join("cache/suggestions")
}

/// Looks for strangers in these photos (names in full; none for all), asks all photos about them, and keeps what was
/// found in place of earlier suggestions of the same photos; those of others stay, with their numbers. What is masked
/// already says nothing and is not found again. `memory`: bytes that photos decoded at the same time may take.
///
/// # Errors
/// [`Error::Io`] when nothing can be written; [`Error::Cancelled`]. A photo that cannot be read is a note.
pub fn suggest(
    folder: &Path,
    opened: &Opened,
    photos: &[String],
    memory: u64,
    task: &Task,
) -> Result<Suggestions> {
    let options = StrangerOptions::default();
    let found = task.timed("find strangers", || strangers(folder, opened, photos, &options, memory, task))?;
    let site = &opened.site;
    let mut all: Vec<(&Photo, Found)> = Vec::new();
    for (place, found) in found {
        all.extend(found.into_iter().map(|found| (&site.photos[place], found)));
    }
    // What is equal stays in the order of photos, from the top.
    all.sort_by(|a, b| b.1.weight.total_cmp(&a.1.weight));
    let target = suggestion_folder(folder);
    std::fs::create_dir_all(&target).map_err(Error::io(&target, "create the folder"))?;
    // Until the list names the new ones the old ones have their masks.
    let old = suggestions(folder).map(|found| found.list).unwrap_or_default();
    let first = old.iter().map(|suggestion| suggestion.number).max().unwrap_or(0) + 1;
    let mut new = Vec::with_capacity(all.len());
    for ((photo, found), number) in all.iter().zip(first..) {
        let size = [photo.camera.width, photo.camera.height];
        let mask = format!("{number}.png");
        let bytes = mask_png(&found.masked, size).map_err(Error::io(&target, "encode a mask for it"))?;
        write_atomically(target.join(&mask), &bytes)?;
        let pixels = found.masked.count();
        new.push(Suggestion {
            number,
            photo: photo.name.clone(),
            size,
            rect: found.masked.bounds(),
            pixels,
            share: pixels as f64 / (f64::from(size[0]) * f64::from(size[1])),
            score: f64::from(found.score),
            mask,
            picture: format!("{}.jpg", file_name_of_photo(&photo.name)),
        });
    }
    task.timed("draw suggestions", || pictures(&target, &all, first, task))?;
    // Somebody may dismiss one just now: the list is read after that, or written before it.
    let _listing = LISTING.lock().unwrap_or_else(PoisonError::into_inner);
    let mut kept = others(folder, opened, photos);
    kept.list.extend(new);
    write_atomically(target.join(FILE), &to_json(&kept))?;
    tidied(&target, &kept)?;
    Ok(kept)
}

/// Held by whoever reads the list to write it.
static LISTING: Mutex<()> = Mutex::new(());

/// What was suggested of photos that are not looked at now.
fn others(folder: &Path, opened: &Opened, looked_at: &[String]) -> Suggestions {
    // None yet, or of a program that wrote them otherwise: they can be looked for again.
    let list = suggestions(folder).map(|found| found.list).unwrap_or_default();
    let is_other = |suggestion: &Suggestion| {
        let photo = &suggestion.photo;
        let is_there = opened.site.photos.iter().any(|it| it.name == *photo);
        is_there && !looked_at.is_empty() && !looked_at.contains(photo)
    };
    Suggestions { version: VERSION, list: list.into_iter().filter(is_other).collect() }
}

/// The suggestions that were made last.
///
/// # Errors
/// [`Error::Request`] when there are none; [`Error::Input`] and [`Error::Io`] when they cannot be read.
pub fn suggestions(project: &Path) -> Result<Suggestions> {
    let file = suggestion_folder(project).join(FILE);
    if !file.is_file() {
        return Err(Error::Request(
            "nothing is suggested yet; `quadratura mask --suggest` looks for it".into(),
        ));
    }
    let found: Suggestions = read_json(&file, LARGEST, "run `quadratura mask --suggest` again")?;
    Ok(found)
}

/// The edits that accept suggestions by their numbers; all of them where there is none.
///
/// # Errors
/// [`Error::Request`] for numbers that are not there, all at once; [`Error::Input`] and [`Error::Io`] for masks that
/// cannot be read.
pub fn accepted(project: &Path, numbers: &[u32]) -> Result<Vec<MaskEdit>> {
    let suggestions = suggestions(project)?;
    let known = |number: &u32| suggestions.list.iter().any(|suggestion| suggestion.number == *number);
    let unknown = numbers.iter().filter(|number| !known(number));
    let errors = unknown.map(|number| Error::Request(format!("there is no suggestion {number}"))).collect();
    if let Some(error) = Error::of_all(errors) {
        return Err(error);
    }
    let wanted = suggestions.list.iter().filter(|s| numbers.is_empty() || numbers.contains(&s.number));
    let edit = |suggestion: &Suggestion| {
        let masked = pixels(project, suggestion)?;
        Ok(MaskEdit::Add { photo: suggestion.photo.clone(), from: MaskFrom::Suggested, masked })
    };
    wanted.map(edit).collect()
}

/// What a suggestion would mask, in pixels of its photo.
///
/// # Errors
/// As [`read_mask`].
pub fn pixels(project: &Path, suggestion: &Suggestion) -> Result<Spans> {
    read_mask(&suggestion_folder(project).join(&suggestion.mask), suggestion.size)
}

/// Forgets suggestions that somebody has looked at and that are nothing; the others keep their numbers.
///
/// # Errors
/// As [`suggestions`]; [`Error::Io`] when the list cannot be written.
pub fn dismiss(project: &Path, numbers: &[u32]) -> Result<()> {
    let _listing = LISTING.lock().unwrap_or_else(PoisonError::into_inner);
    let mut kept = suggestions(project)?;
    kept.list.retain(|suggestion| !numbers.contains(&suggestion.number));
    write_atomically(suggestion_folder(project).join(FILE), &to_json(&kept))
}

/// A suspect in pixels of its photo.
struct Found {
    masked: Spans,
    score: f32,
    weight: f32,
}

/// By the photo's place in the site.
fn strangers(
    folder: &Path,
    opened: &Opened,
    photos: &[String],
    options: &StrangerOptions,
    memory: u64,
    task: &Task,
) -> Result<Vec<(usize, Vec<Found>)>> {
    let site = &opened.site;
    let store = StackStore::new(folder);
    let stacks: Vec<Option<Stack>> =
        site.photos.iter().map(|photo| store.current(&photo.name).ok().flatten()).collect();
    let gains = photo_gains(site, &stacks, &opened.project.colour, folder, memory, task)?;
    let relief = SiteRelief::open(site, &gains::inputs(site, &stacks), folder, memory, task)?;
    let surfaces = Surfaces::of(&site.model);
    let budget = Budget::new(memory);
    let reader = Reader { opened, surfaces: &surfaces, gains: &gains, options, budget: &budget, task };
    let looks: Vec<Option<Look>> =
        (0..site.photos.len()).into_par_iter().map(|place| reader.look(place)).collect::<Result<_>>()?;
    let witnesses = Witnesses { looks: &looks, surfaces: &surfaces, relief: relief.whole() };
    let asked = |place: &usize| photos.is_empty() || photos.contains(&site.photos[*place].name);
    let places: Vec<usize> = (0..looks.len()).filter(asked).collect();
    let mut found = Vec::new();
    for (done, &place) in (0..).zip(&places) {
        task.step("ask the others", done, places.len() as u64)?;
        let Some(look) = &looks[place] else { continue };
        let apart = disagreement(&witnesses, place, options, task)?;
        let small = suspects(&apart, look.donor.camera.width as usize, options);
        let photo = &site.photos[place];
        found.push((place, small.iter().map(|suspect| enlarged(suspect, look, photo)).collect()));
    }
    task.step("ask the others", places.len() as u64, places.len() as u64)?;
    Ok(found)
}

struct Reader<'a> {
    opened: &'a Opened,
    surfaces: &'a Surfaces,
    gains: &'a Gains,
    options: &'a StrangerOptions,
    budget: &'a Budget,
    task: &'a Task,
}

impl Reader<'_> {
    /// A photo made small; none where it cannot be read.
    fn look(&self, place: usize) -> Result<Option<Look>> {
        self.task.go_on()?;
        let photo = &self.opened.site.photos[place];
        let (width, height) = (u64::from(photo.camera.width), u64::from(photo.camera.height));
        // As decoded with alpha, once more in colour alone, and as words while it is made smaller.
        let made = self.budget.with(width * height * 16, || self.small(photo));
        match made {
            Ok((pixels, projector)) => {
                let project = &self.opened.project;
                let (model, tolerance) = (&self.opened.site.model, project.options.tolerance);
                let donor = Donor::new(&projector, &pixels, &[], model, self.surfaces, tolerance);
                let optics: &Optics = &self.gains.optics[place];
                Ok(Some(Look::new(donor, self.gains.of_photo[place], optics)))
            }
            Err(Error::Cancelled) => Err(Error::Cancelled),
            Err(error) => {
                self.task.of(&photo.name).note(format!("it is not asked: {error}"));
                Ok(None)
            }
        }
    }

    fn small(&self, photo: &Photo) -> Result<(PhotoPixels, Projector)> {
        let longest = photo.camera.width.max(photo.camera.height);
        let scale = f64::from(self.options.longest_side) / f64::from(longest);
        let camera = scaled(&photo.camera, scale.min(1.0));
        let small = reference(&read_shown(photo)?, camera.width, camera.height);
        let rgb = small.rgb.as_chunks::<3>().0.iter().zip(&small.valid);
        let samples = rgb.flat_map(|(&[r, g, b], valid)| [r, g, b, if *valid { u8::MAX } else { 0 }]);
        let samples = Samples::U8(samples.collect());
        let pixels =
            PhotoPixels { width: camera.width, height: camera.height, channels: 4, samples, icc: None };
        let projector = Projector { name: photo.name.clone(), camera, pose: photo.pose };
        Ok((pixels, projector))
    }
}

/// A suspect of a small photo in pixels of the photo itself.
fn enlarged(suspect: &Suspect, look: &Look, photo: &Photo) -> Found {
    let (small, large) = (&look.donor.camera, &photo.camera);
    let [across, down] =
        [(large.width, small.width), (large.height, small.height)].map(|(l, s)| f64::from(l) / f64::from(s));
    let edge = |at: i32, scale: f64| (f64::from(at) * scale).round() as i32;
    let bounds = suspect.masked.bounds();
    let rows = edge(bounds.y, down)..edge(bounds.bottom(), down);
    let masked = Spans::of_rows(rows, |y, out| {
        let row = ((f64::from(y) + 0.5) / down) as i32;
        out.extend(suspect.masked.row(row).iter().map(|run| edge(run.start, across)..edge(run.end, across)));
    });
    Found { masked, score: suspect.score, weight: suspect.weight }
}

/// Removes masks and pictures that no suggestion names any more.
fn tidied(folder: &Path, kept: &Suggestions) -> Result<()> {
    let of_one = |suggestion: &Suggestion| [suggestion.mask.clone(), suggestion.picture.clone()];
    let named: BTreeSet<String> = kept.list.iter().flat_map(of_one).chain([FILE.to_owned()]).collect();
    for entry in std::fs::read_dir(folder).map_err(Error::io(folder, "read the folder"))? {
        let path = entry.map_err(Error::io(folder, "read the folder"))?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if path.is_file() && !named.contains(&*name) {
            std::fs::remove_file(&path).map_err(Error::io(&path, "remove it"))?;
        }
    }
    Ok(())
}

/// A picture of each photo that something is suggested of.
fn pictures(folder: &Path, all: &[(&Photo, Found)], first: u32, task: &Task) -> Result<()> {
    let mut photos: Vec<&Photo> = all.iter().map(|(photo, _)| *photo).collect();
    photos.sort_by(|a, b| a.name.cmp(&b.name));
    photos.dedup_by(|a, b| a.name == b.name);
    for photo in photos {
        task.go_on()?;
        let pixels = read_photo(&photo.file, photo.camera.width, photo.camera.height)?;
        let mut overlay = Overlay::new(&pixels, PICTURE_SIDE);
        drop(pixels);
        let longest = photo.camera.width.max(photo.camera.height);
        let unit = f64::from(longest) / f64::from(PICTURE_SIDE);
        for ((other, found), number) in all.iter().zip(first..) {
            if other.name == photo.name {
                outline(&mut overlay, &found.masked);
                let bounds = found.masked.bounds();
                let corner = DVec2::new(f64::from(bounds.x), f64::from(bounds.y) - 16.0 * unit);
                overlay.number(corner.max(DVec2::splat(4.0 * unit)), 12.0 * unit, number, COLOUR);
            }
        }
        overlay.write(&folder.join(format!("{}.jpg", file_name_of_photo(&photo.name))))?;
    }
    Ok(())
}

/// Seldom seen on facades.
const COLOUR: [u8; 3] = [255, 40, 200];

/// The rim of a set: the ends of its runs, and what has nothing above or below.
fn outline(overlay: &mut Overlay, masked: &Spans) {
    let mut line = |x0: i32, y0: i32, x1: i32, y1: i32| {
        let at = |x: i32, y: i32| DVec2::new(f64::from(x), f64::from(y));
        overlay.line(at(x0, y0), at(x1, y1), COLOUR, 1.0);
    };
    let rows = masked.rows();
    for y in rows.start..rows.end {
        masked.row(y).iter().for_each(|run| {
            line(run.start, y, run.start, y + 1);
            line(run.end, y, run.end, y + 1);
        });
    }
    let shifted = |by: i32| {
        Spans::of_rows(rows.start + by..rows.end + by, |y, out| {
            out.extend(masked.row(y - by).iter().cloned())
        })
    };
    for (rim, edge) in [(masked.minus(&shifted(1)), 0), (masked.minus(&shifted(-1)), 1)] {
        rim.iter().for_each(|(y, run)| line(run.start, y + edge, run.end, y + edge));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_accepted_before_something_is_suggested() {
        let folder = tempfile::tempdir().unwrap();
        assert!(accepted(folder.path(), &[]).unwrap_err().to_string().contains("--suggest"));
    }

    #[test]
    fn suggestions_are_accepted_by_number_and_strangers_are_told_all_at_once() {
        let project = tempfile::tempdir().unwrap();
        let folder = suggestion_folder(project.path());
        std::fs::create_dir_all(&folder).unwrap();
        let mut kept = Suggestions { version: VERSION, list: Vec::new() };
        for number in 1..=2 {
            let masked = Spans::of_pixels(PixelRect::of_size(number, 1), |_, _| true);
            std::fs::write(folder.join(format!("{number}.png")), mask_png(&masked, [9, 4]).unwrap()).unwrap();
            kept.list.push(Suggestion {
                number,
                photo: "a.jpg".into(),
                size: [9, 4],
                rect: masked.bounds(),
                pixels: number.into(),
                share: 0.1,
                score: 1.0,
                mask: format!("{number}.png"),
                picture: "a.jpg.jpg".into(),
            });
        }
        std::fs::write(folder.join(FILE), to_json(&kept)).unwrap();
        let pixels = |numbers: &[u32]| {
            let edits = accepted(project.path(), numbers).unwrap();
            let count = |edit: &MaskEdit| match edit {
                MaskEdit::Add { masked, from: MaskFrom::Suggested, .. } => masked.count(),
                other => panic!("{other:?}"),
            };
            edits.iter().map(count).collect::<Vec<_>>()
        };
        assert_eq!((pixels(&[]), pixels(&[2])), (vec![1, 2], vec![2]));
        let told = accepted(project.path(), &[2, 7, 8]).unwrap_err().to_string();
        assert!(told.contains('7') && told.contains('8'), "{told}");
        dismiss(project.path(), &[1]).unwrap();
        assert_eq!(pixels(&[]), [2], "the others stay, with their numbers");
        assert_eq!(super::suggestions(project.path()).unwrap().list[0].number, 2);
    }
}
