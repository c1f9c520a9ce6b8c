//! How paint changes a surface.

use glam::Vec3;

/// What is added to both sides of a ratio of light. Where a channel is next to black, a ratio of it says nothing: with this, a change
/// adds to a dark channel and multiplies a bright one.
const DARK: f32 = 0.01;

/// The change of a surface by paint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// For R, G, B the natural logarithm of (painted + 0.01) / (before + 0.01), of the shares of light that are reflected.
    pub colour: Vec3,
    /// The share of what was covered that stays covered, 0..=1.
    pub alpha: f32,
}

impl Change {
    /// No change.
    pub const NONE: Self = Self { colour: Vec3::ZERO, alpha: 1.0 };

    /// Returns the change from one colour to another: shares of light that are reflected, linear.
    pub fn of_colour(before: Vec3, painted: Vec3) -> Self {
        let ratio = (painted + DARK) / (before + DARK);
        Self { colour: Vec3::from_array(ratio.to_array().map(f32::ln)), alpha: 1.0 }
    }

    /// Returns true where nothing changes.
    pub fn is_none(&self) -> bool {
        *self == Self::NONE
    }

    /// Returns this change followed by another one.
    pub fn then(&self, other: &Self) -> Self {
        Self { colour: self.colour + other.colour, alpha: self.alpha * other.alpha }
    }

    /// Returns the factors for R, G, B of light plus 0.01.
    pub fn factors(&self) -> Vec3 {
        self.colour.exp()
    }

    /// Returns the share of light that is reflected after the change, linear, from that before.
    pub fn reflected(&self, before: Vec3) -> Vec3 {
        ((before + DARK) * self.factors() - DARK).clamp(Vec3::ZERO, Vec3::ONE)
    }

    /// Returns the share of light that a leaf lets through after the change: it changes as what is reflected, from `before` to
    /// `after`, and both together are no more than all light.
    pub fn through(&self, through: Vec3, before: Vec3, after: Vec3) -> Vec3 {
        let ratio = (after + 1e-4) / (before + 1e-4);
        (through * ratio).min(Vec3::ONE - after).max(Vec3::ZERO)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_gives_the_painted_colour_again_and_twice_the_change_is_both_changes() {
        let (before, painted) = (Vec3::new(0.05, 0.2, 0.0), Vec3::new(0.6, 0.0, 0.3));
        let change = Change::of_colour(before, painted);
        assert!(change.reflected(before).abs_diff_eq(painted, 1e-6));
        let back = Change::of_colour(painted, before);
        assert!(change.then(&back).reflected(before).abs_diff_eq(before, 1e-6));
        assert!(Change::of_colour(before, before).is_none());
    }

    #[test]
    fn a_leaf_lets_through_as_much_more_as_it_reflects_but_never_more_than_all_light() {
        let (before, painted) = (Vec3::new(0.1, 0.2, 0.4), Vec3::new(0.2, 0.1, 0.9));
        let change = Change::of_colour(before, painted);
        let through = change.through(Vec3::new(0.1, 0.3, 0.4), before, painted);
        assert!(through.abs_diff_eq(Vec3::new(0.2, 0.15, 0.1), 1e-3), "{through}");
    }
}
