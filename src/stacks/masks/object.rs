//! Masks of objects with a margin, for things that the model contains but represents incorrectly.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use crate::fill::mattes::{SiteMattes, mattes};
use quadratura_base::error::{Error, Message, Remedy, Result};
use quadratura_base::geometry::{PixelRect, Spans};
use quadratura_base::scene::impostor::Facing;
use quadratura_base::scene::{Model, Object, ObjectId, Photo, Site};
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_document::masks::{MaskOrigin, MaskedObject};
use quadratura_layers::ProjectedModel;
use quadratura_layers::matte::Matte;
use quadratura_layers::software::owners;
use quadratura_sites::budget::default_memory;
use quadratura_sites::impostors::with_impostors;
use quadratura_sites::named::objects_named;
use quadratura_sites::see_through::with_see_through;

/// Finds the pixels at which photos show objects of the complete model.
pub struct ObjectMasks<'a> {
    folder: &'a Path,
    project: &'a Project,
    site: &'a Site,
    /// The complete model, including removed objects, in which impostors turn. One sees through objects that may have mattes.
    model: Arc<Model>,
    /// The mattes of the project once a mask depends on them: none where they cannot be found.
    mattes: Option<Option<SiteMattes>>,
    /// The photos without mattes that were noted.
    noted: BTreeSet<String>,
    task: &'a Task,
}

impl<'a> ObjectMasks<'a> {
    /// Prepares masks of the objects of some names or patterns. `whole` is the complete model, including removed objects. The
    /// mattes of the project are used where a mask depends on them, and are found where they are not up to date; without a stack
    /// there are none.
    ///
    /// # Errors
    /// Returns [`Error::Request`] when the model has no such object.
    pub fn new(
        folder: &'a Path,
        project: &'a Project,
        site: &'a Site,
        whole: Model,
        patterns: &[String],
        task: &'a Task,
    ) -> Result<Self> {
        let (photos, transform) = (&site.photos, &project.world_from_model);
        let model = with_impostors(whole.into(), photos, transform, &project.impostors, &Task::silent());
        let model = with_see_through(model, &project.see_through, &Task::silent());
        note_removed(&model, project, patterns, task)?;
        // What is removed from the model has no mattes.
        let sees_through = |object: &Object| {
            let present = site.model.object_named(&object.name);
            present.is_some_and(|id| site.model.object(id).see_through)
        };
        let model = Arc::new(Arc::unwrap_or_clone(model).with_see_through(sees_through));
        Ok(Self { folder, project, site, model, mattes: None, noted: BTreeSet::new(), task })
    }

    /// Returns the pixels at which a photo shows the objects of a name or pattern, grown by `margin` pixels (rows and columns):
    /// of an impostor its rectangle, of see-through objects what their mattes hold, and behind them what is seen through
    /// them, as far as mattes are known. Photos without mattes are noted where that makes a difference.
    ///
    /// # Errors
    /// Returns [`Error::Request`] when the model has no such object, and [`Error::Cancelled`]. Mattes that cannot be found for
    /// another reason are noted.
    pub fn pixels(&mut self, photo: &Photo, pattern: &str, margin: u32) -> Result<Spans> {
        let objects: BTreeSet<ObjectId> = objects_named(&self.model, pattern)?.into_iter().collect();
        let facing = self.model.facing(&Facing::of_pose(&photo.pose));
        let shown = ShownObjects::new(&facing, photo, self.project.options.tolerance);
        if !shown.depends_on_mattes(&objects) {
            return Ok(shown.pixels(&objects, &[], margin));
        }
        self.find_mattes()?;
        let found = self.mattes.as_ref().and_then(Option::as_ref);
        let own = self.site.photo_named(&photo.name);
        let Some((all, own)) = found.zip(own).filter(|(all, own)| !all.of(*own).is_empty()) else {
            if found.is_some() && self.noted.insert(photo.name.clone()) {
                self.task.with_subject(&photo.name).note((
                    "no mattes are known of this photo, so see-through objects are masked in it as if they were solid; ",
                    Remedy::Build,
                    " makes what they need; mask the objects again afterwards",
                ));
            }
            return Ok(shown.pixels(&objects, &[], margin));
        };
        let names: BTreeSet<&str> = objects.iter().map(|id| &self.model.object(*id).name[..]).collect();
        let mattes: Vec<(bool, &Matte)> = all
            .objects()
            .into_iter()
            .flat_map(|name| {
                all.of_object(own, name).map(|matte| (names.contains(name), matte)).collect::<Vec<_>>()
            })
            .collect();
        Ok(shown.pixels(&objects, &mattes, margin))
    }

