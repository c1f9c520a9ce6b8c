//! RealityScan's, Meshroom's, OpenSfM's, OpenMVG's, VisualSFM's and fSpy's files.

#![cfg(test)]

use std::fmt::Write as _;

use glam::{DMat3, DQuat, DVec2, DVec3};
use serde_json::{Value, json};

use super::{Observed, Shot, Site, Written};

pub(in super::super) const K: [f64; 3] = [-0.06, 0.015, -0.003];
pub(in super::super) const P: [f64; 2] = [0.0011, -0.0006];

/// Brown's model as OpenCV's documentation has it.
fn opencv(x: f64, y: f64, k: [f64; 3], p: [f64; 2]) -> DVec2 {
    let r2 = x * x + y * y;
    let radial = 1.0 + k[0] * r2 + k[1] * r2 * r2 + k[2] * r2 * r2 * r2;
    DVec2::new(
        x * radial + 2.0 * p[0] * x * y + p[1] * (r2 + 2.0 * x * x),
        y * radial + p[0] * (r2 + 2.0 * y * y) + 2.0 * p[1] * x * y,
    )
}

pub(super) fn pinhole(shot: &Shot, bent: DVec2) -> DVec2 {
    bent * shot.f + DVec2::from(shot.centre_px)
}

pub(super) fn plane(shot: &Shot, point: DVec3) -> DVec2 {
    let seen = shot.see(point);
    DVec2::new(seen.x / seen.z, seen.y / seen.z)
}

pub(super) fn brown(site: &Site, k: [f64; 3], p: [f64; 2]) -> Vec<Observed> {
    site.observed(|shot, point| {
        let at = plane(shot, point);
        pinhole(shot, opencv(at.x, at.y, k, p))
    })
}

/// A file of RealityScan beside each photo, with attributes or elements.
pub(in super::super) fn xmp(site: &Site, model: &str, elements: bool) -> Written {
    let coefficients = match model {
        "division" => "-0.05 0 0 0 0 0".to_owned(),
        _ => format!("{:?} {:?} {:?} 0 {:?} {:?}", K[0], K[1], K[2], P[0], P[1]),
    };
    let file = |shot: &Shot| {
        let (m, c) = (shot.longer_side(), shot.off_middle());
        let values = [
            ("DistortionModel", model.to_owned()),
            ("FocalLength35mm", format!("{:?}", shot.f * 36.0 / m)),
            ("Skew", "0".to_owned()),
            ("AspectRatio", "1".to_owned()),
            ("PrincipalPointU", format!("{:?}", c.x / m)),
            ("PrincipalPointV", format!("{:?}", c.y / m)),
        ];
        let attributes: String = match elements {
            true => String::new(),
            false => values.iter().map(|(name, value)| format!(" xcr:{name}=\"{value}\"")).collect(),
        };
        let below: String = match elements {
            true => values.iter().map(|(name, value)| format!("<xcr:{name}>{value}</xcr:{name}>")).collect(),
            false => String::new(),
        };
        let rows: Vec<String> = shot.rows().iter().map(|value| format!("{value:?}")).collect();
        let text = format!(
            "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\
             <rdf:Description xmlns:xcr=\"http://www.capturingreality.com/ns/xcr/1.1#\"{attributes}>{below}\
             <xcr:Rotation>{}</xcr:Rotation><xcr:Position>{:?} {:?} {:?}</xcr:Position>\
             <xcr:DistortionCoeficients>{coefficients}</xcr:DistortionCoeficients></rdf:Description></rdf:RDF></x:xmpmeta>\n",
            rows.join(" "),
            shot.centre.x,
            shot.centre.y,
            shot.centre.z
        );
        (shot.name.replace(".jpg", ".xmp"), text.into_bytes())
    };
    let observed = match model {
        "division" => site.observed(|shot, point| {
            let at = plane(shot, point);
            pinhole(shot, at * 2.0 / (1.0 + (1.0 + 0.2 * at.length_squared()).sqrt()))
        }),
        _ => brown(site, K, P),
    };
    Written { files: site.shots.iter().map(file).collect(), observed }
}

