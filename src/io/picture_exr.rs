//! Writes the program's pictures as OpenEXR: colours and alpha as 16-bit floats in linear light, depths as 32-bit floats. As in PNG
//! files, the pixels' hash is in the file, so that pictures that were changed are recognised and never overwritten.

use std::fs::File;
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use exr::image::read::read_first_flat_layer_from_file;
use exr::meta::attribute::Chromaticities;
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Blocks, Compression, Encoding, FlatSamples, Image, Layer,
    LayerAttributes, LineOrder, MetaData, SmallVec, Text, Vec2, WritableImage, f16,
};

use super::picture_png::{MADE_BY, MOST_BYTES, WrittenPicture, place};
use quadratura_base::error::{Error, Result};
use quadratura_files::atomic::write_atomically;
use quadratura_files::hash::hash_bytes;
use quadratura_view::LinearPicture;

/// The extension of the files.
pub const EXTENSION: &str = "exr";

/// The primaries and white of sRGB, which are those of ITU-R BT.709.
pub(super) const PRIMARIES: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.30, 0.60),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.3290),
};

/// Writes a picture as `folder/STEM.exr`; where that is a file that was changed or made by others, as `STEM-2.exr` and so on.
///
/// Its channels are `R`, `G`, `B`, `A`, multiplied by alpha as OpenEXR has it, and `Z` where the picture has depths.
///
/// # Errors
/// [`Error::Io`], [`Error::Request`] for a picture that OpenEXR cannot hold; an existing file stays.
pub fn write_exr(folder: &Path, stem: &str, picture: &LinearPicture) -> Result<WrittenPicture> {
    let placed = place(folder, stem, EXTENSION, is_unchanged);
    let bytes = encoded(picture).map_err(|error| {
        Error::Request(format!(
            "{}: the picture cannot be written as OpenEXR: {error}",
            placed.path.display()
        ))
    })?;
    write_atomically(&placed.path, &bytes)?;
    Ok(placed)
}

fn encoded(picture: &LinearPicture) -> exr::error::Result<Vec<u8>> {
    let color = |channel: usize| {
        let value = |pixel: &[f32; 4]| half(if channel < 3 { pixel[channel] * pixel[3] } else { pixel[3] });
        FlatSamples::F16(picture.rgba.iter().map(value).collect())
    };
    let mut channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = SmallVec::new();
    for (index, name) in ["R", "G", "B", "A"].into_iter().enumerate() {
        channels.push(AnyChannel::new(name, color(index)));
    }
    channels
        .extend(picture.depths.iter().map(|depths| AnyChannel::new("Z", FlatSamples::F32(depths.clone()))));
    let channels = AnyChannels::sort(channels);
    let mut attributes =
        LayerAttributes { software_name: Some(Text::from(MADE_BY)), ..LayerAttributes::default() };
    attributes.other.insert(Text::from(MADE_BY), AttributeValue::Text(Text::from(&hash_of(&channels)[..])));
    let (compression, blocks) = (Compression::ZIP16, Blocks::ScanLines);
    let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
    let size = (picture.width as usize, picture.height as usize);
    let mut image = Image::from_layer(Layer::new(size, attributes, encoding, channels));
    image.attributes.chromaticities = Some(PRIMARIES);
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes)?;
    Ok(bytes.into_inner())
}

/// Returns the nearest 16-bit float that is a number.
pub(super) fn half(value: f32) -> f16 {
    f16::from_f32(value.clamp(-f16::MAX.to_f32(), f16::MAX.to_f32()))
}

/// Returns the hash of all numbers, channel by channel in the order of the file.
fn hash_of(channels: &AnyChannels<FlatSamples>) -> String {
    let mut bytes = Vec::new();
    for channel in &channels.list {
        match &channel.sample_data {
            FlatSamples::F16(samples) => bytes.extend(samples.iter().flat_map(|sample| sample.to_le_bytes())),
            FlatSamples::F32(samples) => bytes.extend(samples.iter().flat_map(|sample| sample.to_le_bytes())),
            FlatSamples::U32(samples) => bytes.extend(samples.iter().flat_map(|sample| sample.to_le_bytes())),
        }
    }
    hash_bytes(&bytes)
}

