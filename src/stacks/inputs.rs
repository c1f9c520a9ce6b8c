//! The hash of a stack's inputs: while it is unchanged, the stack is up to date.

use std::collections::BTreeMap;

use blake3::Hasher;
use serde::Serialize;

use quadratura_base::error::Result;
use quadratura_base::scene::builder::says_backdrop;
use quadratura_base::scene::impostor::Impostor;
use quadratura_base::scene::{Model, Photo};
use quadratura_document::Decisions;
use quadratura_files::known_hashes::hash_unchanged;
use quadratura_layers::{BoxShape, Method, ObjectOptions, Options};

/// A counter of changes in what a build makes from the same inputs.
const REVISION: u32 = 3;

/// The inputs of stacks: the model, options and program that all photos of a project share, and the decisions about
/// single photos' layers.
#[derive(Debug)]
pub struct Inputs<'a> {
    model: String,
    options: &'a Options,
    decisions: &'a Decisions,
}

impl<'a> Inputs<'a> {
    /// Collects the inputs: a model in world coordinates, options, and decisions.
    pub fn new(model: &Model, options: &'a Options, decisions: &'a Decisions) -> Self {
        Self { model: hash_of_model(model), options, decisions }
    }

    /// Returns the hash of all inputs of the stack of `photo`: 64 hexadecimal digits, and where decisions about its
    /// layers exist, `-` and 64 more.
    ///
    /// # Errors
    /// Returns [`quadratura_base::Error::Io`] when the photo cannot be read.
    pub fn hash(&self, photo: &Photo) -> Result<String> {
        let pixels = hash_unchanged(&photo.file)?;
        let (camera, pose) = (&photo.camera, &photo.pose);
        let camera = (camera.width, camera.height, camera.matrix_rows());
        let pose = (pose.rotation_rows(), pose.translation);
        let program = (env!("CARGO_PKG_VERSION"), REVISION);
        let all = (program, &photo.name, pixels, &self.model, camera, pose, HashedOptions::new(self.options));
        // The names of mask files do not matter, and without masks the hash is the same as before masks were
        // introduced.
        let mut masks = photo.masks.iter().map(|mask| hash_unchanged(mask)).collect::<Result<Vec<_>>>()?;
        masks.sort_unstable();
        let base = hash_of(&all);
        let base = if masks.is_empty() { base } else { hash_of(&(base, masks)) };
        let decided = self.decisions.of(&photo.name).of_stack();
        Ok(if decided.is_default() { base } else { format!("{base}-{}", hash_of(&decided)) })
    }
}

/// The options as they are hashed. Those that change nothing are absent, so that the hash is the same as before they
/// were introduced.
#[derive(Serialize)]
struct HashedOptions<'a> {
    method: &'a Method,
    tolerance: f32,
    min_support: u32,
    margin: u32,
    boxes: &'a BoxShape,
    published: bool,
    largest_side: u32,
    reach: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    least_visible: Option<(u32, f32, &'a BTreeMap<String, ObjectOptions>)>,
    #[serde(skip_serializing_if = "Option::is_none")]
    tolerated: Option<f32>,
}

impl<'a> HashedOptions<'a> {
    fn new(options: &'a Options) -> Self {
        let Options { method, tolerance, min_support, margin, boxes, published, largest_side, .. } = options;
        let Options { min_visible, min_share, objects, .. } = options;
        let all_faces = objects.is_empty() && (*min_visible == 0 || *min_share == 0.0);
        Self {
            method,
            tolerance: *tolerance,
            min_support: *min_support,
            margin: *margin,
            boxes,
            published: *published,
            largest_side: *largest_side,
            reach: options.reach,
            tolerated: (options.tolerated > 0.0).then_some(options.tolerated),
            least_visible: (!all_faces).then_some((*min_visible, *min_share, objects)),
        }
    }
}

/// Returns the hexadecimal BLAKE3 hash of a value's JSON.
fn hash_of(value: &impl serde::Serialize) -> String {
    let text = serde_json::to_vec(value).expect("plain data is JSON");
    blake3::hash(&text).to_hex().to_string()
}

/// Returns the hash of the model, exact to the bit and in the order of its file.
pub fn hash_of_model(model: &Model) -> String {
    let mut hasher = Hasher::new();
    for vertex in &model.vertices {
        add_numbers(&mut hasher, vertex.to_array());
    }
    model.ring_vertices.iter().for_each(|vertex| add(&mut hasher, [*vertex]));
    model.triangles.iter().for_each(|triangle| add(&mut hasher, *triangle));
    for object in &model.objects {
        hasher.update(object.name.as_bytes());
        // Names contain no zero bytes, so that two names cannot be mistaken for one.
        hasher.update(&[0, object.billboard.into()]);
        if let Some(Impostor { foot, axis, height, half_width }) = object.impostor {
            add_numbers(&mut hasher, foot.to_array());
            add_numbers(&mut hasher, axis.to_array());
            add_numbers(&mut hasher, [height, half_width, 0.0]);
        }
        // Only what was decided, so that the hash is the same as before such decisions were introduced.
        if object.see_through != object.impostor.is_some() {
            hasher.update(&[2, object.see_through.into()]);
        }
        // Backdrops have layers of their own; models without any keep their hash.
        if says_backdrop(&object.name) {
            hasher.update(&[3]);
        }
    }
    for face in &model.faces {
        let (ring, triangles) = (face.ring.end, face.triangles.end);
        add(&mut hasher, [face.object.0, face.index.0, ring, triangles, face.planar.into()]);
        add_numbers(&mut hasher, face.plane.normal.to_array());
        add_numbers(&mut hasher, face.plane.point.to_array());
    }
    hasher.finalize().to_hex().to_string()
}

