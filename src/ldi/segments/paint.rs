//! The texels of parts are taken from the depth pixels, and carried past rims.

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::TILE;
use super::atlas::{Atlas, BLOCK, BORDER, packed};
use super::cells::SegmentPatch;
use super::mesh::{MeshPart, SegmentMesh, TexturedPart};
use crate::layout::ResolutionLevel;
use quadratura_base::error::Result;
use quadratura_base::task::Task;

/// A rectangle of texels.
struct TexelRect {
    size: [usize; 2],
    rgba: Vec<[u8; 4]>,
    /// Which ones have a colour.
    held: Vec<bool>,
}

/// Gives the parts of meshes their texels; returns them with the atlases.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`].
pub(super) fn painted(
    level: &ResolutionLevel,
    patches: &[SegmentPatch],
    meshes: Vec<SegmentMesh>,
    task: &Task,
) -> Result<(Vec<TexturedPart>, Vec<Atlas>)> {
    let parts: Vec<MeshPart> = meshes.into_iter().flat_map(|mesh| mesh.parts).collect();
    let kind = |part: &MeshPart| (is_first(level, patches, part), is_opaque(level, patches, part));
    let kinds: Vec<(bool, bool)> = parts.par_iter().map(kind).collect();
    let sizes: Vec<[u32; 2]> = parts.iter().map(size_of).collect();
    let mut places = vec![(0, [0; 2]); parts.len()];
    let mut atlases = Vec::new();
    for kind in [(true, true), (true, false), (false, true), (false, false)] {
        let members: Vec<usize> = (0..parts.len()).filter(|&i| kinds[i] == kind).collect();
        let packed = packed(&members.iter().map(|&i| sizes[i]).collect::<Vec<_>>());
        for (&i, (picture, at)) in members.iter().zip(packed.places) {
            places[i] = (atlases.len() + picture, at);
        }
        atlases.extend(packed.sizes.into_iter().map(|size| Atlas::new(kind.0, kind.1, size)));
    }
    let whose: FxHashMap<(u32, [u32; 2]), usize> =
        patches.iter().map(|patch| (patch.segment, patch.tile)).zip(0..).collect();
    // As many at once as there are threads, and not all: they are as large as the atlases.
    for (chunk, start) in parts.chunks(256).zip((0..).step_by(256)) {
        task.step("atlas", start as u64, parts.len() as u64)?;
        let texels: Vec<TexelRect> = chunk
            .par_iter()
            .zip(&sizes[start..])
            .map(|(part, size)| texels_of(level, patches, &whose, part, *size))
            .collect();
        for (texels, &(atlas, at)) in texels.iter().zip(&places[start..]) {
            texels.copy_to(&mut atlases[atlas], at);
        }
    }
    let textured = |((part, size), (atlas, at)): ((MeshPart, [u32; 2]), (usize, [u32; 2]))| TexturedPart {
        segment: part.segment,
        atlas,
        origin: origin_of(&part),
        at,
        size,
        vertices: part.vertices,
        triangles: part.triangles,
    };
    Ok((parts.into_iter().zip(sizes).zip(places).map(textured).collect(), atlases))
}

/// Returns whether most depth pixels of a part are the nearest ones of their rays.
fn is_first(level: &ResolutionLevel, patches: &[SegmentPatch], part: &MeshPart) -> bool {
    let (mut first, mut all) = (0, 0);
    for patch in part.patches.iter().map(|&place| &patches[place]) {
        for pixel in &patch.pixels {
            let index = pixel.index as usize;
            let starts_row = level.rows[(patch.tile[1] * TILE + u32::from(pixel.y)) as usize] == pixel.index;
            first += usize::from(starts_row || level.columns[index - 1] != level.columns[index]);
            all += 1;
        }
    }
    2 * first > all
}

/// Returns whether a part covers all of its rectangle with opaque depth pixels.
fn is_opaque(level: &ResolutionLevel, patches: &[SegmentPatch], part: &MeshPart) -> bool {
    let [left, top, right, bottom] = part.bounds;
    let pixels = || part.patches.iter().flat_map(|&place| &patches[place].pixels);
    pixels().count() == ((right - left) * (bottom - top)) as usize
        && pixels().all(|pixel| level.colours[pixel.index as usize][3] == 255)
}

fn origin_of(part: &MeshPart) -> [i32; 2] {
    [part.bounds[0] - BORDER as i32, part.bounds[1] - BORDER as i32]
}

