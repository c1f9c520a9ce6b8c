//! Suggested masks: transient objects that only one photo shows, found by comparison with the others, and kept in
//! `cache/suggestions/` until they are accepted.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::agreement::{AgreementInputs, SiteAgreement};
use crate::gains;
use crate::relief::SiteRelief;
use quadratura_base::error::{Error, Remedy, Result};
use quadratura_base::geometry::{PixelRect, Spans};
use quadratura_base::scene::{Photo, PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_document::masks::MaskOrigin;
use quadratura_document::names::file_name_of_photo;
use quadratura_document::{Project, Stack};
use quadratura_files::atomic::write_atomically;
use quadratura_files::json::{read_json, to_json};
use quadratura_import::photo::read_photo;
use quadratura_io::mask_file::{mask_png, read_mask};
use quadratura_io::overlay::Overlay;
use quadratura_io::stack_store::StackStore;
use quadratura_layers::agreement::{PhotoEvidence, Thing};
use quadratura_sites::masks::MaskEdit;

/// The suggestions: likely ones first, and of these large and strongly different ones.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Suggestions {
    /// The version of the file's format.
    pub version: u32,
    /// The suggestions, numbered from 1.
    pub list: Vec<MaskSuggestion>,
}

/// A region of a photo that shows something which other photos do not.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MaskSuggestion {
    /// The number by which it is accepted.
    pub number: u32,
    /// The photo's name.
    pub photo: String,
    /// The photo's size in pixels.
    pub size: [u32; 2],
    /// The bounding box of the suggested mask, in photo pixels.
    pub rect: PixelRect,
    /// The number of pixels that would be masked.
    pub pixels: u64,
    /// The share of the photo's pixels that would be masked, 0..=1.
    pub share: f64,
    /// The mean difference from the colours of the photos that contradict it, as a natural logarithm of light.
    pub score: f64,
    /// How likely it is a thing that stands before what the others show, 0..=1.
    pub likelihood: f64,
    /// The suggested mask as a PNG beside `suggestions.json`, in which masked pixels are black.
    pub mask: String,
    /// The picture of the photo with all its suggestions, beside `suggestions.json`.
    pub picture: String,
}

impl MaskSuggestion {
    /// Returns true for what is listed unless all is asked for.
    pub fn is_likely(&self) -> bool {
        self.likelihood >= LIKELY
    }
}

/// The version of the file's format.
const VERSION: u32 = 2;
/// The likelihood from which on a suggestion is listed.
const LIKELY: f64 = 0.45;
/// The width in photo pixels by which suggested masks are wider than what was found, because colours at its rim are
/// mixed.
pub const MARGIN_PX: u32 = 6;
/// What the search cannot see.
pub const UNSEEN: &str = "Not found: objects in front of surfaces that fewer than two other photos show, objects in front of the sky \
                          alone, and dark objects in front of dark surfaces.";
/// The largest size of the file that is read, in bytes.
const LARGEST: u64 = 64 << 20;
/// The name of the list's file.
const FILE: &str = "suggestions.json";

/// The longer side of a picture in pixels.
const PICTURE_SIDE: u32 = 1600;

/// Returns the folder of suggestions.
pub fn suggestion_folder(project: &Path) -> PathBuf {
    project.join("cache/suggestions")
}