fn add<const N: usize>(hasher: &mut Hasher, numbers: [u32; N]) {
    hasher.update(numbers.map(u32::to_le_bytes).as_flattened());
}

fn add_numbers(hasher: &mut Hasher, numbers: [f64; 3]) {
    hasher.update(numbers.map(f64::to_le_bytes).as_flattened());
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use glam::{DMat3, DVec3};

    use super::*;
    use quadratura_base::geometry::{Pinhole, Pose, Similarity};
    use quadratura_base::scene::synthetic::Modeller;

    fn photo(file: &Path) -> Photo {
        let camera = Pinhole { width: 4, height: 3, fx: 3.0, fy: 3.0, cx: 2.0, cy: 1.5 };
        let pose = Pose { rotation: DMat3::IDENTITY, translation: DVec3::ZERO };
        Photo { name: "a.png".into(), camera, pose, file: file.into(), masks: Vec::new(), exposure: None }
    }

    #[test]
    fn a_change_of_model_options_camera_pixels_or_masks_changes_the_hash() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let model = Model { vertices: vec![DVec3::ONE], ..Model::default() };
        let (options, photo) = (Options::default(), photo(file.path()));
        let none = Decisions::default();
        let hash = Inputs::new(&model, &options, &none).hash(&photo).unwrap();
        assert_eq!(Inputs::new(&model, &options, &none).hash(&photo).unwrap(), hash);

        let moved = Similarity { translation: DVec3::X, ..Similarity::IDENTITY };
        assert_ne!(Inputs::new(&model.transformed(&moved), &options, &none).hash(&photo).unwrap(), hash);
        let wider = Options { margin: 9, ..Options::default() };
        assert_ne!(Inputs::new(&model, &wider, &none).hash(&photo).unwrap(), hash);
        let mut other = photo.clone();
        other.camera.cx += 1e-9;
        assert_ne!(Inputs::new(&model, &options, &none).hash(&other).unwrap(), hash);
        let mask = tempfile::NamedTempFile::new().unwrap();
        let masked = Photo { masks: vec![mask.path().into()], ..photo.clone() };
        let with_mask = Inputs::new(&model, &options, &none).hash(&masked).unwrap();
        assert_ne!(with_mask, hash);
        std::fs::write(mask.path(), "other").unwrap();
        assert_ne!(Inputs::new(&model, &options, &none).hash(&masked).unwrap(), with_mask);
        std::fs::write(file.path(), "pixels").unwrap();
        assert_ne!(Inputs::new(&model, &options, &none).hash(&photo).unwrap(), hash);
    }

    #[test]
    fn only_models_with_a_backdrop_have_another_hash_than_before_these_had_layers_of_their_own() {
        let hash = |name: &str| hash_of_model(&Modeller::new().object(name).finish());
        let before = |name: &str| {
            let mut hasher = Hasher::new();
            hasher.update(name.as_bytes());
            hasher.update(&[0, 0]);
            hasher.finalize().to_hex().to_string()
        };
        assert_eq!(hash("trees"), before("trees"));
        assert_ne!(hash("Trees.Backdrop"), before("Trees.Backdrop"));
    }

    #[test]
    fn a_decision_changes_the_hash_of_its_own_photo_and_leaves_its_ground() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let model = Model::default();
        let options = Options::default();
        let photo = photo(file.path());
        let hash = |name: &str, text: &str| {
            let mut decisions = Decisions::default();
            decisions.set(name, serde_json::from_str(text).unwrap());
            Inputs::new(&model, &options, &decisions).hash(&photo).unwrap()
        };
        let plain = hash("a.png", "{}");
        let merged = hash("a.png", r#"{"merge":[[{"object":"a"},{"object":"b"}]]}"#);
        assert!(merged.starts_with(&format!("{plain}-")) && merged.len() == 129);
        assert_ne!(hash("a.png", r#"{"options":{"margin":9}}"#), merged);
        let for_any_stack = r#"{"pin":[{"object":"a"}],"exclude":[{"object":"b"}],"names":[{"name":"n","of":[{"object":"a"}]}]}"#;
        assert_eq!(hash("a.png", for_any_stack), plain);
        assert_eq!(hash("b.png", r#"{"merge":[[{"object":"a"}]]}"#), plain, "another photo's");
    }
}
