//! Filling of a photo's surroundings: by direction from other photos, of which those nearby count most, else from
//! the dome.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::cells::{CELL_PX, RegionCells};
use super::photo::{FilledRegion, FilledTexel, in_255ths};
use super::ranked_donors::{AGREEMENT_ALONE, BLACK, DonorColour, chosen};
use super::region::Region;
use super::seam::seam;
use super::{DIFFUSED_CONFIDENCE, FillOrigin, INVENTED_CONFIDENCE, MOST_CONFIDENCE, MOST_DONORS};
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::Image;
use quadratura_base::scene::PhotoId;
use quadratura_base::scene::light::srgb_from_linear;
use quadratura_base::task::Task;
use quadratura_projection::Projector;
use quadratura_projection::dome::DomeSampler;
use quadratura_projection::exposure::surroundings::SurroundingsFactors;
use quadratura_projection::surroundings::pixels_per_angle;
use quadratura_projection::twin::sample::{Footprint, Lookup};
use quadratura_view::Blend;
use quadratura_view::agreement::AgreementGrid;
use quadratura_view::optics::Optics;
use quadratura_view::optics::squared_radius;
use quadratura_view::srgb::Srgb;
use quadratura_view::weights::{Claim, border, octaves_missing};

/// The confidence of a photo's surroundings, beside their outline, below which they give nothing: there other
/// things are mixed in.
const LEAST_GIVEN: f64 = 0.3;

/// The agreement below which a direction is outvoted and gives nothing, as on surfaces.
const OUTVOTED: f64 = 0.5;

/// The surroundings that a photo shows, without filling.
pub struct SurroundingsDonor {
    /// The photo.
    pub photo: PhotoId,
    /// Its camera and pose.
    pub projector: Projector,
    /// Its texels, by image layer.
    pub layers: Vec<SurroundingsTexels>,
    /// Its exposure relative to the common one (natural logarithms).
    pub gain: [f64; 3],
    /// Its optics.
    pub optics: Optics,
    /// The factors that bring it to one sky; `None` where there are none.
    pub factors: Option<SurroundingsFactors>,
}

/// An image layer of the surroundings.
pub struct SurroundingsTexels {
    /// The texels.
    pub lookup: Lookup,
    /// Where they are paint; `None` where nothing is.
    pub painted: Option<Image<bool>>,
    /// How far others confirm them; `None` where nothing is contradicted.
    pub agreement: Option<AgreementGrid>,
}

/// A colour in linear light, whether it is paint, and its confidence.
struct SeenColour {
    light: [f64; 3],
    painted: bool,
    confidence: f64,
    agreement: f64,
}

impl SurroundingsDonor {
    /// Returns what the photo shows at a position, in its own exposure.
    fn seen(&self, px: DVec2, footprint: f64) -> Option<SeenColour> {
        let found = |texels: &SurroundingsTexels| {
            let texel = texels.lookup.texel(px, Footprint::Square(footprint))?;
            let at = [px.x, px.y].map(|at| at.floor() as i32);
            let painted =
                texels.painted.as_ref().and_then(|painted| painted.get(at[0], at[1])) == Some(&true);
            let agreement = texels.agreement.as_ref().filter(|_| !painted).map_or(1.0, |grid| grid.at(px));
            (texel.confidence > 0.0).then_some(SeenColour {
                light: texel.colour,
                painted,
                confidence: texel.confidence,
                agreement,
            })
        };
        self.layers.iter().find_map(found)
    }

    /// Brings light of the photo at a position to the common exposure and the common sky.
    fn common(&self, light: [f64; 3], px: DVec2) -> [f32; 3] {
        let light = self.optics.undone(light, squared_radius(&self.projector.camera, px));
        let to_sky = self.to_one_sky(px);
        [0, 1, 2].map(|c| (light[c] * (to_sky[c] - self.gain[c]).exp()) as f32)
    }

    /// Returns the factor from the common exposure and sky to the photo's at a position, with its vignetting.
    fn factor(&self, px: DVec2) -> [f32; 3] {
        // Optics darken in proportion, apart from their offset, which the filling does without.
        let bright = self.optics.undone([1.0; 3], squared_radius(&self.projector.camera, px));
        let to_sky = self.to_one_sky(px);
        [0, 1, 2].map(|c| ((self.gain[c] - to_sky[c]).exp() / bright[c].max(1e-6)) as f32)
    }

    /// Returns the logarithms of the factors to the common sky at a position.
    fn to_one_sky(&self, px: DVec2) -> [f64; 3] {
        let factors = self.factors.as_ref();
        factors.map_or([0.0; 3], |factors| factors.at(&self.projector.camera, px).map(f64::from))
    }
}

