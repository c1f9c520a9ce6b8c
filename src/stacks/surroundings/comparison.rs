//! The comparison of the photos' surroundings, one photo after the other, so that few of them have to be in memory at a time.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use crate::shelf::{Shelf, Shelved};
use quadratura_base::error::Result;
use quadratura_base::scene::{PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_layers::agreement::directions::{
    DirectionPhoto, DirectionPhotos, direction_agreement, surroundings_agreement,
};
use quadratura_layers::agreement::far_colours::FarColours;
use quadratura_layers::agreement::suspects::Suspects;
use quadratura_layers::agreement::voters;
use quadratura_layers::one_sky::one_sky;
use quadratura_projection::exposure::LightGroups;
use quadratura_projection::exposure::surroundings::SurroundingsFactors;
use quadratura_view::agreement::PhotoAgreement;

impl Shelved for DirectionPhoto {
    fn bytes(&self) -> u64 {
        self.bytes()
    }
}

/// The photos that take part in a comparison: those of a shelf that have surroundings and are not left out.
pub(super) struct PhotosOnShelf<'a> {
    pub shelf: &'a Shelf<DirectionPhoto>,
    /// Their ids, rising.
    pub ids: Vec<PhotoId>,
}

impl DirectionPhotos for PhotosOnShelf<'_> {
    fn count(&self) -> usize {
        self.ids.len()
    }

    fn photo(&self, number: usize) -> Result<Arc<DirectionPhoto>> {
        Ok(self.shelf.get(self.ids[number].index())?.expect("photos that take part were prepared"))
    }
}

impl PhotosOnShelf<'_> {
    /// Changes each photo.
    pub fn change_all(&self, change: impl Fn(PhotoId, &mut DirectionPhoto) + Sync) -> Result<()> {
        let one = |id: &PhotoId| self.shelf.change(id.index(), |photo| change(*id, photo));
        self.ids.par_iter().try_for_each(one)
    }

    /// Brings the photos nearer to one sky, and adds what that takes to their `factors`, which are in the site's order.
    pub fn unite(&self, factors: &mut [Option<SurroundingsFactors>], task: &Task) -> Result<()> {
        let found = task.timed("one sky", || one_sky(self, task))?;
        for (id, found) in self.ids.iter().zip(found) {
            self.shelf.change(id.index(), |photo| photo.multiply(&found))?;
            let of_photo = &mut factors[id.index()];
            *of_photo = Some(of_photo.take().map_or(found.clone(), |before| before.times(&found)));
        }
        Ok(())
    }

    /// Finds how far others confirm each photo's surroundings, in the order of the site's photos, and keeps it with the prepared
    /// photos. `scale` is that of [`direction_agreement`].
    pub fn compare(
        &self,
        site: &Site,
        groups: &LightGroups,
        scale: f64,
        task: &Task,
    ) -> Result<Vec<PhotoAgreement>> {
        let mut suspects = self.polled(site, groups, scale, task)?;
        for number in 0..self.count() {
            task.check_cancelled()?;
            let other = self.photo(number)?;
            let asking = suspects.par_iter_mut().enumerate().filter(|(asking, _)| *asking != number);
            asking.for_each(|(_, suspects)| suspects.ask(&other, scale));
        }
        let mut agreement = vec![PhotoAgreement::default(); site.photos.len()];
        for (id, suspects) in self.ids.iter().zip(suspects) {
            self.shelf.change(id.index(), |photo| {
                let mut values = photo.agreement_of_pixels();
                suspects.lower(photo, &mut values);
                agreement[id.index()] = surroundings_agreement(photo, &values);
                photo.set_agreement(&values);
            })?;
        }
        Ok(agreement)
    }

    /// Counts the votes of the nearest photos about each photo, keeps them with it, and returns what it is suspected to show of
    /// things that are near.
    fn polled(&self, site: &Site, groups: &LightGroups, scale: f64, task: &Task) -> Result<Vec<Suspects>> {
        let eyes: Vec<DVec3> = site.photos.iter().map(|photo| photo.pose.center_in_world()).collect();
        let without: Vec<PhotoId> =
            site.photo_ids().filter(|id| self.ids.binary_search(id).is_err()).collect();
        let colours = FarColours::new(self)?;
        let count = self.count() as u64;
        let one = |(done, id): (u64, &PhotoId)| {
            task.step("compare surroundings", done, count)?;
            let is_same_light = |other: PhotoId| groups.of(other) == groups.of(*id);
            let tested = self.of(*id)?;
            let others = voters(&eyes, *id, &without, groups).into_iter();
            let others = others.map(|other| Ok((self.of(other)?, is_same_light(other))));
            let others: Vec<(Arc<DirectionPhoto>, bool)> = others.collect::<Result<_>>()?;
            let others: Vec<(&DirectionPhoto, bool)> =
                others.iter().map(|(photo, same_light)| (&**photo, *same_light)).collect();
            let values = direction_agreement(&tested, &others, scale, task)?;
            let suspects = Suspects::find(&tested, colours.as_ref());
            drop(tested);
            self.shelf.change(id.index(), |photo| photo.set_agreement(&values))?;
            Ok(suspects)
        };
        let suspects = (0..).zip(&self.ids).map(one).collect::<Result<_>>()?;
        task.step("compare surroundings", count, count)?;
        Ok(suspects)
    }

    fn of(&self, id: PhotoId) -> Result<Arc<DirectionPhoto>> {
        Ok(self.shelf.get(id.index())?.expect("photos that take part were prepared"))
    }
}
