//! Billboards that turn towards the camera ([`quadratura_base::scene::impostor`]).

use super::surfaces::Surfaces;
use crate::handover::origin::Placement;
use quadratura_base::scene::impostor::{Facing, Impostor};
use quadratura_handover::blender::scene::{BillboardUse, SceneBillboard, SceneLayer, uv_from_place};
use quadratura_projection::Server;

/// Returns the billboards with their layers; `layers` are all image layers, in the order of layer textures.
pub fn billboards(surfaces: &Surfaces, layers: &[SceneLayer], placement: &Placement) -> Vec<SceneBillboard> {
    let model = &surfaces.site.model;
    let mut billboards = Vec::new();
    for object in &model.objects {
        let (Some(impostor), Some(&face)) = (&object.impostor, object.faces.first()) else { continue };
        let photos = surfaces.photos_of(face);
        let servers = photos.iter().flat_map(|photo| photo.servers.iter());
        billboards.push(SceneBillboard {
            name: object.name.clone(),
            foot: placement.point(impostor.foot).to_array(),
            axis: placement.direction(impostor.axis).to_array(),
            size: [impostor.half_width, impostor.height].map(|side| placement.length(side)),
            uses: servers.map(|server| use_of(surfaces, impostor, server, layers, placement)).collect(),
        });
    }
    billboards
}

fn use_of(
    surfaces: &Surfaces,
    impostor: &Impostor,
    server: &Server,
    layers: &[SceneLayer],
    placement: &Placement,
) -> BillboardUse {
    let photo = Facing::of_pose(&surfaces.sources.photo(server.photo).pose);
    let across = impostor.across(&photo);
    // What the mirror image shows at a distance from the axis is in the photo at the same one to the other side.
    let (across, eye) = match server.back {
        true => (-across, impostor.mirrored(&photo).eye),
        false => (across, photo.eye),
    };
    let layer = server.layer_texture.0 as usize;
    let rows = layers[layer].uv_from_world;
    BillboardUse {
        layer,
        uv_from_place: uv_from_place(
            rows,
            placement.point(impostor.foot),
            placement.direction(impostor.axis),
            placement.direction(across),
        ),
        seen_from: placement.point(eye).to_array(),
        mirrored: server.back,
    }
}
