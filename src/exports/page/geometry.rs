//! The model as the page draws it: planar surfaces, which image layers texture each face, and grids in the planes of faces.
//!
//! All numbers are little-endian; positions are those of the world less the page's origin. `viewer/geometry.js` reads the parts.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use super::labels::ByteLabels;
use super::plane::differences;
use super::shelf::PageShelf;
use super::tiles::PlacedTiles;
use quadratura_base::geometry::Plane;
use quadratura_base::geometry::polygon::{PlaneFrame, fit_plane};
use quadratura_base::scene::{FaceId, Model, PhotoId};
use quadratura_page::chunk::Chunk;
use quadratura_projection::continuation::FaceColours;
use quadratura_projection::relief::FaceRelief;
use quadratura_projection::{Domain, LayerTextureId, Server, Sources};
use quadratura_sites::site_parts::SiteParts;

/// What a surface is; the numbers are those of `viewer/geometry.js`.
const OPAQUE: u8 = 0;
const SEE_THROUGH: u8 = 1;
const IMPOSTOR: u8 = 2;
const SKIRT: u8 = 3;

/// Flags of a server.
const BACK: u8 = 1;
const PINNED: u8 = 2;

/// The largest height of a relief, in steps; the steps are an eighth of a cell where that suffices.
const MOST_STEPS: f64 = 32_000.0;
const STEPS_PER_CELL: f64 = 8.0;

/// What the geometry is made of.
pub struct GeometryInputs<'a> {
    /// All that the site's pictures are made of.
    pub parts: &'a SiteParts,
    /// The published photos; servers name them by their places here.
    pub photos: &'a [PhotoId],
    /// The labels of each published photo.
    pub labels: &'a [ByteLabels],
    /// The tiles of layers beside their photos' visible pixels: halved ones, and those of layers that one sees through.
    pub tiles: [&'a [PlacedTiles]; 2],
    /// The point of the world that is zero on the page.
    pub origin: DVec3,
}

/// Returns the chunk with surfaces, servers and layers.
pub fn geometry(inputs: &GeometryInputs) -> Chunk {
    let mut chunk = Chunk::default();
    let (model, sources) = (&inputs.parts.skirts.model, &inputs.parts.skirts.sources);
    add_surfaces(&mut chunk, inputs, model, sources);
    add_impostors(&mut chunk, model, inputs.origin);
    add_servers(&mut chunk, inputs, sources);
    add_layers(&mut chunk, inputs, sources);
    chunk
}

/// Adds the vertices, and of each surface its face, kind, plane and triangles. They are in the model's order, so that of faces at one
/// depth the last is drawn last.
fn add_surfaces(chunk: &mut Chunk, inputs: &GeometryInputs, model: &Model, sources: &Sources) {
    let origin = inputs.origin;
    let vertices = model.vertices.iter().flat_map(|vertex| (*vertex - origin).as_vec3().to_array());
    chunk.add_numbers("vertices", vertices.map(f32::to_le_bytes));
    let see_through = sources.see_through_faces(model);
    let (mut faces, mut kinds, mut planes, mut counts, mut corners) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for face in model.face_ids().filter(|face| !sources.far.contains(*face) && !model.is_replaced(*face)) {
        let kind = match face {
            _ if inputs.parts.skirts.holds(face) => SKIRT,
            _ if model.stands_for_impostor(face) => IMPOSTOR,
            _ if see_through.contains(&face) => SEE_THROUGH,
            _ => OPAQUE,
        };
        for (plane, triangles) in planar_parts(model, face) {
            faces.push(face.0);
            kinds.push(kind);
            planes.extend([
                plane.normal.x,
                plane.normal.y,
                plane.normal.z,
                plane.normal.dot(plane.point - origin),
            ]);
            counts.push(if kind == IMPOSTOR { 0 } else { triangles.len() as u32 });
            corners.extend(triangles.iter().filter(|_| kind != IMPOSTOR).flatten().copied());
        }
    }
    chunk.add_numbers("surface_faces", faces.into_iter().map(u32::to_le_bytes));
    chunk.add_packed("surface_kinds", &kinds);
    chunk.add_numbers("surface_planes", planes.into_iter().map(f64::to_le_bytes));
    chunk.add_numbers("surface_triangles", counts.into_iter().map(u32::to_le_bytes));
    chunk.add_numbers("corners", corners.into_iter().map(u32::to_le_bytes));
    let both_sides = model.face_ids().map(|face| u8::from(model.object(model.face(face).object).billboard));
    chunk.add_packed("face_billboards", &both_sides.collect::<Vec<_>>());
}

/// Returns the planes of a face with the triangles in them: one, or one a triangle where it is not planar.
fn planar_parts(model: &Model, face: FaceId) -> Vec<(Plane, Vec<[u32; 3]>)> {
    let triangles = model.face_triangles(face);
    if triangles.is_empty() && model.impostor(face).is_none() {
        return Vec::new();
    }
    if model.face(face).planar || model.impostor(face).is_some() {
        return vec![(model.face(face).plane, triangles.to_vec())];
    }
    let of_triangle = |corners: &[u32; 3]| {
        let plane = fit_plane(&corners.map(|vertex| model.vertices[vertex as usize]))?;
        Some((plane, vec![*corners]))
    };
    triangles.iter().filter_map(of_triangle).collect()
}

