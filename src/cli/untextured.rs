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

/// The untextured faces of several stacks.
#[derive(Debug, Default)]
pub struct UntexturedReport {
    photos: Vec<(String, Vec<stack::Untextured>)>,
}

impl UntexturedReport {
    /// Adds the untextured faces of a photo's stack and the faces that exclude the photo.
    pub fn add(&mut self, stack: &Stack, decided: &PhotoDecisions) {
        self.photos.push((stack.photo.name.clone(), untextured(stack, decided)));
    }

    /// Returns the numbers by photo and reason, and the faces that no photo textures.
    pub fn summary(&self) -> String {
        if self.photos.is_empty() {
            return String::new();
        }
        let mut headings = vec!["faces without texture"];
        headings.extend(UntexturedReason::ALL.map(UntexturedReason::word));
        let mut table = Table::new(&headings);
        for (photo, faces) in &self.photos {
            let count = |reason| faces.iter().filter(|face| face.reason == reason).count().to_string();
            table.row([photo.clone()].into_iter().chain(UntexturedReason::ALL.map(count)));
        }
        format!("{}{}", table.render(), self.nowhere_in_words())
    }

    /// Returns every face, photo by photo.
    pub fn by_photo(&self) -> String {
        let mut text = String::new();
        for (photo, faces) in &self.photos {
            text.push_str(&format!("{photo}: {} without texture\n", counted(faces.len(), "face")));
            let mut table = Table::default();
            for face in faces {
                table.row([format!("  {}[{}]", face.object, face.face), face.in_words()]);
            }
            text.push_str(&table.render());
        }
        text
    }

    /// Returns the faces by photo, and those that no photo textures, as JSON.
    pub fn to_json(&self) -> Value {
        let by_photo: BTreeMap<_, _> =
            self.photos.iter().map(|(photo, faces)| (photo, json!(faces))).collect();
        let nowhere: Vec<_> = self
            .nowhere()
            .into_iter()
            .map(|((object, face), reasons)| json!({ "object": object, "face": face, "reasons": reasons }))
            .collect();
        json!({ "by_photo": by_photo, "in_every_photo": nowhere })
    }

    /// Returns the faces that no photo textures, with the number of photos by reason.
    fn nowhere(&self) -> BTreeMap<(&str, FaceIndex), BTreeMap<UntexturedReason, usize>> {
        let mut faces: BTreeMap<_, BTreeMap<UntexturedReason, usize>> = BTreeMap::new();
        for face in self.photos.iter().flat_map(|(_, faces)| faces) {
            *faces.entry((face.object.as_str(), face.face)).or_default().entry(face.reason).or_default() += 1;
        }
        faces.retain(|_, reasons| reasons.values().sum::<usize>() == self.photos.len());
        faces
    }

    fn nowhere_in_words(&self) -> String {
        let faces = self.nowhere();
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
