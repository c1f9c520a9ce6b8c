//! Photos that another program's cameras name and the folder lacks: the project is made of the others, and that is said.

use std::fs;

use serde_json::{Value, json};

use super::site::{Site, json_of, stderr_of};

/// The photos of the folder, and the one that only the cameras know, in a row along x and a unit apart; all look along z.
const THERE: [&str; 2] = ["left.png", "right.png"];
const NAMED: [&str; 3] = ["left.png", "right.png", "gone.png"];

/// Cameras of a program: how the format is called here, the files, and what `--cameras` is given.
struct Written {
    format: &'static str,
    files: Vec<(String, String)>,
    cameras: &'static str,
}

impl Written {
    fn one(format: &'static str, cameras: &'static str, text: String) -> Self {
        Self { format, files: vec![(cameras.to_owned(), text)], cameras }
    }
}

/// Returns a text for each photo with its place in the row.
fn each(text: impl Fn(usize, &str) -> String) -> String {
    NAMED.iter().enumerate().map(|(x, name)| text(x, name)).collect()
}

fn every(value: impl Fn(usize, &str) -> Value) -> Value {
    NAMED.iter().enumerate().map(|(x, name)| value(x, name)).collect()
}

fn metashape() -> Written {
    let cameras = each(|x, name| {
        let label = name.trim_end_matches(".png");
        format!(
            "<camera id=\"{x}\" sensor_id=\"0\" label=\"{label}\"><transform>1 0 0 {x} 0 1 0 0 0 0 1 0 0 0 0 1</transform></camera>"
        )
    });
    let text = format!(
        "<?xml version=\"1.0\"?><document version=\"2.0.0\"><chunk label=\"all\"><sensors>\
         <sensor id=\"0\" type=\"frame\"><calibration type=\"frame\" class=\"adjusted\">\
         <resolution width=\"160\" height=\"120\"/><f>160</f></calibration></sensor></sensors>\
         <cameras>{cameras}</cameras></chunk></document>"
    );
    Written::one("Metashape", "cameras.xml", text)
}

fn realityscan_table() -> Written {
    let head = "#name,x,y,alt,heading,pitch,roll,f,px,py,k1,k2,k3,k4,t1,t2\n".to_owned();
    let rows = each(|x, name| format!("{name},{x},0,0,180,0,180,36,0,0,0,0,0,0,0,0\n"));
    Written::one("RealityScan's table", "cameras.csv", head + &rows)
}

fn realityscan_xmp() -> Written {
    let file = |(x, name): (usize, &&str)| {
        let text = format!(
            "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\
             <rdf:Description xmlns:xcr=\"http://www.capturingreality.com/ns/xcr/1.1#\" xcr:DistortionModel=\"brown3\" \
             xcr:FocalLength35mm=\"36\" xcr:PrincipalPointU=\"0\" xcr:PrincipalPointV=\"0\">\
             <xcr:Rotation>1 0 0 0 1 0 0 0 1</xcr:Rotation><xcr:Position>{x} 0 0</xcr:Position>\
             <xcr:DistortionCoeficients>0 0 0 0 0 0</xcr:DistortionCoeficients></rdf:Description></rdf:RDF></x:xmpmeta>\n"
        );
        (format!("photos/{}", name.replace(".png", ".xmp")), text)
    };
    let files = NAMED.iter().enumerate().map(file).collect();
    Written { format: "RealityScan's metadata", files, cameras: "photos" }
}

fn meshroom() -> Written {
    let id = |x: usize| (1000 + x).to_string();
    let view = |x: usize, name: &str| {
        json!({
            "viewId": id(x), "poseId": id(x), "intrinsicId": "1", "path": format!("D:/site/photos/{name}"),
            "width": "160", "height": "120",
        })
    };
    let pose = |x: usize, _: &str| {
        let rotation = ["1", "0", "0", "0", "1", "0", "0", "0", "1"];
        let transform = json!({"rotation": rotation, "center": [x.to_string(), "0", "0"]});
        json!({"poseId": id(x), "pose": {"transform": transform, "locked": "0"}})
    };
    let text = json!({
        "version": ["1", "2", "6"],
        "views": every(view),
        "intrinsics": [{
            "intrinsicId": "1", "width": "160", "height": "120", "sensorWidth": "36", "type": "radial3",
            "pixelRatio": "1", "focalLength": "36", "principalPoint": ["0", "0"], "distortionParams": ["0", "0", "0"],
        }],
        "poses": every(pose),
    });
    Written::one("Meshroom", "cameras.sfm", text.to_string())
}

