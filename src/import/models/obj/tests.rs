//! OBJ files, good and bad.

use proptest::prelude::*;

use super::*;
use crate::mutations::mutations;
use quadratura_base::scene::Model;

fn read_text(text: impl AsRef<[u8]>) -> Result<(Model, Vec<String>)> {
    let (path, text) = (Path::new("site.obj"), text.as_ref());
    let mut notes = Vec::new();
    let builder = read(path, text, text.len() as u64, &Task::silent(), &mut notes)?;
    super::super::finish(path, builder, notes, &Task::silent())
}

fn model(text: impl AsRef<[u8]>) -> Model {
    read_text(text).unwrap().0
}

/// Returns the reader's error for `text`, without the file's name.
fn complaint(text: impl AsRef<[u8]>) -> String {
    read_text(text).unwrap_err().to_string().replace("site.obj, ", "")
}

fn objects(model: &Model) -> Vec<(&str, usize)> {
    model.objects.iter().map(|o| (o.name.as_str(), o.faces.len())).collect()
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn objects_come_from_o_and_groups_inside_are_sub_objects() {
    let text = format!("{SQUARE}o house\nf 1 2 3\ng roof\nf 1 3 4\no tree\nf 1 2 4\no house\nf 2 3 4\n");
    let model = model(text);
    assert_eq!(objects(&model), [("house", 2), ("house/roof", 1), ("tree", 1)]);
    assert_eq!(model.face_name(quadratura_base::scene::FaceId(3)), "house[1]");
}

#[test]
fn groups_are_objects_where_there_is_no_o() {
    let text = format!("{SQUARE}f 1 2 3\ng wall  west\nf 1 2 3 4\ng\nf 2 3 4\n");
    assert_eq!(objects(&model(text)), [("site", 2), ("wall west", 1)]);
}

#[test]
fn every_form_of_corner_is_read() {
    for face in
        ["1 2 3 4", "1/9 2/9 3/9 4/9", "1//7 2//7 3//7 4//7", "1/1/1 2/1/1 3/1/1 4/1/1", "-4 -3 -2 -1"]
    {
        assert_eq!(model(format!("{SQUARE}f {face}\n")).ring_vertices, [0, 1, 2, 3], "{face}");
    }
}

#[test]
fn line_ends_continuations_comments_and_byte_order_mark_are_no_obstacle() {
    let text = "\u{feff}# one\r\nv 0 0 0 # corner\r\nv 1 0 \\\r\n 0\r\n\tv 1 1 0 0.5 0.5 0.5\r\nv 0 1 0 1\r\nf 1 2 \\\r\n3 4";
    let model = model(text);
    assert_eq!(model.vertices[1], DVec3::X);
    assert_eq!(model.triangles.len(), 2);
}

#[test]
fn names_of_any_encoding_and_coordinates_of_every_digit_are_kept() {
    let mut text = b"o caf\xe9\n".to_vec();
    text.extend(b"v 4500000.12345678 0 0\nv 1 0 0\nv 0 1 1e-3\nf 1 2 3\n");
    let model = model(text);
    assert_eq!(model.objects[0].name, "café");
    assert_eq!(model.vertices[0].x, 4_500_000.123_456_78);
}

#[test]
fn a_comment_ends_with_its_line_and_a_name_holds_whatever_its_line_does() {
    let text = format!(
        "# made in C:\\models\\\n{SQUARE}mtllib C:\\lib\\\nusemap C:\\maps\\\no Wall #3\\\nf 1 2 3 # lower \\\n\
         o Wall #4\nusemtl Tree#billboard\\\nf 1 3 4\n# end \\\ng Group#1-Entity\nf 1 2 4\no #\nf 2 3 \\ \n 4 #\\\n"
    );
    let (model, notes) = read_text(&text).unwrap();
    let names = [("Wall #3\\", 1), ("Wall #4", 1), ("Wall #4/Group#1-Entity", 1), ("#", 1)];
    assert_eq!((objects(&model), notes), (names.to_vec(), Vec::<String>::new()));
    let turning: Vec<bool> = model.objects.iter().map(|object| object.billboard).collect();
    assert_eq!(turning, [false, true, true, true], "a material holds for the groups and objects behind it");
    let other_ends = text.replace('\n', "\r");
    assert_eq!(objects(&read_text(other_ends).unwrap().0), names);
}

#[test]
fn only_statements_of_numbers_are_continued() {
    let text =
        format!("{SQUARE}curv 0 1 \\\n 1 2 \\\n 3\nfoo 1 \\\nvt 0 \\\n nan\nl 1 \\\n 2\nf 1 \\\n 2 \\\n 3\n");
    let (model, notes) = read_text(text).unwrap();
    assert_eq!(model.ring_vertices, [0, 1, 2]);
    assert_eq!(
        notes,
        ["`curv` is left out (1 times, first in line 5)", "`foo` is left out (1 times, first in line 8)"]
    );
}

#[test]
fn names_are_the_same_when_their_bytes_are() {
    // Two names of a temple in GBK that a lossy conversion makes equal, and one in UTF-8 beside them.
    let names: [&[u8]; 5] = [
        b"\xb5\xee\xce\xdd\xb6\xa5",
        b"\xb5\xee\xb6\xab\xc7\xbd",
        b"a  b",
        "a b".as_bytes(),
        b"\xb5\xee\xce\xdd\xb6\xa5",
    ];
    let mut text = SQUARE.as_bytes().to_vec();
    for name in names {
        text.extend([b"o ", name, b" \t\nf 1 2 3\n"].concat());
    }
    let (read, notes) = read_text(&text).unwrap();
    assert_eq!(objects(&read), [("殿屋顶", 2), ("殿东墙", 1), ("a b (2)", 1), ("a b", 1)]);
    assert_eq!(
        notes[0],
        "2 of 4 names of objects are not UTF-8: they are shown as GBK, which is a guess, such as \"殿屋顶\""
    );
    assert_eq!(notes[1], "1 objects look like others by name: they are numbered, such as \"a b (2)\"");
    // What no encoding tells apart is told apart by a number; what is called so itself keeps its name.
    let surroundings = format!("{SQUARE}o [surroundings]\nf 1 2 3\no [surroundings] (object)\nf 1 2 3\n");
    assert_eq!(
        objects(&model(surroundings)),
        [("[surroundings] (object)", 1), ("[surroundings] (object) (2)", 1)]
    );
}

#[test]
fn a_billboard_is_named_so_or_wears_such_a_material() {
    let text = format!(
        "{SQUARE}o tree billboard\nf 1 2 3\no bush\nusemtl Billboard_bush\nf 1 2 3\no wall\nusemtl stone\nf 1 2 3\n"
    );
    assert_eq!(model(text).objects.iter().map(|o| o.billboard).collect::<Vec<_>>(), [true, true, false]);
}

#[test]
fn a_fault_is_named_with_its_line() {
    assert_eq!(
        complaint(format!("{SQUARE}f 1 2 9\n")),
        "line 5: a face names vertex 9, but only 4 were read so far; export the model again, vertices before faces"
    );
    for (text, place, found) in [
        ("v 1 2\n", "line 1: ", "fewer than three coordinates"),
        ("\nv 1 2 x\n", "line 2: ", "`x` where a coordinate"),
        ("v 1 nan 2\n", "line 1: ", "`nan` where a coordinate should be, which is no number"),
        ("\r\nv 1 -1.#IND00 2\n", "line 2: ", "`-1.#IND00` where a coordinate should be, which is no number"),
        ("v 0 0 0\rv 1 2 -nan(ind)\r", "line 2: ", "`-nan(ind)` where"),
        ("v 1 2 1.#QNAN0\n", "line 1: ", "delete or repair this vertex"),
        ("v inf 2 0\n", "line 1: ", "`inf` where"),
        ("v 1 2 3#corner\n", "line 1: ", "`3#corner` where a coordinate"),
        ("v 1 2 # 3\n", "line 1: ", "fewer than three coordinates"),
        ("v 1 1e308 2\n", "line 1: ", "not within 1e15"),
        ("v 0 0 0\nf 1 0 1\n", "line 2: ", "`0` where the number of a vertex"),
        ("v 0 0 0\nf 1 -2 1\n", "line 2: ", "names vertex -2"),
        ("v 0 0 0\nf 1 99999999999999999999 1\n", "line 2: ", "where the number of a vertex"),
        ("v 0 0 0 \\\n\nf 1 a 1\n", "line 3: ", "`a` where the number"),
    ] {
        let said = complaint(text);
        assert!(said.starts_with(place) && said.contains(found), "{said}");
    }
}

#[test]
fn a_file_that_is_no_obj_is_refused() {
    assert!(complaint("").contains("no faces among 0 vertices"));
    assert!(complaint([0u8, 159, 146, 150, 10, 7].repeat(50)).contains("no faces"));
    let utf16: Vec<u8> = SQUARE.encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert!(complaint(&utf16).contains("it is text in UTF-16, expected UTF-8; save it as UTF-8"));
    assert!(complaint([b"\xff\xfe", &utf16[..]].concat()).contains("UTF-16"));
    assert!(complaint("v 0 0 0\nf 1 1 1\n").contains("none of its 1 faces has an area"));
    assert!(complaint(vec![b'v'; LONGEST_LINE + 10]).contains("a line of more than"));
}

#[test]
fn flaws_of_faces_are_notes_with_counts_and_names() {
    let text = format!("{SQUARE}v 2 2 2\nf 1 2 2\nf 1 2 5 4\nf 1 3 2 4\nf 1 2\n curv 1 2\n f 1 2 3\n");
    let (_, notes) = read_text(text).unwrap();
    assert_eq!(
        notes,
        [
            "`curv` is left out (1 times, first in line 10)",
            "3 faces without area: not textured (site[0], site[2], site[3])",
            "1 face with the same corner twice in a row: treated as one corner (site[0])",
            "1 face not planar: treated as separate triangles (site[1])",
        ]
    );
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: mutations(300), ..Default::default() })]

    #[test]
    fn damaged_files_are_read_or_refused(
        cut in 0..200usize,
        changes in prop::collection::vec((0..200usize, any::<u8>()), 0..6),
    ) {
        let mut text = SQUARE.as_bytes().to_vec();
        text.extend(b"o a#1\\\nf 1 2 \\\n 3 4\n# x \\\ng \xb5\xee\nf -1 -2 -3\rusemtl x\r\ng \xb5\xef\nf 1/1 2/2 3/3 # end\\\n");
        text.truncate(cut.max(1));
        for (at, byte) in changes {
            let at = at % text.len();
            text[at] = byte;
        }
        let _ = read_text(text);
    }
}
