//! The slots of a pixel: the sums of one surface, and which depth pixels belong to it.

use glam::{BVec4A, Mat4, Vec4};

use super::{APART, LEVEL, OVERFULL, PER_OPAQUE, SLIGHT};

/// The sums of one surface at a pixel. All of it is in fours, as the processor computes them.
#[derive(Debug, Clone, Copy)]
pub struct Slot<const N: usize> {
    /// Inverse depth in the picture's camera, in 1/world unit; the sum of weights, 0 where there is no surface; the number of
    /// the surface of the depth pixel that was drawn last, 0 where it is unknown; and its slope, see [`Dot::slope`]. Numbers
    /// of surfaces have 16 bits, which single precision holds exactly.
    pub(super) head: Vec4,
    /// The sums of weights times values: see [`COLOUR`](super::COLOUR) and [`BLENDED`](super::BLENDED).
    pub seen: [Vec4; N],
}

/// What a depth pixel adds to the slots of its pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct SlotAddition<const N: usize> {
    pub(super) q: f32,
    pub(super) surface: f32,
    pub(super) slope: f32,
    /// Along how many pixels its slope counts.
    pub(super) along: f32,
    /// What it adds for a weight of 1.
    pub(super) seen: [Vec4; N],
}

impl<const N: usize> Default for Slot<N> {
    fn default() -> Self {
        Self { head: Vec4::ZERO, seen: [Vec4::ZERO; N] }
    }
}

// Loops over `N` have no iterators: these are calls in the profile `quick`, which does not optimise across all functions.
#[allow(clippy::needless_range_loop)]
impl<const N: usize> Slot<N> {
    pub(super) fn new(weight: f32, addition: &SlotAddition<N>) -> Self {
        let mut slot = Self::default();
        slot.add(weight, addition);
        slot
    }

    /// Returns the inverse depth in the picture's camera, in 1/world unit.
    #[inline(always)]
    pub fn q(&self) -> f32 {
        self.head.x
    }

    /// Returns the sum of weights, 0 where there is no surface.
    #[inline(always)]
    pub fn weight(&self) -> f32 {
        self.head.y
    }

    /// Adds a depth pixel. A surface's weights make 1 where it covers a pixel, so what is far beyond 1 belongs to another
    /// surface at nearly the same depth, such as a window before its wall: the later one, which is nearer, replaces that
    /// share of what is there.
    pub(super) fn add(&mut self, weight: f32, addition: &SlotAddition<N>) {
        let mut sum = self.weight() + weight;
        if sum > OVERFULL {
            // What is translucent replaces only as much as it covers.
            self.keep_share((1.0 - weight * addition.seen[0].w) / self.weight());
            sum = 1.0;
        }
        self.head = Vec4::new(self.q().max(addition.q), sum, addition.surface, addition.slope);
        self.add_share(weight, &addition.seen);
    }

    #[inline(always)]
    fn keep_share(&mut self, share: f32) {
        for i in 0..N {
            self.seen[i] *= share;
        }
    }

    #[inline(always)]
    fn add_share(&mut self, weight: f32, seen: &[Vec4; N]) {
        for i in 0..N {
            self.seen[i] += weight * seen[i];
        }
    }

    /// Returns whether a depth pixel is of the slot's surface, lies on it or meets it.
    pub(super) fn holds(&self, SlotAddition { q, surface, slope, along, .. }: &SlotAddition<N>) -> bool {
        let [own_q, _, own_surface, own_slope] = self.head.to_array();
        let of_two = (*surface != own_surface) & (*surface != 0.0) & (own_surface != 0.0);
        let (one, two) = (LEVEL * own_q, APART * own_q + along * slope.max(own_slope));
        (q - own_q).abs() <= if of_two { one.min(two) } else { one }
    }

    /// Returns linear light R, G, B times the share of the pixel that the surface covers, that share, and further values
    /// times the share that it would cover if it were opaque. `before` is the sum of weights of what is before it,
    /// with which it counts together, so that no gap is left where the near surface ends.
    #[inline(always)]
    pub fn covering(&self, before: f32) -> [Vec4; N] {
        let mut covering = [Vec4::ZERO; N];
        if self.weight() > 0.0 {
            let share = (PER_OPAQUE * (before + self.weight())).min(1.0) / self.weight();
            for i in 0..N {
                covering[i] = self.seen[i] * share;
            }
        }
        covering
    }
}

/// Adds what is not level with the near slot.
pub(super) fn add_apart<const N: usize>(
    near: &mut Slot<N>,
    far: &mut Slot<N>,
    weight: f32,
    addition: &SlotAddition<N>,
) {
    if addition.q > near.q() {
        if near.weight() > SLIGHT || near.weight() > far.weight() {
            *far = *near;
        }
        *near = Slot::new(weight, addition);
    } else if far.weight() == 0.0 || far.holds(addition) {
        far.add(weight, addition);
    } else if addition.q > far.q() {
        *far = Slot::new(weight, addition);
    }
}

/// Adds a depth pixel to four near slots at once, if each of them that has a weight is empty or holds it: what [`Slot::add`]
/// does, without a branch for each. Returns whether it did.
#[inline(always)]
pub(super) fn add_to_four<const N: usize>(
    slots: [&mut Slot<N>; 4],
    weights: Vec4,
    addition: &SlotAddition<N>,
) -> bool {
    let [a, b, c, d] = slots;
    let Mat4 { x_axis: q, y_axis: sum, z_axis: surface, w_axis: slope } =
        Mat4::from_cols(a.head, b.head, c.head, d.head).transpose();
    let (own_q, own) = (Vec4::splat(addition.q), Vec4::splat(addition.surface));
    let known = surface.cmpeq(own) | surface.cmpeq(Vec4::ZERO) | own.cmpeq(Vec4::ZERO);
    let (apart, one) = ((own_q - q).abs(), LEVEL * q);
    let touched = weights.cmpgt(Vec4::ZERO);
    let free: BVec4A = sum.cmpeq(Vec4::ZERO) | !touched;
    if !(free | (apart.cmple(one) & known)).all() {
        // The slots of a picture of small faces hold neighbours of the depth pixel's face as a rule, see [`Slot::holds`].
        let two = APART * q + addition.along * slope.max(Vec4::splat(addition.slope));
        let tolerance = Vec4::select(known, one, one.min(two));
        if !(free | apart.cmple(tolerance)).all() {
            return false;
        }
    }
    let mut whole = sum + weights;
    let full = whole.cmpgt(Vec4::splat(OVERFULL));
    if full.any() {
        let left = Vec4::select(full, (1.0 - weights * addition.seen[0].w) / sum, Vec4::ONE);
        whole = Vec4::select(full, Vec4::ONE, whole);
        a.keep_share(left.x);
        b.keep_share(left.y);
        c.keep_share(left.z);
        d.keep_share(left.w);
    }
    let of_touched = |new: Vec4, old: Vec4| Vec4::select(touched, new, old);
    let heads = Mat4::from_cols(
        of_touched(q.max(own_q), q),
        whole,
        of_touched(own, surface),
        of_touched(Vec4::splat(addition.slope), slope),
    );
    let heads = heads.transpose();
    (a.head, b.head, c.head, d.head) = (heads.x_axis, heads.y_axis, heads.z_axis, heads.w_axis);
    a.add_share(weights.x, &addition.seen);
    b.add_share(weights.y, &addition.seen);
    c.add_share(weights.z, &addition.seen);
    d.add_share(weights.w, &addition.seen);
    true
}
