//! The choice of the shader for a view: the constants and functions that are generated before `project.wgsl`.

use std::fmt::Write;

use wgpu::TextureFormat;

use super::render_target::{COLOR, FACES, LINEAR};
use quadratura_projection::turned::MOST_ON_IMPOSTORS;
use quadratura_view::legend::{
    AGREEMENT, CONFIDENCE, CONTINUED, COVERAGE, COVERAGE_DOUBLINGS, ColourRamp, DENSITY, DENSITY_OCTAVES,
    MATTE, linear,
};
use quadratura_view::shot::MOST_TAPS;
use quadratura_view::{Blend, DisplayMode, Mode, Quality, Shot};

/// A program of the renderer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Program {
    /// Draws the face that owns each pixel.
    Faces,
    /// Draws an image.
    Picture {
        /// The formula of blending.
        mode: Mode,
        /// The number of photos blended per point.
        photos: u32,
        /// The display mode.
        display: DisplayMode,
        /// The quality of filtering and sampling.
        quality: Quality,
        /// True when texels are corrected for their cameras' optics; on software adapters this costs time
        /// even where the optics are neutral.
        undoes_optics: bool,
        /// True when some face is pinned to a photo; this costs registers.
        pins: bool,
        /// True when some object is an impostor.
        impostors: bool,
        /// True when texels have an agreement below 1 that matters.
        agreement: bool,
        /// True when some layer texture has a matte.
        mattes: bool,
        /// True when one sees through texels that show the sky within the outlines of the model.
        outlines: bool,
        /// True when it draws the skirts and see-through faces, blended over what is behind them; false when it draws all others.
        see_through: bool,
        /// True when it draws the numbers of see-through faces where something of them is there, instead of colours.
        numbers: bool,
        /// True when trees cast shadows on what it draws.
        shadows: bool,
        /// True when the image is drawn in linear light with 16-bit floats.
        linear: bool,
    },
}

/// What a site has that its programs must do.
#[derive(Debug, Clone, Copy)]
pub struct SiteFeatures {
    /// Whether there are optics to undo.
    pub undoes_optics: bool,
    /// Whether some face is pinned to a photo.
    pub pins: bool,
    /// Whether some object is an impostor.
    pub impostors: bool,
    /// Whether photos contradict each other.
    pub contradicted: bool,
    /// Whether some layer texture has a matte.
    pub mattes: bool,
    /// Whether some photo shows the sky within the outlines of the model.
    pub outlines: bool,
}

impl Program {
    /// Returns the program that draws a view's image.
    pub fn new(shot: &Shot, features: &SiteFeatures) -> Self {
        let SiteFeatures { undoes_optics, pins, impostors, contradicted, mattes, outlines } = *features;
        let single = match shot.display {
            DisplayMode::BestPhoto
            | DisplayMode::Group
            | DisplayMode::Layer
            | DisplayMode::Density
            | DisplayMode::Agreement => true,
            DisplayMode::Colour
            | DisplayMode::Weights
            | DisplayMode::Confidence
            | DisplayMode::Item
            | DisplayMode::Coverage
            | DisplayMode::Matte
            | DisplayMode::Provenance => false,
        };
        let mode = if single { Mode::Best } else { shot.blend.mode };
        let photos = if mode == Mode::Best { 1 } else { shot.blend.photos.clamp(1, Blend::MOST) };
        let agreement = contradicted && (shot.blend.agreement || shot.display == DisplayMode::Agreement);
        let outlines = outlines && shot.blend.agreement && shot.display == DisplayMode::Colour;
        let Shot { display, quality, linear, .. } = *shot;
        let (see_through, numbers, shadows) = (false, false, false);
        Self::Picture {
            mode,
            photos,
            display,
            quality,
            undoes_optics,
            pins,
            impostors,
            agreement,
            mattes,
            outlines,
            see_through,
            numbers,
            shadows,
            linear,
        }
    }