/// Adds the rectangles that turn towards cameras: face, foot, axis, height and half width.
fn add_impostors(chunk: &mut Chunk, model: &Model, origin: DVec3) {
    let (mut faces, mut numbers) = (Vec::new(), Vec::new());
    for face in model.face_ids().filter(|face| model.stands_for_impostor(*face)) {
        let Some(impostor) = model.impostor(face) else { continue };
        faces.push(face.0);
        numbers.extend((impostor.foot - origin).to_array());
        numbers.extend(impostor.axis.to_array());
        numbers.extend([impostor.height, impostor.half_width]);
    }
    chunk.add_numbers("impostor_faces", faces.into_iter().map(u32::to_le_bytes));
    chunk.add_numbers("impostors", numbers.into_iter().map(f64::to_le_bytes));
}

/// Adds the servers, by face; last those of the surroundings. Servers of photos that are not published are left out, and so is the
/// dome, which the page has as a picture of its own.
fn add_servers(chunk: &mut Chunk, inputs: &GeometryInputs, sources: &Sources) {
    let (mut counts, mut photos, mut layers, mut flags, mut sides) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut half_planes = Vec::new();
    let mut add = |servers: &[Server]| {
        let before = photos.len();
        for server in servers {
            let Some(place) = inputs.photos.iter().position(|photo| *photo == server.photo) else { continue };
            photos.push(place as u16);
            layers.push(server.layer_texture.0);
            flags.push(if server.back { BACK } else { 0 } | if server.pinned { PINNED } else { 0 });
            let of_domain = match &server.domain {
                Domain::Whole => &[],
                Domain::Inside(sides) => &sides[..],
            };
            sides.push(of_domain.len().min(usize::from(u8::MAX)) as u8);
            let numbers = of_domain.iter().take(usize::from(u8::MAX));
            half_planes.extend(
                numbers.flat_map(|side| [side.normal.x, side.normal.y, side.offset].map(|v| v as f32)),
            );
        }
        counts.push((photos.len() - before) as u32);
    };
    (0..sources.of_face.len() as u32).for_each(|face| add(sources.servers_of(FaceId(face))));
    add(sources.servers_of_surroundings());
    chunk.add_numbers("server_counts", counts.into_iter().map(u32::to_le_bytes));
    chunk.add_numbers("server_photos", photos.into_iter().map(u16::to_le_bytes));
    chunk.add_numbers("server_layers", layers.into_iter().map(u32::to_le_bytes));
    chunk.add_packed("server_flags", &flags);
    chunk.add_packed("server_sides", &sides);
    chunk.add_numbers("half_planes", half_planes.into_iter().map(f32::to_le_bytes));
}

/// Adds what is to be known of layers: their labels as a set of 256 bits, and where their tiles are. A skirt's layer has the labels of
/// the surroundings of which it is made.
fn add_layers(chunk: &mut Chunk, inputs: &GeometryInputs, sources: &Sources) {
    let mut of_layer: BTreeMap<LayerTextureId, &[u8]> = BTreeMap::new();
    for labels in inputs.labels {
        of_layer.extend(labels.of_layer.iter().map(|(layer, numbers)| (*layer, &numbers[..])));
    }
    let made_of: BTreeMap<LayerTextureId, LayerTextureId> = inputs.parts.skirts.made_of().collect();
    let mut sets = Vec::new();
    for layer in (0..sources.layer_textures.len() as u32).map(LayerTextureId) {
        let own = made_of.get(&layer).unwrap_or(&layer);
        let mut words = [0u32; 8];
        of_layer.get(own).into_iter().flat_map(|numbers| numbers.iter()).for_each(|number| {
            words[usize::from(*number) / 32] |= 1 << (number % 32);
        });
        sets.extend(words);
    }
    chunk.add_numbers("layer_labels", sets.into_iter().map(u32::to_le_bytes));
    for (name, tiles) in ["hidden", "cut"].into_iter().zip(inputs.tiles) {
        let mut places = Vec::new();
        let mut slots = Vec::new();
        for placed in tiles {
            let [x, y] = placed.corner.map(|at| at as u32);
            let [columns, rows] = placed.tiles.map(|count| count as u32);
            places.extend([placed.layer.0, placed.pixels, x, y, columns, rows]);
            slots.extend(&placed.slots);
        }
        chunk.add_numbers(format!("{name}_tiles"), places.into_iter().map(u32::to_le_bytes));
        chunk.add_numbers(format!("{name}_slots"), slots.into_iter().map(u32::to_le_bytes));
    }
}

/// A grid in the plane of a face.
struct TexelGrid<'a> {
    face: u32,
    frame: &'a PlaneFrame,
    low: DVec2,
    cell: f64,
    size: [u32; 2],
}

