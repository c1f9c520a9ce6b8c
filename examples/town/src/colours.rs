//! Procedural colours of surfaces. Patterns fade where a pixel covers more than their detail, so that photos from near and far agree.

use glam::{DVec2, DVec3, dvec2};

use crate::houses::{STOREY, Surface};

/// What a surface is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Material {
    /// The paving of streets and courtyards.
    Cobbles,
    /// A plastered wall with windows and a door.
    Facade,
    /// A plastered wall without windows.
    Plaster,
    /// A roof.
    Tiles,
    /// A column.
    Stone,
}

/// Returns the colour of a surface at a point, linear, without light. `footprint`: what a pixel covers there, in metres.
pub fn albedo(surface: &Surface, point: DVec3, footprint: f64) -> DVec3 {
    let offset = point - surface.origin;
    let place = dvec2(offset.dot(surface.axes[0]), offset.dot(surface.axes[1]));
    let Surface { material, seed, .. } = *surface;
    let grain = |size: f64| noise(place / size, seed ^ size.to_bits()) * detail(size, footprint);
    match material {
        Material::Cobbles => {
            let stone = edges(place, dvec2(0.22, 0.14), 0.02, footprint);
            DVec3::new(0.30, 0.29, 0.27)
                * (1.0 - 0.45 * stone)
                * (1.0 + 0.25 * grain(2.7) + 0.3 * grain(0.19))
        }
        Material::Facade => facade(surface, place, footprint),
        Material::Plaster => hue(seed >> 8) * (1.0 + plaster(&grain)),
        Material::Tiles => {
            let rows = edges(place, dvec2(0.18, 0.33), 0.03, footprint);
            let tone = DVec3::new(0.36, 0.15, 0.10).lerp(DVec3::new(0.22, 0.18, 0.17), unit(hash(seed, 3)));
            tone * (1.0 - 0.4 * rows) * (1.0 + 0.3 * grain(0.25) + 0.2 * grain(1.9))
        }
        Material::Stone => {
            DVec3::new(0.45, 0.43, 0.39) * (1.0 + 0.3 * grain(0.06) + 0.25 * grain(0.35) + 0.15 * grain(1.3))
        }
    }
}

fn plaster(grain: &impl Fn(f64) -> f64) -> f64 {
    0.12 * grain(3.1) + 0.14 * grain(0.8) + 0.12 * grain(0.21) + 0.1 * grain(0.05)
}

/// A wall with a row of windows per storey; one place on the ground floor has a door.
fn facade(surface: &Surface, place: DVec2, footprint: f64) -> DVec3 {
    let seed = surface.seed;
    let grain = |size: f64| noise(place / size, seed ^ size.to_bits()) * detail(size, footprint);
    let wall = hue(seed >> 8) * (1.0 + plaster(&grain));
    let columns = (surface.width / 2.6).floor().max(1.0);
    let pitch = surface.width / columns;
    let [column, storey] = [(place.x / pitch).floor(), (place.y / STOREY).floor()];
    let centre = dvec2((column + 0.5) * pitch, (storey + 0.55) * STOREY);
    let door = storey == 0.0 && column == (unit(hash(seed, 1)) * columns).floor();
    let (half, centre) =
        if door { (dvec2(0.6, 1.15), dvec2(centre.x, 1.15)) } else { (dvec2(0.5, 0.8), centre) };
    let away = (place - centre).abs() - half;
    let frame = inside(away - 0.14, footprint);
    let opening = inside(away, footprint);
    let own = hash(seed ^ column.to_bits().rotate_left(17), storey.to_bits());
    let trim = DVec3::new(0.55, 0.53, 0.48) * (1.0 + 0.2 * grain(0.12));
    let glass = if door {
        DVec3::new(0.16, 0.10, 0.06) * (1.0 + 0.35 * grain(0.09))
    } else {
        let bars = edges(place - centre, dvec2(0.5, 0.55), 0.05, footprint);
        let pane = DVec3::new(0.05, 0.07, 0.09) * (0.6 + unit(own)) * (1.0 + 0.3 * grain(0.4));
        pane.lerp(DVec3::splat(0.5), bars)
    };
    wall.lerp(trim, frame).lerp(glass, opening)
}

/// The colour of a house's plaster.
fn hue(seed: u64) -> DVec3 {
    let tones =
        [[0.52, 0.40, 0.24], [0.55, 0.48, 0.38], [0.46, 0.30, 0.22], [0.40, 0.42, 0.36], [0.58, 0.52, 0.46]];
    let tone = DVec3::from_array(tones[(hash(seed, 5) % 5) as usize]);
    tone * (0.85 + 0.3 * unit(hash(seed, 6)))
}

/// How much of a pattern of this size is left in a pixel of this footprint: all where it is four times as large, nothing below one.
fn detail(size: f64, footprint: f64) -> f64 {
    ((size / footprint - 1.0) / 3.0).clamp(0.0, 1.0)
}

/// How much of a pixel lies inside of a rectangle: `away` is the signed distance from its sides.
fn inside(away: DVec2, footprint: f64) -> f64 {
    let share = |away: f64| (0.5 - away / footprint).clamp(0.0, 1.0);
    share(away.x) * share(away.y)
}

/// How much of a pixel lies on the joints of a grid of cells, which have this width.
fn edges(place: DVec2, cell: DVec2, width: f64, footprint: f64) -> f64 {
    let share = |place: f64, cell: f64| {
        let to_joint = (place / cell - (place / cell).round()).abs() * cell;
        let sharp = (0.5 - (to_joint - 0.5 * width) / footprint.max(0.3 * width)).clamp(0.0, 1.0);
        let mean = (width / cell).min(1.0);
        mean + (sharp - mean) * detail(cell, footprint)
    };
    let (x, y) = (share(place.x, cell.x), share(place.y, cell.y));
    x + y - x * y
}

/// Smooth noise between -1 and 1 with one value per unit square.
fn noise(place: DVec2, seed: u64) -> f64 {
    let cell = place.floor();
    let within = place - cell;
    let smooth = within * within * (DVec2::splat(3.0) - 2.0 * within);
    let at = |x: f64, y: f64| {
        let [x, y] = [cell.x + x, cell.y + y].map(|cell| cell as i64 as u64);
        2.0 * unit(hash(seed ^ x.wrapping_mul(0x9e37_79b9_7f4a_7c15), y)) - 1.0
    };
    let row = |y: f64| at(0.0, y) + (at(1.0, y) - at(0.0, y)) * smooth.x;
    row(0.0) + (row(1.0) - row(0.0)) * smooth.y
}

/// Returns bits that depend on both numbers.
pub fn hash(a: u64, b: u64) -> u64 {
    let mut bits = a ^ b.wrapping_mul(0xd6e8_feb8_6659_fd93);
    bits = (bits ^ (bits >> 32)).wrapping_mul(0xd6e8_feb8_6659_fd93);
    bits = (bits ^ (bits >> 29)).wrapping_mul(0xa24b_aed4_963e_e407);
    bits ^ (bits >> 32)
}

/// Returns bits as a number in [0, 1).
pub fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 * 0.5_f64.powi(53)
}
