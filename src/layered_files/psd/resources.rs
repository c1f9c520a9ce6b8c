//! Writes the properties of the whole document in a PSD: size, resolution, colour profile, key.

use super::variant::PsdVariant;
use crate::LayeredDocument;

/// The number of the colour mode RGB.
const COLOUR_MODE_RGB: u16 = 3;
/// Number of channels of the merged picture, which has no alpha.
const MERGED_CHANNELS: u16 = 3;

/// Encodes everything before the layers: header, an empty colour table, resources.
pub fn head(document: &LayeredDocument, kind: PsdVariant) -> Vec<u8> {
    let mut out = b"8BPS".to_vec();
    out.extend(kind.version().to_be_bytes());
    out.extend([0; 6]);
    out.extend(MERGED_CHANNELS.to_be_bytes());
    out.extend(document.height.to_be_bytes());
    out.extend(document.width.to_be_bytes());
    out.extend(u16::from(document.depth.bits()).to_be_bytes());
    out.extend(COLOUR_MODE_RGB.to_be_bytes());
    put_block(&mut out, &[]);
    put_block(&mut out, &resources(document));
    out
}

/// Appends `bytes` with their length before them.
fn put_block(out: &mut Vec<u8>, bytes: &[u8]) {
    out.extend((bytes.len() as u32).to_be_bytes());
    out.extend(bytes);
}

fn resources(document: &LayeredDocument) -> Vec<u8> {
    let mut out = Vec::new();
    put_resource(&mut out, 1005, &resolution());
    if let Some(icc) = &document.icc {
        put_resource(&mut out, 1039, icc);
    }
    put_resource(&mut out, 1060, xmp(document).as_bytes());
    out
}

fn put_resource(out: &mut Vec<u8>, id: u16, bytes: &[u8]) {
    out.extend(b"8BIM");
    out.extend(id.to_be_bytes());
    out.extend([0, 0]); // an empty name
    put_block(out, bytes);
    if bytes.len() % 2 == 1 {
        out.push(0);
    }
}

/// Encodes 72 pixels per inch in both directions: photos have no resolution, but editors ask when it is
/// missing.
fn resolution() -> Vec<u8> {
    const PER_INCH: [u8; 8] = [0, 72, 0, 0, 0, 1, 0, 1];
    [PER_INCH, PER_INCH].concat()
}

/// Returns XMP with the document key in `dc:identifier`, which GIMP, Krita and Photoshop all preserve.
fn xmp(document: &LayeredDocument) -> String {
    let (key, title) = (escaped(&document.key), escaped(&document.title));
    format!(
        concat!(
            "<?xpacket begin=\"\u{feff}\" id=\"W5M0MpCehiHzreSzNTczkc9d\"?>\n",
            "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\">\n",
            " <rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\n",
            "  <rdf:Description rdf:about=\"\" xmlns:dc=\"http://purl.org/dc/elements/1.1/\"",
            " xmlns:xmp=\"http://ns.adobe.com/xap/1.0/\">\n",
            "   <dc:identifier>{}</dc:identifier>\n",
            "   <dc:title><rdf:Alt><rdf:li xml:lang=\"x-default\">{}</rdf:li></rdf:Alt></dc:title>\n",
            "   <xmp:CreatorTool>Quadratura</xmp:CreatorTool>\n",
            "  </rdf:Description>\n",
            " </rdf:RDF>\n",
            "</x:xmpmeta>\n",
            "<?xpacket end=\"w\"?>",
        ),
        key, title
    )
}

/// Escapes text for XML; control characters, which XML does not allow, become spaces.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push(' '),
            c => out.push(c),
        }
    }
    out
}
