//! Faces without texture, by photo and by face, each with its reason.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::table::{Table, counted};
use crate::document::stack::{self, Reason};
use crate::document::{PhotoDecisions, Stack};
use crate::recipe::untextured::untextured;

/// So many faces are listed for people; programs get all of them.
const MOST_FACES: usize = 40;

/// What several stacks say of the faces that they do not texture.
#[derive(Debug, Default)]
pub struct Untextured {
    photos: Vec<(String, Vec<stack::Untextured>)>,
}

impl Untextured {
    /// Adds what one photo's stack says, and the faces that the photo was excluded for.
    pub fn add(&mut self, stack: &Stack, decided: &PhotoDecisions) {
        self.photos.push((stack.photo.name.clone(), untextured(stack, decided)));
    }

    /// How many, by photo and reason; and the faces that no photo textures.
    pub fn summary(&self) -> String {
        if self.photos.is_empty() {
            return String::new();
        }
        let mut headings = vec!["faces without texture"];
        headings.extend(Reason::ALL.map(Reason::word));
        let mut table = Table::new(&headings);
        for (photo, faces) in &self.photos {
            let count = |reason| faces.iter().filter(|face| face.reason == reason).count().to_string();
            table.row([photo.clone()].into_iter().chain(Reason::ALL.map(count)));
        }
        format!("{}{}", table.render(), self.nowhere_in_words())
    }

    /// Every one of them, photo by photo.
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

    /// By photo, and the faces that no photo textures.
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

    /// Faces that no photo textures, with the number of photos by reason.
    fn nowhere(&self) -> BTreeMap<(&str, u32), BTreeMap<Reason, usize>> {
        let mut faces: BTreeMap<_, BTreeMap<Reason, usize>> = BTreeMap::new();
        for face in self.photos.iter().flat_map(|(_, faces)| faces) {
            *faces.entry((face.object.as_str(), face.face)).or_default().entry(face.reason).or_default() += 1;
        }
        faces.retain(|_, reasons| reasons.values().sum::<usize>() == self.photos.len());
        faces
    }

    fn nowhere_in_words(&self) -> String {
        let faces = self.nowhere();
        if faces.is_empty() {
            return "\nEvery face has texture from some photo.\n".into();
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
        format!(
            "\n{} without texture from any photo:\n{}{more}",
            counted(faces.len(), "face"),
            table.render()
        )
    }
}
