//! The jobs for OpenCue: a list of commands for each stage, of which `cuecmd` makes one job.

use std::path::Path;

use super::graph::{JobStage, command, quoted};

/// Returns the name of a stage's list, and its commands, one a line.
pub fn list(stages: &[JobStage], at: usize, project: &Path, out: &Path) -> (String, String) {
    let stage = &stages[at];
    let line = |job| {
        let words = command(stage, job, &project.display().to_string(), out);
        words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ") + "\n"
    };
    (format!("{}-{}.txt", at + 1, stage.name), (0..stage.jobs()).map(line).collect())
}

/// Returns a script that submits one stage: `cuecmd` knows no dependencies, so each stage is submitted when the one before it is
/// done.
pub fn submit(stages: &[JobStage]) -> String {
    let mut text = String::from(
        "#!/bin/sh\n\
         # Submits one stage to OpenCue: sh submit.sh STAGE. Submit a stage when the one before it is done; all may be submitted\n\
         # again, because each command leaves alone what is done.\n\
         set -eu\ncd \"$(dirname \"$0\")\"\ncase ${1:-} in\n",
    );
    for (at, JobStage { name, after, cores, memory, .. }) in stages.iter().enumerate() {
        let gigabytes = memory.div_ceil(1 << 30);
        let after = after.map(|after| format!(" # after {after}")).unwrap_or_default();
        text +=
            &format!("{name}) cuecmd {}-{name}.txt --cores {cores} --memory {gigabytes} ;;{after}\n", at + 1);
    }
    let names: Vec<&str> = stages.iter().map(|stage| stage.name).collect();
    text + &format!("*) echo \"usage: sh submit.sh {}\" >&2; exit 2 ;;\nesac\n", names.join("|"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::graph::stages;
    use crate::plan::graph::tests::all;

    #[test]
    fn each_line_is_a_command_that_a_shell_reads_and_each_stage_is_submitted_by_itself() {
        let stages = stages(&all());
        let (name, lines) = list(&stages, 0, Path::new("/site/it's one"), Path::new("/site/jobs"));
        assert_eq!((&name[..], lines.lines().count()), ("1-stacks.txt", 3));
        let first =
            "quadratura --threads 4 build '/site/it'\\''s one' --stacks-only --part 1/3 --memory 4294967296";
        assert_eq!(lines.lines().next(), Some(first));
        assert!(
            submit(&stages)
                .contains("fillings) cuecmd 3-fillings.txt --cores 4 --memory 5 ;; # after estimates\n")
        );
    }
}
