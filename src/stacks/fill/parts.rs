//! What a filling takes from other photos, in parts: a photo that changes leaves the fillings up to date that take nothing from it.

use std::collections::{BTreeMap, BTreeSet};

use super::donors::given_by_pin;
use super::inputs::FillInputs;
use super::see_through::SurfaceMattes;
use super::{FillJob, FillPurpose, FilledPhoto, WITHOUT_MATTES};
use crate::agreement::hash_of_relief;
use crate::gains;
use crate::turns::FillCheck;
use quadratura_base::error::Result;
use quadratura_base::scene::{FaceIndex, Photo, PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_document::stack::FillBasis;
use quadratura_document::{Project, Stack};
use quadratura_files::hash::{Hashing, hash_bytes};
use quadratura_io::failures::forget_failure;
use quadratura_io::photo_lock::WorkLock;
use quadratura_layers::agreement::PhotoEvidence;
use quadratura_layers::fill::FillContext;

/// The present state of everything that fillings are made from, photo by photo and face by face.
pub(super) struct FillParts<'a> {
    site: &'a Site,
    inputs: &'a FillInputs,
    /// The hash of what all fillings have in common: options, decisions, the cameras, and where something is see-through the
    /// stacks of all photos, because its mattes are made from them.
    common: String,
    /// Per photo in the site's order, the hash of what it gives to others: its stack, exposure and agreement, and the faces of which
    /// a pin makes it give what others contradict.
    photos: Vec<String>,
    /// Per face, by object and index, the hash of its relief and of which photos serve it.
    faces: BTreeMap<(&'a str, FaceIndex), String>,
    /// What says that the surroundings are the same.
    surroundings: &'a str,
}

impl<'a> FillParts<'a> {
    /// Collects the parts. `stacks` and `evidence` are in the site's order; `surroundings` is the stamp of the site's surroundings.
    pub fn new(
        (project, site): (&Project, &'a Site),
        inputs: &'a FillInputs,
        stacks: &[Option<Stack>],
        context: &FillContext,
        evidence: &[PhotoEvidence],
        mattes: &SurfaceMattes,
        surroundings: &'a str,
    ) -> Self {
        let of_stacks = gains::photo_inputs(site, stacks);
        let cameras: Vec<String> =
            site.photos.iter().map(|photo| format!("{:?} {:?}", photo.camera, photo.pose)).collect();
        let seen_through = if mattes.is_empty() { &[] } else { &of_stacks[..] };
        let donors = context.source.at_once();
        let common =
            hash_bytes(format!("{} {cameras:?} {seen_through:?}", inputs.in_common(donors)).as_bytes());
        let given = |(photo, stack): (PhotoId, &String)| {
            let evidence = evidence.get(photo.index()).map(|evidence| &evidence.agreement);
            let (gain, optics) = (context.gains.of_photo[photo.index()], context.gains.optics[photo.index()]);
            let mut text = serde_json::to_vec(&(stack, gain, optics, evidence)).expect("plain data is JSON");
            let pinned = evidence.map(|evidence| given_by_pin(project, site, photo, evidence));
            // Only what is pinned, so that the hash is the same as before pins counted.
            pinned.into_iter().flatten().for_each(|face| text.extend(face.0.to_le_bytes()));
            hash_bytes(&text)
        };
        let photos = site.photo_ids().zip(&of_stacks).map(given).collect();
        let of_face = |(index, serving): (usize, &Vec<PhotoId>)| {
            let face = &site.model.faces[index];
            let relief = context.relief.of_face.get(index).and_then(Option::as_ref).map(hash_of_relief);
            let hash = hash_bytes(format!("{relief:?} {serving:?}").as_bytes());
            ((site.model.object(face.object).name.as_str(), face.index), hash)
        };
        let faces = context.serving.iter().enumerate().map(of_face).collect();
        Self { site, inputs, common, photos, faces, surroundings }
    }

    /// Returns the hash of what the filling of a stack is made from, where it takes from `donors` at most.
    pub fn of_stack(&self, stack: &Stack, donors: &[String]) -> String {
        let mut hash = Hashing::default();
        hash.add(self.common.as_bytes());
        hash.add(self.inputs.of_photo(stack).as_bytes());
        for surface in &stack.surfaces {
            let face = self.faces.get(&(surface.object.as_str(), surface.face));
            hash.add(face.map_or("", String::as_str).as_bytes());
        }
        for donor in donors {
            let photo = self.site.photo_named(donor);
            hash.add(photo.map_or("", |photo| &self.photos[photo.index()]).as_bytes());
        }
        hash.add(if stack.surroundings().is_some() { self.surroundings } else { "" }.as_bytes());
        hash.hash()
    }

    /// Adds to the basis of a stack's filling the photos that are `asked` for it or have paint that is propagated to it.
    pub fn basis(
        &self,
        basis: FillBasis,
        stack: &Stack,
        asked: Vec<PhotoId>,
        painters: &[PhotoId],
    ) -> FillBasis {
        let asked: BTreeSet<PhotoId> = asked.into_iter().chain(painters.iter().copied()).collect();
        let donors: Vec<String> = asked.iter().map(|photo| self.site.photo(*photo).name.clone()).collect();
        FillBasis { parts: self.of_stack(stack, &donors), donors, ..basis }
    }
}

impl FillJob<'_> {
    /// Returns the result for a photo whose filling would be made again as it is, although something of the project has changed
    /// since: from now on its stack names the present state. `None` where it has to be filled.
    pub(super) fn confirmed(
        &self,
        photo: &Photo,
        stack: &Stack,
        parts: &FillParts,
        lock: Option<&WorkLock>,
        task: &Task,
    ) -> Result<Option<FilledPhoto>> {
        let Some((fill, basis)) = stack.fill.as_ref().and_then(|fill| Some((fill, fill.basis.as_ref()?)))
        else {
            return Ok(None);
        };
        let again = self.request.force || self.purpose == FillPurpose::Report;
        if again || fill.inputs.ends_with(WITHOUT_MATTES) || basis.parts.is_empty() {
            return Ok(None);
        }
        let is_whole = || Ok(self.store.up_to_date(&photo.name, &stack.inputs)?.is_some());
        if parts.of_stack(stack, &basis.donors) != basis.parts || !is_whole()? {
            return Ok(None);
        }
        let (donors, hash) = (basis.donors.clone(), basis.parts.clone());
        let mut stack = stack.clone();
        let basis = FillBasis { donors, parts: hash, ..self.reuse.basis(&stack) };
        let inputs = self.inputs.of_stack(&stack);
        if let Some(fill) = &mut stack.fill {
            (fill.inputs, fill.basis) = (inputs, Some(basis));
        }
        let checked = self.turns.map(|turns| turns.check_filling(&stack, self.inputs, task)).transpose()?;
        lock.iter().try_for_each(|lock| lock.check())?;
        let committed = self.store.replace_stack_json(&stack)?;
        forget_failure(self.store.project(), &photo.name);
        self.turns.inspect(|turns| turns.committed(&photo.name));
        let is_behind = checked.is_some_and(|(check, _)| check == FillCheck::OtherPaint);
        Ok(Some(FilledPhoto { is_behind, ..FilledPhoto::untouched(photo, committed.stack) }))
    }
}