/// RealityScan's table. Heading, pitch and roll are those whose product, as documented, is the camera's.
pub(in super::super) fn table(site: &Site) -> Written {
    let mut text = format!(
        "#cameras {}\n#name,x,y,alt,heading,pitch,roll,f,px,py,k1,k2,k3,k4,t1,t2\n",
        site.shots.len()
    );
    for shot in &site.shots {
        let (m, c, centre) = (shot.longer_side(), shot.off_middle(), shot.centre);
        // Camera to world with y up and looking along -z: Rz(-h) Rx(p) Ry(r) has sin p at row 2, column 1.
        let gl = shot.rotation.transpose() * DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0));
        let at = |row: usize, column: usize| gl.col(column)[row];
        let level = at(0, 1).hypot(at(1, 1));
        let pitch = at(2, 1).atan2(level);
        // A level camera has a pitch of 90 degrees, where heading and roll are one angle.
        let (heading, roll) = match level < 1e-9 {
            true => ((-at(1, 0)).atan2(at(0, 0)), 0.0),
            false => (at(0, 1).atan2(at(1, 1)), (-at(2, 0)).atan2(at(2, 2))),
        };
        let angles = [heading, pitch, roll].map(f64::to_degrees);
        writeln!(
            text,
            "{},{:?},{:?},{:?},{:?},{:?},{:?},{:?},{:?},{:?},{:?},{:?},{:?},0,{:?},{:?}",
            shot.name,
            centre.x,
            centre.y,
            centre.z,
            angles[0],
            angles[1],
            angles[2],
            shot.f * 36.0 / m,
            c.x / m,
            c.y / m,
            K[0],
            K[1],
            K[2],
            P[0],
            P[1]
        )
        .unwrap();
    }
    Written::one("cameras.csv", text, brown(site, K, P))
}

fn texts(values: &[f64]) -> Value {
    values.iter().map(|value| json!(format!("{value:?}"))).collect()
}

/// Meshroom's file with radial3 or brown.
pub(in super::super) fn meshroom(site: &Site, model: &str) -> Written {
    const SENSOR: f64 = 23.5;
    let (parameters, p) = match model {
        "radial3" => (texts(&K), [0.0; 2]),
        _ => (texts(&[K[0], K[1], K[2], P[0], P[1]]), P),
    };
    let observed = brown(site, K, p);
    let id = |index: usize| (1000 + index).to_string();
    let view = |(index, shot): (usize, &Shot)| {
        json!({
            "viewId": id(index), "poseId": id(index), "intrinsicId": id(index), "frameId": index.to_string(),
            "path": format!("D:/a site/photos/{}", shot.name),
            "width": shot.size[0].to_string(), "height": shot.size[1].to_string(),
        })
    };
    let intrinsic = |(index, shot): (usize, &Shot)| {
        let c = shot.off_middle();
        json!({
            "intrinsicId": id(index), "width": shot.size[0].to_string(), "height": shot.size[1].to_string(),
            "sensorWidth": SENSOR.to_string(), "type": model, "pixelRatio": "1",
            "focalLength": format!("{:?}", shot.f * SENSOR / f64::from(shot.size[0])),
            "principalPoint": texts(&[c.x, c.y]), "distortionParams": parameters,
        })
    };
    let pose = |(index, shot): (usize, &Shot)| {
        // By columns.
        let rotation = texts(&shot.rotation.to_cols_array());
        json!({"poseId": id(index), "pose": {"transform": {"rotation": rotation, "center": texts(&shot.centre.to_array())}, "locked": "0"}})
    };
    let landmark = |(index, (position, _)): (usize, &(DVec3, Vec<usize>))| {
        let seen = observed.iter().filter(|it| it.point == index);
        let seen = seen.map(
            |it| json!({"observationId": id(it.photo), "featureId": "0", "x": texts(&it.at.to_array())}),
        );
        json!({"landmarkId": index.to_string(), "X": texts(&position.to_array()), "observations": seen.collect::<Vec<_>>()})
    };
    let mut views: Vec<Value> = site.shots.iter().enumerate().map(view).collect();
    views.push(json!({"viewId": "7", "poseId": "7", "intrinsicId": "1000", "path": "D:/a site/photos/not registered.jpg"}));
    // In the order of the program, which has no other than that of a list.
    let parts = [
        ("version", json!(["1", "2", "6"])),
        ("views", json!(views)),
        ("intrinsics", site.shots.iter().enumerate().map(intrinsic).collect()),
        ("poses", site.shots.iter().enumerate().map(pose).collect()),
        ("structure", site.points.iter().enumerate().map(landmark).collect()),
    ];
    let parts: Vec<String> = parts.iter().map(|(key, list)| format!("\"{key}\": {list:#}")).collect();
    let whole = format!("{{\n{}\n}}\n", parts.join(",\n"));
    Written::one("cameras.sfm", whole, observed)
}

