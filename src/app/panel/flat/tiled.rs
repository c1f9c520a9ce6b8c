//! Pictures of any size as textures: in tiles, at the resolution in use, made when they become visible.

use std::collections::BTreeMap;
use std::sync::{Arc, Weak};

use eframe::egui::{
    Color32, ColorImage, Context, Painter, Rect, TextureFilter, TextureHandle, TextureOptions, pos2,
};
use glam::DVec2;

use super::placement::PlacedPicture;
use crate::state::flat::levels::{Levels, TILE_SIDE as SIDE};
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::light::bytes_of_light_times;
use quadratura_view::Picture;

/// The most tiles made in a frame; the others show a smaller picture until their turn.
const MOST_A_FRAME: usize = 4;
/// The number of tiles beyond which invisible ones are dropped: 200 megabytes.
const MOST_KEPT: usize = 200;
/// Pixels have hard edges when they are magnified, and are averaged when they are reduced.
const FILTER: TextureOptions = TextureOptions {
    magnification: TextureFilter::Nearest,
    minification: TextureFilter::Linear,
    ..TextureOptions::LINEAR
};

/// The light factors that change nothing.
pub const AS_IT_IS: [f64; 3] = [1.0; 3];

/// The pictures that were drawn, with their tiles.
#[derive(Default)]
pub struct TiledPictures {
    made: Vec<Tiled>,
}

impl TiledPictures {
    /// Returns the tiles of a picture; they are made as they become visible.
    pub fn of(&mut self, levels: &Levels) -> &mut Tiled {
        let known = self.made.iter().position(|tiled| tiled.is_of(levels));
        let place = known.unwrap_or_else(|| {
            self.made.push(Tiled::new(levels));
            self.made.len() - 1
        });
        &mut self.made[place]
    }

    /// Drops the tiles of pictures that the state does not keep any more.
    pub fn drop_gone(&mut self) {
        self.made.retain(|tiled| tiled.levels.strong_count() > 0);
    }
}

/// A picture drawn in tiles.
pub struct Tiled {
    /// The picture that the tiles are of.
    levels: Weak<Vec<Picture>>,
    tiles: BTreeMap<TileIndex, TextureHandle>,
    /// The factors of its linear light, R, G, B.
    light: [f64; 3],
}

/// The level, column and row of a tile.
type TileIndex = (usize, u32, u32);

impl Tiled {
    /// Makes a picture with no tile on the device yet.
    fn new(levels: &Levels) -> Self {
        Self { levels: Arc::downgrade(levels), tiles: BTreeMap::new(), light: AS_IT_IS }
    }

    fn is_of(&self, levels: &Levels) -> bool {
        std::ptr::eq(self.levels.as_ptr(), Arc::as_ptr(levels))
    }

    /// Sets the factors of its linear light, R, G, B.
    pub fn set_light(&mut self, factors: [f64; 3]) {
        if self.light != factors {
            self.light = factors;
            self.tiles.clear();
        }
    }

    /// Draws the picture; `corner` is its top left corner in the pixel coordinates of `seen`.
    pub fn draw(&mut self, painter: &Painter, seen: &PlacedPicture, corner: (i32, i32)) {
        let Some(levels) = self.levels.upgrade() else { return };
        let bounds = PixelRect { x: corner.0, y: corner.1, w: levels[0].width, h: levels[0].height };
        let painter = painter.with_clip_rect(painter.clip_rect().intersect(seen.rect_of(bounds)));
        let level = level_at(seen.magnification(), levels.len());
        let places = places(level, seen.window(bounds), corner);
        let mut made = 0;
        for position in &places {
            if !self.tiles.contains_key(position) && made < MOST_A_FRAME {
                self.make(&levels, *position, painter.ctx());
                made += 1;
            }
            self.draw_tile(&levels, *position, &painter, seen, corner);
        }
        if places.iter().any(|position| !self.tiles.contains_key(position)) {
            painter.ctx().request_repaint();
        }
        if self.tiles.len() > MOST_KEPT {
            self.tiles.retain(|position, _| places.contains(position) || position.0 + 1 == levels.len());
        }
    }

    fn make(&mut self, levels: &Levels, position: TileIndex, context: &Context) {
        let (level, column, row) = position;
        let picture = &levels[level];
        let mut image = tile(picture, column, row);
        if self.light != AS_IT_IS {
            brighten(&mut image, self.light);
        }
        let name = format!("tile {column}, {row} of level {level}");
        self.tiles.insert(position, context.load_texture(name, image, FILTER));
    }

