//! Options of the method, shared by the command line, the project file and the editor.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::cluster::SMALLEST_TILE;

/// The smallest tolerance allowed: five times [`super::rasteriser::TIE`], because depths in f32 cannot
/// separate a finer tolerance from rounding.
const LEAST_TOLERANCE: f32 = 1e-5;

/// The algorithm that finds the visibility layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// The occlusion graph: every pair of fragments is counted, cycles are forgiven or cut.
    #[default]
    Graph,
    /// Stencil peeling as published in 2003; its order may be wrong, and the contradictions are reported.
    Stencil,
}

/// The shape of an image layer's rectangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BoxShape {
    /// Width and height are powers of two.
    #[default]
    PowerOfTwo,
    /// Width and height are the bounding box's with its margin.
    Exact,
}

/// Options of the visibility sort and of the image layers. [`Options::default`] has those of new projects; a file
/// without some of the fields was written before these existed, and means what was done then.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// The algorithm that finds the visibility layers.
    pub method: Method,
    /// Relative depth tolerance: a occludes b where depth_a (1 + tolerance) < depth_b. Range: 1e-5 <=
    /// tolerance < 0.1; below that, rounding decides ([`super::rasteriser::TIE`]).
    pub tolerance: f32,
    /// The largest support, in pixels, at which a refused edge counts as contact noise.
    pub min_support: u32,
    /// Pixels added on every side of an element's bounding box.
    pub margin: u32,
    /// The shape of rectangles: sides that are powers of two, or the exact box.
    pub boxes: BoxShape,
    /// Merges image layers within one visibility layer only, as published in 2003.
    pub published: bool,
    /// The longest side that an image layer may have, in pixels; larger elements are split into several side
    /// by side.
    pub largest_side: u32,
    /// A face that the photo shows at fewer pixels than this, and at a smaller share of its pixels than
    /// `min_share`, gets no image layer; 0 gives every face one, as does a file without this field.
    #[serde(default)]
    pub min_visible: u32,
    /// The share of the pixels that a face covers, 0 to 1, from which it gets an image layer however few of them
    /// are visible; 0 gives every face one.
    pub min_share: f32,
    /// The share, 0 to 1, of the visible pixels of the smaller of two parts of one object up to which the parts may
    /// occlude each other and be one element; 0, as in a file without this field, keeps them apart.
    #[serde(default)]
    pub tolerated: f32,
    /// How far from its visible part the layer of the surroundings is needed, as a share of the photo's longer side,
    /// 0 to 1; 1 is all of the photo.
    pub reach: f32,
    /// The objects whose `min_visible`, `min_share` or `tolerated` differ, by name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub objects: BTreeMap<String, ObjectOptions>,
}

/// The options that differ for one object; `None` stands for the photo's or the project's value.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ObjectOptions {
    /// Overrides [`Options::min_visible`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_visible: Option<u32>,
    /// Overrides [`Options::min_share`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_share: Option<f32>,
    /// Overrides [`Options::tolerated`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerated: Option<f32>,
}

/// The share of new projects.
const TOLERATED: f32 = 0.0;

/// The reach of the surroundings, as a share of the photo's longer side. Nothing behind a silhouette is seen farther
/// than this from views near the photo, and a whole photo of filling for a strip of sky would be mostly invented.
const REACH: f32 = 0.04;

impl Default for Options {
    fn default() -> Self {
        Self {
            method: Method::Graph,
            tolerance: 1e-4,
            min_support: 16,
            margin: 1,
            boxes: BoxShape::PowerOfTwo,
            published: false,
            largest_side: 16384,
            min_visible: 64,
            min_share: 0.005,
            tolerated: TOLERATED,
            reach: REACH,
            objects: BTreeMap::new(),
        }
    }
}

impl Options {
    /// Returns the options of a project file without any: those of new projects, without what changed stacks after
    /// the first format was released. So a new version of the program puts no stack out of date.
    pub fn of_before() -> Self {
        Self { min_visible: 0, tolerated: 0.0, ..Self::default() }
    }

    /// Describes the first option that is out of range, named as in `project.json`; `None` when all options
    /// are valid.
    pub fn problem(&self) -> Option<String> {
        // The condition is negated so that NaN counts as out of range too.
        if !(self.tolerance >= LEAST_TOLERANCE && self.tolerance < 0.1) {
            return Some(format!(
                "tolerance is {}, expected {LEAST_TOLERANCE} at least and less than 0.1",
                self.tolerance
            ));
        }
        if self.margin > LARGEST_MARGIN {
            return Some(format!("margin is {}, expected at most {LARGEST_MARGIN} pixels", self.margin));
        }
        if !(SMALLEST_TILE..=LARGEST_SIDE).contains(&self.largest_side) {
            return Some(format!(
                "largest_side is {}, expected {SMALLEST_TILE} to {LARGEST_SIDE} pixels",
                self.largest_side
            ));
        }
        // After subtracting its margins, a tile has to keep half of the smallest tile's side, within a power
        // of two.
        if SMALLEST_TILE / 2 + 2 * self.margin > 1 << self.largest_side.ilog2() {
            return Some(format!(
                "largest_side is {}, too small for a margin of {} pixels on every side",
                self.largest_side, self.margin
            ));
        }
        self.problem_of_shares()
    }