/// OpenSfM's reconstruction and tracks, with the camera *brown*.
pub(in super::super) fn opensfm(site: &Site) -> Written {
    let observed = brown(site, K, P);
    let (mut cameras, mut shots, mut points) = (json!({}), json!({}), json!({}));
    let mut tracks = String::from("OPENSFM_TRACKS_VERSION_v2\n");
    for (index, shot) in site.shots.iter().enumerate() {
        let (m, c) = (shot.longer_side(), shot.off_middle());
        let axis = DQuat::from_mat3(&shot.rotation).to_scaled_axis();
        let translation = -(shot.rotation * shot.centre);
        cameras[index.to_string()] = json!({
            "projection_type": "brown", "width": shot.size[0], "height": shot.size[1],
            "focal_x": shot.f / m, "focal_y": shot.f / m, "c_x": c.x / m, "c_y": c.y / m,
            "k1": K[0], "k2": K[1], "k3": K[2], "p1": P[0], "p2": P[1],
        });
        shots[&shot.name] = json!({
            "rotation": axis.to_array(), "translation": translation.to_array(), "camera": index.to_string(), "orientation": 1,
        });
    }
    for (index, (position, _)) in site.points.iter().enumerate() {
        points[index.to_string()] = json!({"coordinates": position.to_array(), "color": [1, 2, 3]});
    }
    for it in &observed {
        let shot = &site.shots[it.photo];
        let at = (it.at - shot.middle()) / shot.longer_side();
        writeln!(tracks, "{}\t{}\t0\t{:?}\t{:?}\t0.001\t1\t2\t3\t-1\t-1", shot.name, it.point, at.x, at.y)
            .unwrap();
    }
    let small = json!({"cameras": {}, "shots": {}, "points": {}});
    let whole = json!([{"cameras": cameras, "shots": shots, "points": points}, small]);
    let files = vec![
        ("reconstruction.json".to_owned(), format!("{whole:#}").into_bytes()),
        ("tracks.csv".to_owned(), tracks.into_bytes()),
    ];
    Written { files, observed }
}

/// OpenMVG's file with a lens `disto_k3`, `disto_t2` or `fisheye`.
pub(in super::super) fn openmvg(site: &Site, lens: &str) -> Written {
    const FISHEYE: [f64; 4] = [0.01, -0.004, 0.002, -0.0005];
    let observed = match lens {
        "fisheye" => site.observed(|shot, point| {
            let at = plane(shot, point);
            let theta = at.length().atan();
            let powers =
                theta + FISHEYE.iter().zip([3, 5, 7, 9]).map(|(k, n)| k * theta.powi(n)).sum::<f64>();
            pinhole(shot, at * (powers / at.length()))
        }),
        "disto_t2" => brown(site, K, P),
        _ => brown(site, K, [0.0; 2]),
    };
    let coefficients = match lens {
        "fisheye" => json!(FISHEYE),
        "disto_t2" => json!([K[0], K[1], K[2], P[0], P[1]]),
        _ => json!(K),
    };
    let pair = |(index, value): (usize, Value)| json!({"key": index, "value": value});
    let view = |(index, shot): (usize, &Shot)| {
        pair((
            index,
            json!({"polymorphic_id": 1073741824, "ptr_wrapper": {"id": 2147483649u32, "data": {
                "local_path": "", "filename": shot.name, "width": shot.size[0], "height": shot.size[1],
                "id_view": index, "id_intrinsic": index, "id_pose": index,
            }}}),
        ))
    };
    let intrinsic = |(index, shot): (usize, &Shot)| {
        let mut data = json!({
            "width": shot.size[0], "height": shot.size[1], "focal_length": shot.f, "principal_point": shot.centre_px,
        });
        data[lens] = coefficients.clone();
        pair((index, json!({"polymorphic_id": 1, "ptr_wrapper": {"id": index, "data": data}})))
    };
    let extrinsic = |(index, shot): (usize, &Shot)| {
        let rows = shot.rows();
        pair((
            index,
            json!({"rotation": [rows[..3], rows[3..6], rows[6..]], "center": shot.centre.to_array()}),
        ))
    };
    let landmark = |(index, (position, _)): (usize, &(DVec3, Vec<usize>))| {
        let seen = observed.iter().filter(|it| it.point == index);
        let seen = seen.map(|it| pair((it.photo, json!({"id_feat": 0, "x": it.at.to_array()}))));
        pair((index, json!({"X": position.to_array(), "observations": seen.collect::<Vec<_>>()})))
    };
    let shots = || site.shots.iter().enumerate();
    let whole = json!({
        "sfm_data_version": "0.3", "root_path": "photos of somebody",
        "views": shots().map(view).collect::<Vec<_>>(),
        "intrinsics": shots().map(intrinsic).collect::<Vec<_>>(),
        "extrinsics": shots().map(extrinsic).collect::<Vec<_>>(),
        "structure": site.points.iter().enumerate().map(landmark).collect::<Vec<_>>(),
        "control_points": [],
    });
    Written::one("sfm_data.json", format!("{whole:#}"), observed)
}