    /// Finds the mattes of the project, once.
    fn find_mattes(&mut self) -> Result<()> {
        if self.mattes.is_some() {
            return Ok(());
        }
        let found = mattes(self.folder, self.project, self.site, false, default_memory(), self.task);
        self.mattes = Some(match found {
            Ok(found) => Some(found),
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => {
                let text = Message::from(
                    "see-through objects are masked as if they were solid, with all that is seen through them: ",
                );
                self.task.note(text.and(&error).and("; mask the objects again afterwards"));
                None
            }
        });
        Ok(())
    }
}

/// The number of objects that a note lists.
const LISTED: usize = 5;

/// Notes the objects of some patterns through which one sees, but which are removed from the model, so that they have no mattes.
fn note_removed(model: &Model, project: &Project, patterns: &[String], task: &Task) -> Result<()> {
    let mut removed = BTreeSet::new();
    for pattern in patterns {
        let objects = objects_named(model, pattern)?.into_iter().map(|id| model.object(id));
        let is_removed = |object: &&Object| object.see_through && project.objects_off.contains(&object.name);
        removed.extend(objects.filter(is_removed).map(|object| &object.name[..]));
    }
    let more = removed.len().saturating_sub(LISTED);
    let mut names = removed.into_iter().take(LISTED).collect::<Vec<_>>().join(", ");
    if more > 0 {
        names.push_str(&format!(" and {more} more"));
    }
    if !names.is_empty() {
        task.note((
            format!(
                "removed objects have no mattes, so that everything is masked that is seen through {names}; to mask only \
                 what the mattes hold, mask see-through objects before they are removed: "
            ),
            Remedy::RestoreObject,
            " restores one",
        ));
    }
    Ok(())
}

/// The nearest object at each pixel of a photo.
struct NearestObjects {
    /// The item plus one.
    owners: Vec<u32>,
    /// The objects of the items.
    objects: Vec<ObjectId>,
    width: usize,
}

impl NearestObjects {
    fn new(model: &Model, photo: &Photo, tolerance: f32) -> Self {
        let view = ProjectedModel::new(model, &photo.camera, &photo.pose);
        let objects = view.items.iter().map(|item| model.face(item.face).object).collect();
        Self { owners: owners(&view, tolerance), objects, width: photo.camera.width as usize }
    }

    fn at(&self, x: i32, y: i32) -> Option<ObjectId> {
        let item = self.owners[y as usize * self.width + x as usize].checked_sub(1)?;
        Some(self.objects[item as usize])
    }
}

/// The objects that a photo shows.
struct ShownObjects<'a> {
    /// The model as the photo's camera sees it ([`Model::facing`]).
    model: &'a Model,
    nearest: NearestObjects,
    /// The nearest solid objects, where one sees through some object.
    behind: Option<NearestObjects>,
    whole: PixelRect,
}

impl<'a> ShownObjects<'a> {
    fn new(model: &'a Model, photo: &Photo, tolerance: f32) -> Self {
        let nearest = |model: &Model| NearestObjects::new(model, photo, tolerance);
        let behind = model.has_see_through().then(|| nearest(&model.without_see_through()));
        Self { model, nearest: nearest(model), behind, whole: photo.camera.rect() }
    }

    /// Returns whether what the photo shows of these objects depends on mattes.
    fn depends_on_mattes(&self, objects: &BTreeSet<ObjectId>) -> bool {
        let Some(behind) = &self.behind else { return false };
        let is_any_see_through = objects.iter().any(|id| self.model.object(*id).see_through);
        self.whole.pixels().any(|(x, y)| {
            self.nearest.at(x, y).is_some_and(|id| self.model.object(id).see_through)
                && (is_any_see_through || behind.at(x, y).is_some_and(|id| objects.contains(&id)))
        })
    }

    /// Returns the pixels that show these objects, grown by a margin in pixels (rows and columns). `mattes` are all that
    /// are known of the photo, each with whether it is of one of the objects. A pixel that shows a mixture shows all of it.
    fn pixels(&self, objects: &BTreeSet<ObjectId>, mattes: &[(bool, &Matte)], margin: u32) -> Spans {
        let is_visible = |x: i32, y: i32| {
            let Some(nearest) = self.nearest.at(x, y) else { return false };
            let is_own = objects.contains(&nearest);
            let Some(behind) = self.behind.as_ref().filter(|_| self.model.object(nearest).see_through) else {
                return is_own;
            };
            // How much of the pixel is known to be some see-through object, and one of the masked ones.
            let (mut covered, mut own) = (None, 0);
            for (is_own, matte) in mattes {
                let is_known = matte.known.get(x, y).is_some_and(|known| known.is_known());
                let Some([.., alpha]) = matte.texels.get(x, y).filter(|_| is_known) else { continue };
                covered = covered.max(Some(*alpha));
                own = own.max(if *is_own { *alpha } else { 0 });
            }
            let is_seen_behind = || behind.at(x, y).is_some_and(|id| objects.contains(&id));
            covered.map_or(is_own, |alpha| own > 0 || (alpha < u8::MAX && is_seen_behind()))
        };
        let grown = Spans::of_pixels(self.whole, is_visible).grown(margin as i32);
        grown.intersection(&Spans::of_pixels(self.whole, |_, _| true))
    }
}

