//! Builds the sRGB colour profile for 16-bit photos that have none: Krita asks about such pixels, or takes
//! them for linear light, while viewers agree on sRGB for 8 bits.
//!
//! It is a matrix and tone curve profile of version 4 (ICC.1:2010): the primaries of IEC 61966-2-1, adapted
//! to the D50 of the profile connection space.

/// Encodes a number as s15Fixed16, big-endian.
fn fixed(value: f64) -> [u8; 4] {
    ((value * 65536.0).round() as i32).to_be_bytes()
}

fn numbers(kind: &[u8; 4], values: &[f64]) -> Vec<u8> {
    [&kind[..], &[0; 4], values.iter().map(|v| fixed(*v)).collect::<Vec<_>>().as_flattened()].concat()
}

/// Encodes a text in American English as a version 4 profile does.
fn text(text: &str) -> Vec<u8> {
    let units: Vec<[u8; 2]> = text.encode_utf16().map(u16::to_be_bytes).collect();
    let length = (2 * units.len() as u32).to_be_bytes();
    let one_record_of_12: &[u8] = &[0, 0, 0, 1, 0, 0, 0, 12];
    let at_28 = 28u32.to_be_bytes();
    [b"mluc", &[0; 4], one_record_of_12, b"enUS", &length, &at_28, units.as_flattened()].concat()
}

/// Returns the curve tag: (a v + b)^2.4 above 0.04045 and v / 12.92 below.
pub fn tone_curve() -> Vec<u8> {
    let values = [2.4, 1.0 / 1.055, 0.055 / 1.055, 1.0 / 12.92, 0.04045];
    let mut curve = numbers(b"para", &values);
    curve.splice(8..8, [0, 3, 0, 0]); // kind 3: these five parameters
    curve
}

/// Returns the profile, which always has the same bytes.
pub fn srgb_profile() -> Vec<u8> {
    const D50: [f64; 3] = [0.96420, 1.0, 0.82491];
    let adaptation = [1.04788, 0.02292, -0.05022, 0.02959, 0.99048, -0.01707, -0.00925, 0.01508, 0.75168];
    let curve = tone_curve();
    let tags: [(&[u8; 4], Vec<u8>); 10] = [
        (b"desc", text("sRGB")),
        (b"cprt", text("Public domain")),
        (b"wtpt", numbers(b"XYZ ", &D50)),
        (b"chad", numbers(b"sf32", &adaptation)),
        (b"rXYZ", numbers(b"XYZ ", &[0.43607, 0.22249, 0.01392])),
        (b"gXYZ", numbers(b"XYZ ", &[0.38515, 0.71687, 0.09708])),
        (b"bXYZ", numbers(b"XYZ ", &[0.14307, 0.06061, 0.71410])),
        (b"rTRC", curve.clone()),
        (b"gTRC", curve.clone()),
        (b"bTRC", curve),
    ];
    assembled(&tags, &numbers(b"XYZ ", &D50)[8..])
}

fn assembled(tags: &[(&[u8; 4], Vec<u8>)], illuminant: &[u8]) -> Vec<u8> {
    const HEADER: usize = 128;
    let mut table = (tags.len() as u32).to_be_bytes().to_vec();
    let mut data = Vec::new();
    for (name, bytes) in tags {
        let at = HEADER + 4 + 12 * tags.len() + data.len();
        table.extend(*name);
        table.extend((at as u32).to_be_bytes());
        table.extend((bytes.len() as u32).to_be_bytes());
        data.extend(bytes);
        data.resize(data.len().next_multiple_of(4), 0);
    }
    let size = HEADER + table.len() + data.len();
    let mut profile = vec![0; HEADER];
    profile[..4].copy_from_slice(&(size as u32).to_be_bytes());
    profile[8..12].copy_from_slice(&[4, 0x20, 0, 0]);
    profile[12..24].copy_from_slice(b"mntrRGB XYZ ");
    profile[24..36].copy_from_slice(&[7, 218, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0]); // the standard's own year
    profile[36..40].copy_from_slice(b"acsp");
    profile[68..80].copy_from_slice(illuminant);
    [profile, table, data].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_profile_has_its_size_in_front_and_its_tags_within() {
        let profile = srgb_profile();
        let number = |at: usize| u32::from_be_bytes(profile[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!(number(0), profile.len());
        for tag in 0..number(128) {
            let (at, length) = (number(132 + 12 * tag + 4), number(132 + 12 * tag + 8));
            assert!(at % 4 == 0 && at + length <= profile.len());
        }
    }

    #[test]
    fn the_primaries_add_up_to_white() {
        let (x, y, z) =
            (0.43607 + 0.38515 + 0.14307, 0.22249 + 0.71687 + 0.06061, 0.01392 + 0.09708 + 0.71410);
        for (sum, white) in [(x, 0.9642), (y, 1.0), (z, 0.82491)] {
            assert!(f64::abs(sum - white) < 3e-4, "{sum} {white}");
        }
    }
}