/// Searches these photos (full names; all photos for an empty list) for transient objects, by comparison with all
/// photos. The results replace earlier suggestions for the same photos; those for others stay, with their numbers.
/// Masked pixels are neither used nor found again. Masks are `margin` photo pixels wider than what was found. `memory` is
/// the budget in bytes for photos decoded at the same time.
///
/// # Errors
/// Returns [`Error::Io`] when nothing can be written, or [`Error::Cancelled`]. A photo that cannot be read is
/// noted.
pub fn suggest(
    folder: &Path,
    project: &Project,
    site: &Site,
    photos: &[String],
    margin: u32,
    memory: u64,
    task: &Task,
) -> Result<Suggestions> {
    let found = task.timed("find transient objects", || {
        transients(folder, project, site, photos, margin, memory, task)
    })?;
    let mut all: Vec<(&Photo, FoundRegion)> = Vec::new();
    for (id, found) in found {
        all.extend(found.into_iter().map(|found| (site.photo(id), found)));
    }
    // The sort is stable: equal ones stay in the order of photos, from top to bottom. Likely ones get the first numbers.
    all.sort_by(|a, b| {
        let is_likely = |found: &FoundRegion| f64::from(found.likelihood) >= LIKELY;
        is_likely(&b.1).cmp(&is_likely(&a.1)).then(b.1.weight.total_cmp(&a.1.weight))
    });
    let target = suggestion_folder(folder);
    std::fs::create_dir_all(&target).map_err(Error::io(&target, "create the folder"))?;
    // New files get new numbers, because the old list is valid until it is replaced.
    let old = suggestions(folder).map(|found| found.list).unwrap_or_default();
    let first = old.iter().map(|suggestion| suggestion.number).max().unwrap_or(0) + 1;
    let mut new = Vec::with_capacity(all.len());
    for ((photo, found), number) in all.iter().zip(first..) {
        let size = [photo.camera.width, photo.camera.height];
        let mask = format!("{number}.png");
        let bytes = mask_png(&found.masked, size).map_err(Error::io(&target, "encode a mask for it"))?;
        write_atomically(target.join(&mask), &bytes)?;
        let pixels = found.masked.count();
        new.push(MaskSuggestion {
            number,
            photo: photo.name.clone(),
            size,
            rect: found.masked.bounds(),
            pixels,
            share: pixels as f64 / (f64::from(size[0]) * f64::from(size[1])),
            score: f64::from(found.score),
            likelihood: f64::from(found.likelihood),
            mask,
            picture: format!("{}.jpg", file_name_of_photo(&photo.name)),
        });
    }
    task.timed("draw suggestions", || pictures(&target, &all, first, task))?;
    // A suggestion may be dismissed concurrently: the lock orders reading and writing of the list.
    let _listing = LISTING.lock().unwrap_or_else(PoisonError::into_inner);
    let mut kept = others(folder, site, photos);
    kept.list.extend(new);
    write_atomically(target.join(FILE), &to_json(&kept))?;
    remove_unused(&target, &kept)?;
    Ok(kept)
}

/// The least share of a photo that a transient object takes to be large: a person nearby, or a car. The largest regions
/// without masks are two strips along the eaves on castle (13 photos), 0.90 and 0.48 %; then 0.23 % on piazza (9), 0.15 %
/// on entry (5) and 0.09 % on fountain (6). So no photo of the four sites is named.
const LARGE: f64 = 0.01;

/// What is large and in one photo only: photos with its share, largest first.
#[derive(Debug, Default, PartialEq)]
pub struct LargeFindings {
    /// Things, which can be masked.
    pub things: Vec<(String, f64)>,
    /// Haze, glare and shadows, where nothing stands that a mask could outline.
    pub light: Vec<(String, f64)>,
}

/// Returns what is large of that which these photos (full names) show and other photos do not. What was found is cached, for
/// [`suggest`] and for views.
///
/// # Errors
/// [`Error::Cancelled`]. A photo that cannot be read takes no part.
pub fn photos_with_large(
    folder: &Path,
    project: &Project,
    site: &Site,
    photos: &[String],
    memory: u64,
    task: &Task,
) -> Result<LargeFindings> {
    if photos.is_empty() {
        return Ok(LargeFindings::default());
    }
    // Whatever built these photos has reported those that cannot be read.
    let quiet = Task::silent().with_stop_flag(task.stop_flag());
    let search = || transients(folder, project, site, photos, 0, memory, &quiet);
    let found = task.timed("look for transient objects", search)?;
    let large = |wanted: &dyn Fn(&FoundRegion) -> bool| {
        let of_photo = |(id, regions): &(PhotoId, Vec<FoundRegion>)| {
            let photo = site.photo(*id);
            let pixels = f64::from(photo.camera.width) * f64::from(photo.camera.height);
            let largest =
                regions.iter().filter(|region| wanted(region)).map(|region| region.masked.count()).max()?;
            Some((photo.name.clone(), largest as f64 / pixels))
        };
        let mut large: Vec<_> =
            found.iter().filter_map(of_photo).filter(|(_, share)| *share >= LARGE).collect();
        large.sort_by(|a, b| b.1.total_cmp(&a.1));
        large
    };
    Ok(LargeFindings {
        things: large(&|region| !region.is_light && f64::from(region.likelihood) >= LIKELY),
        light: large(&|region| region.is_light),
    })
}

