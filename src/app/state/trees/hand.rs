//! The tool that places trees and drags them: a press places one or takes one, and a drag moves, resizes or turns it.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use crate::state::space::view_pixel::ViewPixel;
use quadratura_document::Project;
use quadratura_document::trees::PlacedTree;

/// The distance in pixels below which a press moves nothing: a click only selects.
const LEAST_PX: f64 = 3.0;
/// The lowest tree that a drag makes, as a share of its height before.
const LOWEST: f64 = 0.05;
/// The turn of a drag across the view's width, in degrees.
const DEGREES_PER_WIDTH: f64 = 360.0;

/// The tool.
#[derive(Debug, Clone)]
pub struct TreeHand {
    /// Whether it is in use: the left button places and drags trees.
    pub on: bool,
    /// The species of trees that are placed.
    pub species: String,
    /// The tree that is held.
    pub held: Option<HeldTree>,
}

impl Default for TreeHand {
    fn default() -> Self {
        Self { on: false, species: "maple".into(), held: None }
    }
}

/// What a drag does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Hold {
    /// Moves the foot along the surfaces.
    #[default]
    Move,
    /// Changes the height.
    Height,
    /// Turns.
    Turn,
}

impl Hold {
    /// Returns the word for a step of the history.
    pub fn word(self) -> &'static str {
        match self {
            Self::Move => "place",
            Self::Height => "height",
            Self::Turn => "turn",
        }
    }
}

/// A tree that is held by the mouse.
#[derive(Debug, Clone)]
pub struct HeldTree {
    /// The project before the button was pressed.
    pub before: Arc<Project>,
    /// The tree when this kind of drag began.
    start: PlacedTree,
    /// Its height and width then, in world units.
    size: [f64; 2],
    hold: Hold,
    /// Where the pointer was then, in pixels of the view.
    from_px: DVec2,
    /// Whether the pointer has left the place where the button was pressed.
    moved: bool,
}

impl HeldTree {
    /// Takes a tree of this height and width in world units.
    pub fn new(before: Arc<Project>, tree: PlacedTree, size: [f64; 2], at_px: DVec2) -> Self {
        Self { before, start: tree, size, hold: Hold::default(), from_px: at_px, moved: false }
    }

    /// Returns the name of the tree.
    pub fn name(&self) -> &str {
        &self.start.name
    }

    /// Begins another kind of drag with the tree as it is now, where it is another one.
    pub fn hold_for(&mut self, hold: Hold, now: &PlacedTree, size: [f64; 2], at_px: DVec2) {
        if hold != self.hold {
            (self.start, self.size, self.hold, self.from_px) = (now.clone(), size, hold, at_px);
        }
    }

