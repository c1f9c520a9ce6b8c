//! COLMAP's dense depth maps, `*.geometric.bin` and `*.photometric.bin`: `width&height&channels&` as text, then 32-bit floats,
//! little-endian, x fastest (`mvs/mat.h` of COLMAP). A map of depths has one channel, one of normals three.

use super::depth_file::{COPY, DepthFile};
use quadratura_base::error::Result;

/// Reads the numbers of a file, rows from the top.
pub(super) fn read(source: &mut DepthFile, size: [u32; 2]) -> Result<Vec<f32>> {
    let mut header = 0;
    let mut next = |source: &mut DepthFile, what: &str| {
        let word = source.word(|byte| byte == b'&', &mut header)?;
        source.number(&word, what)
    };
    let [width, height, channels] =
        [next(source, "width")?, next(source, "height")?, next(source, "number of channels")?];
    match channels {
        1 => {}
        3 => {
            let found = "three channels: a map of normals; expected one channel";
            return Err(source.wrong(
                "header",
                found,
                "give the file of the same name in `stereo/depth_maps`",
            ));
        }
        other => return Err(source.wrong("header", format!("{other} channels; expected one"), COPY)),
    }
    source.check_size([width, height], size)?;
    let count = size[0] as usize * size[1] as usize;
    source.check_rest(header, 4 * count as u64)?;
    source.floats(count, f32::from_le_bytes)
}