    /// Returns the program that draws the see-through faces of a view where something of them is there. Optics change
    /// colours alone.
    pub fn of_seen_faces(shot: &Shot, features: &SiteFeatures) -> Self {
        let shot = Shot { display: DisplayMode::Matte, quality: Quality::Preview, ..shot.clone() };
        let mut program =
            Self::new(&shot, &SiteFeatures { undoes_optics: false, ..*features }).of_see_through();
        if let Self::Picture { numbers, .. } = &mut program {
            *numbers = true;
        }
        program
    }

    /// Returns the program that draws the skirts and see-through faces of the same image, which have mattes; that of all faces
    /// where it draws faces.
    pub fn of_see_through(mut self) -> Self {
        if let Self::Picture { see_through, mattes, outlines, .. } = &mut self {
            (*see_through, *mattes, *outlines) = (true, true, false);
        }
        self
    }

    /// Returns the program of the same image with all texels as they are: nothing is behind the layers that are peeled off.
    pub fn without_outlines(mut self) -> Self {
        if let Self::Picture { outlines, .. } = &mut self {
            *outlines = false;
        }
        self
    }

    /// Returns the program of the same image in which trees cast shadows, or in which they cast none.
    pub fn with_shadows(mut self, casts: bool) -> Self {
        if let Self::Picture { shadows, .. } = &mut self {
            *shadows = casts;
        }
        self
    }

    /// Returns the format that it draws in.
    pub fn format(self) -> TextureFormat {
        match self {
            Self::Faces | Self::Picture { numbers: true, .. } => FACES,
            Self::Picture { linear: true, .. } => LINEAR,
            Self::Picture { linear: false, .. } => COLOR,
        }
    }

    /// Returns true when trees cast shadows on what it draws.
    pub fn has_shadows(self) -> bool {
        matches!(self, Self::Picture { shadows: true, .. })
    }

    /// Returns true when the program draws skirts and see-through faces.
    pub fn is_of_see_through(self) -> bool {
        matches!(self, Self::Picture { see_through: true, numbers: false, .. })
    }

    /// Returns true when the program lays its colours over what is behind them.
    pub fn blends(self) -> bool {
        self.is_of_see_through() || matches!(self, Self::Picture { outlines: true, .. })
    }

    /// Returns true when colours are filtered as stored, in sRGB.
    pub fn reads_stored(self) -> bool {
        matches!(self, Self::Picture { quality: Quality::Preview, .. })
    }
}

/// Generates the WGSL that precedes `project.wgsl`: constants, `Best`, and the functions of the display mode.
pub fn generated(program: Program) -> String {
    let Program::Picture {
        mode,
        photos,
        display,
        quality,
        undoes_optics,
        pins,
        impostors,
        agreement,
        mattes,
        outlines,
        see_through,
        numbers: _,
        shadows: _,
        linear: _,
    } = program
    else {
        return String::new();
    };
    let mut text = String::new();
    let _ = write!(
        text,
        "const BEST = 0u; const DEBEVEC = 1u; const LUMIGRAPH = 2u; const SMOOTH = 3u;\n\
         const MODE = {}u;\nconst ANISOTROPIC = {};\nconst MOST_TAPS = {MOST_TAPS:?};\nconst COUNTS_ALL = {};\n\
         const STORED = {};\nconst UNDOES_OPTICS = {undoes_optics};\nconst PINS = {pins};\n\
         const IMPOSTORS = {impostors};\n\
         const AGREEMENT = {agreement};\nconst AGREEMENT_WEIGHS = {};\n\
         const MATTES = {mattes};\nconst OUTLINES = {outlines};\nconst SEE_THROUGH = {see_through};\nconst CUT_OUT = {};\nconst CONTINUES = {};\n",
        mode as u32,
        quality.is_anisotropic(),
        // Counts and the largest confidence are over all contributing photos, not over the best.
        match display {
            DisplayMode::Coverage | DisplayMode::Confidence => true,
            DisplayMode::Colour
            | DisplayMode::Weights
            | DisplayMode::BestPhoto
            | DisplayMode::Group
            | DisplayMode::Density
            | DisplayMode::Agreement
            | DisplayMode::Layer
            | DisplayMode::Item
            | DisplayMode::Matte
            | DisplayMode::Provenance => false,
        },
        quality == Quality::Preview,
        // The agreement is shown of the photo that would be best without it: the one that is contradicted.
        agreement && display != DisplayMode::Agreement,
        see_through && !matches!(display, DisplayMode::Colour | DisplayMode::Matte),
        !see_through && matches!(display, DisplayMode::Colour | DisplayMode::Provenance),
    );
    text.push_str(&continued_color(display));
    text.push_str(shades(see_through || outlines));
    text.push_str(&slots(photos));
    text.push_str(&mixed(display, photos));
    text.push_str(&ramp_of(display).map_or(String::new(), ramp));
    text.push_str(&display_color(display));
    text.push_str(&finished(display, see_through, outlines));
    text
}

