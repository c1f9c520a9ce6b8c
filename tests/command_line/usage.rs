//! Words that are no command, and what the program says of itself.

use std::process::{Command, Stdio};

use super::site::{Site, program, stderr_of, stdout_of};

#[test]
fn wrong_usage_has_exit_status_2_and_names_the_word() {
    let site = Site::new();
    for (words, named) in [
        ("varnish project", "varnish"),
        ("build", "PROJECT"),
        ("build project --tolerance 2", "tolerance"),
        ("build project --method magic", "magic"),
        ("build project --memory much", "much"),
        ("build project --threads 0", "0"),
        ("export project --format doc --out out", "doc"),
        ("new project --photos a --cameras b", "--model"),
        ("render project --out out", "--cameras"),
        ("render project --cameras photos --through a,b --out out", "--through"),
        ("render project --cameras photos --out out --size 960", "960"),
        ("render project --cameras photos --out out --mode mean", "mean"),
        ("render project --cameras photos --out out --photos-per-point 9", "9"),
        ("score project --cameras held", "--photos"),
        ("new project --photos a --cameras b --model c --model-transform up", "up"),
    ] {
        let message = stderr_of(&site.run(words).failure().code(2));
        assert!(message.contains(named), "{words}: {message}");
    }
}

#[test]
fn a_number_out_of_range_is_answered_with_the_range_also_below_zero() {
    let site = Site::new();
    let render = "render project --cameras photos --out out";
    let export = "ldi export a.ldi --format page --out out";
    for (words, expected) in [
        (format!("{export} --triangles -5"), "expected a whole number, 2 to 1000000000"),
        (format!("{export} --triangles 99999999999999999999"), "expected a whole number, 2 to 1000000000"),
        (format!("{export} --quality -1"), "1 to 100"),
        (format!("{render} --photos-per-point -1"), "1 to 8"),
        (format!("{render} --scale -0.5"), "above 0"),
        (format!("{render} --fps -25"), "above 0"),
        (format!("{render} --size -9x5"), "a width and a height"),
        (format!("{render} --texture-memory -2G"), "-2G"),
        ("build project --threads -1".into(), "1 to 1024"),
        ("build project --min-support -1".into(), "a whole number, 0 to"),
        ("build project --tolerance -0.1".into(), "tolerance"),
        ("tree place project oak --at 0,0,0 --height -3".into(), "a length above 0"),
        ("tree light project --sun-light -1,0".into(), "three numbers"),
        ("tree render oak --cameras orbit --out out --seed -1".into(), "a whole number, 0 to"),
        ("decide project --photo left --margin -1".into(), "a whole number of 0 or more"),
        ("surroundings project --export a.png --width -1".into(), "2 to 16384"),
        ("ldi render a.ldi --out out --stereo -0.065".into(), "above 0"),
    ] {
        let message = stderr_of(&site.run(&words).failure().code(2));
        assert!(message.contains(expected) && !message.contains("unexpected"), "{words}: {message}");
    }
}

/// Elsewhere a window might open, and nobody would close it.
#[cfg(target_os = "linux")]
#[test]
fn without_a_display_the_editor_says_so_with_a_command_and_without() {
    let site = Site::new();
    site.make_project();
    for words in ["", "edit", "edit project"] {
        let mut command = site.command(words);
        for variable in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
            command.env_remove(variable);
        }
        let message = stderr_of(&command.assert().failure().code(1));
        assert!(message.contains("no display") && message.contains("--help"), "{words}: {message}");
    }
}

#[test]
fn help_lists_the_commands_that_there_are_and_hides_those_for_packagers() {
    let site = Site::new();
    let help = stdout_of(&site.run("--help").success());
    for command in [
        "edit", "new", "check", "update", "build", "fill", "export", "import", "watch", "stroke", "colour",
        "render", "score", "info", "formats",
    ] {
        assert!(help.contains(&format!("  {command} ")), "{help}");
    }
    for word in ["completions", "man "] {
        assert!(!help.contains(&format!("  {word}")), "{help}");
    }
}

#[test]
fn formats_are_listed_with_what_is_kept_and_what_is_lost() {
    let site = Site::new();
    let text = stdout_of(&site.run("formats").success());
    for expected in ["Metashape's .xml", "kept: ", "not: tie points", "OpenRaster", "RealityScan"] {
        assert!(text.contains(expected), "{text}");
    }
}

#[test]
fn packagers_get_completions_and_a_manual_page() {
    let site = Site::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = stdout_of(&site.run(&format!("completions {shell}")).success());
        assert!(script.contains("save-options"), "{shell}");
    }
    let page = stdout_of(&site.run("man").success());
    assert!(page.contains(".TH quadratura 1") && page.contains("save\\-options"), "{page}");
}

#[test]
fn a_reader_that_has_seen_enough_is_no_error() {
    let site = Site::new();
    let mut man = Command::new(program())
        .current_dir(site.folder.path())
        .args(["completions", "bash"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(man.stdout.take());
    let ended = man.wait_with_output().unwrap();
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
}

#[test]
fn nothing_is_coloured_where_nobody_looks() {
    let site = Site::new();
    let message = stderr_of(&site.run("info nowhere").failure());
    assert!(message.starts_with("error: ") && !message.contains('\u{1b}'), "{message:?}");
}
