//! The search for mattes in three rounds over a site's photos: the colours of the objects, their silhouettes, and the mattes.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::MatteBasis;
use super::behind::{Sight, colours, evidence};
use crate::error::{Error, Message, Result};
use crate::layers::fill::{Donor, FillContext};
use crate::layers::matte::{
    CANDIDATES, ColourModel, Compared, Expected, FindOptions, Likely, Matte, SeenImpostor, Silhouette,
    find_mattes, object_model,
};
use crate::raster::Image;
use crate::recipe::fill::surroundings::SurroundingsFiller;
use crate::scene::{ObjectId, PhotoId};
use crate::task::Task;

/// The steps of the logarithm of odds in which photos are kept between the rounds.
const STEPS: f32 = 16.0;

/// A search among the photos of a site.
pub(super) struct Search<'a> {
    pub basis: &'a MatteBasis<'a>,
    pub context: &'a FillContext<'a>,
    /// The impostors of the model, rising.
    pub impostors: &'a [ObjectId],
    pub around: SurroundingsFiller<'a>,
    /// The photos whose mattes cannot be found.
    pub failed: BTreeSet<PhotoId>,
    pub task: &'a Task,
}

/// What is kept of a photo between the rounds.
struct Kept {
    /// Per pixel of the sight the logarithm of the odds in [`STEPS`], and whether it is known what is behind.
    odds: Vec<(i8, bool)>,
    /// The silhouettes by impostor.
    silhouettes: BTreeMap<u16, Silhouette>,
}