fn size_of(part: &MeshPart) -> [u32; 2] {
    let [left, top, right, bottom] = part.bounds;
    [right - left, bottom - top].map(|side| (side as u32 + 2 * BORDER).next_multiple_of(BLOCK))
}

/// Takes the texels of a part, with those of the segment around it.
fn texels_of(
    level: &ResolutionLevel,
    patches: &[SegmentPatch],
    whose: &FxHashMap<(u32, [u32; 2]), usize>,
    part: &MeshPart,
    size: [u32; 2],
) -> TexelRect {
    let origin = origin_of(part);
    let size = size.map(|side| side as usize);
    let mut texels =
        TexelRect { size, rgba: vec![[0; 4]; size[0] * size[1]], held: vec![false; size[0] * size[1]] };
    let tiles = |axis: usize| {
        let last = origin[axis] + size[axis] as i32 - 1;
        (origin[axis].max(0) as u32 / TILE)..=(last.max(0) as u32 / TILE)
    };
    for tile in tiles(1).flat_map(|y| tiles(0).map(move |x| [x, y])) {
        let Some(&place) = whose.get(&(part.segment, tile)) else { continue };
        for pixel in &patches[place].pixels {
            let within = |axis: usize, at: u8| (tile[axis] * TILE) as i32 + i32::from(at) - origin[axis];
            let (x, y) = (within(0, pixel.x), within(1, pixel.y));
            if (0..size[0] as i32).contains(&x) && (0..size[1] as i32).contains(&y) {
                let at = y as usize * size[0] + x as usize;
                texels.rgba[at] = level.colours[pixel.index as usize];
                texels.held[at] = true;
            }
        }
    }
    (0..BORDER).for_each(|_| texels.carry());
    texels.fill_blocks();
    texels
}

impl TexelRect {
    /// Gives each texel beside ones with a colour their mean, and no opacity.
    fn carry(&mut self) {
        let [width, height] = self.size;
        let mut carried = Vec::new();
        for (at, _) in self.held.iter().enumerate().filter(|(_, held)| !**held) {
            let (x, y) = (at % width, at / width);
            let (mut sum, mut count) = ([0u32; 3], 0);
            for y in y.saturating_sub(1)..height.min(y + 2) {
                for x in x.saturating_sub(1)..width.min(x + 2) {
                    let beside = y * width + x;
                    if self.held[beside] {
                        (0..3).for_each(|c| sum[c] += u32::from(self.rgba[beside][c]));
                        count += 1;
                    }
                }
            }
            if count > 0 {
                let [r, g, b] = sum.map(|sum| ((sum + count / 2) / count) as u8);
                carried.push((at, [r, g, b, 0]));
            }
        }
        for (at, colour) in carried {
            self.rgba[at] = colour;
            self.held[at] = true;
        }
    }

    /// Gives what is left in a block of a JPEG the mean of the block, and to empty blocks that of the one before, so that they
    /// cost few bytes.
    fn fill_blocks(&mut self) {
        let [width, height] = self.size;
        let side = BLOCK as usize;
        let mut last = [128u8; 3];
        for (top, left) in
            (0..height).step_by(side).flat_map(|y| (0..width).step_by(side).map(move |x| (y, x)))
        {
            let places = (top..top + side).flat_map(|y| (left..left + side).map(move |x| y * width + x));
            let (mut sum, mut count) = ([0u32; 3], 0);
            for at in places.clone().filter(|&at| self.held[at]) {
                (0..3).for_each(|c| sum[c] += u32::from(self.rgba[at][c]));
                count += 1;
            }
            if count > 0 {
                last = sum.map(|sum| (sum / count) as u8);
            }
            let [r, g, b] = last;
            places.filter(|&at| !self.held[at]).for_each(|at| self.rgba[at] = [r, g, b, 0]);
        }
    }

    fn copy_to(&self, atlas: &mut Atlas, at: [u32; 2]) {
        let width = atlas.width as usize;
        for (row, texels) in self.rgba.chunks_exact(self.size[0]).enumerate() {
            let start = (at[1] as usize + row) * width + at[0] as usize;
            let rgb = &mut atlas.rgb[3 * start..3 * (start + texels.len())];
            rgb.as_chunks_mut::<3>()
                .0
                .iter_mut()
                .zip(texels)
                .for_each(|(out, [r, g, b, _])| *out = [*r, *g, *b]);
            let opacity = &mut atlas.opacity[start..start + texels.len()];
            opacity.iter_mut().zip(texels).for_each(|(out, [.., a])| *out = *a);
        }
    }
}
