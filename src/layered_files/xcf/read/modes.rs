//! Blend modes by GIMP's numbers.

use crate::BlendMode;

const NORMAL_LEGACY: u32 = 0;
const NORMAL: u32 = 28;
const PASS_THROUGH: u32 = 61;

/// The modes that GIMP has twice: as in 2.8, and as from 2.10 on.
const TWICE: [&str; 16] = [
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
];

/// Names of modes as GIMP 2.10 shows them, in runs that begin with the given number.
const RUNS: [(usize, &[&str]); 5] = [
    (1, &["dissolve", "behind", "multiply", "screen", "overlay"]),
    (6, &TWICE),
    (
        22,
        &[
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
        ],
    ),
    (32, &TWICE),
    (
        48,
        &[
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
        ],
    ),
];

fn name(mode: usize) -> Option<&'static str> {
    RUNS.iter().find_map(|(first, names)| names.get(mode.checked_sub(*first)?).copied())
}

/// What a user has chosen for the places where a layer or what is below it has nothing, by GIMP's numbers from 1 on: both are left,
/// or only what is within one of them, or within both.
const COMPOSITES: [Option<&str>; 4] = [
    None,
    Some("composite mode clip to backdrop"),
    Some("composite mode clip to layer"),
    Some("composite mode intersection"),
];

/// Returns the blend mode of this number and of this way of compositing; a group that passes through counts as normal.
pub fn blend(mode: u32, composite: i32) -> BlendMode {
    let chosen = usize::try_from(composite).ok().and_then(|number| number.checked_sub(1));
    let composite = chosen.and_then(|index| COMPOSITES.get(index).copied().flatten());
    match (mode, composite) {
        (NORMAL_LEGACY | NORMAL | PASS_THROUGH, None) => BlendMode::Normal,
        (NORMAL_LEGACY | NORMAL | PASS_THROUGH, Some(composite)) => {
            BlendMode::Other(format!("normal with {composite}"))
        }
        (mode, _) => {
            BlendMode::Other(name(mode as usize).map_or_else(|| format!("mode {mode}"), str::to_owned))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_have_the_names_of_the_page_on_the_format() {
        for (mode, name) in [
            (1, "dissolve"),
            (6, "difference"),
            (22, "colour erase"),
            (23, "overlay"),
            (30, "multiply"),
            (37, "HSV hue"),
            (60, "split"),
        ] {
            assert_eq!(blend(mode, 0), BlendMode::Other(name.into()));
        }
        assert_eq!(
            (blend(0, 1), blend(28, -2), blend(61, 0)),
            (BlendMode::Normal, BlendMode::Normal, BlendMode::Normal)
        );
        assert_eq!(blend(28, 2), BlendMode::Other("normal with composite mode clip to backdrop".into()));
        assert_eq!(blend(u32::MAX, 9), BlendMode::Other("mode 4294967295".into()));
    }
}
