//! The bit depth of layered files.

use quadratura_base::scene::Samples;

/// Bits per sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "u8", into = "u8")]
pub enum Depth {
    /// 8 bits: 0..=255.
    Eight,
    /// 16 bits: 0..=65535.
    Sixteen,
}

impl Depth {
    /// Returns the depth of samples.
    pub(crate) fn from_samples(samples: &Samples) -> Self {
        match samples {
            Samples::U8(_) => Self::Eight,
            Samples::U16(_) => Self::Sixteen,
        }
    }

    /// Returns bytes per sample: 1 or 2.
    pub fn bytes(self) -> u64 {
        u64::from(self.bits()) / 8
    }

    /// Returns bits per sample: 8 or 16.
    pub fn bits(self) -> u8 {
        match self {
            Self::Eight => 8,
            Self::Sixteen => 16,
        }
    }
}

impl From<Depth> for u8 {
    fn from(depth: Depth) -> Self {
        depth.bits()
    }
}

impl TryFrom<u8> for Depth {
    type Error = String;

    fn try_from(bits: u8) -> Result<Self, String> {
        match bits {
            8 => Ok(Self::Eight),
            16 => Ok(Self::Sixteen),
            _ => Err(format!("{bits} bits per sample; expected 8 or 16")),
        }
    }
}
