//! `--format nuke`: a script that projects the image layers of one photo at a time onto the model. Experimental: no Nuke has read it.
//!
//! ```text
//! site.nk                      the script
//! layers/PHOTO.layers/         the image layers, to be painted on: the folder format, named by token
//! surfaces/TOKEN.obj           the surfaces of a layer, cut as they are in it
//! photos/                      the undistorted pictures of photos that had to be resampled
//! ```

use std::path::Path;

use glam::DVec3;

use super::HandoverOptions;
use super::blender::layers::{HandedStacks, file_of, handed_stacks};
use super::folder::HandoverFolder;
use super::origin::Placement;
use super::photos::{camera_of, copied, is_resampled, linked};
use quadratura_base::error::Result;
use quadratura_base::scene::Photo;
use quadratura_base::task::Task;
use quadratura_document::Stack;
use quadratura_handover::nuke::geometry::surfaces_obj;
use quadratura_handover::nuke::{NukeLayer, NukePhoto, script};
use quadratura_io::stack_readers::StackReader;
use quadratura_layers::LayerIndex;
use quadratura_sites::open::Opened;
use quadratura_stacks::paint::parts_of_layer;

/// The program's name in files.
const GENERATOR: &str = concat!("Quadratura ", env!("CARGO_PKG_VERSION"));

/// Writes the script with layers and surfaces.
///
/// # Errors
/// Returns the errors of reading photos and stacks and of writing, or [`quadratura_base::Error::Cancelled`].
pub fn write(
    folder: &mut HandoverFolder,
    project: &Path,
    opened: &Opened,
    photos: &[&Photo],
    placement: &Placement,
    options: &HandoverOptions,
    task: &Task,
) -> Result<()> {
    // Stacks that change meanwhile stay readable as they were.
    let _reader = StackReader::begin(project);
    let HandedStacks { chosen, folders, .. } = handed_stacks(folder, project, opened, photos, options, task)?;
    let mut written = Vec::new();
    for photo in photos {
        let Some(id) = opened.site.photo_named(&photo.name) else { continue };
        let Some(stack) = &chosen[id.index()] else { continue };
        let file = match is_resampled(project, photo) {
            true => copied(folder, "photos", photo)?,
            false => linked(folder, photo)?,
        };
        let mut layers = Vec::new();
        // Farthest first.
        for index in stack.layer_indices().rev() {
            task.check_cancelled()?;
            if !stack.is_of_surroundings(stack.layer(index)) {
                layers.push(layer(folder, stack, index, &folders[id.index()], placement)?);
            }
        }
        written.push(NukePhoto { camera: camera_of(photo, file, placement), layers });
    }
    folder.leave_out("the mixing of photos: the script projects one photo at a time, which the node `choose_photo` chooses");
    folder.leave_out("surroundings, relief, exposures and trees");
    folder.write("site.nk", script(&written, GENERATOR).as_bytes())
}

/// Writes the surfaces of a layer, and describes it.
fn layer(
    folder: &mut HandoverFolder,
    stack: &Stack,
    index: LayerIndex,
    layers: &str,
    placement: &Placement,
) -> Result<NukeLayer> {
    let layer = stack.layer(index);
    let parts = parts_of_layer(stack, index);
    let placed = |outline: &[[f64; 3]]| -> Vec<DVec3> {
        outline.iter().map(|&point| placement.point(DVec3::from_array(point))).collect()
    };
    let outlines: Vec<Vec<DVec3>> = parts.list.iter().map(|part| placed(part.own_outline())).collect();
    let geometry = format!("surfaces/{}.obj", layer.id);
    let obj = surfaces_obj(outlines.iter().map(Vec::as_slice), GENERATOR);
    folder.write(&geometry, obj.as_bytes())?;
    Ok(NukeLayer {
        token: layer.id.clone(),
        name: layer.name.clone(),
        order: layer.order,
        rect: layer.rect,
        file: format!("{layers}/{}", file_of(&layer.id)),
        geometry,
    })
}
