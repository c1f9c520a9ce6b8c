//! Atlases: the rectangles of parts are packed into pictures.

/// How many texels of what is beyond a rectangle's cells it holds, for the pixel by which rims are moved and for filtering.
pub const BORDER: u32 = 2;
/// Sides of rectangles are multiples of this, so that no block of a JPEG holds two of them.
pub const BLOCK: u32 = 8;
/// The longest side of an atlas: what nearly all devices with WebGL 2 draw.
pub const LONGEST: u32 = 4096;

/// A picture with the colours of parts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Atlas {
    /// Whether it shows mostly what the reference camera sees first, and not what is hidden behind it.
    pub first: bool,
    /// Whether its parts have neither rims nor translucent texels.
    pub opaque: bool,
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// sRGB, rows from the top; also beyond rims, where colours are carried on.
    pub rgb: Vec<u8>,
    /// Opacity; 0 beyond rims.
    pub opacity: Vec<u8>,
}

impl Atlas {
    pub(super) fn new(first: bool, opaque: bool, [width, height]: [u32; 2]) -> Self {
        let texels = width as usize * height as usize;
        Self { first, opaque, width, height, rgb: vec![0; 3 * texels], opacity: vec![0; texels] }
    }
}

/// Where rectangles are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Packed {
    /// Of each rectangle, its picture and its upper left corner.
    pub places: Vec<(usize, [u32; 2])>,
    /// The sizes of the pictures.
    pub sizes: Vec<[u32; 2]>,
}

/// Packs rectangles into pictures of [`LONGEST`] at most: higher ones first, in shelves from the top; each goes to the first
/// shelf of at most its height and an eighth in which there is room.
pub fn packed(rectangles: &[[u32; 2]]) -> Packed {
    let area: u64 = rectangles.iter().map(|[w, h]| u64::from(*w) * u64::from(*h)).sum();
    let widest = rectangles.iter().map(|[width, _]| *width).max().unwrap_or(BLOCK);
    let square = ((area as f64 * 1.05).sqrt() as u32).next_multiple_of(TILED);
    let width = square.clamp(widest, LONGEST);
    let mut order: Vec<usize> = (0..rectangles.len()).collect();
    order.sort_by_key(|&i| (std::cmp::Reverse(rectangles[i][1]), std::cmp::Reverse(rectangles[i][0]), i));
    let mut shelves: Vec<AtlasShelf> = Vec::new();
    let (mut places, mut sizes) = (vec![(0, [0, 0]); rectangles.len()], Vec::<[u32; 2]>::new());
    for i in order {
        let [w, h] = rectangles[i];
        // Shelves get lower and lower; the newest ones have the fitting height.
        let found = shelves
            .iter_mut()
            .find(|shelf| shelf.used + w <= width && h <= shelf.height && shelf.height <= h + h / 8);
        let shelf = match found {
            Some(shelf) => shelf,
            None => {
                if sizes.last().is_none_or(|size| size[1] + h > LONGEST) {
                    sizes.push([width, 0]);
                }
                let picture = sizes.len() - 1;
                let y = sizes[picture][1];
                sizes[picture][1] += h;
                shelves.push(AtlasShelf { picture, y, height: h, used: 0 });
                shelves.last_mut().expect("it was pushed")
            }
        };
        places[i] = (shelf.picture, [shelf.used, shelf.y]);
        shelf.used += w;
    }
    Packed { places, sizes }
}

/// Widths of pictures are multiples of this.
const TILED: u32 = 64;

/// A row of rectangles.
struct AtlasShelf {
    picture: usize,
    y: u32,
    height: u32,
    used: u32,
}
