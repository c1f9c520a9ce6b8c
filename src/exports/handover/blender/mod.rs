//! `--format blender`: a script, a description of the site, and the pictures that both refer to.
//!
//! ```text
//! scene.py                     builds the scene: blender -P scene.py
//! scene.json                   cameras, model, image layers
//! layers/PHOTO.layers/         the image layers, to be painted on: the folder format, named by token
//! confidence/TOKEN.png         the weight of each texel, and how far it is known
//! surroundings.png             what is around in directions that no photo shows
//! photos/                      the undistorted pictures of photos that had to be resampled
//! ```

mod billboards;
pub mod blend;
mod confidence;
mod dome;
pub(super) mod layers;
mod meshes;
mod surfaces;
mod weighing;

use std::path::Path;

use rayon::prelude::*;

use self::confidence::{LayerConfidence, confidence_of};
use self::layers::{HandedStacks, handed_stacks};
use self::surfaces::Surfaces;
use super::HandoverOptions;
use super::folder::HandoverFolder;
use super::origin::Placement;
use super::photos::{camera_of, copied, is_resampled, linked};
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::{Photo, PhotoId, up};
use quadratura_base::task::Task;
use quadratura_document::Stack;
use quadratura_files::json::to_json;
use quadratura_handover::blender::SCRIPT;
use quadratura_handover::blender::scene::{
    SCENE_VERSION, Scene, SceneLayer, ScenePhoto, SceneSurroundings, uv_from_world,
};
use quadratura_io::layer_png::rgb_png;
use quadratura_io::stack_readers::StackReader;
use quadratura_projection::{LayerTextureId, Texels};
use quadratura_sites::open::Opened;
use quadratura_stacks::far_backdrops::FarBackdrops;
use quadratura_stacks::layer_textures::LayerTextureFiles;
use quadratura_stacks::sources::sources;
use quadratura_views::preview::{PhotoEstimates, photo_estimates};

/// The folder of photos that had to be resampled.
const PHOTOS: &str = "photos";

/// The name of the script.
pub const SCRIPT_FILE: &str = "scene.py";

/// Writes the site for Blender.
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
    let site = &opened.site;
    let HandedStacks { store, all, chosen, folders } =
        handed_stacks(folder, project, opened, photos, options, task)?;
    let ids: Vec<PhotoId> = photos.iter().filter_map(|photo| site.photo_named(&photo.name)).collect();
    let sources = sources(site, &chosen, &opened.project.decisions);
    let far = FarBackdrops::new(site);
    let files = LayerTextureFiles::new(&store, &chosen, true)
        .with_far(&chosen, far.clone().into())
        .with_paint(&store, &chosen)?;
    let PhotoEstimates { gains, dome, agreement } =
        photo_estimates(project, &opened.project, site, &all, (&sources, &files), task)?;
    let mut scene_photos = Vec::new();
    for (photo, id) in photos.iter().zip(&ids) {
        let file = match is_resampled(project, photo) {
            true => copied(folder, PHOTOS, photo)?,
            false => linked(folder, photo)?,
        };
        let gain = gains.of_photo[id.index()].map(|gain| (-gain).exp());
        scene_photos.push(ScenePhoto::new(&camera_of(photo, file, placement), gain));
    }
    let layers = described(&ids, &chosen, &folders, opened, placement);
    let rects: Vec<PixelRect> =
        chosen.iter().flatten().flat_map(|stack| &stack.image_layers).map(|layer| layer.rect).collect();
    let weighed = |number: usize| {
        let id = LayerTextureId(number as u32);
        let camera = &sources.photo(sources.layer_texture(id).photo).camera;
        Ok(confidence_of(&files.layer_texture(id)?, rects[number], camera, |px| agreement.at(id, px)))
    };
    let confidences = write_confidences(folder, &layers, &rects, &weighed, task)?;
    let surfaces = Surfaces::new(site, &sources, &confidences, &rects, &ids, options.photos_per_face);
    let (objects, materials, degenerate) = meshes::objects(&surfaces, &far, placement);
    if degenerate > 0 {
        folder.leave_out(format!("{degenerate} faces without area"));
    }
    let surroundings = sources.servers_of_surroundings().iter().map(|server| SceneSurroundings {
        layer: server.layer_texture.0 as usize,
        parts: surfaces::parts_of(&server.domain, rects[server.layer_texture.0 as usize]),
    });
    let up = up(&site.photos);
    let dome = dome.as_deref().map(|dome| dome::write_dome(folder, dome, up, placement)).transpose()?;
    let scene = Scene {
        version: SCENE_VERSION,
        origin: placement.origin.to_array(),
        up: placement.direction(up).to_array(),
        photos: scene_photos,
        objects,
        materials,
        billboards: billboards::billboards(&surfaces, &layers, placement),
        surroundings: surroundings.collect(),
        surroundings_scale: placement.length(sources.surroundings_scale),
        dome,
        layers,
    };
    leave_out_what_blender_lacks(folder, opened);
    folder.write("scene.json", &to_json(&scene))?;
    folder.write(SCRIPT_FILE, SCRIPT.as_bytes())
}

