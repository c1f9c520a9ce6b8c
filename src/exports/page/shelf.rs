//! Rectangles beside each other in rows, the highest first.

/// The width of a sheet that is wide enough for every rectangle.
const WIDTH: u32 = 1024;

/// The places of rectangles in a sheet.
pub struct PageShelf {
    /// The corners, in the order in which the rectangles were given.
    pub corners: Vec<[u32; 2]>,
    /// The sheet's width and height, 1 at least.
    pub size: [u32; 2],
}

impl PageShelf {
    /// Packs rectangles of these sizes.
    pub fn new(sizes: impl Iterator<Item = [u32; 2]>) -> Self {
        let sizes: Vec<[u32; 2]> = sizes.collect();
        let width = sizes.iter().map(|size| size[0]).fold(WIDTH, u32::max);
        let mut order: Vec<usize> = (0..sizes.len()).collect();
        order.sort_by_key(|at| (std::cmp::Reverse(sizes[*at][1]), *at));
        let mut corners = vec![[0; 2]; sizes.len()];
        let (mut x, mut y, mut height) = (0, 0, 0);
        for at in order {
            let [w, h] = sizes[at];
            if x + w > width {
                (x, y, height) = (0, y + height, 0);
            }
            corners[at] = [x, y];
            (x, height) = (x + w, height.max(h));
        }
        Self { corners, size: [width, (y + height).max(1)] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    #[test]
    fn rectangles_lie_beside_each_other_within_the_sheet() {
        let mut rng = Rng::new(3);
        let sizes: Vec<[u32; 2]> =
            (0..200).map(|_| [0; 2].map(|_: u32| rng.between(1.0, 300.0) as u32)).collect();
        let shelf = PageShelf::new(sizes.iter().copied());
        let ends = |at: usize| [0, 1].map(|axis| shelf.corners[at][axis] + sizes[at][axis]);
        for a in 0..sizes.len() {
            assert!((0..2).all(|axis| ends(a)[axis] <= shelf.size[axis]));
            let apart = |b: &usize| {
                (0..2).any(|axis| {
                    shelf.corners[a][axis] >= ends(*b)[axis] || shelf.corners[*b][axis] >= ends(a)[axis]
                })
            };
            assert!((0..a).all(|b| apart(&b)), "{a}");
        }
    }
}
