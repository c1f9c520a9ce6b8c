//! What is refused, with its line, and what is noted.

use super::*;

#[test]
fn what_is_wrong_is_told_with_its_line() {
    let deep = format!("{}{}", "list ".repeat(65), "end ".repeat(65));
    let cases = [
        ("\n\nend", "line 3: `end` without a list"),
        ("\nlist\nsphere 1 0 0 0", "line 2: `list` is never closed"),
        ("\nobject twig", "line 2: `object \"twig\"`, but no `name` before it"),
        ("name a object a", "no `name` before it"),
        ("name a eyep", "\"eyep\" after `name`"),
        ("name", "the file ends; expected the name of `name`"),
        ("\ndifference sphere 1 0 0 0 end", "line 2: `difference`, expected a plant without it"),
        ("intersect end", "`intersect`"),
        ("sphere red 1 0 0 0", "line 1: the surface \"red\", which is not known here"),
        ("sphere 1 0 0", "the file ends; expected number 3 of 3 of the middle of `sphere`"),
        ("sphere -1 0 0 0", "the radius -1"),
        ("sphere 1e999 0 0 0", "inf, expected the radius of `sphere`: a finite number"),
        ("sphere 1e16 0 0 0", "up to 1e15"),
        ("sphere (1 / 0) 0 0 0", "an expression whose value is inf"),
        ("sphere (height) 0 0 0", "\"height\" in an expression, which no `define` before it names"),
        ("sphere (1 0 0 0", "\"0\" in an expression, expected an operator or `)`"),
        ("sphere (linear(0, 1, 2, 3)) 0 0 0", "the function \"linear\""),
        ("sphere (exp(1)) 0 0 0", "the function \"exp\", expected sin, cos"),
        ("sphere (hypot(1)) 0 0 0", "expected `,` of hypot"),
        ("triangle 0 0 0 1 0 0 0 1", "8 numbers of `triangle`"),
        ("triangleuv 0 0 0 1 0 0 0 1 0", "9 numbers of `triangleuv`"),
        ("poly 0 0 0 1 1 1", "6 numbers of `poly`"),
        ("sphere 1 0 0 0 rotate 0 0 0 90", "`rotate` about 0 0 0"),
        ("sphere 1 0 0 0 scale 1e8 1 1 scale 1e8 1 1", "beyond 1e15 together"),
        ("triangle 1e8 0 0 0 1 0 0 0 1 scale 1e8 1 1", "a point that its transform brings beyond 1e15"),
        ("define 3 4", "`define` of \"3\""),
        (&deep, "more than 64 lists are open"),
        ("\n/* never", "line 2: a comment `/*` without `*/`"),
        ("triangle 0 0 0 1 0 0 0 1 0 texture image no.png map uv", "no picture \"no.png\""),
        ("triangle 0 0 0 1 0 0 0 1 0 texture image ../a.png map uv", "outside of the plant's folder"),
    ];
    for (text, expected) in cases {
        let message = refused(text);
        assert!(message.contains(expected), "{text:?}: {message}");
        assert!(message.contains("tree.ray"), "{message}");
    }
    let aliases: String = (1..70).map(|i| format!("name a{i} object a{} translate 1 0 0 ", i - 1)).collect();
    let message = refused(&format!("name a0 {TRIANGLE} {aliases} object a69"));
    assert!(message.contains("levels, but a plant has at most 64"), "{message}");
}

#[test]
fn what_is_left_out_is_noted_once_with_its_number() {
    let (plant, notes) = noted(
        "plane 0 0 0 0 0 1 texture checker red\nplane 0 0 9 0 0 -1\nblob .5 1 1 0 0 0\ntorus diffuse 1 0 0 2 1 0 0 0 0 0 1\n\
         heightfield hill.hf translate 1 0 0\nspere 1 0 0 0\nunion sphere 1 0 0 0 box 0 0 0 1 1 1 end\n\
         sphere 1 0 0 0 scale 1 0 1\ntriangle 0 0 0 1 1 1 2 2 2\nsphere 1 0 0 0 texture marble\n\
         triangle diffuse 2 0 0 0 0 0 1 0 0 0 1 0\n",
    );
    let expected = [
        "line 5: a height field is left out",
        "line 1: a plane is left out, because it has no end (and 1 more)",
        "line 3: a blob is left out",
        "line 4: a torus is left out",
        "line 6, \"spere\": an unknown statement is left out",
        "line 7: a union is read as a list",
        "line 8: something is left out, because its transform is singular",
        "line 9: a primitive has no area",
        "a texture has no effect",
        "line 11: a share of light is brought into the range",
    ];
    for expected in expected {
        assert!(notes.iter().any(|note| note.contains(expected)), "{expected}: {notes:?}");
    }
    assert_eq!((notes.len(), plant.whole().uses.len()), (expected.len(), 2), "{notes:?}");
    let (_, notes) = noted("name leaf triangle 0 0 0 1 0 0 0 1 0");
    assert!(notes.len() == 1 && notes[0].contains("the plant is empty"), "{notes:?}");
}

#[test]
fn views_light_and_the_program_itself_are_passed_over_silently() {
    let (plant, notes) = noted(
        "eyep 0 -9 4 lookp 0 0 (1 + 1) up 0 0 1 fov 45 screen 512 512 maxdepth 2 background 0 0 0 sample 4 jitter\n\
         light 1.4 point 20 0 66 light .2 .2 .2 ambient light 1 directional 1 1 1 noshadow atmosphere fog 1 1 1 .1 .1 .1\n\
         outfile object filter box 1 report verbose frames 32 shutter 1 framelength 1 starttime -1\n\
         sphere 1 0 0 (time + frame)\n",
    );
    assert!(notes.is_empty() && plant.whole().counts.levels == 1, "{notes:?}");
}