impl TexelGrid<'_> {
    /// Returns the mapping from positions to cells: across, its offset, up, its offset.
    fn cells_from_position(&self, origin: DVec3) -> [f64; 8] {
        let row = |direction: DVec3, low: f64| {
            let across = direction / self.cell;
            let offset = (direction.dot(origin - self.frame.origin) - low) / self.cell;
            [across.x, across.y, across.z, offset]
        };
        let (a, b) = (row(self.frame.u, self.low.x), row(self.frame.v, self.low.y));
        std::array::from_fn(|at| if at < 4 { a[at] } else { b[at - 4] })
    }
}

/// Adds the grids of a kind: faces, mappings, sizes and corners in the sheet that they are packed into. Returns the corners, and the
/// sheet's size.
fn add_grids(chunk: &mut Chunk, name: &str, grids: &[TexelGrid], origin: DVec3) -> (Vec<[u32; 2]>, [u32; 2]) {
    let shelf = PageShelf::new(grids.iter().map(|grid| grid.size));
    let faces = grids.iter().map(|grid| grid.face.to_le_bytes());
    chunk.add_numbers(format!("{name}_faces"), faces);
    let mappings = grids.iter().flat_map(|grid| grid.cells_from_position(origin));
    chunk.add_numbers(format!("{name}_mappings"), mappings.map(f64::to_le_bytes));
    let places =
        grids.iter().zip(&shelf.corners).flat_map(|(grid, [x, y])| [*x, *y, grid.size[0], grid.size[1]]);
    chunk.add_numbers(format!("{name}_places"), places.map(|value| (value as u16).to_le_bytes()));
    chunk.add_numbers(format!("{name}_size"), shelf.size.map(u32::to_le_bytes));
    (shelf.corners, shelf.size)
}

/// Returns the chunk of the relief and of the colours with which surfaces continue.
pub fn grids(parts: &SiteParts, origin: DVec3) -> Chunk {
    let mut chunk = Chunk::default();
    let faces = || parts.skirts.model.face_ids().filter(|face| !parts.skirts.holds(*face));
    let relief: Vec<(FaceId, &FaceRelief)> = faces()
        .filter_map(|face| Some((face, parts.relief.of(face)?)))
        .filter(|(_, of)| of.largest() > 0.0)
        .collect();
    let grids: Vec<TexelGrid> = relief
        .iter()
        .map(|(face, of)| TexelGrid {
            face: face.0,
            frame: &of.frame,
            low: of.low,
            cell: of.cell,
            size: of.size,
        })
        .collect();
    let (corners, size) = add_grids(&mut chunk, "relief", &grids, origin);
    let mut cells = vec![0i16; size[0] as usize * size[1] as usize];
    let mut steps = Vec::with_capacity(relief.len());
    for ((_, of), corner) in relief.iter().zip(corners) {
        let step = (of.cell / STEPS_PER_CELL).max(of.largest() / MOST_STEPS);
        steps.push(step as f32);
        let values = of.heights.iter().map(|height| (f64::from(*height) / step).round() as i16);
        copy(&mut cells, size[0], values, corner, of.size[0]);
    }
    chunk.add_numbers("relief_steps", steps.into_iter().map(f32::to_le_bytes));
    let left = std::iter::once(0).chain(cells.iter().copied());
    chunk.add_numbers(
        "relief_heights",
        cells.iter().zip(left).map(|(value, left)| value.wrapping_sub(left).to_le_bytes()),
    );
    add_continuation(&mut chunk, parts, origin);
    chunk
}

fn add_continuation(chunk: &mut Chunk, parts: &SiteParts, origin: DVec3) {
    let faces = parts.skirts.model.face_ids().filter(|face| !parts.skirts.holds(*face));
    let continued: Vec<(FaceId, &FaceColours)> =
        faces.filter_map(|face| Some((face, parts.continuation.of(face)?))).collect();
    let grids: Vec<TexelGrid> = continued
        .iter()
        .map(|(face, of)| TexelGrid {
            face: face.0,
            frame: &of.frame,
            low: of.low,
            cell: of.cell,
            size: of.size,
        })
        .collect();
    let (corners, size) = add_grids(chunk, "continued", &grids, origin);
    let mut cells = vec![[0u8; 3]; size[0] as usize * size[1] as usize];
    for ((_, of), corner) in continued.iter().zip(corners) {
        copy(&mut cells, size[0], of.colours.iter().copied(), corner, of.size[0]);
    }
    chunk.add_packed("continued_colours", &differences(cells.as_flattened(), 3));
}

/// Copies the values of a grid, by rows of `columns`, into a sheet.
fn copy<T>(cells: &mut [T], width: u32, values: impl Iterator<Item = T>, corner: [u32; 2], columns: u32) {
    for (at, value) in values.enumerate() {
        let [x, y] = [at as u32 % columns + corner[0], at as u32 / columns + corner[1]];
        cells[y as usize * width as usize + x as usize] = value;
    }
}