    /// Describes the first share that is not a share, of the project or of an object.
    fn problem_of_shares(&self) -> Option<String> {
        let is_share = |share: &f32| (0.0..=1.0).contains(share);
        let of_objects = self.objects.iter().flat_map(|(object, own)| {
            let shares = [("min_share", own.min_share), ("tolerated", own.tolerated)];
            shares.into_iter().filter_map(move |(name, share)| Some((name, Some(object), share?)))
        });
        let of_all = [
            ("min_share", None, self.min_share),
            ("tolerated", None, self.tolerated),
            ("reach", None, self.reach),
        ];
        let (name, object, share) =
            of_all.into_iter().chain(of_objects).find(|(.., share)| !is_share(share))?;
        let of = object.map_or(String::new(), |object| format!(" of {object:?}"));
        Some(format!("{name}{of} is {share}, expected 0 to 1"))
    }

    /// Returns `min_visible` and `min_share` for the faces of an object.
    pub fn least_visible(&self, object: &str) -> (u32, f32) {
        let own = self.objects.get(object).copied().unwrap_or_default();
        (own.min_visible.unwrap_or(self.min_visible), own.min_share.unwrap_or(self.min_share))
    }

    /// Returns `tolerated` for the parts of an object.
    pub(crate) fn tolerated_share(&self, object: &str) -> f32 {
        self.objects.get(object).and_then(|own| own.tolerated).unwrap_or(self.tolerated)
    }

    /// Returns true when the parts of some object may overlap.
    pub(crate) fn tolerates(&self) -> bool {
        self.tolerated > 0.0 || self.objects.values().any(|own| own.tolerated.is_some_and(|own| own > 0.0))
    }
}

/// The largest margin allowed, in pixels; a wider one is taken for a typing error.
const LARGEST_MARGIN: u32 = 4096;
/// The largest side allowed, in pixels: the largest power of two that leaves rectangle coordinates in i32
/// room for additions.
const LARGEST_SIDE: u32 = 1 << 20;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_can_be_used_and_what_is_out_of_range_is_named() {
        assert_eq!(Options::default().problem(), None);
        let worse = |options: Options| options.problem().unwrap_or_default();
        assert!(worse(Options { tolerance: f32::NAN, ..Options::default() }).contains("tolerance"));
        assert!(worse(Options { margin: u32::MAX, ..Options::default() }).contains("margin"));
        assert!(
            worse(Options { largest_side: 64, margin: 20, ..Options::default() }).contains("margin of 20")
        );
        assert!(worse(Options { largest_side: 0, ..Options::default() }).contains("largest_side"));
        for min_share in [f32::NAN, -0.1, 1.1, f32::INFINITY] {
            assert!(worse(Options { min_share, ..Options::default() }).starts_with("min_share is "));
            let own = ObjectOptions { min_share: Some(min_share), ..ObjectOptions::default() };
            let objects = BTreeMap::from([("tower".to_owned(), own)]);
            assert!(
                worse(Options { objects, ..Options::default() }).starts_with(r#"min_share of "tower" is "#)
            );
        }
        assert!(worse(Options { reach: 1.5, ..Options::default() }).starts_with("reach is "));
        assert_eq!(Options { min_visible: u32::MAX, min_share: 1.0, ..Options::default() }.problem(), None);
    }

    #[test]
    fn fields_that_a_file_does_not_have_mean_what_was_done_before_them() {
        let read = |text: &str| serde_json::from_str::<Options>(text).unwrap();
        assert_eq!(read("{}"), Options::of_before());
        assert_eq!(read(r#"{"margin": 4}"#), Options { margin: 4, ..Options::of_before() });
        let written = serde_json::to_string(&Options::default()).unwrap();
        assert_eq!(read(&written), Options::default(), "a new project keeps what it was made with");
    }

    #[test]
    fn an_object_overrides_what_it_names_and_inherits_the_rest() {
        let own = ObjectOptions { min_visible: Some(9), ..ObjectOptions::default() };
        let objects = BTreeMap::from([("tower".to_owned(), own)]);
        let options = Options { objects, ..Options::default() };
        assert_eq!(options.least_visible("tower"), (9, 0.005));
        assert_eq!(options.least_visible("gate"), (64, 0.005));
    }
}
