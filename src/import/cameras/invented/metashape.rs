//! Metashape's XML of *Export Cameras*, and its project.

#![cfg(test)]

use std::fmt::Write as _;
use std::io::Write as _;

use glam::{DMat3, DMat4, DQuat, DVec2, DVec3};

use super::{Observed, Shot, Site, Written};

/// The coefficients of the lens, in Metashape's names.
pub(in super::super) const K: [f64; 4] = [-0.05, 0.02, -0.004, 0.0015];
pub(in super::super) const P: [f64; 2] = [0.0012, -0.0007];
pub(in super::super) const B: [f64; 2] = [1.75, -2.5];

/// The motion of the camera: rotation as axis times angle, and translation in the camera's frame and the chunk's lengths.
pub(in super::super) const MOTION: [DVec3; 2] =
    [DVec3::new(0.002, -0.004, 0.001), DVec3::new(0.01, 0.002, -0.004)];

/// The chunk's place in the world, of which lengths in the chunk are the part that the scale says, and that of its component.
const SCALE: f64 = 2.5;

fn chunk_turn() -> DMat3 {
    DMat3::from_quat(DQuat::from_xyzw(0.2, -0.4, 0.1, 0.7).normalize())
}

fn chunk_shift() -> DVec3 {
    DVec3::new(10.0, -20.0, 5.0)
}

fn component() -> DMat4 {
    DMat4::from_rotation_translation(DQuat::from_rotation_z(0.3), DVec3::new(1.0, 2.0, -3.0))
}

/// Where a camera at rest shows a point of its frame: the manual's formula of the frame camera.
pub(in super::super) fn shown(shot: &Shot, point: DVec3) -> DVec2 {
    let (x, y) = (point.x / point.z, point.y / point.z);
    let r2 = x * x + y * y;
    let radial = 1.0 + K[0] * r2 + K[1] * r2.powi(2) + K[2] * r2.powi(3) + K[3] * r2.powi(4);
    let x1 = x * radial + P[0] * (r2 + 2.0 * x * x) + 2.0 * P[1] * x * y;
    let y1 = y * radial + P[1] * (r2 + 2.0 * y * y) + 2.0 * P[0] * x * y;
    let c = shot.off_middle();
    let [w, h] = shot.size.map(f64::from);
    DVec2::new(w * 0.5 + c.x + x1 * shot.f + x1 * B[0] + y1 * B[1], h * 0.5 + c.y + y1 * shot.f)
}

/// Where a camera that moves shows a point: the row whose pose shows it in that row, found by halving.
fn shown_moving(shot: &Shot, world: DVec3) -> DVec2 {
    let [_, h] = shot.size.map(f64::from);
    let [w, d] = MOTION;
    let at_row = |row: f64| {
        let time = 2.0 * row / h - 1.0;
        // Camera to world of that row: R exp(-time w), t + time R d.
        let to_world = shot.rotation.transpose() * DMat3::from_quat(DQuat::from_scaled_axis(-time * w));
        let centre = shot.centre + time * (shot.rotation.transpose() * d) * SCALE;
        shown(shot, to_world.transpose() * (world - centre))
    };
    let (mut low, mut high) = (-h, 2.0 * h);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if at_row(middle).y > middle { low = middle } else { high = middle }
    }
    at_row(low)
}

fn row_text(numbers: &[f64]) -> String {
    numbers.iter().map(|number| format!("{number:?}")).collect::<Vec<_>>().join(" ")
}

fn sensors(site: &Site) -> String {
    let mut text = String::from("<sensors next_id=\"9\">\n");
    for (id, shot) in site.shots.iter().enumerate() {
        let ([w, h], c) = (shot.size, shot.off_middle());
        write!(
            text,
            "<sensor id=\"{id}\" label=\"a camera\" type=\"frame\"><resolution width=\"{w}\" height=\"{h}\"/>\
             <calibration type=\"frame\" class=\"initial\"><resolution width=\"{w}\" height=\"{h}\"/><f>1</f></calibration>\
             <calibration type=\"frame\" class=\"adjusted\"><resolution width=\"{w}\" height=\"{h}\"/><f>{:?}</f>",
            shot.f
        )
        .unwrap();
        let values = [("cx", c.x), ("cy", c.y), ("b1", B[0]), ("b2", B[1]), ("p1", P[0]), ("p2", P[1])];
        let radial = K.iter().enumerate().map(|(i, k)| (["k1", "k2", "k3", "k4"][i], *k));
        for (name, value) in values.into_iter().chain(radial) {
            write!(text, "<{name}>{value:?}</{name}>").unwrap();
        }
        text.push_str("</calibration></sensor>\n");
    }
    text + "</sensors>\n"
}