impl Search<'_> {
    /// Returns the mattes of these photos. One that fails is noted and left out.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn mattes(mut self, photos: &[PhotoId]) -> Result<Vec<(PhotoId, Vec<Matte>)>> {
        let mut samples = Vec::new();
        let (task, count) = (self.task, photos.len() as u64);
        for (done, id) in (0..).zip(photos) {
            task.step("compare billboards", done, 2 * count)?;
            let found = self.tried(*id, |search, own, sight, task| {
                let evidence =
                    evidence(search.basis, search.context, *id, (own, sight), &mut search.around, task)?;
                Ok(Compared::new(&evidence).map(|compared| compared.object_samples(&evidence)))
            })?;
            samples.extend(found.flatten().into_iter().flatten());
        }
        let model = object_model(&samples);
        let mut kept = BTreeMap::new();
        for (done, id) in (count..).zip(photos) {
            task.step("compare billboards", done, 2 * count)?;
            let found = self
                .tried(*id, |search, own, sight, task| search.kept(*id, own, sight, model.as_ref(), task))?;
            kept.extend(found.map(|found| (*id, found)));
        }
        task.step("compare billboards", 2 * count, 2 * count)?;
        let mut mattes = Vec::with_capacity(photos.len());
        for (done, id) in (0..).zip(photos) {
            task.step("mattes", done, count)?;
            let found =
                self.tried(*id, |search, own, sight, task| search.found(&kept, *id, own, sight, task))?;
            // A photo that fails now may not the next time.
            if !self.failed.contains(id) {
                mattes.push((*id, found.unwrap_or_default()));
            }
        }
        task.step("mattes", count, count)?;
        Ok(mattes)
    }

    /// Does some work on a photo; returns `None` where it shows no impostor, and where that fails, which is noted.
    fn tried<T>(
        &mut self,
        photo: PhotoId,
        work: impl FnOnce(&mut Self, &Donor, &Sight, &Task) -> Result<T>,
    ) -> Result<Option<T>> {
        let task = self.task.with_subject(&self.basis.opened.site.photo(photo).name);
        let tried = || {
            let own: Option<Arc<Donor>> = self.context.source.own(photo)?;
            let own = own.ok_or_else(|| Error::Request("the photo cannot be read".into()))?;
            let sight = task.timed("matte sight", || Sight::new(self.basis, &own, self.impostors));
            sight.map(|sight| work(self, &own, &sight, &task)).transpose()
        };
        match tried() {
            Ok(done) => Ok(done),
            Err(Error::Cancelled) => Err(Error::Cancelled),
            Err(error) => {
                if self.failed.insert(photo) {
                    task.note(Message::from("its mattes cannot be found: ").and(&error));
                }
                Ok(None)
            }
        }
    }

    /// Returns how likely a photo's pixels show impostors, and the silhouettes that follow.
    fn kept(
        &mut self,
        photo: PhotoId,
        own: &Donor,
        sight: &Sight,
        model: Option<&ColourModel>,
        task: &Task,
    ) -> Result<Kept> {
        let evidence = evidence(self.basis, self.context, photo, (own, sight), &mut self.around, task)?;
        let odds = task.timed("matte odds", || {
            let compared = Compared::new(&evidence)?;
            Some(compared.log_odds(&evidence, model))
        });
        // Where nothing is known of the colours, it is not known either what is behind.
        let none = || Image::filled(evidence.colours.rect(), 0.0);
        let is_known = odds.is_some();
        let odds = odds.unwrap_or_else(none);
        let mut silhouettes: BTreeMap<u16, Silhouette> = BTreeMap::new();
        for ((at, odds), candidates) in odds.iter().zip(sight.candidates.pixels()) {
            // Where several are, nobody knows which one is shown.
            let [index, 0, ..] = *candidates else { continue };
            let Some(seen) = usize::from(index).checked_sub(1).map(|index| &sight.seen[index]) else {
                continue;
            };
            if let Some((place, _)) = seen.met(at).filter(|_| is_known) {
                let silhouette = silhouettes.entry(index).or_insert_with(|| Silhouette::new(seen));
                silhouette.add(place, 1.0 / (1.0 + (-odds).exp()));
            }
        }
        let step = |(odds, predicted): (&f32, bool)| ((odds * STEPS).round() as i8, predicted && is_known);
        let predicted = evidence.predicted.pixels().iter().map(Option::is_some);
        Ok(Kept { odds: odds.pixels().iter().zip(predicted).map(step).collect(), silhouettes })
    }

    /// Finds the mattes of a photo.
    fn found(
        &self,
        kept: &BTreeMap<PhotoId, Kept>,
        photo: PhotoId,
        own: &Donor,
        sight: &Sight,
        task: &Task,
    ) -> Result<Vec<Matte>> {
        let Some(Kept { odds, .. }) = kept.get(&photo) else { return Ok(Vec::new()) };
        let rect = sight.candidates.rect();
        let colours = colours(own, rect);
        let log_odds = Image::new(rect, odds.iter().map(|(odds, _)| f32::from(*odds) / STEPS).collect());
        let is_predicted = Image::new(rect, odds.iter().map(|(_, predicted)| *predicted).collect());
        let expected = task.timed("matte silhouettes", || expected(kept, photo, sight));
        let likely = Likely {
            colours: &colours,
            candidates: &sight.candidates,
            log_odds: &log_odds,
            is_predicted: &is_predicted,
            expected: &expected,
        };
        let model = &self.basis.opened.site.model;
        let names: Vec<&str> = self.impostors.iter().map(|id| &model.object(*id).name[..]).collect();
        find_mattes(&likely, &names, &FindOptions::default(), task)
    }
}

/// Returns what the other photos expect at each pixel of each candidate.
fn expected(kept: &BTreeMap<PhotoId, Kept>, photo: PhotoId, sight: &Sight) -> Image<[f32; CANDIDATES]> {
    let of_impostor = |(index, seen): (u16, &SeenImpostor)| {
        let others = kept.iter().filter(|(other, _)| **other != photo);
        let others = others.filter_map(|(_, kept)| kept.silhouettes.get(&index));
        Silhouette::new(seen).expected_from(others)
    };
    let expected: Vec<Expected> = (1..).zip(&sight.seen).map(of_impostor).collect();
    let of_candidate = |at: (i32, i32), candidate: u16| {
        let index = usize::from(candidate).checked_sub(1)?;
        Some(expected[index].at(sight.seen[index].met(at)?.0))
    };
    let pixel = |(at, candidates): ((i32, i32), &[u16; CANDIDATES])| {
        candidates.map(|candidate| of_candidate(at, candidate).unwrap_or(0.0))
    };
    Image::new(sight.candidates.rect(), sight.candidates.iter().map(pixel).collect())
}
