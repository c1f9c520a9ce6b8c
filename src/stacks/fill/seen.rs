//! Where paint is seen: the edits of the choice and of its exceptions, and their description.

use serde::Serialize;

use quadratura_base::scene::{FaceIndex, Model, Site};
use quadratura_document::paint::PaintBook;
use quadratura_layers::Faces;
use quadratura_layers::fill::{FillOptions, Propagation};

/// An edit of where paint is seen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SeenEdit {
    /// The paint that the edit concerns.
    pub paint: EditedPaint,
    /// Where it is seen from now on.
    pub seen: Seen,
}

/// The photos in which paint is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seen {
    /// All photos that show the surface.
    Everywhere,
    /// Only the photo on which it was painted.
    OnlyHere,
}

/// The paint that an edit concerns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum EditedPaint {
    /// All paint of the project; exceptions stay.
    All,
    /// All paint on a photo.
    OfPhoto(String),
    /// All paint on an object or on faces of one.
    On(Faces),
    /// The paint of an import.
    OfImport(u32),
    /// The paint of other photos on this photo, which keeps its pixels where that is seen only in its photos.
    To(String),
}

/// Returns the options after an edit.
pub fn edited(options: &FillOptions, edit: &SeenEdit, model: &Model) -> FillOptions {
    let mut options = options.clone();
    let only_here = edit.seen == Seen::OnlyHere;
    match &edit.paint {
        EditedPaint::All => {
            options.propagate = if only_here { Propagation::None } else { Propagation::all() };
        }
        EditedPaint::OfPhoto(photo) if only_here => drop(options.only_here.photos.insert(photo.clone())),
        EditedPaint::OfPhoto(photo) => {
            options.only_here.photos.remove(photo);
            if !options.propagates(photo) {
                let patterns = options.propagate.patterns().iter().chain([photo]);
                options.propagate = Propagation::Of(patterns.cloned().collect());
            }
        }
        EditedPaint::On(faces) => {
            let surfaces = &mut options.only_here.surfaces;
            let all = std::mem::take(surfaces).into_iter();
            let (same, mut others): (Vec<Faces>, Vec<Faces>) =
                all.partition(|other| other.object == faces.object);
            others.extend(if only_here { united(same, faces) } else { without(same, faces, model) });
            *surfaces = others.into_iter().collect();
        }
        EditedPaint::OfImport(number) if only_here => drop(options.only_here.imports.insert(*number)),
        EditedPaint::OfImport(number) => drop(options.only_here.imports.remove(number)),
        EditedPaint::To(photo) if only_here => drop(options.protected.insert(photo.clone())),
        EditedPaint::To(photo) => drop(options.protected.remove(photo)),
    }
    options
}

/// Unites faces of one object.
fn united(same: Vec<Faces>, added: &Faces) -> Option<Faces> {
    let is_whole = same.iter().chain([added]).any(|faces| faces.faces.is_empty());
    let mut faces: Vec<FaceIndex> =
        same.iter().chain([added]).flat_map(|faces| faces.faces.clone()).collect();
    faces.sort_unstable();
    faces.dedup();
    Some(if is_whole { Faces::whole(&added.object) } else { Faces { object: added.object.clone(), faces } })
}

/// Takes faces away from others of their object; `None` when nothing is left.
fn without(same: Vec<Faces>, taken: &Faces, model: &Model) -> Option<Faces> {
    let all = united(same.clone(), same.first()?)?;
    let object = model.objects.iter().find(|object| object.name == taken.object);
    let of_object = || FaceIndex::all(object.map_or(0, |object| object.faces.len()));
    let mut faces: Vec<FaceIndex> = if all.faces.is_empty() { of_object().collect() } else { all.faces };
    faces.retain(|face| !taken.holds(&taken.object, *face));
    (!faces.is_empty()).then(|| Faces { object: taken.object.clone(), faces })
}

/// Returns a sentence about whose paint is seen in other photos.
pub fn propagation_in_words(options: &FillOptions) -> String {
    match &options.propagate {
        Propagation::Undecided => {
            "nobody has chosen yet whether paint is seen from everywhere; until then it is seen \
                                   only in its photo"
                .into()
        }
        Propagation::None => "paint is seen only in its photo".into(),
        all if all.is_all() => "paint is seen from everywhere".into(),
        Propagation::Of(photos) => format!("paint of {} is seen from everywhere", photos.join(", ")),
    }
}

/// Returns a line for each kind of exception; empty without exceptions.
pub fn exceptions_in_words(options: &FillOptions) -> Vec<String> {
    let of =
        |what: &str, list: Vec<String>| (!list.is_empty()).then(|| format!("{what}: {}", list.join(", ")));
    let only_here = &options.only_here;
    let words = [
        of("only in its photo, paint of", only_here.photos.iter().cloned().collect()),
        of("only in its photo, paint on", only_here.surfaces.iter().map(Faces::to_string).collect()),
        of("only in its photo, paint of import", only_here.imports.iter().map(u32::to_string).collect()),
        of("protected from paint of other photos", options.protected.iter().cloned().collect()),
    ];
    words.into_iter().flatten().collect()
}

