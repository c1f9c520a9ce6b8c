//! Decisions about single photos' layers: edits of `decisions` in `project.json`, each checked against the present
//! stacks. The functions are pure; the caller saves the result.

mod checks;
mod cost;
mod face;
mod list;
mod mergeable;
mod named;
mod state;

use std::collections::BTreeSet;

use self::checks::{refuse_merge, refuse_split, refuse_surroundings, refuse_unknown, refuse_unseen};
pub use self::cost::MergeCost;
pub use self::face::{FaceInPhoto, FaceInPhotos, face_in_photos, photos_of_faces};
pub use self::list::{DecisionKind, ListedDecision, decided};
pub use self::mergeable::{MergePartner, MergeableLayer, mergeable};
pub use self::named::{faces_named, faces_of_layer};
pub use self::state::{EXCLUDED, stale, state_of_face};
use crate::layer_names::layers_of_names;
use crate::unsatisfied::{holds, list as in_words};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{FaceIndex, Model, Site};
use quadratura_document::decisions::{LayerNaming, PhotoOptions};
use quadratura_document::{PhotoDecisions, Project, Stack};
use quadratura_layers::{Faces, LayerIndex};
use quadratura_sites::named::index_of_photo;

/// A decision to be made. Photos may be given by abbreviated names ([`index_of_photo`]), faces only exactly.
#[derive(Debug, Clone, PartialEq)]
pub enum LayerEdit {
    /// The elements of these faces share one image layer of the photo.
    Merge {
        /// The photo's name.
        photo: String,
        /// The faces.
        of: Vec<Faces>,
    },
    /// The groups share no image layer with each other; a single group shares with nothing else.
    Split {
        /// The photo's name.
        photo: String,
        /// The groups of faces.
        groups: Vec<Vec<Faces>>,
    },
    /// The image layer that contains most of these faces gets this name; `None` restores its automatic name.
    Rename {
        /// The photo's name.
        photo: String,
        /// The faces of the image layer.
        of: Vec<Faces>,
        /// The new name; `None` for the automatic one.
        name: Option<String>,
    },
    /// The photo does not texture these faces.
    Exclude {
        /// The photo's name.
        photo: String,
        /// The faces.
        of: Vec<Faces>,
    },
    /// Only this photo textures these faces, as far as it shows them.
    Pin {
        /// The photo's name.
        photo: String,
        /// The faces.
        of: Vec<Faces>,
    },
    /// Parts of objects among these faces become one, wherever the order allows it, however much they occlude each
    /// other; in the overlap the photo does not texture what is behind.
    Tolerate {
        /// The photo's name.
        photo: String,
        /// The faces.
        of: Vec<Faces>,
    },
    /// Removes exclusions of these faces from the photo and pins to it.
    Free {
        /// The photo's name.
        photo: String,
        /// The faces.
        of: Vec<Faces>,
    },
    /// Replaces the photo's own options of the method.
    Options {
        /// The photo's name.
        photo: String,
        /// The options that differ for this photo.
        options: PhotoOptions,
    },
    /// Removes one decision, by its number in [`decided`].
    Forget {
        /// The photo's name.
        photo: String,
        /// The number in the list of decisions, counted from 1.
        number: usize,
    },
    /// Removes all decisions about a photo, or all decisions of the project.
    Reset {
        /// The photo's name; `None` for all photos.
        photo: Option<String>,
    },
}

impl LayerEdit {
    /// Returns the name of the undo step, such as `merge of tower, gate[2]`.
    pub fn name(&self) -> String {
        match self {
            Self::Merge { of, .. } => format!("merge of {}", in_short(of)),
            Self::Split { groups, .. } => match &groups[..] {
                [alone] => format!("split of {}", in_short(alone)),
                groups => format!("split into {} groups", groups.len()),
            },
            Self::Rename { name: Some(name), .. } => format!("rename to {name}"),
            Self::Rename { name: None, of, .. } => format!("own name of {}", in_short(of)),
            Self::Exclude { photo, of } => format!("exclusion of {photo} for {}", in_short(of)),
            Self::Pin { photo, of } => format!("pin of {} to {photo}", in_short(of)),
            Self::Tolerate { of, .. } => format!("overlaps within {}", in_short(of)),
            Self::Free { photo, of } => format!("no exclusion or pin of {} in {photo}", in_short(of)),
            Self::Options { photo, .. } => format!("options of {photo}"),
            Self::Forget { photo, number } => format!("remove decision {number} of {photo}"),
            Self::Reset { photo: Some(photo) } => format!("reset of {photo}"),
            Self::Reset { photo: None } => "reset of all decisions".into(),
        }
    }