/// Generates `Shade`, what of a photo is blended: a colour; where one sees through, also the matte, whose blend is `covered`.
/// It precedes the functions of [`slots`].
fn shades(with_mattes: bool) -> &'static str {
    if with_mattes {
        "alias Shade = vec4f;\n\
         fn shade(color: vec3f, matte: f32) -> Shade { return vec4f(color, matte); }\n\
         fn color_of(shade: Shade) -> vec3f { return shade.rgb; }\n\
         fn covered(best: Best) -> f32 { return blended(best).a; }\n"
    } else {
        "alias Shade = vec3f;\n\
         fn shade(color: vec3f, matte: f32) -> Shade { return color; }\n\
         fn color_of(shade: Shade) -> vec3f { return shade; }\n\
         fn covered(best: Best) -> f32 { return 1.0; }\n"
    }
}

/// Generates `Best`: the k best penalties with their colours, rising, and the next penalty. It is unrolled
/// slot by slot, so that all of it stays in registers.
fn slots(k: u32) -> String {
    let mut text = String::from("struct Best {\n");
    for i in 0..k {
        let _ = writeln!(text, "    q{i}: f32, c{i}: Shade,");
    }
    text.push_str("    next: f32,\n}\n");
    let empty: String = (0..k).map(|_| "INFINITE, Shade(), ").collect();
    let _ = writeln!(text, "fn no_best() -> Best {{ return Best({empty}INFINITE); }}");
    text.push_str("fn is_any(best: Best) -> bool { return best.q0 < INFINITE; }\n");
    text.push_str("fn next_of(best: Best) -> f32 { return best.next; }\n");
    text.push_str("fn join(best: Best, q_in: f32, color_in: Shade) -> Best {\n");
    text.push_str(
        "    var b = best; var q = q_in; var c = color_in; var before = false; var t = 0.0; var u = c;\n",
    );
    for i in 0..k {
        let _ = writeln!(
            text,
            "    before = q < b.q{i}; t = b.q{i}; u = b.c{i}; \
             b.q{i} = select(t, q, before); b.c{i} = select(u, c, before); \
             q = select(q, t, before); c = select(c, u, before);"
        );
    }
    text.push_str("    b.next = min(b.next, q);\n    return b;\n}\n");
    // With one photo fewer, the first that is left out is the next.
    text.push_str("fn fewer(best: Best) -> Best {\n    var b = best;\n");
    if k > MOST_ON_IMPOSTORS {
        let _ = writeln!(text, "    b.next = b.q{MOST_ON_IMPOSTORS};");
    }
    for i in MOST_ON_IMPOSTORS..k {
        let _ = writeln!(text, "    b.q{i} = INFINITE;");
    }
    text.push_str("    return b;\n}\n");
    text.push_str("fn blended(b: Best) -> Shade {\n    var sum = Shade(); var weight = 0.0; var w = 0.0;\n");
    text.push_str("    var ties = 0.0; var even = Shade();\n");
    for i in 0..k {
        let _ = writeln!(
            text,
            "    if b.q{i} < INFINITE {{ w = raw_weight(b.q{i}, b.next); sum += w * b.c{i}; weight += w; \
             even += b.c{i}; ties += 1.0; }}"
        );
    }
    text.push_str("    if weight > 0.0 { return sum / weight; }\n    return even / max(ties, 1.0);\n}\n");
    text
}

