//! Levels of detail of a sub-object's polygons, for views in which it is small and still drawn as polygons: limbs with fewer sides and
//! segments. The published system draws the polygons of the file at any size (Max 1996); a limb is kept as a curve, whose polygons can be
//! made again, as few as the view needs.

use std::f64::consts::PI;

use super::primitive::{CurvePoint, Limb, Primitive, Shape};
use super::stretch::largest_stretch;

/// The deviation of the finest level after the full detail, as a share of the radius of the thickest limb. Each level deviates by twice as
/// much as the one before.
const FINEST: f64 = 0.02;
/// The most levels besides the full detail.
const MOST_COARSER: usize = 8;
/// A level has at most this share of the polygons of the one before, or is left out.
const WORTH: f64 = 0.75;

/// The numbers of sides and of segments of a limb.
type Tessellation = [u32; 2];

/// The levels of detail of a sub-object's own primitives, from fine to coarse; level 0 is the full detail.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DetailLevels {
    /// From level 1 on.
    coarser: Vec<CoarserLevel>,
}

#[derive(Debug, Clone, PartialEq)]
struct CoarserLevel {
    /// How far surfaces are from those of full detail at most, in the sub-object's unit.
    deviation: f64,
    /// Of each limb, in the order of the primitives.
    limbs: Vec<Tessellation>,
}

impl DetailLevels {
    /// Finds the levels of primitives; without limbs there is the full detail alone.
    pub fn of(primitives: &[Primitive]) -> Self {
        let limbs: Vec<LimbTessellations> = limbs(primitives).map(LimbTessellations::new).collect();
        let others = primitives.iter().filter(|primitive| !matches!(primitive.shape, Shape::Limb(_)));
        let others: u64 = others.map(|primitive| primitive.shape.polygons()).sum();
        let polygons = |limbs: &[Tessellation]| -> u64 {
            let of_limbs = limbs.iter().map(|[sides, segments]| u64::from(*sides) * u64::from(*segments));
            others + of_limbs.sum::<u64>()
        };
        let mut fewest = polygons(&limbs.iter().map(|limb| limb.full).collect::<Vec<_>>());
        let mut deviation = FINEST * limbs.iter().map(|limb| limb.radius).fold(0.0, f64::max);
        let mut coarser = Vec::new();
        for _ in 0..MOST_COARSER {
            let level: Vec<Tessellation> = limbs.iter().map(|limb| limb.within(deviation)).collect();
            let count = polygons(&level);
            if count > 0 && count as f64 <= WORTH * fewest as f64 {
                fewest = count;
                coarser.push(CoarserLevel { deviation, limbs: level });
            }
            deviation *= 2.0;
        }
        Self { coarser }
    }

    /// Returns the number of levels, the full detail included.
    pub fn count(&self) -> usize {
        1 + self.coarser.len()
    }

    /// Returns the coarsest level whose surfaces are no farther than `most` from those of full detail, in the sub-object's unit.
    pub fn level(&self, most: f64) -> usize {
        self.coarser.partition_point(|level| level.deviation <= most)
    }

    /// Returns how far the surfaces of a level are from those of full detail at most, in the sub-object's unit.
    #[cfg(test)]
    pub fn deviation(&self, level: usize) -> f64 {
        level.checked_sub(1).map_or(0.0, |index| self.coarser[index].deviation)
    }

    /// Returns the limbs among a sub-object's own primitives as a level has them.
    pub(super) fn limbs<'a>(
        &'a self,
        primitives: &'a [Primitive],
        level: usize,
    ) -> impl Iterator<Item = Limb> + 'a {
        let coarser = level.checked_sub(1).map(|index| &self.coarser[index].limbs);
        limbs(primitives).enumerate().map(move |(index, limb)| match coarser {
            Some(coarser) => limb.with(coarser[index]),
            None => limb.clone(),
        })
    }
}

fn limbs(primitives: &[Primitive]) -> impl Iterator<Item = &Limb> {
    primitives.iter().filter_map(|primitive| match &primitive.shape {
        Shape::Limb(limb) => Some(limb),
        _ => None,
    })
}

impl Limb {
    /// Returns the limb with other numbers of sides and segments. Its radius is changed so that it looks as wide, on average over all
    /// directions across it: the mean width of a convex outline is its perimeter over pi (Cauchy).
    fn with(&self, [sides, segments]: Tessellation) -> Self {
        let factor = widened(self.sides, sides);
        let points = self.points.iter();
        let points = points.map(|point| CurvePoint { radius: factor * point.radius, ..*point });
        Self { points: points.collect(), sides, segments, object_from_limb: self.object_from_limb }
    }
}

/// Returns the factor on the radius of a polygon of `given` sides that gives one of `sides` sides the same perimeter.
fn widened(given: u32, sides: u32) -> f64 {
    let of_radius = |sides: u32| f64::from(sides) * (PI / f64::from(sides)).sin();
    of_radius(given) / of_radius(sides)
}

/// Returns how far apart the outlines of two polygons around a circle of radius 1 are at most: one of `given` sides, and one of fewer sides
/// and the same perimeter.
fn apart_across(given: u32, sides: u32) -> f64 {
    if given == sides {
        return 0.0;
    }
    let inner = |sides: u32| (PI / f64::from(sides)).cos();
    let factor = widened(given, sides);
    (factor - inner(given)).max(1.0 - factor * inner(sides))
}

/// What a limb can be drawn as, and how far that is from its full detail.
struct LimbTessellations {
    full: Tessellation,
    /// The largest radius, in the sub-object's unit.
    radius: f64,
    /// Numbers of segments, from few to many, with the distance from the full detail that comes from them where sides are fewer, too, in the
    /// sub-object's unit.
    along: Vec<(u32, f64)>,
}

impl LimbTessellations {
    fn new(limb: &Limb) -> Self {
        let stretch = largest_stretch(&limb.object_from_limb.matrix3);
        let radius = limb.points.iter().map(|point| point.radius).fold(0.0, f64::max);
        // Of three sides, the radius is the widest.
        let most = stretch * widened(limb.sides, 3);
        let halves =
            std::iter::successors(Some(limb.segments), |count| (*count > 1).then(|| count.div_ceil(2)));
        let mut along: Vec<_> = halves.map(|count| (count, most * limb.apart_along(count))).collect();
        along.reverse();
        Self { full: [limb.sides, limb.segments], radius: stretch * radius, along }
    }

    /// Returns the fewest polygons whose surfaces are no farther than this from those of full detail; half of it goes to segments.
    fn within(&self, deviation: f64) -> Tessellation {
        let fits = |(_, apart): &&(u32, f64)| *apart <= 0.5 * deviation;
        let Some((segments, apart)) = self.along.iter().find(fits) else { return self.full };
        let left = deviation - apart;
        let [given, _] = self.full;
        let sides = (3..given).find(|sides| self.radius * apart_across(given, *sides) <= left);
        [sides.unwrap_or(given), *segments]
    }
}