    /// Draws a tile, or the same part of the smallest level while the tile is not made.
    fn draw_tile(
        &mut self,
        levels: &Levels,
        position: TileIndex,
        painter: &Painter,
        seen: &PlacedPicture,
        corner: (i32, i32),
    ) {
        let (level, column, row) = position;
        let last = (levels.len() - 1, 0, 0);
        if !self.tiles.contains_key(&position) && !self.tiles.contains_key(&last) {
            self.make(levels, last, painter.ctx());
        }
        let (width, height) = tile_size(&levels[level], column, row);
        let scale = f64::from(1u32 << level);
        let at = |tile: u32, px: u32| (f64::from(tile) * f64::from(SIDE) + f64::from(px)) * scale;
        let low = DVec2::new(at(column, 0), at(row, 0));
        let high = DVec2::new(at(column, width), at(row, height));
        let origin = DVec2::new(f64::from(corner.0), f64::from(corner.1));
        let area = Rect::from_min_max(seen.at(origin + low), seen.at(origin + high));
        let (texture, from, to) = match self.tiles.get(&position) {
            Some(texture) => (texture, DVec2::ZERO, DVec2::new(f64::from(width), f64::from(height))),
            None => {
                let shrunk = f64::from(1u32 << last.0);
                let Some(texture) = self.tiles.get(&last) else { return };
                (texture, low / shrunk, high / shrunk)
            }
        };
        let size = texture.size_vec2();
        let uv =
            |position: DVec2| pos2((position.x as f32 + 1.0) / size.x, (position.y as f32 + 1.0) / size.y);
        painter.image(texture.id(), area, Rect::from_min_max(uv(from), uv(to)), Color32::WHITE);
    }
}

/// Returns the coarsest of `count` levels whose pixels are at most as large as the screen's.
fn level_at(magnification: f64, count: usize) -> usize {
    let level = (1.0 / magnification).log2().floor().max(0.0) as usize;
    level.min(count - 1)
}

/// Returns the tiles of a level that intersect the window.
fn places(level: usize, window: PixelRect, corner: (i32, i32)) -> Vec<TileIndex> {
    if window.is_empty() {
        return Vec::new();
    }
    let side = (SIDE << level) as i32;
    let range = |from: i32, to: i32| (from / side) as u32..=((to - 1) / side) as u32;
    let columns = range(window.x - corner.0, window.right() - corner.0);
    let rows = range(window.y - corner.1, window.bottom() - corner.1);
    rows.flat_map(|row| columns.clone().map(move |column| (level, column, row))).collect()
}

/// Returns the pixels of a tile with a border of one pixel from its neighbours; without it, filtering would show seams.
fn tile(picture: &Picture, column: u32, row: u32) -> ColorImage {
    let (width, height) = tile_size(picture, column, row);
    let from_to = |tile: u32, side: u32, size: u32| {
        let first = tile * SIDE;
        (first.saturating_sub(1) as usize, (first + side).min(size - 1) as usize)
    };
    let (left, right) = from_to(column, width, picture.width);
    let (top, bottom) = from_to(row, height, picture.height);
    let first = [column, row].map(|tile| (tile * SIDE) as usize);
    let all = picture.rgba.as_chunks::<4>().0;
    let mut pixels = Vec::with_capacity((width as usize + 2) * (height as usize + 2));
    for y in [top].into_iter().chain(first[1]..first[1] + height as usize).chain([bottom]) {
        let line = &all[y * picture.width as usize..][..picture.width as usize];
        pixels.push(colour(line[left]));
        pixels.extend(line[first[0]..][..width as usize].iter().map(|rgba| colour(*rgba)));
        pixels.push(colour(line[right]));
    }
    ColorImage::new([width as usize + 2, height as usize + 2], pixels)
}

fn colour([r, g, b, a]: [u8; 4]) -> Color32 {
    Color32::from_rgba_unmultiplied(r, g, b, a)
}

/// Multiplies linear light by factors, R, G, B.
fn brighten(image: &mut ColorImage, factors: [f64; 3]) {
    let brought = factors.map(bytes_of_light_times);
    for pixel in &mut image.pixels {
        let [r, g, b, a] = pixel.to_srgba_unmultiplied();
        let [r, g, b] = [(0, r), (1, g), (2, b)].map(|(channel, byte)| brought[channel][usize::from(byte)]);
        *pixel = Color32::from_rgba_unmultiplied(r, g, b, a);
    }
}