/// Generates `mixed`, the colour of the best photos at a place across a stripe, and `mixed_with`, that colour or a pinned
/// photo's. Colours are blended, but for weights: there each place has the colour of one photo, and the photos' parts of
/// a stripe are as wide as their weights, so that no mixture looks like another photo.
fn mixed(display: DisplayMode, k: u32) -> String {
    if display != DisplayMode::Weights {
        return "fn mixed(b: Best, place: f32) -> vec3f { return color_of(blended(b)); }\n\
                fn mixed_with(color: vec3f, pinned: vec3f, share: f32, place: f32) -> vec3f {\n    \
                return mix(color, pinned, share);\n}\n"
            .into();
    }
    let mut text =
        String::from("fn mixed(b: Best, place: f32) -> vec3f {\n    var all = 0.0; var w = 0.0;\n");
    let raw = |i: u32| format!("select(0.0, raw_weight(b.q{i}, b.next), b.q{i} < INFINITE)");
    for i in 0..k {
        let _ = writeln!(text, "    all += {};", raw(i));
    }
    text.push_str("    if all <= 0.0 { return color_of(b.c0); }\n");
    for i in 0..k {
        let _ = writeln!(text, "    w += {} / all; if place < w {{ return color_of(b.c{i}); }}", raw(i));
    }
    text.push_str("    return color_of(b.c0);\n}\n");
    text.push_str(
        "fn mixed_with(color: vec3f, pinned: vec3f, share: f32, place: f32) -> vec3f {\n    \
         return select(color, pinned, place < share);\n}\n",
    );
    text
}

/// The WGSL of `palette`, the identifying colour of a number, see
/// [`quadratura_view::legend::colour_of_number`].
const PALETTE: &str = "fn palette(number: u32) -> vec3f {\n\
     let hue = fract(f32(number) * 0.4607);\n\
     let wheel = abs(fract(vec3f(hue) + vec3f(0.0, 0.6666667, 0.3333333)) * 6.0 - 3.0) - 1.0;\n\
     let light = 0.16 + 0.785 * fract(f32(number) * 0.7446);\n\
     let saturation = 0.5745 + 0.3955 * fract(f32(number) * 0.9868);\n\
     return mix(vec3f(0.03), clamp(wheel, vec3f(0.0), vec3f(1.0)), saturation) * light + 0.04;\n}\n";

/// Returns the colour ramp of a display mode.
fn ramp_of(display: DisplayMode) -> Option<ColourRamp> {
    match display {
        DisplayMode::Agreement => Some(AGREEMENT),
        DisplayMode::Confidence => Some(CONFIDENCE),
        DisplayMode::Coverage => Some(COVERAGE),
        DisplayMode::Density => Some(DENSITY),
        DisplayMode::Colour
        | DisplayMode::Weights
        | DisplayMode::BestPhoto
        | DisplayMode::Group
        | DisplayMode::Layer
        | DisplayMode::Item
        | DisplayMode::Matte
        | DisplayMode::Provenance => None,
    }
}

/// Generates `ramp`, the colour at a share of a ramp, see [`quadratura_view::legend::colour_at`].
fn ramp(stops: ColourRamp) -> String {
    let stop = |colour: [u8; 3]| {
        let [r, g, b] = linear(colour);
        format!("vec3f({r:?}, {g:?}, {b:?})")
    };
    let mut text = String::from("fn ramp(share: f32) -> vec3f {\n");
    let _ = writeln!(text, "    let place = clamp(share, 0.0, 1.0) * {:?};", (stops.len() - 1) as f32);
    let _ = writeln!(text, "    var color = {};", stop(stops[0]));
    for (before, colour) in stops[1..].iter().enumerate() {
        let (colour, before) = (stop(*colour), before as f32);
        let _ = writeln!(text, "    color = mix(color, {colour}, clamp(place - {before:?}, 0.0, 1.0));");
    }
    text + "    return color;\n}\n"
}