/// Returns whether this program wrote the picture in the file, pixel for pixel; `None` if that cannot be determined.
fn is_unchanged(path: &Path) -> Option<bool> {
    // The package is tested against broken files. Should one still make it panic, the file is not this program's.
    catch_unwind(AssertUnwindSafe(|| {
        // What is not this program's is not decoded.
        let headers = MetaData::read_from_buffered(std::io::BufReader::new(File::open(path).ok()?), false)
            .ok()?
            .headers;
        let [header] = &headers[..] else { return None };
        let Some(AttributeValue::Text(hash)) = header.own_attributes.other.get(&Text::from(MADE_BY)) else {
            return None;
        };
        let pixels = header.layer_size.0.checked_mul(header.layer_size.1)?;
        if header.deep || pixels.checked_mul(header.channels.bytes_per_pixel)? > MOST_BYTES {
            return None;
        }
        let image = read_first_flat_layer_from_file(path).ok()?;
        Some(hash_of(&image.layer_data.channel_data) == hash.to_string())
    }))
    .ok()
    .flatten()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth_image::read_depth_map;

    fn picture(red: f32) -> LinearPicture {
        let rgba = vec![[red, 0.25, 2.0, 0.5], [1e9, 0.0, 0.0, 1.0], [0.1, 0.2, 0.3, 0.0]];
        LinearPicture { width: 3, height: 1, rgba, depths: Some(vec![12.25, 1e-3, f32::INFINITY]) }
    }

    fn samples(path: &Path, name: &str) -> Vec<f32> {
        let image = read_first_flat_layer_from_file(path).unwrap();
        let channel =
            image.layer_data.channel_data.list.iter().find(|channel| channel.name == *name).unwrap();
        channel.sample_data.values_as_f32().collect()
    }

    #[test]
    fn colours_are_half_floats_times_alpha_and_depths_are_whole_floats() {
        let folder = tempfile::tempdir().unwrap();
        let written = write_exr(folder.path(), "view", &picture(0.5)).unwrap();
        assert_eq!(written.path, folder.path().join("view.exr"));
        let image = read_first_flat_layer_from_file(&written.path).unwrap();
        let kinds =
            image.layer_data.channel_data.list.iter().map(|channel| {
                (channel.name.to_string(), matches!(channel.sample_data, FlatSamples::F16(_)))
            });
        let expected = [("A", true), ("B", true), ("G", true), ("R", true), ("Z", false)];
        assert_eq!(kinds.collect::<Vec<_>>(), expected.map(|(name, is_half)| (name.to_owned(), is_half)));
        assert_eq!(
            samples(&written.path, "R"),
            [0.25, 65504.0, 0.0],
            "no infinity, and nothing where alpha is 0"
        );
        assert_eq!(samples(&written.path, "B"), [1.0, 0.0, 0.0], "above white");
        assert_eq!(samples(&written.path, "A"), [0.5, 1.0, 0.0]);
        assert_eq!(image.attributes.chromaticities, Some(PRIMARIES));
        let depths = read_depth_map(&written.path, [3, 1]).unwrap();
        assert_eq!(depths.values, [12.25, 1e-3, f32::INFINITY], "the program reads its own depths");
    }

    #[test]
    fn a_picture_of_ours_is_replaced_and_one_that_was_changed_is_kept() {
        let folder = tempfile::tempdir().unwrap();
        let first = write_exr(folder.path(), "view", &picture(0.5)).unwrap().path;
        let again = write_exr(folder.path(), "view", &picture(0.75)).unwrap();
        assert_eq!((again.path.clone(), again.spared.len()), (first.clone(), 0));
        // Another program keeps the hash and changes a pixel.
        let mut image = read_first_flat_layer_from_file(&first).unwrap();
        for channel in &mut image.layer_data.channel_data.list {
            if let FlatSamples::F16(samples) = &mut channel.sample_data {
                samples[0] = f16::from_f32(0.125);
            }
        }
        image.write().to_file(&first).unwrap();
        let second = write_exr(folder.path(), "view", &picture(0.5)).unwrap();
        assert_eq!((second.path, second.spared), (folder.path().join("view-2.exr"), vec![first.clone()]));
        std::fs::write(&first, b"no picture").unwrap();
        assert_eq!(write_exr(folder.path(), "view", &picture(0.5)).unwrap().spared, [first]);
    }
}
