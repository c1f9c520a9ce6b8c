//! The command `formats`: which files of other programs are read and written.

use std::fmt::Write as _;

use serde_json::json;

use super::Outcome;
use quadratura_import::cameras;

/// A format: its files, what is kept of them, and what is lost.
type Row = [&'static str; 3];

const PHOTOS: [Row; 1] = [[
    "JPEG, PNG, TIFF and WebP, in sub-folders too",
    "8 and 16 bits, alpha, RGB profile, exposure of the EXIF",
    "CMYK, gamma and cICP are not applied; pages and frames behind the first",
]];
const MODELS: [Row; 2] = [
    ["OBJ", "polygons of any number of corners, holes, objects and groups", "materials, textures, normals"],
    [
        "glTF and GLB",
        "meshes with their nodes, joined to polygons again",
        "materials, textures, skins, animations; compressed geometry",
    ],
];
const TEXTURED: [Row; 3] = [
    [
        "GLB (glTF 2.0 in one file)",
        "objects, polygons as counts of their triangles, one set of textures, unlit; tried with Blender and Khronos' validator",
        "what depends on the view: highlights, surroundings, trees; image layers; lens shift of cameras",
    ],
    [
        "OBJ with MTL and pictures",
        "objects, polygons, one set of textures; not tried with other programs",
        "what depends on the view; image layers; cameras",
    ],
    [
        "USD as text (.usda) with pictures, and packed (.usdz)",
        "objects, convex polygons, one set of textures, the photos' cameras; tried with USD's validators alone",
        "what depends on the view; image layers",
    ],
];
const LAYERED: [Row; 4] = [
    [
        "PSD and PSB",
        "layers with names, groups, masks and profile, 8 and 16 bits",
        "effects, adjustments and smart objects: their pixels as the editor last drew them",
    ],
    ["XCF of GIMP", "layers with names, groups and masks", "effects"],
    ["OpenRaster", "layers with names and groups", "masks; effects"],
    ["a folder of PNG files with stack.json", "layers, with what each is", "groups"],
];
const PICTURES: [Row; 2] = [
    [
        "PNG (8 and 16 bits) and OpenEXR (linear, half floats)",
        "colour and alpha; views and settings as text",
        "layers",
    ],
    ["APNG, and videos through FFmpeg where it is installed", "colour", "alpha in most"],
];
const ORTHOPHOTOS: [Row; 2] = [
    [
        "TIFF, BigTIFF and PNG, GeoTIFF for plans of sites with north; sources as a second PNG, place as JSON",
        "colour, alpha, resolution, place; where each pixel comes from",
        "what depends on the viewpoint; surroundings, trees",
    ],
    [
        "a page (PDF)",
        "the picture at its scale, scale bar, north, title block",
        "alpha: it is on white; 8 bits as JPEG",
    ],
];
const DEPTH: [Row; 2] = [
    [
        "layered depth images (.ldi), a folder of pictures, GLB",
        "colour, depth and alpha of all layers",
        "sources of the pixels, outside of .ldi",
    ],
    ["a page (HTML) that shows them", "new views in a browser", "editing"],
];

const OTHER_PROGRAMS: [Row; 4] = [
    [
        "a folder for Blender 4.2 or newer: scene.py, scene.json, layers",
        "cameras, model, image layers, exposures, the site's frame; paint on the layers is imported; tried with Blender 4.5",
        "relief, trees",
    ],
    [
        "OpenEXR: a file of several parts per photo, half floats in linear light",
        "photo, image layers with rectangle, order and name, depth; exposures as numbers; tried with OpenEXR's own package alone",
        "guides, masks; deep data",
    ],
    [
        "a script for Nuke 12 or newer with layers and surfaces (experimental: not tried with the program itself)",
        "cameras, image layers on their cut surfaces, one photo at a time; paint on the layers is imported",
        "the mixing of photos, surroundings, relief, trees",
    ],
    [
        "cameras: COLMAP's text files, transforms.json, cameras.json",
        "undistorted cameras; points with their observations (COLMAP); not tried with other programs",
        "model, image layers, masks",
    ],
];

/// Runs `formats`.
pub fn run() -> Outcome {
    let cameras = cameras::described();
    let subjects: [(&str, &str, &[Row]); 9] = [
        ("Cameras", "in", &cameras),
        ("Photos", "in", &PHOTOS),
        ("Models", "in", &MODELS),
        ("Models with textures", "out", &TEXTURED),
        ("Layered files", "out and in", &LAYERED),
        ("Pictures and videos", "out", &PICTURES),
        ("Orthophotos", "out", &ORTHOPHOTOS),
        ("Layered depth images", "out", &DEPTH),
        ("Other programs", "out", &OTHER_PROGRAMS),
    ];
    let (mut text, mut list) = (String::new(), Vec::new());
    for (subject, direction, rows) in subjects {
        let _ = writeln!(text, "{subject} ({direction})");
        for [files, kept, lost] in rows {
            let _ = writeln!(text, "  {files}\n      kept: {kept}");
            if !lost.is_empty() {
                let _ = writeln!(text, "      not: {lost}");
            }
            list.push(json!({
                "subject": subject, "read": direction.contains("in"), "written": direction.contains("out"),
                "files": files, "kept": kept, "lost": lost,
            }));
        }
        text.push('\n');
    }
    text.push_str("Details are in docs/formats.md.\n");
    Outcome { text, json: json!({ "formats": list }), problems: Vec::new() }
}
