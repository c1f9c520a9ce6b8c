//! The numbers by which GIMP knows how a layer is laid over what is below.

use crate::io::layered::Blend;

const NORMAL_LEGACY: u32 = 0;
const NORMAL: u32 = 28;
const PASS_THROUGH: u32 = 61;

/// The names of modes 1 to 60, as GIMP 2.10 shows them.
const NAMES: [&str; 60] = [
    "dissolve",
    "behind",
    "multiply",
    "screen",
    "overlay",
    "difference",
    "addition",
    "subtract",
    "darken only",
    "lighten only",
    "HSV hue",
    "HSV saturation",
    "HSL colour",
    "HSV value",
    "divide",
    "dodge",
    "burn",
    "hard light",
    "soft light",
    "grain extract",
    "grain merge",
    "colour erase",
    "overlay",
    "LCh hue",
    "LCh chroma",
    "LCh colour",
    "LCh lightness",
    "normal",
    "behind",
    "multiply",
    "screen",
    "difference",
    "addition",
    "subtract",
    "darken only",
    "lighten only",
    "HSV hue",
    "HSV saturation",
    "HSL colour",
    "HSV value",
    "divide",
    "dodge",
    "burn",
    "hard light",
    "soft light",
    "grain extract",
    "grain merge",
    "vivid light",
    "pin light",
    "linear light",
    "hard mix",
    "exclusion",
    "linear burn",
    "luma darken only",
    "luma lighten only",
    "luminance",
    "colour erase",
    "erase",
    "merge",
    "split",
];

/// How a layer of this mode is laid over what is below; a group that passes through counts as normal.
pub fn blend(mode: u32) -> Blend {
    match mode {
        NORMAL_LEGACY | NORMAL | PASS_THROUGH => Blend::Normal,
        mode => {
            let name = (mode as usize).checked_sub(1).and_then(|index| NAMES.get(index));
            Blend::Other(name.map_or_else(|| format!("mode {mode}"), |name| (*name).to_owned()))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_have_the_names_of_the_page_on_the_format() {
        for (mode, name) in
            [(1, "dissolve"), (22, "colour erase"), (23, "overlay"), (30, "multiply"), (37, "HSV hue")]
        {
            assert_eq!(blend(mode), Blend::Other(name.into()));
        }
        assert_eq!((blend(0), blend(28), blend(61)), (Blend::Normal, Blend::Normal, Blend::Normal));
        assert_eq!(blend(u32::MAX), Blend::Other("mode 4294967295".into()));
    }
}