/// Returns the exceptions that name what is not there, each as a sentence. They have no effect.
pub fn exceptions_of_what_is_gone(options: &FillOptions, site: &Site, book: &PaintBook) -> Vec<String> {
    let of_photo = |list: &str, photo: &String| {
        site.photo_named(photo)
            .is_none()
            .then(|| format!("{list} names the photo {photo:?}, which the site does not have"))
    };
    let only_here = &options.only_here;
    let photos = only_here.photos.iter().filter_map(|photo| of_photo("fill.only_here.photos", photo));
    let protected = options.protected.iter().filter_map(|photo| of_photo("fill.protected", photo));
    let gone = |faces: &&Faces| faces.in_model(&site.model).is_empty();
    let surfaces = only_here
        .surfaces
        .iter()
        .filter(gone)
        .map(|faces| format!("fill.only_here.surfaces names {faces}, which the model does not have"));
    let known = |number: u32| {
        let entries = book.entries.iter().map(|entry| entry.import);
        entries.chain(book.imports.iter().map(|import| import.number)).any(|other| other == number)
    };
    let imports = only_here.imports.iter().filter(|number| !known(**number));
    let imports = imports
        .map(|number| format!("fill.only_here.imports names import {number}, of which there is no paint"));
    photos.chain(protected).chain(surfaces).chain(imports).collect()
}

/// The choice and its exceptions, as programs read them.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct SeenReport {
    /// `undecided`, `none`, `all` or `some`.
    pub state: &'static str,
    /// The options in `project.json`: `propagate`, `only_here` and `protected`.
    pub options: FillOptions,
    /// The exceptions that name what is not there.
    pub gone: Vec<String>,
}

impl SeenReport {
    /// Reports a project's choice.
    pub fn new(options: &FillOptions, site: &Site, book: &PaintBook) -> Self {
        let state = match &options.propagate {
            Propagation::Undecided => "undecided",
            Propagation::None => "none",
            all if all.is_all() => "all",
            Propagation::Of(_) => "some",
        };
        let gone = exceptions_of_what_is_gone(options, site, book);
        let FillOptions { propagate, only_here, protected, .. } = options.clone();
        Self {
            state,
            options: FillOptions { propagate, only_here, protected, ..FillOptions::default() },
            gone,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on(options: &FillOptions, paint: EditedPaint, seen: Seen) -> FillOptions {
        let mut model = Model::default();
        model.objects.push(quadratura_base::scene::Object {
            name: "wall".into(),
            faces: (0..4).map(quadratura_base::scene::FaceId).collect(),
            billboard: false,
            impostor: None,
            see_through: false,
            turned: false,
        });
        edited(options, &SeenEdit { paint, seen }, &model)
    }

    #[test]
    fn a_photo_is_taken_out_of_all_and_put_back() {
        let all = on(&FillOptions::default(), EditedPaint::All, Seen::Everywhere);
        let some = on(&all, EditedPaint::OfPhoto("b.jpg".into()), Seen::OnlyHere);
        assert!(!some.propagates("b.jpg") && some.propagates("a.jpg"));
        assert_eq!(on(&some, EditedPaint::OfPhoto("b.jpg".into()), Seen::Everywhere), all);
        let none = on(&some, EditedPaint::All, Seen::OnlyHere);
        let one = on(&none, EditedPaint::OfPhoto("b.jpg".into()), Seen::Everywhere);
        assert!(one.propagates("b.jpg") && !one.propagates("a.jpg"));
    }

    #[test]
    fn faces_are_taken_out_of_an_object_and_put_back() {
        let faces = |list: &[u32]| Faces {
            object: "wall".into(),
            faces: list.iter().map(|i| FaceIndex(*i)).collect(),
        };
        let only_here =
            |options: &FillOptions| options.only_here.surfaces.iter().cloned().collect::<Vec<_>>();
        let whole = on(&FillOptions::default(), EditedPaint::On(Faces::whole("wall")), Seen::OnlyHere);
        let rest = on(&whole, EditedPaint::On(faces(&[1, 2])), Seen::Everywhere);
        assert_eq!(only_here(&rest), [faces(&[0, 3])]);
        let more = on(&rest, EditedPaint::On(faces(&[1])), Seen::OnlyHere);
        assert_eq!(only_here(&more), [faces(&[0, 1, 3])]);
        assert_eq!(
            only_here(&on(&more, EditedPaint::On(Faces::whole("wall")), Seen::OnlyHere)),
            only_here(&whole)
        );
        let none = on(&more, EditedPaint::On(Faces::whole("wall")), Seen::Everywhere);
        assert!(none.only_here.is_empty());
        assert!(on(&none, EditedPaint::On(faces(&[1])), Seen::Everywhere).only_here.is_empty());
    }

    #[test]
    fn exceptions_are_listed_by_kind() {
        let options = on(&FillOptions::default(), EditedPaint::OfImport(7), Seen::OnlyHere);
        let options = on(&options, EditedPaint::To("c.jpg".into()), Seen::OnlyHere);
        let lines = ["only in its photo, paint of import: 7", "protected from paint of other photos: c.jpg"];
        assert_eq!(exceptions_in_words(&options), lines);
        let back = on(&options, EditedPaint::OfImport(7), Seen::Everywhere);
        let back = on(&back, EditedPaint::To("c.jpg".into()), Seen::Everywhere);
        assert_eq!(back, FillOptions::default());
    }
}
