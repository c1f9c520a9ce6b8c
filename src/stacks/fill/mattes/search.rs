//! The search for mattes in three rounds over a site's photos: the colours of the objects, their silhouettes, and the mattes.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::behind::{MatteSight, colours, evidence};
use super::{MatteBasis, SeeThroughPiece};
use crate::fill::surroundings::SurroundingsFiller;
use quadratura_base::error::{Error, Message, Result};
use quadratura_base::raster::Image;
use quadratura_base::scene::PhotoId;
use quadratura_base::task::Task;
use quadratura_layers::fill::{Donor, FillContext};
use quadratura_layers::matte::{
    CANDIDATES, ColourModel, Compared, ExpectedPiece, FindOptions, Likely, Matte, PieceSilhouette, SeenPiece,
    find_mattes, object_model,
};

/// The steps of the logarithm of odds in which photos are kept between the rounds.
const STEPS: f32 = 16.0;

/// A search among the photos of a site.
pub(super) struct Search<'a> {
    pub basis: &'a MatteBasis<'a>,
    pub context: &'a FillContext<'a>,
    /// The see-through surfaces of the model.
    pub pieces: &'a [SeeThroughPiece],
    pub around: SurroundingsFiller<'a>,
    /// The photos whose mattes cannot be found.
    pub failed: BTreeSet<PhotoId>,
    pub task: &'a Task,
}

/// The mattes that a search has found.
pub(super) struct FoundMattes {
    /// The mattes by photo.
    pub of_photo: Vec<(PhotoId, Vec<Matte>)>,
    /// The photos whose mattes could not be found.
    pub failed: BTreeSet<PhotoId>,
}

/// What is kept of a photo between the rounds.
struct RoundState {
    /// Per pixel of the sight the logarithm of the odds in [`STEPS`], and whether it is known what is behind.
    odds: Vec<(i8, bool)>,
    /// The silhouettes by piece.
    silhouettes: BTreeMap<u16, PieceSilhouette>,
}

/// Returns pieces that are like each other, in groups.
fn kinds(pieces: &[SeeThroughPiece]) -> Vec<BTreeSet<u16>> {
    let mut kinds: Vec<BTreeSet<u16>> = Vec::new();
    for (index, piece) in (1..).zip(pieces) {
        let is_like = |kind: &&mut BTreeSet<u16>| {
            kind.first().is_some_and(|other| piece.is_like(&pieces[usize::from(*other) - 1]))
        };
        match kinds.iter_mut().find(is_like) {
            Some(kind) => drop(kind.insert(index)),
            None => kinds.push(BTreeSet::from([index])),
        }
    }
    kinds
}

/// Returns the index of each piece's kind.
fn kind_of_pieces(kinds: &[BTreeSet<u16>], pieces: usize) -> Vec<usize> {
    let mut of_piece = vec![0; pieces];
    for (index, kind) in kinds.iter().enumerate() {
        kind.iter().for_each(|piece| of_piece[usize::from(*piece) - 1] = index);
    }
    of_piece
}