/// Returns the columns and rows of a tile without its border.
fn tile_size(picture: &Picture, column: u32, row: u32) -> (u32, u32) {
    ((picture.width - column * SIDE).min(SIDE), (picture.height - row * SIDE).min(SIDE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::panel::flat::placement::{on_screen, screen_rect};
    use crate::state::flat::levels::levels_of;
    use crate::state::flat::placement::Placement;

    fn levels(width: u32, height: u32) -> Levels {
        levels_of(Picture { width, height, rgba: vec![255; 4 * width as usize * height as usize] })
    }

    #[test]
    fn a_tile_in_twice_the_light_is_brighter_and_as_transparent() {
        let mut image = ColorImage::new([2, 1], vec![colour([100, 100, 200, 255]), Color32::TRANSPARENT]);
        brighten(&mut image, [2.0, 1.0, 2.0]);
        assert_eq!(image.pixels, [colour([138, 100, 255, 255]), Color32::TRANSPARENT]);
    }

    #[test]
    fn the_level_is_the_coarsest_that_loses_nothing_on_the_screen() {
        assert_eq!(levels(3000, 2000).len(), 4, "3000, 1500, 750, 375");
        assert_eq!([8.0, 1.0, 0.51, 0.5, 0.26, 0.01].map(|m| level_at(m, 4)), [0, 0, 0, 1, 1, 3]);
    }

    #[test]
    fn tiles_cover_the_window_and_nothing_else() {
        let window = PixelRect { x: 500, y: 1030, w: 30, h: 10 };
        assert_eq!(places(0, window, (0, 0)), [(0, 0, 2), (0, 1, 2)]);
        assert_eq!(places(0, window, (500, 1030)), [(0, 0, 0)]);
        assert_eq!(places(2, PixelRect { x: 0, y: 0, w: 3000, h: 2000 }, (0, 0)), [(2, 0, 0), (2, 1, 0)]);
        assert_eq!(tile_size(&levels(3000, 2000)[2], 1, 0), (238, 500));
    }

    #[test]
    fn a_tile_has_a_pixel_of_its_neighbours_all_around_and_its_own_at_the_pictures_border() {
        let rgba =
            (0..1030u32 * 520).flat_map(|at| [(at % 1030 % 251) as u8, (at / 1030 % 241) as u8, 7, 255]);
        let picture = Picture { width: 1030, height: 520, rgba: rgba.collect() };
        for (column, row) in [(0, 0), (1, 0), (2, 0), (1, 1), (2, 1)] {
            let image = tile(&picture, column, row);
            let (width, height) = tile_size(&picture, column, row);
            assert_eq!(image.size, [width as usize + 2, height as usize + 2]);
            for (x, y) in (0..height + 2).flat_map(|y| (0..width + 2).map(move |x| (x, y))) {
                let inside =
                    |tile: u32, at: u32, size: u32| (tile * SIDE + at).saturating_sub(1).min(size - 1);
                let (px, py) = (inside(column, x, 1030), inside(row, y, 520));
                let expected = Color32::from_rgb((px % 251) as u8, (py % 241) as u8, 7);
                assert_eq!(image[(x as usize, y as usize)], expected, "{x}, {y} of {column}, {row}");
            }
        }
    }

    #[test]
    fn a_picture_is_drawn_from_what_is_there_and_finer_in_the_next_frames() {
        let (levels, mut pictures) = (levels(3000, 2000), TiledPictures::default());
        let context = Context::default();
        let view = Rect::from_min_max(pos2(0.0, 0.0), pos2(3000.0, 2000.0));
        let mut placement = Placement::default();
        let bounds = PixelRect { x: 0, y: 0, w: 3000, h: 2000 };
        placement.settle(bounds, screen_rect(view));
        placement.show_pixels(screen_rect(view), on_screen(view.center()), 1.0);
        let seen = PlacedPicture::new(&placement, view, 1.0);
        let counts: Vec<usize> = (0..7)
            .map(|_| {
                let painter = context.layer_painter(eframe::egui::LayerId::background());
                let tiled = pictures.of(&levels);
                tiled.draw(&painter.with_clip_rect(view), &seen, (0, 0));
                tiled.tiles.keys().filter(|position| position.0 == 0).count()
            })
            .collect();
        assert_eq!(counts[..3], [4, 8, 12]);
        assert_eq!(counts[6..], [24]);
        pictures.drop_gone();
        assert_eq!(pictures.made.len(), 1, "the picture is still there");
        drop(levels);
        pictures.drop_gone();
        assert!(pictures.made.is_empty());
    }
}