/// An `.nvm` as VisualSFM writes it, or as COLMAP does. The principal point is in the middle: photos without are left out.
pub(in super::super) fn nvm(site: &Site, of_colmap: bool) -> (Site, Written) {
    const R: f64 = 0.06;
    let keep: Vec<usize> =
        (0..site.shots.len()).filter(|&index| site.shots[index].off_middle() == DVec2::ZERO).collect();
    let mut kept = Site {
        shots: keep.iter().map(|&index| site.shots[index].clone()).collect(),
        points: site.points.clone(),
    };
    for (_, photos) in &mut kept.points {
        *photos = photos.iter().filter_map(|photo| keep.iter().position(|index| index == photo)).collect();
    }
    let observed = kept.observed(|shot, point| {
        let at = plane(shot, point);
        let r2 = at.length_squared();
        if of_colmap {
            // COLMAP's SIMPLE_RADIAL with k = -r.
            return pinhole(shot, at * (1.0 - R * r2));
        }
        // The measured distance d with d (1 + R d^2) = r, by halving.
        let (mut low, mut high, r) = (0.0f64, r2.sqrt(), r2.sqrt());
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if middle * (1.0 + R * middle * middle) < r { low = middle } else { high = middle }
        }
        pinhole(shot, if r == 0.0 { at } else { at * (low / r) })
    });
    let mut text = format!("NVM_V3 \n\n{}\n", kept.shots.len());
    for shot in &kept.shots {
        let (q, c) = (DQuat::from_mat3(&shot.rotation), shot.centre);
        writeln!(
            text,
            "{}\t{:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?} {R} 0",
            shot.name, shot.f, q.w, q.x, q.y, q.z, c.x, c.y, c.z
        )
        .unwrap();
    }
    writeln!(text, "\n{}", kept.points.len()).unwrap();
    for (index, (p, _)) in kept.points.iter().enumerate() {
        let seen: Vec<String> = observed
            .iter()
            .filter(|it| it.point == index)
            .map(|it| {
                let at = if of_colmap { it.at } else { it.at - kept.shots[it.photo].middle() };
                format!("{} 0 {:?} {:?}", it.photo, at.x, at.y)
            })
            .collect();
        writeln!(text, "{:?} {:?} {:?} 1 2 3 {} {}", p.x, p.y, p.z, seen.len(), seen.join(" ")).unwrap();
    }
    text.push_str("\n0\n");
    let written = Written::one("site.nvm", text, observed);
    (kept, written)
}

/// A project of fSpy for one photo.
pub(in super::super) fn fspy(site: &Site, index: usize) -> (Site, Written) {
    let shot = site.shots[index].clone();
    let (half, c) = (0.5 * shot.longer_side(), shot.off_middle());
    let gl = shot.rotation.transpose() * DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0));
    let row = |row: usize| json!([gl.x_axis[row], gl.y_axis[row], gl.z_axis[row], shot.centre[row]]);
    let state = json!({"globalSettings": {}, "cameraParameters": {
        "principalPoint": {"x": c.x / half, "y": -c.y / half},
        "relativeFocalLength": shot.f / half, "imageWidth": shot.size[0], "imageHeight": shot.size[1],
        "cameraTransform": {"rows": [row(0), row(1), row(2), json!([0.0, 0.0, 0.0, 1.0])]},
    }});
    let state = state.to_string();
    let numbers = [1u32, state.len() as u32, 3].map(u32::to_le_bytes).concat();
    let bytes = [b"fspy", &numbers[..], state.as_bytes(), b"JPG"].concat();
    let name = shot.name.replace(".jpg", ".fspy");
    let points = site.points.iter().filter(|(_, photos)| photos.contains(&index));
    let site = Site { points: points.map(|(point, _)| (*point, vec![0])).collect(), shots: vec![shot] };
    let observed = site.observed(|shot, point| pinhole(shot, plane(shot, point)));
    let written = Written { files: vec![(name, bytes)], observed };
    (site, written)
}