/// The text of a chunk; `label` names the photos.
fn chunk(site: &Site, moving: bool, label: impl Fn(&Shot) -> String) -> String {
    let (turn, shift) = (chunk_turn(), chunk_shift());
    let world_from_chunk = DMat4::from_translation(shift) * DMat4::from_mat3(turn * SCALE);
    let inverse = (world_from_chunk * component()).inverse();
    let mut text = format!("<chunk label=\"Chunk 1\" enabled=\"true\">\n{}", sensors(site));
    let rows = component().transpose().to_cols_array();
    let component = DMat3::from_mat4(component());
    let of_component = row_text(&component.transpose().to_cols_array());
    write!(
        text,
        "<components active_id=\"0\"><component id=\"0\" label=\"Component 1\"><transform>\
         <rotation locked=\"false\">{of_component}</rotation><translation>{}</translation></transform></component></components>\n\
         <cameras next_id=\"9\">\n",
        row_text(&[rows[3], rows[7], rows[11]])
    )
    .unwrap();
    for (id, shot) in site.shots.iter().enumerate() {
        // A rotation alone: the chunk's scale is in its lengths.
        let rotation = DMat3::from_mat4(inverse) * SCALE * shot.rotation.transpose();
        let t = inverse.transform_point3(shot.centre);
        let r = rotation.transpose().to_cols_array();
        let rows = [r[0], r[1], r[2], t.x, r[3], r[4], r[5], t.y, r[6], r[7], r[8], t.z, 0.0, 0.0, 0.0, 1.0];
        let shutter = match moving {
            false => String::new(),
            true => {
                let turn = DMat3::from_quat(DQuat::from_scaled_axis(MOTION[0])).transpose().to_cols_array();
                format!(
                    "<rolling_shutter><rotation>{}</rotation><translation>{}</translation></rolling_shutter>",
                    row_text(&turn),
                    row_text(&MOTION[1].to_array())
                )
            }
        };
        writeln!(
            text,
            "<camera id=\"{id}\" sensor_id=\"{id}\" component_id=\"0\" label=\"{}\"><transform>{}</transform>\
             <orientation>6</orientation>{shutter}</camera>",
            label(shot),
            row_text(&rows)
        )
        .unwrap();
    }
    write!(
        text,
        "<camera id=\"77\" sensor_id=\"0\" label=\"not_aligned.jpg\"/>\n</cameras>\n<transform><rotation locked=\"true\">{}</rotation>\
         <translation locked=\"true\">{}</translation><scale locked=\"true\">{SCALE}</scale></transform>\n",
        row_text(&turn.transpose().to_cols_array()),
        row_text(&shift.to_array())
    )
    .unwrap();
    text
}

fn markers(observed: &[Observed]) -> String {
    let mut text = String::from("<markers>\n");
    let points = observed.iter().map(|it| it.point).max().unwrap_or(0);
    for point in 0..=points {
        write!(text, "<marker marker_id=\"{point}\">").unwrap();
        for it in observed.iter().filter(|it| it.point == point) {
            write!(
                text,
                "<location camera_id=\"{}\" pinned=\"true\" x=\"{:?}\" y=\"{:?}\"/>",
                it.photo, it.at.x, it.at.y
            )
            .unwrap();
        }
        text.push_str("</marker>\n");
    }
    text + "</markers>\n"
}

const HEAD: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";

/// *Export Cameras*, with the markers.
pub(in super::super) fn export(site: &Site, moving: bool) -> Written {
    let observed = site.observed(|shot, point| match moving {
        false => shown(shot, shot.see(point)),
        true => shown_moving(shot, point),
    });
    let text = format!(
        "{HEAD}<document version=\"2.0.0\">\n{}<frames><frame id=\"0\">{}</frame></frames>\n</chunk>\n</document>\n",
        chunk(site, moving, |shot| shot.name.clone()),
        markers(&observed)
    );
    Written::one("cameras.xml", text, observed)
}

/// A project: photos by their paths on another machine, and labels without endings.
pub(in super::super) fn project(site: &Site) -> Written {
    let observed = site.observed(|shot, point| shown(shot, shot.see(point)));
    let label = |shot: &Shot| shot.name.split('.').next().unwrap().to_owned();
    let chunk = format!(
        "{HEAD}{}<frames next_id=\"1\"><frame id=\"0\" path=\"0/frame.zip\"/></frames></chunk>\n",
        chunk(site, false, label)
    );
    let photos: String = site
        .shots
        .iter()
        .enumerate()
        .map(|(id, shot)| {
            format!("<camera camera_id=\"{id}\"><photo path=\"D:\\site\\photos\\{}\"/></camera>\n", shot.name)
        })
        .collect();
    let frame = format!("{HEAD}<frame><cameras>\n{photos}</cameras>\n{}</frame>\n", markers(&observed));
    let project = format!(
        "{HEAD}<document><chunks next_id=\"1\"><chunk id=\"0\" path=\"0/chunk.zip\"/></chunks></document>"
    );
    let psx = format!("{HEAD}<document version=\"1.2.0\" path=\"{{projectname}}.files/project.zip\"/>\n");
    let files = vec![
        ("site.psx".to_owned(), psx.into_bytes()),
        ("site.files/project.zip".to_owned(), zipped(&project)),
        ("site.files/0/chunk.zip".to_owned(), zipped(&chunk)),
        ("site.files/0/0/frame.zip".to_owned(), zipped(&frame)),
    ];
    Written { files, observed }
}

/// An archive with this `doc.xml`.
pub(in super::super) fn zipped(text: &str) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    zip.start_file("doc.xml", zip::write::SimpleFileOptions::default()).unwrap();
    zip.write_all(text.as_bytes()).unwrap();
    zip.finish().unwrap().into_inner()
}
