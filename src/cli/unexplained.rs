//! What the commands say about sparse points that no face explains.

use super::words::command_for_project;
use quadratura_sites::check::unexplained::{Miss, Unexplained};

/// The number of photos that are named.
const LISTED: usize = 3;

/// Returns one line for reports of other things; empty where too few points are unexplained to tell anything.
pub fn unexplained_line(found: Option<&Unexplained>) -> String {
    let telling = found.filter(|found| found.is_telling());
    telling.and_then(|found| found.sentence(LISTED)).map_or_else(String::new, |sentence| {
        let check = command_for_project("check");
        format!(
            "{sentence}: what is there is not modelled, so that views show it as surroundings, infinitely far away, or \
             flat on what is behind it; {check} draws these points\n"
        )
    })
}

/// Returns what `check` says about them, with what each kind of them means.
pub fn unexplained_text(found: Option<&Unexplained>, draws: bool) -> String {
    let Some((found, sentence)) = found.and_then(|found| Some((found, found.sentence(LISTED)?))) else {
        return String::new();
    };
    let kinds = Miss::ALL.map(|miss| (found.of(miss), miss));
    let kinds = kinds.iter().filter(|(count, _)| *count > 0);
    let kinds: String = kinds.map(|(count, miss)| format!("  {count} {}\n", miss.meaning())).collect();
    let aside = match (found.ground, found.far) {
        (0, 0) => String::new(),
        (ground, far) => format!("  not counted: {ground} on ground beside the model, {far} far behind it\n"),
    };
    let drawn = if draws { "The dots in the pictures show them. " } else { "" };
    let advice = match found.is_telling() {
        true => format!(
            "Model what they are on: a box or a billboard is enough, and far trees are a backdrop. {} suggests walls and roofs that \
             are missing.",
            command_for_project("model suggest --add")
        ),
        false => "So few are usually errors of the points.".to_owned(),
    };
    format!("\n{sentence}\n{kinds}{aside}{drawn}{advice}\n")
}