/// Generates `display_color`, which replaces a photo's colour before photos are blended.
fn display_color(display: DisplayMode) -> String {
    let color = match display {
        DisplayMode::Colour
        | DisplayMode::Confidence
        | DisplayMode::Coverage
        | DisplayMode::Item
        | DisplayMode::Matte
        | DisplayMode::Provenance => "color".into(),
        DisplayMode::Weights | DisplayMode::BestPhoto => "palette(candidate.y & 0xffffu)".into(),
        DisplayMode::Group => "palette(photos[candidate.y & 0xffffu].group)".into(),
        DisplayMode::Layer => "palette(candidate.z)".into(),
        DisplayMode::Agreement => "ramp(agreement)".into(),
        // `octaves` is the number that the photo lacks.
        DisplayMode::Density => format!("ramp(0.5 - 0.5 * octaves / {:?})", f64::from(DENSITY_OCTAVES)),
    };
    format!(
        "fn display_color(color: vec3f, candidate: vec4u, octaves: f32, agreement: f32) -> vec3f {{\n    \
         return {color};\n}}\n"
    )
}

/// Generates `continued_color`, what is shown of the light with which a surface continues: its source, where these are shown.
fn continued_color(display: DisplayMode) -> String {
    let color = match display {
        DisplayMode::Provenance => {
            let [r, g, b] = linear(CONTINUED);
            format!("vec3f({r:?}, {g:?}, {b:?})")
        }
        _ => "light".into(),
    };
    format!("fn continued_color(light: vec3f) -> vec3f {{\n    return {color};\n}}\n")
}

/// Generates `finished`, which converts the blended colour to the pixel's.
fn finished(display: DisplayMode, see_through: bool, outlines: bool) -> String {
    let color = match display {
        DisplayMode::Colour if see_through || outlines => {
            "select(vec4f(0.0), vec4f(color, matte), served > 0.0)".into()
        }
        // The colours of sources are multiplied by the matte like all texels; they are shown where it is 1/2 or more.
        DisplayMode::Provenance if see_through => "vec4f(color / matte, 1.0)".into(),
        DisplayMode::Item => "vec4f(palette(face), 1.0)".into(),
        // The last colour of the ramp, laid over its first one, which everything else has.
        DisplayMode::Matte if see_through => {
            "select(vec4f(0.0), vec4f(vec3f(matte), matte), served > 0.0)".into()
        }
        DisplayMode::Matte => {
            let [r, g, b] = linear(MATTE[0]);
            format!("vec4f({r:?}, {g:?}, {b:?}, 1.0)")
        }
        DisplayMode::Confidence => "select(UNSERVED, vec4f(ramp(confident), 1.0), served > 0.0)".into(),
        DisplayMode::Coverage => format!(
            "select(UNSERVED, vec4f(ramp(log2(max(served, 1.0)) / {:?}), 1.0), served > 0.0)",
            f64::from(COVERAGE_DOUBLINGS)
        ),
        DisplayMode::Colour
        | DisplayMode::Weights
        | DisplayMode::BestPhoto
        | DisplayMode::Group
        | DisplayMode::Density
        | DisplayMode::Agreement
        | DisplayMode::Layer
        | DisplayMode::Provenance => "select(UNSERVED, vec4f(color, 1.0), served > 0.0)".into(),
    };
    format!(
        "fn finished(color: vec3f, matte: f32, served: f32, confident: f32, face: u32) -> vec4f {{\n    \
         return {color};\n}}\n"
    )
}

/// Returns the constants and functions that are the same for all programs.
pub fn preamble() -> String {
    let flat = super::render_target::FLAT_LINEAR;
    format!("const UNSERVED = vec4f({flat}, {flat}, {flat}, 0.0);\n{PALETTE}")
}