/// What the filling of a photo's surroundings is made of.
pub struct SurroundingsFilling<'a> {
    /// The photo that is filled.
    pub own: &'a SurroundingsDonor,
    /// The bits per sample of its file.
    pub bits: u8,
    /// Other photos, the nearest cameras first, [`MOST_DONORS`] at most.
    pub donors: &'a [&'a SurroundingsDonor],
    /// What is seen where no photo shows anything; `None` leaves that empty.
    pub dome: Option<&'a DomeSampler<'a>>,
    /// The distance between cameras from which they see other surroundings, in world units.
    pub scale: f64,
}

/// A colour in the common exposure.
struct ExposedColour {
    colour: [f32; 3],
    confidence: f32,
    origin: FillOrigin,
}

impl SurroundingsFilling<'_> {
    /// Fills a region. Texels of which nothing is known stay empty: then the result is without them.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Cancelled`].
    pub fn fill(&self, region: Region, task: &Task) -> Result<Option<FilledRegion>> {
        let pixels: Vec<(u32, u32)> = region.pixels().collect();
        let centre = |(x, y): (u32, u32)| DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let given = |px: &(u32, u32)| {
            if px.0.is_multiple_of(64) {
                task.check_cancelled()?;
            }
            Ok(self.given(centre(*px), 1.0))
        };
        let given: Vec<Option<ExposedColour>> = pixels.par_iter().map(given).collect::<Result<_>>()?;
        let camera = &self.own.projector.camera;
        let cells = RegionCells::around(&region, PixelRect::of_size(camera.width, camera.height));
        let near: Vec<(usize, DVec2)> = cells.near().collect();
        let differences: Vec<(usize, [f32; 3])> =
            near.into_par_iter().filter_map(|(index, px)| Some((index, self.difference(px)?))).collect();
        let seam = seam(&cells, &differences);
        let texel = |((x, y), given): (&(u32, u32), &Option<ExposedColour>)| {
            let given = given.as_ref()?;
            let seam = seam.as_ref().map_or([0.0; 3], |seam| seam.at(*x, *y)).map(f32::exp);
            let factor = self.own.factor(centre((*x, *y)));
            let rgb = self.stored([0, 1, 2].map(|c| given.colour[c] * seam[c] * factor[c]));
            Some(FilledTexel { rgb, confidence: in_255ths(given.confidence), origin: given.origin })
        };
        let texels: Vec<Option<FilledTexel>> = pixels.par_iter().zip(&given).map(texel).collect();
        let known = region.part(|index| texels[index].is_some());
        Ok(known.map(|region| FilledRegion { region, texels: texels.into_iter().flatten().collect() }))
    }

    /// Returns the colour for a position in the photo, at a footprint of so many of its pixels: paint before
    /// photos, these before the dome.
    fn given(&self, px: DVec2, footprint: f64) -> Option<ExposedColour> {
        let camera = &self.own.projector.camera;
        let ray = camera.ray_in_camera(px);
        let direction = self.own.projector.pose.rotation.transpose() * ray;
        let density = pixels_per_angle(camera, ray) / footprint;
        let mut candidates: Vec<(f64, DonorColour, f32)> = Vec::with_capacity(self.donors.len());
        for (donor_index, donor) in self.donors.iter().enumerate() {
            candidates.extend(self.candidate(donor_index, donor, direction, density));
        }
        candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
        let colours: Vec<DonorColour> = candidates.iter().map(|(_, colour, _)| *colour).collect();
        let (at, agreement) = match (colours.iter().position(|colour| colour.painted), colours.len()) {
            (Some(painted), _) => (painted, 1.0),
            (None, 0) => return self.in_dome(direction),
            (None, 1) => (0, AGREEMENT_ALONE),
            _ => chosen(&colours),
        };
        let (_, DonorColour { colour, donor_index, painted, .. }, trust) = candidates[at];
        let photo = self.donors[donor_index].photo;
        let origin = if painted { FillOrigin::Painted(photo) } else { FillOrigin::Photo(photo) };
        Some(ExposedColour { colour, confidence: MOST_CONFIDENCE * agreement * trust, origin })
    }

    /// Returns what a donor shows in a direction (world), with its penalty and its share of the confidence: that
    /// falls with missing resolution and with the distance of the cameras.
    fn candidate(
        &self,
        donor_index: usize,
        donor: &SurroundingsDonor,
        direction: DVec3,
        density: f64,
    ) -> Option<(f64, DonorColour, f32)> {
        let Projector { camera, pose, .. } = &donor.projector;
        let in_donor = pose.rotation * direction;
        let px = camera.image_from_camera(in_donor).filter(|px| camera.rect().contains_position(*px))?;
        let own_density = pixels_per_angle(camera, in_donor);
        let seen = donor.seen(px, own_density / density)?;
        let border = border(camera, px);
        if border <= 0.0 || (!seen.painted && (seen.confidence < LEAST_GIVEN || seen.agreement < OUTVOTED)) {
            return None;
        }
        let away = pose.center_in_world().distance(self.own.projector.pose.center_in_world());
        let distance = if away > 0.0 { away / self.scale.max(f64::MIN_POSITIVE) } else { 0.0 };
        let claim = Claim {
            angle: distance,
            octaves: octaves_missing(density, own_density),
            border,
            confidence: seen.confidence,
            agreement: seen.agreement,
        };
        let colour = donor.common(seen.light, px);
        let log = colour.map(|c| c.max(BLACK).ln());
        let trust = ((own_density / density).min(1.0) / (1.0 + distance)) as f32;
        Some((
            claim.penalty(&Blend::default()),
            DonorColour { colour, log, donor_index, painted: seen.painted },
            trust,
        ))
    }

    fn in_dome(&self, direction: DVec3) -> Option<ExposedColour> {
        let [r, g, b, known] = self.dome?.at(direction);
        let confidence = DIFFUSED_CONFIDENCE + (INVENTED_CONFIDENCE - DIFFUSED_CONFIDENCE) * known;
        Some(ExposedColour { colour: [r, g, b], confidence, origin: FillOrigin::Diffused })
    }

    /// Returns the logarithm of the photo's own colour over the filling at a cell's centre, in the common exposure;
    /// `None` where it does not show its surroundings there.
    fn difference(&self, px: DVec2) -> Option<[f32; 3]> {
        let footprint = f64::from(CELL_PX);
        let own = self.own.seen(px, footprint).filter(|own| own.confidence >= LEAST_GIVEN)?;
        let (own, given) = (self.own.common(own.light, px), self.given(px, footprint)?);
        Some([0, 1, 2].map(|c| (own[c].max(BLACK) / given.colour[c].max(BLACK)).ln()))
    }

    /// Encodes light as the photo's file stores it, in the full range of 16 bits.
    fn stored(&self, linear: [f32; 3]) -> [u16; 3] {
        let srgb = Srgb::tables();
        linear.map(|light| match self.bits {
            16 => (srgb_from_linear(f64::from(light).clamp(0.0, 1.0)) * 65535.0).round() as u16,
            _ => u16::from(srgb.encoded(light)) * 257,
        })
    }
}