impl Search<'_> {
    /// Returns the mattes of these photos, and the photos that failed, which are noted and left out.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn mattes(mut self, photos: &[PhotoId]) -> Result<FoundMattes> {
        let kinds = kinds(self.pieces);
        let of_piece = kind_of_pieces(&kinds, self.pieces.len());
        let kind_of = |index: u16| usize::from(index).checked_sub(1).map(|piece| of_piece[piece]);
        let mut samples = vec![Vec::new(); kinds.len()];
        let (task, count) = (self.task, photos.len() as u64);
        for (done, id) in (0..).zip(photos) {
            task.step("compare see-through surfaces", done, 2 * count)?;
            let found = self.tried(*id, |search, own, sight, task| {
                let evidence =
                    evidence(search.basis, search.context, *id, own, sight, &mut search.around, task)?;
                let Some(compared) = Compared::new(&evidence) else { return Ok(Vec::new()) };
                Ok(compared.object_samples(&evidence, kinds.len(), kind_of))
            })?;
            for (samples, found) in samples.iter_mut().zip(found.into_iter().flatten()) {
                samples.extend(found);
            }
        }
        let models: Vec<Option<ColourModel>> = samples.iter().map(|samples| object_model(samples)).collect();
        let model_of = |index: u16| kind_of(index).and_then(|kind| models[kind].as_ref());
        let mut kept = BTreeMap::new();
        for (done, id) in (count..).zip(photos) {
            task.step("compare see-through surfaces", done, 2 * count)?;
            let found =
                self.tried(*id, |search, own, sight, task| search.kept(*id, own, sight, &model_of, task))?;
            kept.extend(found.map(|found| (*id, found)));
        }
        task.step("compare see-through surfaces", 2 * count, 2 * count)?;
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
        Ok(FoundMattes { of_photo: mattes, failed: self.failed })
    }

    /// Does some work on a photo; returns `None` where it shows no see-through surface, and where that fails, which is noted.
    fn tried<T>(
        &mut self,
        photo: PhotoId,
        work: impl FnOnce(&mut Self, &Donor, &MatteSight, &Task) -> Result<T>,
    ) -> Result<Option<T>> {
        let task = self.task.with_subject(&self.basis.site.photo(photo).name);
        let tried = || {
            let own: Option<Arc<Donor>> = self.context.source.own(photo)?;
            let own = own.ok_or_else(|| Error::Request("the photo cannot be read".into()))?;
            let sight = task.timed("matte sight", || MatteSight::new(self.basis, &own, self.pieces));
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

    /// Returns how likely a photo's pixels show see-through surfaces, and the silhouettes that follow. `model` is that of the
    /// colours of a piece, by its index plus one.
    fn kept<'m>(
        &mut self,
        photo: PhotoId,
        own: &Donor,
        sight: &MatteSight,
        model: &(impl Fn(u16) -> Option<&'m ColourModel> + Sync),
        task: &Task,
    ) -> Result<RoundState> {
        let evidence = evidence(self.basis, self.context, photo, own, sight, &mut self.around, task)?;
        let odds = task.timed("matte odds", || {
            let compared = Compared::new(&evidence)?;
            Some(compared.log_odds(&evidence, model))
        });
        // Where nothing is known of the colours, it is not known either what is behind.
        let none = || Image::filled(evidence.colours.rect(), 0.0);
        let is_known = odds.is_some();
        let odds = odds.unwrap_or_else(none);
        let mut silhouettes: BTreeMap<u16, PieceSilhouette> = BTreeMap::new();
        for ((at, odds), candidates) in odds.iter().zip(sight.candidates.pixels()) {
            // Where several are, nobody knows which one is shown.
            let [index, 0, ..] = *candidates else { continue };
            let Some(seen) = usize::from(index).checked_sub(1).map(|index| &sight.seen[index]) else {
                continue;
            };
            if let Some((place, _)) = seen.met(at).filter(|_| is_known) {
                let silhouette = silhouettes.entry(index).or_insert_with(|| PieceSilhouette::new(seen));
                silhouette.add(place, 1.0 / (1.0 + (-odds).exp()));
            }
        }
        let step = |(odds, predicted): (&f32, bool)| ((odds * STEPS).round() as i8, predicted && is_known);
        let predicted = evidence.predicted.pixels().iter().map(Option::is_some);
        Ok(RoundState { odds: odds.pixels().iter().zip(predicted).map(step).collect(), silhouettes })
    }

    /// Finds the mattes of a photo.
    fn found(
        &self,
        kept: &BTreeMap<PhotoId, RoundState>,
        photo: PhotoId,
        own: &Donor,
        sight: &MatteSight,
        task: &Task,
    ) -> Result<Vec<Matte>> {
        let Some(RoundState { odds, .. }) = kept.get(&photo) else { return Ok(Vec::new()) };
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
        let names: Vec<&str> = self.pieces.iter().map(|piece| &piece.name[..]).collect();
        find_mattes(&likely, &names, &FindOptions::default(), task)
    }
}

/// Returns what the other photos expect at each pixel of each candidate.
fn expected(
    kept: &BTreeMap<PhotoId, RoundState>,
    photo: PhotoId,
    sight: &MatteSight,
) -> Image<[f32; CANDIDATES]> {
    // Of thousands of faces a photo shows few, and what others tell of one takes time.
    let mut is_shown = vec![false; sight.seen.len() + 1];
    sight.candidates.pixels().as_flattened().iter().for_each(|index| is_shown[usize::from(*index)] = true);
    let of_piece = |(index, seen): (u16, &SeenPiece)| {
        if !is_shown[usize::from(index)] {
            return None;
        }
        let others = kept.iter().filter(|(other, _)| **other != photo);
        let others = others.filter_map(|(_, kept)| kept.silhouettes.get(&index));
        Some(PieceSilhouette::new(seen).expected_from(others))
    };
    let expected: Vec<Option<ExpectedPiece>> = (1..).zip(&sight.seen).map(of_piece).collect();
    let of_candidate = |at: (i32, i32), candidate: u16| {
        let index = usize::from(candidate).checked_sub(1)?;
        Some(expected[index].as_ref()?.at(sight.seen[index].met(at)?.0))
    };
    let pixel = |(at, candidates): ((i32, i32), &[u16; CANDIDATES])| {
        candidates.map(|candidate| of_candidate(at, candidate).unwrap_or(0.0))
    };
    Image::new(sight.candidates.rect(), sight.candidates.iter().map(pixel).collect())
}