/// A lock that is held from reading the list until writing it.
static LISTING: Mutex<()> = Mutex::new(());

/// Returns the suggestions for photos that are not searched now.
fn others(folder: &Path, site: &Site, looked_at: &[String]) -> Suggestions {
    // A missing or unreadable list counts as empty, because suggestions can be searched again.
    let list = suggestions(folder).map(|found| found.list).unwrap_or_default();
    let is_other = |suggestion: &MaskSuggestion| {
        let photo = &suggestion.photo;
        let is_there = site.photos.iter().any(|it| it.name == *photo);
        is_there && !looked_at.is_empty() && !looked_at.contains(photo)
    };
    Suggestions { version: VERSION, list: list.into_iter().filter(is_other).collect() }
}

/// Returns the present suggestions.
///
/// # Errors
/// Returns [`Error::Request`] when there are none, or [`Error::Input`] and [`Error::Io`] when they cannot be read.
pub fn suggestions(project: &Path) -> Result<Suggestions> {
    let file = suggestion_folder(project).join(FILE);
    if !file.is_file() {
        return Err(Error::missing((
            "there are no suggestions yet; ",
            Remedy::SuggestMasks,
            " finds transient objects",
        )));
    }
    let found: Suggestions = read_json(&file, LARGEST, ("run ", Remedy::SuggestMasks, " again"))?;
    Ok(found)
}

/// Returns the edits that accept suggestions by their numbers; all likely suggestions for an empty list. Masks become `margin`
/// photo pixels wider than suggested.
///
/// # Errors
/// Returns [`Error::Request`] for numbers that do not exist, all of them together, or [`Error::Input`] and
/// [`Error::Io`] for masks that cannot be read.
pub fn accepted(project: &Path, numbers: &[u32], margin: u32) -> Result<Vec<MaskEdit>> {
    let suggestions = suggestions(project)?;
    let known = |number: &u32| suggestions.list.iter().any(|suggestion| suggestion.number == *number);
    let unknown = numbers.iter().filter(|number| !known(number));
    let found = |number: &u32| format!("there is no suggestion {number} of {}; ", suggestions.list.len());
    let errors =
        unknown.map(|number| Error::missing((found(number), Remedy::SuggestMasks, " lists them"))).collect();
    if let Some(error) = Error::of_all(errors) {
        return Err(error);
    }
    let is_wanted = |s: &&MaskSuggestion| match numbers {
        [] => s.is_likely(),
        numbers => numbers.contains(&s.number),
    };
    let wanted = suggestions.list.iter().filter(is_wanted);
    let edit = |suggestion: &MaskSuggestion| {
        let [width, height] = suggestion.size;
        let photo = whole(width, height);
        let masked = pixels(project, suggestion)?.grown(margin as i32).intersection(&photo);
        Ok(MaskEdit::Add { photo: suggestion.photo.clone(), from: MaskOrigin::Suggested, masked })
    };
    wanted.map(edit).collect()
}

/// Returns the pixels of a photo that a suggestion would mask.
///
/// # Errors
/// Returns the errors of [`read_mask`].
pub fn pixels(project: &Path, suggestion: &MaskSuggestion) -> Result<Spans> {
    read_mask(&suggestion_folder(project).join(&suggestion.mask), suggestion.size)
}

