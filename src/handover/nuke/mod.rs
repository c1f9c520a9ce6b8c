//! A script for Nuke: each image layer is projected by a camera of its own rectangle onto the surfaces that it textures.
//!
//! | module | contents |
//! |---|---|
//! | (this file) | the script as nodes: photos, layers, and the choice among photos |
//! | [`lens`] | the knobs of a camera whose film is a rectangle of a photo |
//! | `text` | the grammar of scripts |
//! | [`geometry`] | the surfaces of a layer as OBJ |
//!
//! Written without Nuke: whether it agrees about `win_translate`, versions of nodes and the crop of `Project3D2` was not seen.

pub mod geometry;
pub mod lens;
mod text;

#[cfg(test)]
mod tests;

use quadratura_base::geometry::PixelRect;

use self::lens::nuke_lens;
use self::text::{Script, number, quoted};
use crate::camera::HandoverCamera;

/// A photo with its image layers.
#[derive(Debug, Clone, PartialEq)]
pub struct NukePhoto {
    /// The photo, with the path of its picture.
    pub camera: HandoverCamera,
    /// The image layers, farthest first.
    pub layers: Vec<NukeLayer>,
}

/// An image layer with the surfaces that it textures.
#[derive(Debug, Clone, PartialEq)]
pub struct NukeLayer {
    /// The token.
    pub token: String,
    /// The readable name.
    pub name: String,
    /// The place in the stack, 0 nearest.
    pub order: u32,
    /// The rectangle in photo pixels.
    pub rect: PixelRect,
    /// The path of its picture.
    pub file: String,
    /// The path of its surfaces.
    pub geometry: String,
}

/// Writes the script, with paths relative to its folder. The nodes `choose_camera`, `choose_photo` and `choose_plate` take photo 0; their knob
/// `which` chooses another one.
pub fn script(photos: &[NukePhoto], generator: &str) -> String {
    let mut script = Script::new(generator);
    let first = photos.first().map(|photo| format_of(&photo.camera, photo.camera.camera.rect(), "photo_0"));
    let directory = r"\[python \{nuke.script_directory()\}]";
    let mut root = vec![("project_directory", format!("\"{directory}\""))];
    root.extend(first.map(|format| ("format", format)));
    script.node("Root", 0, &root);
    for (index, photo) in photos.iter().enumerate() {
        write_photo(&mut script, index, photo);
    }
    let which = "{{choose_photo.which}}".to_owned();
    for (kind, which) in [("camera", which.clone()), ("plate", which), ("photo", "0".to_owned())] {
        (0..photos.len()).rev().for_each(|index| script.push(&format!("{kind}_{index}")));
        script.node("Switch", photos.len(), &[("which", which), ("name", format!("choose_{kind}"))]);
        script.set(&format!("chosen_{kind}"));
    }
    write_picture(&mut script);
    script.finish()
}

/// Writes plate, camera and layers of a photo.
fn write_photo(script: &mut Script, index: usize, photo: &NukePhoto) {
    let camera = &photo.camera;
    let whole = camera.camera.rect();
    script.node(
        "Read",
        0,
        &[
            ("file", quoted(&camera.file)),
            ("format", format_of(camera, whole, &format!("photo_{index}"))),
            ("colorspace", "sRGB".into()),
            ("label", quoted(&camera.name)),
            ("name", format!("plate_{index}")),
        ],
    );
    script.set(&format!("plate_{index}"));
    write_camera(script, camera, whole, &format!("camera_{index}"));
    script.set(&format!("camera_{index}"));
    script.begin_group(&format!("photo_{index}"), &camera.name);
    for layer in &photo.layers {
        write_layer(script, camera, layer);
    }
    script.node("Scene", photo.layers.len(), &[("name", "layers".into())]);
    script.node("Output", 1, &[("name", "Output1".into())]);
    script.end_group();
    script.set(&format!("photo_{index}"));
}

/// Writes a layer: its picture through the camera of its rectangle, on its surfaces.
fn write_layer(script: &mut Script, camera: &HandoverCamera, layer: &NukeLayer) {
    let token = &layer.token;
    write_camera(script, camera, layer.rect, &format!("camera_{token}"));
    script.node(
        "Read",
        0,
        &[
            ("file", quoted(&layer.file)),
            ("format", format_of(camera, layer.rect, &format!("layer_{token}"))),
            ("colorspace", "sRGB".into()),
            ("label", quoted(&format!("{}, order {}", layer.name, layer.order))),
            ("name", format!("layer_{token}")),
        ],
    );
    script.node("Premult", 1, &[("name", format!("premult_{token}"))]);
    // The picture is on top of the stack and becomes input 0, the camera input 1.
    script.node("Project3D2", 2, &[("project_on", "both".into()), ("name", format!("project_{token}"))]);
    script.node("ReadGeo2", 0, &[("file", quoted(&layer.geometry)), ("name", format!("surfaces_{token}"))]);
    script.node("ApplyMaterial", 2, &[("name", format!("apply_{token}"))]);
}

/// Writes a camera whose film is a rectangle of a photo.
fn write_camera(script: &mut Script, camera: &HandoverCamera, rect: PixelRect, name: &str) {
    let lens = nuke_lens(&camera.camera, rect);
    let row = |row: &[f64; 4]| format!("{{{}}}", row.map(number).join(" "));
    let rows: Vec<String> = camera.world_from_gl_camera().iter().map(row).collect();
    let [x, y] = lens.win_translate.map(number);
    script.node(
        "Camera2",
        0,
        &[
            ("useMatrix", "true".into()),
            ("matrix", format!("{{{}}}", rows.join(" "))),
            ("focal", number(lens.focal)),
            ("haperture", number(lens.haperture)),
            ("vaperture", number(lens.vaperture)),
            ("win_translate", format!("{{{x} {y}}}")),
            ("win_scale", "{1 1}".into()),
            ("name", name.into()),
        ],
    );
}

/// Writes what draws the chosen photo's layers from the chosen camera, and compares it with the plate.
fn write_picture(script: &mut Script) {
    script.push("chosen_camera");
    script.push("chosen_photo");
    script.push("chosen_plate");
    // Black, with the format of the plate.
    script.node("Multiply", 1, &[("value", "0".into()), ("name", "frame".into())]);
    script.node("ScanlineRender", 3, &[("motion_vectors_type", "off".into()), ("name", "picture".into())]);
    script.push("chosen_plate");
    script.node("Merge2", 2, &[("operation", "difference".into()), ("name", "difference".into())]);
}

/// Returns a format: width, height, box, pixel aspect (width by height), and a name.
fn format_of(camera: &HandoverCamera, rect: PixelRect, name: &str) -> String {
    let aspect = number(nuke_lens(&camera.camera, rect).pixel_aspect);
    quoted(&format!("{} {} 0 0 {} {} {aspect} {name}", rect.w, rect.h, rect.w, rect.h))
}
