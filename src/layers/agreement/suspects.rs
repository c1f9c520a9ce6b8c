//! Things in a photo's surroundings that are near, unless photos from elsewhere show them in the same directions: what stands on
//! outlines ([`super::far_colours`]) and what is thin ([`super::thin`]). They are found first, then the other photos are asked about
//! them one after the other, so that no more than one of these has to be in memory.

use glam::DVec3;
use rayon::prelude::*;

use super::connected::around;
use super::directions::{AFAR, DirectionPhoto, detail};
use super::far_colours::{self, EDGE_PX, FarColours, STANDING};
use super::thin::{self, thin_things};
use super::tints::{LEVELS, Tint};
use super::votes::agrees;
use quadratura_base::geometry::{Pinhole, Pose};

/// What one photo is suspected to show of things that are near.
pub struct Suspects {
    camera: Pinhole,
    pose: Pose,
    /// What may stand on outlines, in the order in which it is judged.
    standing: Vec<Suspect>,
    /// Thin things.
    thin: Vec<Suspect>,
    /// Whether any photo from elsewhere was asked: where nobody could confirm a thin thing, nothing is known of it.
    is_asked: bool,
}

/// One thing.
struct Suspect {
    /// The indices of its pixels.
    pixels: Vec<u32>,
    /// The colours of its pixels at all levels of detail; of thin things none.
    tints: Vec<[Tint; LEVELS]>,
    /// Which of its pixels others have confirmed.
    confirmed: Vec<bool>,
}

impl Suspect {
    fn new(pixels: Vec<usize>, tints: Vec<[Tint; LEVELS]>) -> Self {
        let confirmed = vec![false; pixels.len()];
        Self { pixels: pixels.into_iter().map(|at| at as u32).collect(), tints, confirmed }
    }

    /// Returns the indices of its pixels.
    fn thing(&self) -> Vec<usize> {
        self.pixels.iter().map(|at| *at as usize).collect()
    }

    /// Returns the number of its pixels that others have confirmed.
    fn confirmed(&self) -> usize {
        self.confirmed.iter().filter(|confirmed| **confirmed).count()
    }
}

impl Suspects {
    /// Finds the things in a photo; those that stand on outlines by the colours that photos show far from these, if they are known.
    pub fn find(photo: &DirectionPhoto, colours: Option<&FarColours>) -> Self {
        let standing = colours.map_or_else(Vec::new, |colours| Self::standing(photo, colours).standing);
        let thin = thin_things(photo).into_iter().map(|thing| Suspect::new(thing, Vec::new())).collect();
        Self { camera: photo.camera, pose: photo.pose, standing, thin, is_asked: false }
    }

    /// Finds what may stand on outlines alone.
    pub(super) fn standing(photo: &DirectionPhoto, colours: &FarColours) -> Self {
        let tints = |at: &usize| std::array::from_fn(|level| photo.tints().tint(photo.centre(*at), level));
        let suspect = |thing: Vec<usize>| {
            let tints = thing.iter().map(tints).collect();
            Suspect::new(thing, tints)
        };
        let things = colours.standing_things(photo).into_iter().flatten();
        let (standing, thin) = (things.map(suspect).collect(), Vec::new());
        Self { camera: photo.camera, pose: photo.pose, standing, thin, is_asked: false }
    }

    /// Asks another photo whether it shows the same, if it was taken from elsewhere: at a distance of a share of `scale` (world
    /// units), that of [`super::directions::direction_agreement`]. Photos from nearby confirm nothing, since what is near shifts too
    /// little between them.
    pub fn ask(&mut self, other: &DirectionPhoto, scale: f64) {
        let away = other.pose.center_in_world().distance(self.pose.center_in_world());
        if away < AFAR * scale {
            return;
        }
        self.is_asked = true;
        let (camera, pose) = (self.camera, self.pose);
        let direction = |at: usize| {
            let [x, y] = [at % camera.width as usize, at / camera.width as usize].map(|at| at as f64 + 0.5);
            pose.rotation.transpose() * camera.ray_in_camera([x, y].into())
        };
        let same = |at: usize, tints: &[Tint; LEVELS]| {
            shows_the_same(other, direction(at), detail(&camera, &pose, direction(at)), tints)
        };
        for Suspect { pixels, tints, confirmed } in &mut self.standing {
            let pixels = pixels.par_iter().zip(tints).zip(confirmed).filter(|(_, confirmed)| !**confirmed);
            pixels.for_each(|((at, tints), confirmed)| *confirmed = same(*at as usize, tints));
        }
        for Suspect { pixels, confirmed, .. } in &mut self.thin {
            let pixels = pixels.par_iter().zip(confirmed).filter(|(_, confirmed)| !**confirmed);
            pixels.for_each(|(at, confirmed)| {
                *confirmed = thin::shows_something(other, direction(*at as usize))
            });
        }
    }

    /// Lowers the agreement (of all pixels, row by row) of the things that too few have confirmed, after all were asked.
    pub fn lower(&self, photo: &DirectionPhoto, values: &mut [f32]) {
        for suspect in &self.standing {
            let thing = suspect.thing();
            if far_colours::is_suspected(photo, &thing, values)
                && far_colours::is_near(suspect.confirmed(), thing.len())
            {
                lower(photo, &thing, values);
            }
        }
        for suspect in self.thin.iter().filter(|_| self.is_asked) {
            let thing = suspect.thing();
            if thin::is_near(suspect.confirmed(), thing.len()) {
                lower(photo, &thing, values);
            }
        }
    }
}

/// Returns whether a photo shows in a direction (world) what another one shows there in these colours and so much detail.
fn shows_the_same(other: &DirectionPhoto, direction: DVec3, of_detail: f64, tints: &[Tint; LEVELS]) -> bool {
    let shown = |px: &_| other.exposed(other.index(*px)).is_some();
    let Some(px) = other.position(direction).filter(shown) else { return false };
    // At the coarser of both footprints.
    let finer = (of_detail - detail(&other.camera, &other.pose, direction)).round();
    let (own, others) = (finer.max(0.0) as usize, (-finer).max(0.0) as usize);
    agrees(other.tints().distance(tints[own.min(LEVELS - 1)], px, others)) > 0.5
}

/// Lowers the agreement of a thing and of its edge.
fn lower(photo: &DirectionPhoto, thing: &[usize], values: &mut [f32]) {
    let size = [photo.camera.width as usize, photo.camera.height as usize];
    for at in thing.iter().flat_map(|at| around(size, *at, EDGE_PX)) {
        if photo.exposed(at).is_some() {
            values[at] = values[at].min(STANDING);
        }
    }
}