/// Writes the pictures of confidence of all layers, of which `weighed` computes one by its number. Few are computed at a time, so that few
/// are in memory.
fn write_confidences(
    folder: &mut HandoverFolder,
    layers: &[SceneLayer],
    rects: &[PixelRect],
    weighed: &(dyn Fn(usize) -> Result<(Vec<u8>, LayerConfidence)> + Sync),
    task: &Task,
) -> Result<Vec<LayerConfidence>> {
    let mut confidences = Vec::with_capacity(layers.len());
    let numbers: Vec<usize> = (0..layers.len()).collect();
    for some in numbers.chunks(rayon::current_num_threads().max(1)) {
        task.step("write confidences", confidences.len() as u64, layers.len() as u64)?;
        let picture = |&number: &usize| {
            let (rgb, reduced) = weighed(number)?;
            let PixelRect { w, h, .. } = rects[number];
            Ok((rgb_png([w, h], &rgb), reduced))
        };
        let pictures: Vec<Result<(Vec<u8>, LayerConfidence)>> = some.par_iter().map(picture).collect();
        for (number, picture) in some.iter().zip(pictures) {
            let (png, reduced) = picture?;
            folder.write(&layers[*number].confidence, &png)?;
            confidences.push(reduced);
        }
    }
    Ok(confidences)
}

/// Describes the image layers of all stacks, in the order of layer textures.
fn described(
    ids: &[PhotoId],
    stacks: &[Option<Stack>],
    folders: &[String],
    opened: &Opened,
    placement: &Placement,
) -> Vec<SceneLayer> {
    let mut layers = Vec::new();
    for (id, stack) in PhotoId::all(stacks.len()).zip(stacks) {
        let Some(stack) = stack else { continue };
        let photo = opened.site.photo(id);
        let pose = placement.pose(&photo.pose);
        let place = ids.iter().position(|other| *other == id).expect("only chosen photos have stacks here");
        layers.extend(stack.image_layers.iter().map(|layer| SceneLayer {
            token: layer.id.clone(),
            name: layer.name.clone(),
            photo: place,
            file: format!("{}/{}", folders[id.index()], layers::file_of(&layer.id)),
            matte: layer.fill.as_ref().is_some_and(|fill| fill.matte_file.is_some()),
            confidence: format!("confidence/{}", layers::file_of(&layer.id)),
            uv_from_world: uv_from_world(&photo.camera, &pose, layer.rect),
        }));
    }
    layers
}

/// Notes what views of the program show and this scene does not.
fn leave_out_what_blender_lacks(folder: &mut HandoverFolder, opened: &Opened) {
    folder.leave_out("relief and the correction of lenses' dark corners: views in Blender lack them");
    if !opened.project.trees.is_empty() {
        folder.leave_out("trees: Blender has no images of them; render them with the program");
    }
}