/// Removes suggestions that were rejected; the others keep their numbers.
///
/// # Errors
/// Returns the errors of [`suggestions`], or [`Error::Io`] when the list cannot be written.
pub fn dismiss(project: &Path, numbers: &[u32]) -> Result<()> {
    let _listing = LISTING.lock().unwrap_or_else(PoisonError::into_inner);
    let mut kept = suggestions(project)?;
    kept.list.retain(|suggestion| !numbers.contains(&suggestion.number));
    write_atomically(suggestion_folder(project).join(FILE), &to_json(&kept))
}

/// A contradicted region in pixels of its photo.
struct FoundRegion {
    /// The region with its margin.
    masked: Spans,
    /// The mean distance from the colours of the other photos, as a natural logarithm.
    score: f32,
    /// How likely it is a thing, 0 to 1.
    likelihood: f32,
    /// Whether it is other light on what the others show, too.
    is_light: bool,
    /// The score times the square root of the number of reduced pixels: large things need not differ as much as small ones.
    weight: f32,
}

/// The least weight of a suggestion.
const LEAST_WEIGHT: f32 = 12.0;

/// Finds the regions that other photos contradict, by the photo's index in the site.
fn transients(
    folder: &Path,
    project: &Project,
    site: &Site,
    photos: &[String],
    margin: u32,
    memory: u64,
    task: &Task,
) -> Result<Vec<(PhotoId, Vec<FoundRegion>)>> {
    let store = StackStore::new(folder);
    let stacks: Vec<Option<Stack>> =
        site.photos.iter().map(|photo| store.current(&photo.name).ok().flatten()).collect();
    let relief = SiteRelief::open(site, gains::photo_inputs(site, &stacks), folder, memory, task)?;
    let gains = gains::photo_gains(site, &stacks, &project.colour, folder, memory, task)?;
    let inputs = AgreementInputs::new(project, site, &stacks, memory);
    let evidence = SiteAgreement::open(folder, site, inputs, &gains, relief.whole(), task)?;
    let asked =
        |(id, _): &(PhotoId, &PhotoEvidence)| photos.is_empty() || photos.contains(&site.photo(*id).name);
    let all = PhotoId::all(site.photos.len()).zip(evidence.whole().iter()).filter(asked);
    let of_photo = |(id, evidence): (PhotoId, &PhotoEvidence)| {
        let found = evidence
            .things
            .iter()
            .map(|thing| enlarged(thing, evidence.agreement.size, site.photo(id), margin));
        (id, found.filter(|found| found.weight >= LEAST_WEIGHT).collect())
    };
    Ok(all.map(of_photo).collect())
}

/// Converts a thing in a reduced photo of this size to pixels of the photo itself, grown by `margin` of them.
fn enlarged(region: &Thing, size: [u32; 2], photo: &Photo, margin: u32) -> FoundRegion {
    let camera = &photo.camera;
    let [across, down] =
        [(camera.width, size[0]), (camera.height, size[1])].map(|(l, s)| f64::from(l) / f64::from(s));
    let edge = |at: i32, scale: f64| (f64::from(at) * scale).round() as i32;
    let bounds = region.pixels.bounds();
    let rows = edge(bounds.y, down)..edge(bounds.bottom(), down);
    let bare = Spans::from_rows(rows, |y, out| {
        let row = ((f64::from(y) + 0.5) / down) as i32;
        out.extend(region.pixels.row(row).iter().map(|run| edge(run.start, across)..edge(run.end, across)));
    });
    let masked = bare.grown(margin as i32).intersection(&whole(camera.width, camera.height));
    let weight = region.distance * (region.pixels.count() as f32).sqrt();
    let Thing { distance, likelihood, is_light, .. } = *region;
    FoundRegion { masked, score: distance, likelihood, is_light, weight }
}

/// Returns all pixels of a photo.
fn whole(width: u32, height: u32) -> Spans {
    let run = 0..width as i32;
    Spans::from_rows(0..height as i32, |_, out| out.push(run.clone()))
}

