//! Reports faces without texture, by photo and by face, each with its reason.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::table::{Table, counted};
use quadratura_base::scene::FaceIndex;
use quadratura_document::stack::{self, UntexturedReason};
use quadratura_document::{PhotoDecisions, Stack};
use quadratura_stacks::untextured::untextured;

/// Maximum number of faces in the list for people; JSON has all of them.
const MOST_FACES: usize = 40;

/// The numbers of faces by reason.
type CountsByReason = BTreeMap<UntexturedReason, usize>;

/// The untextured faces of several stacks. It keeps the faces of each photo only in detail: a site of hundreds of photos has millions.
#[derive(Debug, Default)]
pub struct UntexturedReport {
    in_detail: bool,
    photos: Vec<(String, CountsByReason)>,
    /// For each face the number of photos by reason.
    faces: BTreeMap<(String, FaceIndex), CountsByReason>,
    by_photo: BTreeMap<String, Vec<stack::Untextured>>,
}

impl UntexturedReport {
    /// Makes an empty report, in detail or not.
    pub fn new(in_detail: bool) -> Self {
        Self { in_detail, ..Self::default() }
    }

    /// Adds the untextured faces of a photo's stack and the faces that exclude the photo.
    pub fn add(&mut self, stack: &Stack, decided: &PhotoDecisions) {
        let faces = untextured(stack, decided);
        let mut numbers = CountsByReason::new();
        for face in &faces {
            *numbers.entry(face.reason).or_default() += 1;
            let of_face = self.faces.entry((face.object.clone(), face.face)).or_default();
            *of_face.entry(face.reason).or_default() += 1;
        }
        let name = stack.photo.name.clone();
        self.photos.push((name.clone(), numbers));
        if self.in_detail {
            self.by_photo.insert(name, faces);
        }
    }

    /// Returns the report in words: every face, photo by photo, in detail; else the numbers by photo and reason, and the faces that
    /// no photo textures.
    pub fn text(&self) -> String {
        match self.in_detail {
            true => self.by_photo.iter().map(|(photo, faces)| of_photo(photo, faces)).collect(),
            false => self.summary(),
        }
    }

    fn summary(&self) -> String {
        if self.photos.is_empty() {
            return String::new();
        }
        let mut headings = vec!["faces without texture"];
        headings.extend(UntexturedReason::ALL.map(UntexturedReason::word));
        let mut table = Table::new(&headings);
        for (photo, numbers) in &self.photos {
            let count = |reason| numbers.get(&reason).copied().unwrap_or_default().to_string();
            table.row([photo.clone()].into_iter().chain(UntexturedReason::ALL.map(count)));
        }
        format!("{}{}", table.render(), self.nowhere_in_words())
    }

    /// Returns the numbers by photo, in detail the faces, too, and the faces that no photo textures, as JSON.
    pub fn to_json(&self) -> Value {
        let numbers: BTreeMap<_, _> = self.photos.iter().map(|(photo, numbers)| (photo, numbers)).collect();
        let nowhere: Vec<_> = self
            .nowhere()
            .map(|((object, face), reasons)| json!({ "object": object, "face": face, "reasons": reasons }))
            .collect();
        json!({ "numbers": numbers, "by_photo": self.by_photo, "in_every_photo": nowhere })
    }

    /// Returns the faces that no photo textures, with the number of photos by reason.
    fn nowhere(&self) -> impl Iterator<Item = (&(String, FaceIndex), &CountsByReason)> {
        let is_nowhere = |reasons: &CountsByReason| reasons.values().sum::<usize>() == self.photos.len();
        self.faces.iter().filter(move |(_, reasons)| is_nowhere(reasons))
    }

    fn nowhere_in_words(&self) -> String {
        let faces: Vec<_> = self.nowhere().collect();
        if faces.is_empty() {
            return "\nEvery face is textured by at least one photo.\n".into();
        }
        let mut table = Table::default();
        for ((object, face), reasons) in faces.iter().take(MOST_FACES) {
            let reasons: Vec<_> =
                reasons.iter().map(|(reason, count)| format!("{} in {count}", reason.word())).collect();
            table.row([format!("  {object}[{face}]"), reasons.join(", ")]);
        }
        let more = match faces.len().saturating_sub(MOST_FACES) {
            0 => String::new(),
            more => format!("  and {more} more (--json lists all)\n"),
        };
        format!("\n{} not textured by any photo:\n{}{more}", counted(faces.len(), "face"), table.render())
    }
}

/// Returns every untextured face of a photo in words.
fn of_photo(photo: &str, faces: &[stack::Untextured]) -> String {
    let mut table = Table::default();
    for face in faces {
        table.row([format!("  {}[{}]", face.object, face.face), face.in_words()]);
    }
    format!("{photo}: {} without texture\n{}", counted(faces.len(), "face"), table.render())
}