    /// Returns the photo of the edit; `None` for a reset of all decisions.
    fn photo(&self) -> Option<&str> {
        match self {
            Self::Merge { photo, .. }
            | Self::Split { photo, .. }
            | Self::Rename { photo, .. }
            | Self::Exclude { photo, .. }
            | Self::Pin { photo, .. }
            | Self::Tolerate { photo, .. }
            | Self::Free { photo, .. }
            | Self::Options { photo, .. }
            | Self::Forget { photo, .. } => Some(photo),
            Self::Reset { photo } => photo.as_deref(),
        }
    }
}

/// Lists at most three items, because names of undo steps appear in menus.
fn in_short(of: &[Faces]) -> String {
    const MOST: usize = 3;
    match of.len() {
        0..=MOST => in_words(of),
        more => format!("{} and {} more", in_words(&of[..MOST - 1]), more - (MOST - 1)),
    }
}

/// Returns the project after an edit. `stacks` are in the site's order. For a photo without a stack the edit is not
/// checked against its layers; the next build reports what cannot be satisfied.
///
/// # Errors
/// Returns [`Error::Request`] with the obstacle and a remedy: a photo, object or face that does not exist, a face
/// that the photo does not show, elements that occlude each other, decisions that contradict the edit.
pub fn edited(
    project: &Project,
    edit: &LayerEdit,
    site: &Site,
    stacks: &[Option<&Stack>],
) -> Result<Project> {
    let mut project = project.clone();
    let Some(photo) = edit.photo() else {
        project.decisions = Default::default();
        return Ok(project);
    };
    let photo = whole_name(photo, edit, &project, site)?;
    let stack = site.photo_named(&photo).and_then(|id| *stacks.get(id.index())?);
    let mut context = EditContext { project: &mut project, photo: &photo, model: &site.model, stack };
    context.apply(edit)?;
    match project.decisions.problem(&project.options) {
        Some(problem) => Err(Error::Request(problem)),
        None => Ok(project),
    }
}

/// Returns the full name of a photo. Decisions may outlive their photos, so they can be removed by a photo's full
/// name.
fn whole_name(typed: &str, edit: &LayerEdit, project: &Project, site: &Site) -> Result<String> {
    let takes_back = matches!(edit, LayerEdit::Forget { .. } | LayerEdit::Reset { .. });
    if takes_back && project.decisions.photos.contains_key(typed) {
        return Ok(typed.to_owned());
    }
    Ok(site.photo(index_of_photo(site, typed)?).name.clone())
}

/// The context of an edit.
struct EditContext<'a> {
    project: &'a mut Project,
    photo: &'a str,
    model: &'a Model,
    stack: Option<&'a Stack>,
}

impl EditContext<'_> {
    /// Applies the edit to the project's decisions.
    fn apply(&mut self, edit: &LayerEdit) -> Result<()> {
        let mut decided = self.project.decisions.of(self.photo);
        match edit {
            LayerEdit::Merge { of, .. } => self.merge(&mut decided, of)?,
            LayerEdit::Split { groups, .. } => self.split(&mut decided, groups)?,
            LayerEdit::Rename { of, name, .. } => self.rename(&mut decided, of, name.as_deref())?,
            LayerEdit::Exclude { of, .. } => {
                let of = self.seen(of)?;
                decided.pin = without(&decided.pin, &of, self.model);
                decided.exclude = united([decided.exclude, of].concat());
            }
            LayerEdit::Pin { of, .. } => {
                let of = self.seen(of)?;
                self.unpin_elsewhere(&of);
                decided.exclude = without(&decided.exclude, &of, self.model);
                decided.pin = united([decided.pin, of].concat());
            }
            LayerEdit::Tolerate { of, .. } => {
                decided.tolerate = united([decided.tolerate, self.seen(of)?].concat());
            }
            LayerEdit::Free { of, .. } => {
                let of = united(of.to_vec());
                refuse_unknown(&of, self.model)?;
                decided.exclude = without(&decided.exclude, &of, self.model);
                decided.pin = without(&decided.pin, &of, self.model);
            }
            LayerEdit::Options { options, .. } => decided.options = *options,
            LayerEdit::Forget { number, .. } => list::forget(&mut decided, self.photo, *number)?,
            LayerEdit::Reset { .. } => decided = PhotoDecisions::default(),
        }
        self.project.decisions.set(self.photo, decided);
        Ok(())
    }

    /// Returns the faces, sorted, after checking that the model has them and the photo textures them.
    fn seen(&self, of: &[Faces]) -> Result<Vec<Faces>> {
        let of = united(of.to_vec());
        refuse_surroundings(&of)?;
        refuse_unknown(&of, self.model)?;
        refuse_unseen(&of, self.photo, self.stack)?;
        Ok(of)
    }

    fn merge(&self, decided: &mut PhotoDecisions, of: &[Faces]) -> Result<()> {
        let of = self.seen(of)?;
        if decided.merge.contains(&of) {
            return Ok(());
        }
        decided.merge.push(of);
        self.stack.map_or(Ok(()), |stack| refuse_merge(decided, stack, self.model))
    }

    fn split(&self, decided: &mut PhotoDecisions, groups: &[Vec<Faces>]) -> Result<()> {
        let groups: Vec<Vec<Faces>> = groups.iter().map(|group| self.seen(group)).collect::<Result<_>>()?;
        if decided.split.contains(&groups) {
            return Ok(());
        }
        decided.split.push(groups);
        refuse_split(decided, self.model)
    }

    fn rename(&self, decided: &mut PhotoDecisions, of: &[Faces], name: Option<&str>) -> Result<()> {
        let of = united(of.to_vec());
        refuse_unknown(&of, self.model)?;
        refuse_unseen(&of, self.photo, self.stack)?;
        let mut new = LayerNaming { name: name.unwrap_or_default().trim().to_owned(), of };
        match self.stack {
            Some(stack) => {
                let held = layers_of_names(stack, std::slice::from_ref(&new));
                let layer = held.iter().position(Option::is_some);
                let layer = layer.ok_or_else(|| no_layer(&new.of, self.photo))?;
                refuse_others(stack, LayerIndex::new(layer), &new.of)?;
                let index = layers_of_names(stack, &decided.names)[layer];
                index.map(|index| decided.names.remove(index));
                // The layer's complete content, so that the same layer is found again.
                new.of = faces_of_layer(stack, LayerIndex::new(layer));
            }
            None => decided.names.retain(|old| old.of != new.of),
        }
        if name.is_some() {
            decided.names.push(new);
        }
        Ok(())
    }

    /// Removes other photos' pins of these faces: a face is pinned to one photo, and the last pin is valid.
    fn unpin_elsewhere(&mut self, of: &[Faces]) {
        let photos: BTreeSet<String> = self.project.decisions.photos.keys().cloned().collect();
        for other in photos.iter().filter(|other| *other != self.photo) {
            let mut decided = self.project.decisions.of(other);
            decided.pin = without(&decided.pin, of, self.model);
            self.project.decisions.set(other, decided);
        }
    }
}