    /// Returns the tree with the pointer at a place; `None` where nothing changes. `ground` finds the point of the surfaces under a
    /// place of the view, in pixels.
    pub fn dragged(
        &mut self,
        pixel: &ViewPixel,
        ground: impl FnOnce(DVec2) -> Option<DVec3>,
    ) -> Option<PlacedTree> {
        let by = pixel.at_px - self.from_px;
        self.moved |= by.length() >= LEAST_PX;
        if !self.moved {
            return None;
        }
        let mut tree = self.start.clone();
        let foot = pixel.viewpoint.pose.camera_from_world(DVec3::from_array(tree.at));
        let camera = pixel.viewpoint.camera(pixel.size_px[0], pixel.size_px[1]);
        match self.hold {
            Hold::Move => {
                // The foot moves as the pointer does, wherever the tree was taken.
                let foot_px = camera.image_from_camera(foot)?;
                tree.at = ground(foot_px + by)?.to_array();
            }
            Hold::Height => {
                let [height, width] = self.size;
                let higher = -by.y * foot.z.max(0.0) / camera.fy;
                let taller = (height + higher).max(LOWEST * height);
                tree.height = Some(taller);
                tree.width = tree.width.map(|_| width * taller / height);
            }
            Hold::Turn => {
                let turn = by.x / f64::from(pixel.size_px[0]) * DEGREES_PER_WIDTH;
                tree.turn = (tree.turn + turn).rem_euclid(360.0);
            }
        }
        Some(tree)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::{centred, look_at};
    use quadratura_trees::edit::{TreeChange, placed};
    use quadratura_view::navigation::Viewpoint;

    const SIZE_PX: [u32; 2] = [640, 480];

    /// A view from 12 before a tree 6 high, and the tree, held at its crown.
    fn held() -> (HeldTree, ViewPixel) {
        let change = TreeChange { at: Some([0.0; 3]), width: Some(3.0), ..TreeChange::default() };
        let (trees, _) = placed(&Default::default(), "maple", None, &change).unwrap();
        let pose = look_at(DVec3::new(0.0, -12.0, 3.0), DVec3::new(0.0, 0.0, 3.0));
        let viewpoint = Viewpoint::of_camera(&centred(640, 480, 50.0), &pose, DVec3::ZERO);
        let pixel = ViewPixel { viewpoint, size_px: SIZE_PX, at_px: DVec2::new(320.0, 200.0) };
        let tree = trees.placed[0].clone();
        (HeldTree::new(Arc::default(), tree, [6.0, 3.0], pixel.at_px), pixel)
    }

    fn at(pixel: &ViewPixel, x: f64, y: f64) -> ViewPixel {
        ViewPixel { at_px: pixel.at_px + DVec2::new(x, y), ..*pixel }
    }

    #[test]
    fn a_click_moves_nothing_and_a_drag_moves_the_foot_as_far_as_the_pointer() {
        let (mut held, pixel) = held();
        let mut asked = None;
        assert_eq!(held.dragged(&at(&pixel, 1.0, 1.0), |_| unreachable!()), None);
        let ground = |px: DVec2| {
            asked = Some(px);
            Some(DVec3::new(1.0, 2.0, 0.0))
        };
        let moved = held.dragged(&at(&pixel, 40.0, 0.0), ground).unwrap();
        assert_eq!((moved.at, moved.height, moved.turn), ([1.0, 2.0, 0.0], None, 0.0));
        let camera = pixel.viewpoint.camera(SIZE_PX[0], SIZE_PX[1]);
        let foot = camera.image_from_camera(pixel.viewpoint.pose.camera_from_world(DVec3::ZERO)).unwrap();
        assert!(asked.unwrap().distance(foot + DVec2::new(40.0, 0.0)) < 1e-9);
        assert_eq!(held.dragged(&at(&pixel, 90.0, 0.0), |_| None), None, "in the sky it stays");
    }

    #[test]
    fn the_top_follows_the_pointer_with_the_crown_in_proportion_and_a_tree_never_vanishes() {
        let (mut held, pixel) = held();
        let camera = pixel.viewpoint.camera(SIZE_PX[0], SIZE_PX[1]);
        held.hold_for(Hold::Height, &held.start.clone(), [6.0, 3.0], pixel.at_px);
        let unit = camera.fy / 12.0;
        let taller = held.dragged(&at(&pixel, 0.0, -2.0 * unit), |_| None).unwrap();
        assert!((taller.height.unwrap() - 8.0).abs() < 1e-9 && (taller.width.unwrap() - 4.0).abs() < 1e-9);
        let low = held.dragged(&at(&pixel, 0.0, 900.0 * unit), |_| None).unwrap();
        assert!((low.height.unwrap() - 0.3).abs() < 1e-9);
    }

    #[test]
    fn the_view_is_one_turn_wide_and_another_kind_of_drag_begins_where_the_last_one_ended() {
        let (mut held, pixel) = held();
        held.hold_for(Hold::Turn, &held.start.clone(), [6.0, 3.0], pixel.at_px);
        let turned = held.dragged(&at(&pixel, -160.0, 0.0), |_| None).unwrap();
        assert!((turned.turn - 270.0).abs() < 1e-9);
        held.hold_for(Hold::Height, &turned, [6.0, 3.0], at(&pixel, -160.0, 0.0).at_px);
        let both = held.dragged(&at(&pixel, -160.0, -50.0), |_| None).unwrap();
        assert!(both.turn == turned.turn && both.height.unwrap() > 6.0);
    }
}
