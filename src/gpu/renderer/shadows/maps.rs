//! Maps of what the sun sees, with what they hold, so that one serves for as many pictures as it can.

use wgpu::{Extent3d, Texture, TextureUsages, TextureView};

use crate::device::Gpu;
use crate::drawing::DEPTH;
use quadratura_foliage::{MOST_SUN_VIEWS, SunView};
use quadratura_view::TreeMethod;

/// While the view moves, a map serves if its pixels are at most this factor larger than those of a new one.
const COARSER: f64 = 1.5;
/// The same for the pixels of the images from which its trees are drawn.
const COARSER_IMAGES: f64 = 1.25;

/// Depths that the sun sees: of trees and of faces, a layer for each view.
#[derive(Debug)]
pub struct Maps {
    /// In pixels.
    pub side: u32,
    textures: [Texture; 2],
    /// What is in each layer; `None` where it is of nothing any more.
    pub layers: [Option<ShadowLayer>; MOST_SUN_VIEWS],
}

/// What is in a layer of the maps: a view from the sun, and how its trees were drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShadowLayer {
    pub view: SunView,
    /// The depth of its near plane.
    pub near: f32,
    pub trees: TreeMethod,
    /// The size of the pixels up to which images of trees served.
    pub threshold: f64,
}

impl Maps {
    /// Creates maps of nothing.
    pub fn new(gpu: &Gpu, side: u32) -> Self {
        let texture = |label| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: Extent3d { width: side, height: side, depth_or_array_layers: MOST_SUN_VIEWS as u32 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: DEPTH,
                usage: TextureUsages::TEXTURE_BINDING | TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            })
        };
        Self {
            side,
            textures: ["trees in the sun", "faces in the sun"].map(texture),
            layers: Default::default(),
        }
    }

    /// Returns the views of all layers, or of one, of trees and of faces.
    pub fn views(&self, layer: Option<u32>) -> [TextureView; 2] {
        let dimension = match layer {
            Some(_) => wgpu::TextureViewDimension::D2,
            None => wgpu::TextureViewDimension::D2Array,
        };
        self.textures.each_ref().map(|texture| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(dimension),
                base_array_layer: layer.unwrap_or(0),
                array_layer_count: layer.map(|_| 1),
                ..Default::default()
            })
        })
    }
}

impl ShadowLayer {
    /// Returns whether it serves in place of another one. Where `moves` is false, only what is the same does, so that a picture does not
    /// depend on those before it.
    pub fn serves(&self, wanted: &Self, moves: bool) -> bool {
        self.trees == wanted.trees
            && match moves {
                true => {
                    self.view.holds(&wanted.view)
                        && self.view.pixel <= COARSER * wanted.view.pixel
                        && self.threshold <= COARSER_IMAGES * wanted.threshold
                }
                false => self.view.is_drawn_as(&wanted.view) && self.threshold == wanted.threshold,
            }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use quadratura_base::scene::synthetic::{centred, look_at};
    use quadratura_foliage::{Ball, SunScene, sun_views};

    #[test]
    fn a_layer_serves_a_moving_view_that_it_holds_and_is_fine_enough_for_and_another_view_only_where_it_is_the_same()
     {
        let casters = [-90.0, 0.0, 90.0].map(|x| Ball { middle: DVec3::new(x, 10.0, 4.0), radius: 3.5 });
        let corners = [DVec3::new(-99.0, -99.0, 0.0), DVec3::new(99.0, 99.0, 0.0)];
        let towards_sun = DVec3::new(0.6, -0.4, 0.5).normalize();
        let scene = SunScene { casters: &casters, corners: &corners, towards_sun, up: DVec3::Z };
        let layer = |x: f64, room: f64| {
            let pose = look_at(DVec3::new(x, -9.0, 8.0), DVec3::new(x, 10.0, 0.0));
            let view = sun_views(&centred(200, 150, 170.0), &pose, &scene, 256, room)[0];
            ShadowLayer { view, near: 1.0, trees: TreeMethod::Flakes, threshold: 1.0 }
        };
        let (held, near_by) = (layer(0.0, 0.2), layer(0.5, 0.2));
        assert!(held.serves(&near_by, true) && !held.serves(&near_by, false));
        assert!(held.serves(&held, true) && held.serves(&held, false));
        assert!(!held.serves(&layer(40.0, 0.2), true), "it holds nothing there");
        let polygons = ShadowLayer { trees: TreeMethod::Polygons, ..near_by };
        assert!(!held.serves(&polygons, true));
        let of_threshold = |threshold: f64| ShadowLayer { threshold, ..held };
        let serves = |threshold: f64, moves: bool| of_threshold(threshold).serves(&held, moves);
        assert_eq!([0.8, 1.0, 1.2, 1.3].map(|threshold| serves(threshold, true)), [true, true, true, false]);
        assert_eq!(
            [0.8, 1.0, 1.2, 1.3].map(|threshold| serves(threshold, false)),
            [false, true, false, false]
        );
        let coarse = |factor: f64| {
            let mut layer = held;
            layer.view.pixel *= factor;
            layer.serves(&held, true)
        };
        assert_eq!([1.4, 1.6].map(coarse), [true, false]);
    }
}