/// Returns the origin of an object mask.
pub fn from_object(pattern: &str, margin: u32) -> MaskOrigin {
    MaskOrigin::Object(MaskedObject { name: pattern.to_owned(), margin })
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::raster::Image;
    use quadratura_base::scene::synthetic::{Scene, closed_form};
    use quadratura_layers::matte::Known;

    /// What the photo of a scene shows of the objects of a pattern.
    fn shown(scene: &Scene, model: &Model, pattern: &str, mattes: &[(bool, &Matte)], margin: u32) -> Spans {
        let objects = objects_named(model, pattern).unwrap().into_iter().collect();
        ShownObjects::new(model, &scene.photo(), 1e-4).pixels(&objects, mattes, margin)
    }

    #[test]
    fn what_is_seen_of_an_object_is_masked_with_its_margin_and_what_is_hidden_is_not() {
        let scene = closed_form::two_quads();
        let model = &scene.model;
        let names = || model.objects.iter().map(|object| &object.name[..]);
        let counts: Vec<u64> = names().map(|name| shown(&scene, model, name, &[], 0).count()).collect();
        let both = shown(&scene, model, "*", &[], 0);
        assert_eq!(counts.iter().sum::<u64>(), both.count(), "no pixel shows two of them");
        let (bare, wide) = (shown(&scene, model, "far", &[], 0), shown(&scene, model, "far", &[], 2));
        assert!(bare.minus(&wide).is_empty() && wide.count() > bare.count());
        assert!(objects_named(model, "no such*").is_err());
    }

    #[test]
    fn where_a_matte_is_found_it_is_masked_and_not_the_surface_and_behind_it_what_is_seen_through_it() {
        let scene = closed_form::two_quads();
        let model = Model::clone(&scene.model).with_see_through(|object| object.name == "near");
        let of = |pattern: &str, mattes: &[(bool, &Matte)]| shown(&scene, &model, pattern, mattes, 0);
        let (near, far) = (of("near", &[]), of("far", &[]));
        let without = Model::clone(&model).without_see_through();
        let behind = shown(&scene, &without, "far", &[], 0);
        let whole = scene.photo().camera.rect();
        // A third of the surface each: see-through, mixed, solid; of some rows nothing is known.
        let alpha = |x: i32| [0, 90, 255][(x % 3) as usize];
        let matte = Matte {
            object: "near".into(),
            texels: Image::from_fn(whole, |(x, _)| [0, 0, 0, alpha(x)]),
            known: Image::from_fn(whole, |(x, y)| match near.holds(x, y) {
                true if y % 7 == 0 => Known::Unknown,
                true if y % 7 == 1 => Known::Solved,
                true => Known::Found,
                false => Known::NotShown,
            }),
        };
        let masked =
            [of("near", &[(true, &matte)]), of("far", &[(false, &matte)]), of("*", &[(true, &matte)])];
        let mut through = 0;
        for (x, y) in whole.pixels() {
            let is_known = near.holds(x, y) && y % 7 != 0;
            let is_behind = behind.holds(x, y) && alpha(x) < 255;
            let expected = match is_known {
                true => [alpha(x) > 0, is_behind, alpha(x) > 0 || is_behind],
                false => [near.holds(x, y), far.holds(x, y), near.holds(x, y) || far.holds(x, y)],
            };
            assert_eq!(masked.each_ref().map(|masked| masked.holds(x, y)), expected, "{x}, {y}");
            through += u32::from(is_known && is_behind);
        }
        assert!(through > 100, "the far one is seen through the near one at {through} pixels");
    }

    #[test]
    fn masks_depend_on_mattes_only_where_something_see_through_is_in_front() {
        let scene = closed_form::two_quads();
        let photo = scene.photo();
        let depends = |see_through: &str, masked: &str| {
            let model = Model::clone(&scene.model).with_see_through(|object| object.name == see_through);
            let objects = objects_named(&model, masked).unwrap().into_iter().collect();
            ShownObjects::new(&model, &photo, 1e-4).depends_on_mattes(&objects)
        };
        assert!(depends("near", "near") && depends("near", "far") && depends("far", "far"));
        assert!(!depends("far", "near") && !depends("none", "*"));
    }
}