/// Refuses a name for faces of several image layers.
fn refuse_others(stack: &Stack, layer: LayerIndex, of: &[Faces]) -> Result<()> {
    let layer = stack.layer(layer);
    let held = stack.numbered_elements().filter(|(index, _)| layer.elements.contains(index));
    let held: Vec<_> = held.map(|(_, element)| element).collect();
    let is_other = |faces: &&Faces| !held.iter().any(|element| holds(element, faces));
    let others: Vec<Faces> = of.iter().filter(is_other).cloned().collect();
    if others.is_empty() {
        return Ok(());
    }
    Err(Error::Request(format!(
        "the image layer {:?} of {} does not contain {}, and a name is that of one layer; merge them first, or name \
         each layer by itself",
        layer.name,
        stack.photo.name,
        in_words(&others)
    )))
}

fn no_layer(of: &[Faces], photo: &str) -> Error {
    Error::Request(format!("no image layer of {photo} contains {}", in_words(of)))
}

/// Combines entries to one per object, sorted by name; an entry for a whole object includes its single faces.
fn united(mut list: Vec<Faces>) -> Vec<Faces> {
    list.sort();
    let mut united: Vec<Faces> = Vec::with_capacity(list.len());
    for mut faces in list {
        faces.faces.sort_unstable();
        faces.faces.dedup();
        match united.last_mut() {
            // Whole objects are sorted before single faces.
            Some(last) if last.object == faces.object && last.faces.is_empty() => {}
            Some(last) if last.object == faces.object => {
                last.faces.append(&mut faces.faces);
                last.faces.sort_unstable();
                last.faces.dedup();
            }
            _ => united.push(faces),
        }
    }
    united
}

/// Returns a list without some faces. Faces that the model does not have remain, unless they are named identically.
fn without(list: &[Faces], of: &[Faces], model: &Model) -> Vec<Faces> {
    let rest = |faces: &Faces| {
        if of.contains(faces) {
            return None;
        }
        let taken = |index: &FaceIndex| of.iter().any(|taken| taken.holds(&faces.object, *index));
        let all: Vec<FaceIndex> = match faces.faces.is_empty() {
            true => faces.in_model(model).iter().map(|face| model.face(*face).index).collect(),
            false => faces.faces.clone(),
        };
        let left: Vec<FaceIndex> = all.iter().copied().filter(|index| !taken(index)).collect();
        match left.len() {
            n if n == all.len() => Some(faces.clone()),
            0 => None,
            _ => Some(Faces { object: faces.object.clone(), faces: left }),
        }
    };
    list.iter().filter_map(rest).collect()
}

#[cfg(test)]
mod tests;