/// Removes masks and pictures to which no suggestion refers.
fn remove_unused(folder: &Path, kept: &Suggestions) -> Result<()> {
    let of_one = |suggestion: &MaskSuggestion| [suggestion.mask.clone(), suggestion.picture.clone()];
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

/// Draws a picture of each photo that has suggestions.
fn pictures(folder: &Path, all: &[(&Photo, FoundRegion)], first: u32, task: &Task) -> Result<()> {
    let mut photos: Vec<&Photo> = all.iter().map(|(photo, _)| *photo).collect();
    photos.sort_by(|a, b| a.name.cmp(&b.name));
    photos.dedup_by(|a, b| a.name == b.name);
    for photo in photos {
        task.check_cancelled()?;
        let pixels = read_photo(&photo.file, photo.camera.width, photo.camera.height)?;
        let mut overlay = Overlay::new(&pixels, PICTURE_SIDE).bold();
        drop(pixels);
        let longest = photo.camera.width.max(photo.camera.height);
        let unit = f64::from(longest) / f64::from(PICTURE_SIDE);
        for ((other, found), number) in all.iter().zip(first..) {
            if other.name == photo.name {
                let colour = if f64::from(found.likelihood) >= LIKELY { COLOUR } else { UNLIKELY };
                outline(&mut overlay, &found.masked, colour);
                let bounds = found.masked.bounds();
                let corner = DVec2::new(f64::from(bounds.x), f64::from(bounds.y) - 16.0 * unit);
                overlay.number(corner.max(DVec2::splat(4.0 * unit)), 12.0 * unit, number, colour);
            }
        }
        overlay.write(&folder.join(format!("{}.jpg", file_name_of_photo(&photo.name))))?;
    }
    Ok(())
}

/// The colour of outlines: light, so that the dark seam beside it makes a contrast on any background.
const COLOUR: [u8; 3] = [255, 236, 120];
/// The colour of those that are hardly things.
const UNLIKELY: [u8; 3] = [150, 150, 150];

/// Draws the outline of a set: the ends of its runs, and pixels without a neighbour above or below.
fn outline(overlay: &mut Overlay, masked: &Spans, colour: [u8; 3]) {
    let mut line = |x0: i32, y0: i32, x1: i32, y1: i32| {
        let at = |x: i32, y: i32| DVec2::new(f64::from(x), f64::from(y));
        overlay.line(at(x0, y0), at(x1, y1), colour, 1.0);
    };
    let rows = masked.rows();
    for y in rows.start..rows.end {
        masked.row(y).iter().for_each(|run| {
            line(run.start, y, run.start, y + 1);
            line(run.end, y, run.end, y + 1);
        });
    }
    let shifted = |by: i32| {
        Spans::from_rows(rows.start + by..rows.end + by, |y, out| {
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
        assert!(accepted(folder.path(), &[], 0).unwrap_err().to_string().contains("“suggest masks”"));
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
            kept.list.push(MaskSuggestion {
                number,
                photo: "a.jpg".into(),
                size: [9, 4],
                rect: masked.bounds(),
                pixels: number.into(),
                share: 0.1,
                score: 1.0,
                likelihood: if number == 2 { 0.9 } else { 0.1 },
                mask: format!("{number}.png"),
                picture: "a.jpg.jpg".into(),
            });
        }
        std::fs::write(folder.join(FILE), to_json(&kept)).unwrap();
        let pixels = |numbers: &[u32]| {
            let edits = accepted(project.path(), numbers, 0).unwrap();
            let count = |edit: &MaskEdit| match edit {
                MaskEdit::Add { masked, from: MaskOrigin::Suggested, .. } => masked.count(),
                other => panic!("{other:?}"),
            };
            edits.iter().map(count).collect::<Vec<_>>()
        };
        assert_eq!((pixels(&[]), pixels(&[1, 2])), (vec![2], vec![1, 2]), "unlikely ones only by number");
        let message = accepted(project.path(), &[2, 7, 8], 0).unwrap_err().to_string();
        assert!(message.contains('7') && message.contains('8'), "{message}");
        dismiss(project.path(), &[1]).unwrap();
        assert_eq!(pixels(&[]), [2], "the others stay, with their numbers");
        assert_eq!(super::suggestions(project.path()).unwrap().list[0].number, 2);
    }
}
