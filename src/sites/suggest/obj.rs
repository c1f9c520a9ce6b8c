//! The file of a suggestion: an OBJ whose first line tells whether it was changed since.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use glam::DVec3;

use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::Similarity;
use quadratura_base::scene::Model;
use quadratura_files::hash::hash_bytes;
use quadratura_suggest::SuggestedObject;

/// The beginning of the first line; the hash of all that follows the line stands behind it.
const MARK: &str = "# Suggested by Quadratura; written anew only while unchanged: ";

/// An object of an OBJ: its name, and the outlines of its faces in the file's coordinates.
#[derive(Debug, Clone)]
pub struct NamedRings {
    /// The name.
    pub name: String,
    /// The outlines.
    pub rings: Vec<Vec<DVec3>>,
}

/// Returns the text of an OBJ with named objects of polygons; `to_file` takes the world to the file's coordinates.
pub fn obj_text(objects: &[SuggestedObject], to_file: &Similarity) -> String {
    let ring = |ring: &[DVec3]| ring.iter().map(|corner| to_file.apply(*corner)).collect();
    let named = |object: &SuggestedObject| NamedRings {
        name: object.name.clone(),
        rings: object.faces.iter().map(|face| ring(&face.ring)).collect(),
    };
    let body = body(&objects.iter().map(named).collect::<Vec<_>>(), 0);
    format!("{MARK}{}\n{body}", hash_bytes(body.as_bytes()))
}

/// Returns the content of an OBJ with objects appended; what is there stays as it is, byte for byte.
pub fn appended(content: &[u8], objects: &[NamedRings]) -> Vec<u8> {
    let lines = || content.split(|byte| matches!(byte, b'\n' | b'\r'));
    let keyword = |line: &[u8]| line.trim_ascii_start().split(u8::is_ascii_whitespace).next() == Some(b"v");
    let vertices = lines().filter(|line| keyword(line)).count();
    let mut after = content.to_vec();
    if content.last().is_some_and(|last| !matches!(last, b'\n' | b'\r')) {
        after.push(b'\n');
    }
    after.extend_from_slice(b"# Suggested by Quadratura\n");
    if content.windows(6).any(|word| word == b"usemtl") {
        // The last material would go on.
        after.extend_from_slice(b"usemtl suggested\n");
    }
    after.extend_from_slice(body(objects, vertices).as_bytes());
    after
}

/// Returns the text of an OBJ with the objects and faces of a model, in its order.
pub fn obj_of_model(model: &Model) -> String {
    let mut text = String::from("# Copied by Quadratura: names and faces, without textures\n");
    for DVec3 { x, y, z } in &model.vertices {
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    let mut last = None;
    for (id, face) in model.face_ids().zip(&model.faces) {
        if last != Some(face.object) {
            let object = model.object(face.object);
            let _ = writeln!(text, "o {}", object.name);
            let material = if object.billboard { "billboard" } else { "surface" };
            let _ = writeln!(text, "usemtl {material}");
            last = Some(face.object);
        }
        let corners: String = model.ring(id).iter().map(|vertex| format!(" {}", vertex + 1)).collect();
        let _ = writeln!(text, "f{corners}");
    }
    text
}

/// Returns objects as text, behind `count` vertices.
fn body(objects: &[NamedRings], mut count: usize) -> String {
    let corners = || objects.iter().flat_map(|object| object.rings.iter().flatten());
    let low = corners().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = corners().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    // A millionth of the model: a tenth of a millimetre of a building.
    let digits = (6.0 - (high - low).max_element().max(1e-12).log10().floor()).clamp(0.0, 15.0) as usize;
    let mut body = String::new();
    for object in objects {
        let _ = writeln!(body, "o {}", object.name);
        let mut numbers: BTreeMap<String, usize> = BTreeMap::new();
        for ring in &object.rings {
            let mut line = String::from("f");
            for DVec3 { x, y, z } in ring {
                let vertex = format!("v {x:.digits$} {y:.digits$} {z:.digits$}");
                let number = *numbers.entry(vertex).or_insert_with_key(|vertex| {
                    count += 1;
                    let _ = writeln!(body, "{vertex}");
                    count
                });
                let _ = write!(line, " {number}");
            }
            let _ = writeln!(body, "{line}");
        }
    }
    body
}

/// Returns whether a file is a suggestion that nobody has changed.
///
/// # Errors
/// [`Error::Io`].
pub fn is_ours(file: &Path) -> Result<bool> {
    let Ok(text) = String::from_utf8(std::fs::read(file).map_err(Error::io(file, "read it"))?) else {
        return Ok(false);
    };
    let Some((first, body)) = text.split_once('\n') else { return Ok(false) };
    Ok(first.strip_prefix(MARK).is_some_and(|hash| hash == hash_bytes(body.as_bytes())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::task::Task;
    use quadratura_import::models::read_model;
    use quadratura_suggest::SuggestedFace;
    use quadratura_suggest::planes::PlaneKind;

    fn wall() -> SuggestedObject {
        let ring = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 0.0, 1.0), DVec3::Z];
        SuggestedObject {
            name: "wall_1".into(),
            kind: PlaneKind::Plumb,
            faces: vec![SuggestedFace { ring }],
            points: 40,
            photos_for: 3.0,
            photos_against: 0.0,
            gain: None,
        }
    }

    #[test]
    fn the_file_is_read_back_and_known_until_somebody_changes_it() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("suggested.obj");
        std::fs::write(&file, obj_text(&[wall()], &Similarity::IDENTITY)).unwrap();
        let (model, _) = read_model(&file, &Task::silent()).unwrap();
        assert_eq!((model.objects[0].name.as_str(), model.faces.len()), ("wall_1", 1));
        assert!((model.faces[0].plane.normal - DVec3::NEG_Y).length() < 1e-12, "the front is towards -y");
        assert!(is_ours(&file).unwrap());
        let changed = std::fs::read_to_string(&file).unwrap().replace("wall_1", "church");
        std::fs::write(&file, changed).unwrap();
        assert!(!is_ours(&file).unwrap());
    }

    #[test]
    fn coordinates_of_a_survey_keep_their_digits() {
        let mut wall = wall();
        let far = DVec3::new(3_512_345.25, 5_402_345.5, 400.0);
        wall.faces[0].ring.iter_mut().for_each(|corner| *corner += far);
        let text = obj_text(&[wall], &Similarity::IDENTITY);
        assert!(text.contains("v 3512346.250000 5402345.500000 401.000000"), "{text}");
    }
}