fn opensfm() -> Written {
    let shots = NAMED.iter().enumerate().map(|(x, name)| {
        let shot = json!({"rotation": [0, 0, 0], "translation": [-(x as i32), 0, 0], "camera": "1"});
        ((*name).to_owned(), shot)
    });
    let shots: serde_json::Map<String, Value> = shots.collect();
    let camera =
        json!({"projection_type": "perspective", "width": 160, "height": 120, "focal": 1, "k1": 0, "k2": 0});
    let text = json!([{"cameras": {"1": camera}, "shots": shots, "points": {}}]);
    Written::one("OpenSfM", "reconstruction.json", text.to_string())
}

fn openmvg() -> Written {
    let view = |x: usize, name: &str| {
        let data = json!({
            "local_path": "", "filename": name, "width": 160, "height": 120,
            "id_view": x, "id_intrinsic": 0, "id_pose": x,
        });
        json!({"key": x, "value": {"polymorphic_id": 1073741824, "ptr_wrapper": {"id": 1, "data": data}}})
    };
    let pose = |x: usize, _: &str| {
        let rotation = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
        json!({"key": x, "value": {"rotation": rotation, "center": [x, 0, 0]}})
    };
    let lens = json!({
        "width": 160, "height": 120, "focal_length": 160, "principal_point": [80, 60], "disto_k3": [0, 0, 0],
    });
    let text = json!({
        "sfm_data_version": "0.3", "root_path": "photos of somebody",
        "views": every(view),
        "intrinsics": [{"key": 0, "value": {
            "polymorphic_id": 2147483649u32, "polymorphic_name": "pinhole_radial_k3", "ptr_wrapper": {"id": 1, "data": lens},
        }}],
        "extrinsics": every(pose), "structure": [], "control_points": [],
    });
    Written::one("OpenMVG", "sfm_data.json", text.to_string())
}

fn visualsfm() -> Written {
    let photos = each(|x, name| format!("{name}\t160 1 0 0 0 {x} 0 0 0 0\n"));
    Written::one("VisualSFM", "site.nvm", format!("NVM_V3 \n\n3\n{photos}\n0\n\n0\n"))
}

/// The site with cameras of another program.
fn site_with(written: &Written) -> Site {
    let site = Site::with_photos(&THERE, 160, 120, 1);
    written.files.iter().for_each(|(name, text)| fs::write(site.path(name), text).unwrap());
    site
}

#[test]
fn a_project_is_made_of_the_photos_that_are_there_whatever_program_named_the_others() {
    for written in
        [metashape(), realityscan_table(), realityscan_xmp(), meshroom(), opensfm(), openmvg(), visualsfm()]
    {
        let (site, format) = (site_with(&written), written.format);
        let new =
            format!("new project --photos photos --cameras {} --model model.obj --json", written.cameras);
        // One photo could not be had, which the exit status says.
        let made = site.run(&new).code(1);
        let (report, said) = (json_of(&made), stderr_of(&made));
        assert_eq!(report["photos"], 2, "{format}: {report}");
        let left_out = report["left_out"].to_string();
        assert!(
            left_out.contains("gone") && left_out.contains(" there, or give the folder"),
            "{format}: {left_out}"
        );
        assert!(said.contains("gone") && !said.contains("panicked"), "{format}: {said}");
        assert!(!said.contains("left.png") && !said.contains("right.png"), "{format}: {said}");
        let info = json_of(&site.run("info project --json").code(1));
        let photos = info["photos"].as_array().unwrap().iter();
        let taken = photos.filter(|photo| photo["state"] != "left out").count();
        assert_eq!(taken, 2, "{format}: {info}");
    }
}

#[test]
fn a_file_of_one_photo_that_is_not_there_makes_no_project_and_says_which() {
    let site = Site::with_photos(&THERE, 160, 120, 1);
    let rows = [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]];
    let state = json!({"cameraParameters": {
        "principalPoint": {"x": 0, "y": 0}, "relativeFocalLength": 2, "imageWidth": 160, "imageHeight": 120,
        "cameraTransform": {"rows": rows},
    }});
    let state = state.to_string();
    let numbers = [1u32, state.len() as u32, 3].map(u32::to_le_bytes).concat();
    let bytes = [b"fspy", &numbers[..], state.as_bytes(), b"PNG"].concat();
    fs::write(site.path("left.fspy"), &bytes).unwrap();
    fs::write(site.path("gone.fspy"), &bytes).unwrap();
    site.run("new one --photos photos --cameras left.fspy --model model.obj").success();
    let refused =
        stderr_of(&site.run("new none --photos photos --cameras gone.fspy --model model.obj").code(1));
    assert!(refused.contains("gone") && !site.path("none").exists(), "{refused}");
}
