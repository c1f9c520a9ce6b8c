//! Layers over each other as one OpenEXR file of several parts, for compositing programs: colours as 16-bit floats in linear light,
//! multiplied by alpha, in a part per layer with a data window of its own; depths as 32-bit floats.

use std::io::Cursor;

use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Blocks, Compression, Encoding, FlatSamples, Image,
    ImageAttributes, IntegerBounds, Layer, LayerAttributes, LineOrder, SmallVec, Text, Vec2, WritableImage,
    f16,
};

use super::picture_exr::{PRIMARIES, half};
use super::picture_png::MADE_BY;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::light::linear_of_srgb;
use quadratura_layered_files::Raster;

/// Zip in blocks of 16 lines, which all programs read.
const ENCODING: Encoding = Encoding {
    compression: Compression::ZIP16,
    blocks: Blocks::ScanLines,
    line_order: LineOrder::Increasing,
};

/// A part of the file.
pub struct ExrPart {
    /// The unique name; channels of the part are shown as `NAME.R` and so on.
    pub name: String,
    /// The data window, in pixels of the picture; it may reach outside of it.
    pub rect: PixelRect,
    /// The values, by rows.
    pub content: ExrContent,
    /// Attributes of the program's own: names without the program's, and values.
    pub attributes: Vec<(&'static str, ExrValue)>,
}

/// The values of a part.
pub enum ExrContent {
    /// R, G, B multiplied by A, and A, in linear light.
    Light([Vec<f16>; 4]),
    /// Z: depths along the camera's axis; infinite where there is nothing.
    Depths(Vec<f32>),
}

/// A value of an attribute.
#[derive(Debug, Clone, PartialEq)]
pub enum ExrValue {
    /// A text.
    Text(String),
    /// A whole number.
    Number(i32),
    /// Three numbers.
    Three([f32; 3]),
}

/// Converts colours of sRGB, not multiplied by alpha, to the values of a part.
pub fn light_of(pixels: &Raster) -> ExrContent {
    let light: Vec<f32> =
        (0..=u16::MAX).map(|value| linear_of_srgb(f64::from(value) / 65535.0) as f32).collect();
    let mut channels: [Vec<f16>; 4] = Default::default();
    let count = pixels.width() as usize * pixels.height() as usize;
    channels.iter_mut().for_each(|channel| channel.reserve_exact(count));
    for y in 0..pixels.height() {
        for x in 0..pixels.width() {
            let colour = pixels.rgba16(x, y);
            let alpha = f32::from(colour[3]) / 65535.0;
            for (channel, value) in channels.iter_mut().zip(&colour[..3]) {
                channel.push(half(light[usize::from(*value)] * alpha));
            }
            channels[3].push(half(alpha));
        }
    }
    ExrContent::Light(channels)
}

/// Encodes a picture of `size` pixels (the display window) with these parts, in their order.
///
/// # Errors
/// [`Error::Request`] for what OpenEXR cannot hold, such as two parts of one name.
pub fn layers_exr(size: [u32; 2], parts: Vec<ExrPart>) -> Result<Vec<u8>> {
    let display = IntegerBounds::from_dimensions((size[0] as usize, size[1] as usize));
    let mut attributes = ImageAttributes::new(display);
    attributes.chromaticities = Some(PRIMARIES);
    let layers: SmallVec<[Layer<AnyChannels<FlatSamples>>; 2]> = parts.into_iter().map(layer).collect();
    let mut bytes = Cursor::new(Vec::new());
    let image = Image::from_layers(attributes, layers);
    let written = image.write().to_buffered(&mut bytes);
    written.map_err(|error| Error::Request(format!("the layers cannot be written as OpenEXR: {error}")))?;
    Ok(bytes.into_inner())
}

fn layer(part: ExrPart) -> Layer<AnyChannels<FlatSamples>> {
    let mut attributes = LayerAttributes::named(Text::from(&part.name[..]));
    attributes.layer_position = Vec2(part.rect.x, part.rect.y);
    attributes.software_name = Some(Text::from(MADE_BY));
    for (name, value) in part.attributes {
        let value = match value {
            ExrValue::Text(text) => AttributeValue::Text(Text::from(&text[..])),
            ExrValue::Number(number) => AttributeValue::I32(number),
            ExrValue::Three([x, y, z]) => AttributeValue::FloatVec3((x, y, z)),
        };
        attributes.other.insert(Text::from(&format!("{}:{name}", MADE_BY.to_lowercase())[..]), value);
    }
    let channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = match part.content {
        ExrContent::Light(channels) => ["R", "G", "B", "A"]
            .into_iter()
            .zip(channels)
            .map(|(name, values)| AnyChannel::new(name, FlatSamples::F16(values)))
            .collect(),
        ExrContent::Depths(depths) => {
            std::iter::once(AnyChannel::new("Z", FlatSamples::F32(depths))).collect()
        }
    };
    let size = (part.rect.w as usize, part.rect.h as usize);
    Layer::new(size, attributes, ENCODING, AnyChannels::sort(channels))
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::{ReadChannels, ReadLayers, read};
    use quadratura_layered_files::Depth;

    #[test]
    fn parts_have_their_windows_names_attributes_and_values() {
        let rect = PixelRect { x: -2, y: 5, w: 4, h: 2 };
        let mut pixels = Raster::blank(4, 2, Depth::Sixteen);
        pixels.set_rgba16(1, 1, [65535, 48059, 0, 32768]);
        let light = ExrPart {
            name: "k7q2m9_wall".into(),
            rect,
            content: light_of(&pixels),
            attributes: vec![
                ("order", ExrValue::Number(3)),
                ("name", ExrValue::Text("wall, \u{e4}".into())),
                ("gain", ExrValue::Three([1.0, 2.0, 0.5])),
            ],
        };
        let whole = PixelRect::of_size(8, 7);
        let mut depths = vec![f32::INFINITY; 56];
        depths[9] = 12.5;
        let depth = ExrPart {
            name: "depth".into(),
            rect: whole,
            content: ExrContent::Depths(depths.clone()),
            attributes: Vec::new(),
        };
        let bytes = layers_exr([8, 7], vec![light, depth]).unwrap();
        let read =
            read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
        let image = read.from_buffered(Cursor::new(bytes)).unwrap();
        assert_eq!(image.attributes.display_window, IntegerBounds::from_dimensions((8, 7)));
        assert_eq!(image.attributes.chromaticities, Some(PRIMARIES));
        let [light, depth] = &image.layer_data[..] else { panic!("two parts") };
        assert_eq!((light.attributes.layer_position, light.size), (Vec2(-2, 5), Vec2(4, 2)));
        assert_eq!(light.attributes.layer_name, Some(Text::from("k7q2m9_wall")));
        let of = |name: &str| light.attributes.other[&Text::from(name)].clone();
        assert_eq!(of("quadratura:order"), AttributeValue::I32(3));
        assert_eq!(of("quadratura:gain"), AttributeValue::FloatVec3((1.0, 2.0, 0.5)));
        let values = |layer: &Layer<AnyChannels<FlatSamples>>, name: &str, at: usize| {
            let channel = layer.channel_data.list.iter().find(|channel| channel.name == *name).unwrap();
            channel.sample_data.values_as_f32().nth(at).unwrap()
        };
        // Half of white light, half of half of it (a stored value of 0.733), nothing; the precision of half floats.
        let expected = [("R", 0.5), ("G", 0.2485), ("B", 0.0), ("A", 0.5)];
        assert!(expected.iter().all(|(name, value)| (values(light, name, 5) - value).abs() < 5e-4));
        assert!(expected.iter().all(|(name, _)| values(light, name, 0) == 0.0));
        assert_eq!((values(depth, "Z", 9), values(depth, "Z", 8)), (12.5, f32::INFINITY));
    }

    #[test]
    fn two_parts_of_one_name_are_refused() {
        let part = || ExrPart {
            name: "one".into(),
            rect: PixelRect::of_size(2, 2),
            content: ExrContent::Depths(vec![1.0; 4]),
            attributes: Vec::new(),
        };
        assert!(layers_exr([2, 2], vec![part(), part()]).is_err());
    }
}
