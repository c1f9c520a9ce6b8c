//! Comments, includes, macros and expressions.

use super::*;

/// Returns the only corner's x of a text that ends with a triangle from there.
fn value(text: &str) -> f64 {
    let text = format!("{text} 0 0 9 0 0 0 9 0\n");
    corners(plant(&text).whole(), 0)[0].position.x
}

#[test]
fn expressions_have_the_usual_order_functions_and_names() {
    for (text, expected) in [
        ("(1 + 2 * 3 - 4 / 2)", 5.0),
        ("(-2 ^ 2)", -4.0),
        ("(2 ^ 3 ^ 2)", 512.0),
        ("(7 % 4 - -1)", 4.0),
        ("((1 + 2) * 3e-1)", 0.3 * 3.0),
        ("-(2-1)", -1.0),
        ("(sin(30 * dtor))", 0.5),
        ("(cos(pi) + tan(0))", -1.0),
        ("(asin(1) * rtod + acos(1) + atan(0))", 90.0),
        ("(sqrt(16) + hypot(3, 4))", 9.0),
        ("1.", 1.0),
        ("+.5e1", 5.0),
    ] {
        let found = value(&format!("triangle {text}"));
        assert!((found - expected).abs() < 1e-12, "{text}: {found}");
    }
    assert_eq!(value("define tall 3 define wide (tall * 2) triangle (wide-tall)"), 3.0);
}

#[test]
fn comments_and_macros_are_as_in_c() {
    assert_eq!(value("/* triangle\n*/ # define A 2 \n# define B (A\\\n + 1)/*c*/\ntriangle/**/B"), 3.0);
    assert_eq!(value("#define A 2\n#define NEGATIVE -A\ntriangle NEGATIVE"), -2.0);
    assert_eq!(value("#define A A\n#define triangle triangle\n#undef A\ntriangle 4"), 4.0);
    assert_eq!(value("#ifdef A\n#ifdef B\nend\n#else\nend\n#endif\n#else\ntriangle 5\n#endif\n"), 5.0);
    assert_eq!(value("#ifndef A\n#define A 6\n#else\nend /* \n#endif\ntriangle A"), 6.0);
}

#[test]
fn files_of_the_folder_are_included_and_their_lines_are_told() {
    let files = Files::new(&[
        ("tree.ray", "#include \"parts/twig.ray\"\nobject twig"),
        ("parts/twig.ray", "#include <leaf.ray>\nname twig list object leaf end\n"),
        ("parts/leaf.ray", TRIANGLE),
    ]);
    let message = files.noted().unwrap_err().to_string();
    assert!(message.contains("twig.ray, line 2: `object \"leaf\"`"), "{message}");
    fs::write(files.0.path().join("parts/leaf.ray"), format!("name leaf {TRIANGLE}")).unwrap();
    assert_eq!(files.noted().unwrap().0.whole().name, "twig");
    let message = refused("\n# 41 \"oak.ray\"\n\nobject oak");
    assert!(message.starts_with("oak.ray, line 42: "), "{message}");
}

#[test]
fn includes_and_macros_without_end_are_refused() {
    let files = Files::new(&[("tree.ray", "\n#include \"twig.ray\""), ("twig.ray", "#include \"tree.ray\"")]);
    let message = files.noted().unwrap_err().to_string();
    assert!(
        message.contains(r#"line 1: `#include`"#)
            || message.contains(r#""tree.ray" includes "twig.ray" includes "tree.ray""#),
        "{message}"
    );
    let doubled: String = (1..60).map(|i| format!("#define A{i} A{0} A{0}\n", i - 1)).collect();
    for first in ["", "sphere 1 0 0 0"] {
        let message = refused(&format!("#define A0 {first}\n{doubled}A59"));
        assert!(message.contains("macros that are replaced by more than 1000000 words"), "{message}");
    }
    for (text, expected) in [
        ("#include \"../twig.ray\"", "line 1: `#include` of \"../twig.ray\", outside"),
        ("#include \"no.ray\"", "which is not in the folder"),
        ("#include no.ray", "expected \"FILE\" or <FILE>"),
        ("#define A(x) x", "expected a macro without arguments"),
        ("#define 3", "expected a name"),
        ("\n#if 1\n#endif", "line 2: `#if`, which is not read"),
        ("#wrong", "`#wrong`, expected include"),
        ("#endif", "`#endif` without"),
        ("\n#ifdef A", "line 2: `#ifdef` or `#ifndef` without `#endif`"),
    ] {
        let message = refused(text);
        assert!(message.contains(expected), "{text:?}: {message}");
    }
}