/// Returns these donors by the distance of their cameras from a photo's, the nearest first, [`MOST_DONORS`] at most.
pub fn nearest_first<'a>(
    own: &Projector,
    photos: impl Iterator<Item = (PhotoId, &'a Projector)>,
    most: usize,
) -> Vec<PhotoId> {
    let here = own.pose.center_in_world();
    let mut photos: Vec<(f64, PhotoId)> =
        photos.map(|(id, photo)| (photo.pose.center_in_world().distance(here), id)).collect();
    photos.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    photos.into_iter().map(|(_, id)| id).take(most.min(MOST_DONORS)).collect()
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;
    use crate::LayerIndex;
    use crate::content::PixelSpan;
    use crate::fill::{FillSurfaceId, HiddenSpan};
    use quadratura_base::geometry::{Pinhole, Pose};
    use quadratura_projection::LayerTexturePixels;
    use quadratura_projection::dome::{CubeMap, Dome};
    use quadratura_projection::pyramid::PyramidOptions;
    use quadratura_projection::sources::COVERED;

    const CAMERA: Pinhole = Pinhole { width: 256, height: 128, fx: 150.0, fy: 150.0, cx: 128.0, cy: 64.0 };

    /// A photo at a place along x, in one grey level, that shows its surroundings above this row.
    fn donor(photo: u32, x: f64, grey: u8, rows: i32, painted: bool) -> SurroundingsDonor {
        let rect = PixelRect::of_size(256, 128);
        let texel = |(_, y): (i32, i32)| if y < rows { [grey, grey, grey, 255] } else { [0; 4] };
        let rgba = rect.pixels().flat_map(texel).collect();
        let needed = vec![COVERED; rect.area() as usize];
        let pixels = LayerTexturePixels { rect, rgba, needed, matte: None };
        let lookup = Lookup::new(rect, &pixels, &PyramidOptions::default());
        let painted = painted.then(|| Image::filled(rect, true));
        let pose = Pose { rotation: DMat3::IDENTITY, translation: -DVec3::X * x };
        SurroundingsDonor {
            photo: PhotoId(photo),
            projector: Projector { name: photo.to_string(), camera: CAMERA, pose },
            layers: vec![SurroundingsTexels { lookup, painted, agreement: None }],
            gain: [0.0; 3],
            optics: Optics::default(),
            factors: None,
        }
    }

    #[test]
    fn what_others_show_is_brought_to_the_photos_own_sky() {
        let mut other = donor(1, 0.1, 100, 100, false);
        // It is a third brighter than the common sky, and the own photo is not.
        other.factors = Some(SurroundingsFactors::constant([-0.3; 3]));
        assert!((other.common([0.4; 3], DVec2::new(50.0, 50.0))[0] - 0.4 * (-0.3f32).exp()).abs() < 1e-5);
        let [r, ..] = other.factor(DVec2::new(50.0, 50.0));
        assert!((r - 0.3f32.exp()).abs() < 1e-5, "{r}");
    }

    /// Fills the rows 60 to 70 of a photo that shows rows above 60 in grey 100.
    fn filled(donors: &[SurroundingsDonor], dome: Option<&DomeSampler>) -> Option<FilledRegion> {
        let own = donor(0, 0.0, 100, 60, false);
        let span = |y: u32| HiddenSpan {
            span: PixelSpan { y, x0: 100, x1: 120 },
            layer: LayerIndex(0),
            first: (y - 60) * 20,
        };
        let region = Region { surface: FillSurfaceId::SURROUNDINGS, spans: (60..70).map(span).collect() };
        let donors: Vec<&SurroundingsDonor> = donors.iter().collect();
        let filling = SurroundingsFilling { own: &own, bits: 8, donors: &donors, dome, scale: 1.0 };
        filling.fill(region, &Task::silent()).unwrap()
    }

    fn levels(filled: &FilledRegion) -> (u16, u16) {
        let levels = || filled.texels.iter().map(|texel| texel.rgb[0] / 257);
        (levels().min().unwrap(), levels().max().unwrap())
    }

    #[test]
    fn hidden_surroundings_come_from_the_nearest_photo_brought_to_the_photos_own_level() {
        let found = filled(&[donor(1, 0.5, 140, 128, false), donor(2, 0.1, 120, 128, false)], None).unwrap();
        assert_eq!(found.texels.len(), 200);
        assert!(found.texels.iter().all(|texel| texel.origin == FillOrigin::Photo(PhotoId(2))));
        // The seam brings 120 to the 100 that the photo shows beside it.
        let (low, high) = levels(&found);
        assert!(low >= 98 && high <= 102, "{low} {high}");
        let far = filled(&[donor(1, 5.0, 120, 128, false)], None).unwrap();
        assert!(far.texels[0].confidence < found.texels[0].confidence, "a far camera is trusted less");
    }

    #[test]
    fn paint_of_another_photo_comes_first_and_a_stray_photo_is_passed_over() {
        let painted = [donor(1, 0.1, 120, 128, false), donor(2, 3.0, 120, 128, true)];
        let found = filled(&painted, None).unwrap();
        assert!(found.texels.iter().all(|texel| texel.origin == FillOrigin::Painted(PhotoId(2))));
        let many: Vec<SurroundingsDonor> =
            (1..6).map(|i| donor(i, 0.1 * f64::from(i), if i == 1 { 10 } else { 120 }, 128, false)).collect();
        let found = filled(&many, None).unwrap();
        assert!(found.texels.iter().all(|texel| texel.origin == FillOrigin::Photo(PhotoId(2))));
    }

    #[test]
    fn where_no_photo_shows_anything_the_dome_does_and_without_one_it_stays_empty() {
        let short = [donor(1, 0.1, 120, 40, false)];
        assert_eq!(filled(&short, None), None);
        let dome = Dome::from_light(&CubeMap::from_directions(56, |_| ([0.2; 3], 0.0)));
        let found = filled(&short, Some(&dome.sampler())).unwrap();
        assert!(found.texels.iter().all(|texel| texel.origin == FillOrigin::Diffused));
        assert_eq!(found.texels[0].confidence, in_255ths(DIFFUSED_CONFIDENCE));
    }

    #[test]
    fn donors_are_the_nearest_cameras() {
        let photos = [3.0, 1.0, 2.0, 1.0].map(|x| donor(0, x, 0, 0, false).projector);
        let ids = || PhotoId::all(4).zip(&photos);
        let own = donor(0, 0.0, 0, 0, false).projector;
        assert_eq!(nearest_first(&own, ids(), 3), [1, 3, 2].map(PhotoId));
    }
}
