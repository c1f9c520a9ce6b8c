//! The exposure that a camera wrote into a photo's file (EXIF 2.32, section 4.6.5).

use exif::{Exif, In, Reader, Tag, Value};

use quadratura_base::scene::CameraExposure;

/// Reads exposure time, aperture, sensitivity and flash from an EXIF block. `None` where one of the first three is missing, zero or out
/// of any camera's range: lenses without contacts write an aperture of 0, and film scanners nothing.
pub fn camera_exposure(block: Vec<u8>) -> Option<CameraExposure> {
    let mut reader = Reader::new();
    // Other values of the block may be damaged.
    reader.continue_on_error(true);
    let exif = reader.read_raw(block).or_else(|error| error.distill_partial_result(|_| ())).ok()?;
    let apex = |tag: Tag| number(&exif, tag).map(|value| 2f64.powf(value));
    let seconds = positive(number(&exif, Tag::ExposureTime))
        .or_else(|| apex(Tag::ShutterSpeedValue).map(f64::recip))
        .filter(|seconds| (1e-6..=1e5).contains(seconds))?;
    let f_number = positive(number(&exif, Tag::FNumber))
        .or_else(|| apex(Tag::ApertureValue).map(f64::sqrt))
        .filter(|f_number| (0.3..=300.0).contains(f_number))?;
    // 65535 stands for a sensitivity that is too high for this field.
    let short = number(&exif, Tag::PhotographicSensitivity).filter(|iso| *iso < 65535.0);
    let long = || {
        [Tag::ISOSpeed, Tag::RecommendedExposureIndex, Tag::StandardOutputSensitivity]
            .into_iter()
            .find_map(|tag| positive(number(&exif, tag)))
    };
    let iso = positive(short).or_else(long).filter(|iso| (1.0..=1e7).contains(iso))?;
    // Bit 0 says whether the flash fired.
    let flash = number(&exif, Tag::Flash).is_some_and(|flash| flash as u32 & 1 == 1);
    Some(CameraExposure { seconds, f_number, iso, flash })
}

/// Returns the first number of a field.
fn number(exif: &Exif, tag: Tag) -> Option<f64> {
    let number = match &exif.get_field(tag, In::PRIMARY)?.value {
        Value::Rational(values) => values.first()?.to_f64(),
        Value::SRational(values) => values.first()?.to_f64(),
        value => f64::from(value.get_uint(0)?),
    };
    number.is_finite().then_some(number)
}

fn positive(number: Option<f64>) -> Option<f64> {
    number.filter(|number| *number > 0.0)
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// The fields of a block: tag, and numerator and denominator; whole numbers without one.
    type Fields<'a> = &'a [(u16, u32, Option<u32>)];

    /// Makes an EXIF block, as TIFF does: a directory that refers to the one with these fields, which are in order.
    pub fn block(fields: Fields) -> Vec<u8> {
        let mut bytes = b"II*\0\x08\0\0\0\x01\0".to_vec();
        let entry = |tag: u16, kind: u16, value: u32| {
            let mut entry = [tag.to_le_bytes(), kind.to_le_bytes()].concat();
            entry.extend(1u32.to_le_bytes());
            entry.extend(value.to_le_bytes());
            entry
        };
        bytes.extend(entry(0x8769, 4, 26));
        bytes.extend([0; 4]);
        bytes.extend((fields.len() as u16).to_le_bytes());
        let mut rationals = Vec::new();
        let after = 26 + 2 + 12 * fields.len() as u32 + 4;
        for (tag, value, of) in fields {
            match of {
                None => bytes.extend(entry(*tag, 3, *value)),
                Some(of) => {
                    bytes.extend(entry(*tag, 5, after + rationals.len() as u32));
                    rationals.extend([value.to_le_bytes(), of.to_le_bytes()].concat());
                }
            }
        }
        bytes.extend([0; 4]);
        bytes.extend(rationals);
        bytes
    }

    const TIME: u16 = 0x829a;
    const F_NUMBER: u16 = 0x829d;
    const ISO: u16 = 0x8827;
    const FLASH: u16 = 0x9209;

    #[test]
    fn time_aperture_and_sensitivity_are_read_and_make_one_exposure() {
        let plain = [(TIME, 1, Some(250)), (F_NUMBER, 80, Some(10)), (ISO, 200, None), (FLASH, 16, None)];
        let read = camera_exposure(block(&plain)).unwrap();
        assert_eq!(read, CameraExposure { seconds: 0.004, f_number: 8.0, iso: 200.0, flash: false });
        let longer = [(TIME, 1, Some(125)), (F_NUMBER, 80, Some(10)), (ISO, 200, None)];
        let stops = |read: CameraExposure| read.log().unwrap() / std::f64::consts::LN_2;
        assert!((stops(camera_exposure(block(&longer)).unwrap()) - stops(read) - 1.0).abs() < 1e-12);
        // In APEX: 2^-6 s, f/5.6.
        let apex = [(ISO, 100, None), (0x9201, 6, Some(1)), (0x9202, 5, Some(1))];
        let read = camera_exposure(block(&apex)).unwrap();
        assert!(read.seconds == 1.0 / 64.0 && (read.f_number - 32f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn what_is_missing_zero_or_impossible_gives_no_exposure_and_a_flash_no_comparison() {
        let all = [(TIME, 1, Some(60)), (F_NUMBER, 4, Some(1)), (ISO, 400, None)];
        for without in 0..3 {
            let some: Vec<_> =
                all.iter().enumerate().filter(|(i, _)| *i != without).map(|(_, f)| *f).collect();
            assert_eq!(camera_exposure(block(&some)), None);
            for value in [(0, Some(1)), (1, Some(0)), (4_000_000_000, Some(1))] {
                let mut wrong = all;
                (wrong[without].1, wrong[without].2) = value;
                assert_eq!(camera_exposure(block(&wrong)), None, "{without} {value:?}");
            }
        }
        let flashed = camera_exposure(block(&[&all[..], &[(FLASH, 9, None)]].concat())).unwrap();
        assert!(flashed.flash && flashed.log().is_none());
        let whole = block(&all);
        for length in 0..whole.len() {
            let _ = camera_exposure(whole[..length].to_vec());
        }
    }
}
