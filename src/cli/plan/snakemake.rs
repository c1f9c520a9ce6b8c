//! The jobs for Snakemake: one rule for each stage.

use std::path::Path;

use super::graph::{JobStage, Word, quoted};

/// Returns the content of the `Snakefile`. It reads the inputs of the jobs from `plan.json` beside it.
pub fn snakefile(stages: &[JobStage], project: &Path) -> String {
    let mut text = String::from(
        "# The jobs of a project, written by `quadratura plan`: run `snakemake --cores N` in this folder.\n\
         # Each job leaves alone what is done, so that all of this may be run again at any time.\n\
         import json, os\n\n",
    );
    text += &format!("PROJECT = config.get(\"project\", {})\n", python(&project.display().to_string()));
    text += "PROGRAM = config.get(\"program\", \"quadratura\")\n\
             PLAN = json.load(open(os.path.join(workflow.basedir, \"plan.json\")))\n\
             STAGES = {stage[\"name\"]: stage for stage in PLAN[\"stages\"]}\n\n\
             wildcard_constraints:\n    part=r\"\\d+\"\n\n\
             def done(stage):\n    \
                 return [f\"done/{stage}-{part}\" for part in range(1, len(STAGES[stage][\"jobs\"]) + 1)]\n\n\
             rule all:\n    input: [mark for stage in STAGES for mark in done(stage)]\n";
    stages.iter().for_each(|stage| text += &rule(stage));
    text
}

fn rule(stage: &JobStage) -> String {
    let JobStage { name, after, cores, memory, .. } = stage;
    let mut inputs =
        vec![format!("lambda wildcards: STAGES[\"{name}\"][\"jobs\"][int(wildcards.part) - 1][\"inputs\"]")];
    inputs.extend(after.map(|after| format!("done(\"{after}\")")));
    let words: Vec<String> = stage.words.iter().map(|word| shell_word(word, stage)).collect();
    format!(
        "\nrule {name}:\n    input: {}\n    output: touch(\"done/{name}-{{part}}\")\n    threads: {cores}\n    \
         resources: mem_mb={}\n    shell: {}\n",
        inputs.join(", "),
        memory.div_ceil(1 << 20),
        python(&format!("{{PROGRAM:q}} {}", words.join(" "))),
    )
}

/// Returns a word of a command, in which braces stand for values.
fn shell_word(word: &Word, stage: &JobStage) -> String {
    match word {
        Word::Same(word) => quoted(word).replace('{', "{{").replace('}', "}}"),
        Word::Project => "{PROJECT:q}".to_owned(),
        Word::InPlan(folder) => (*folder).to_owned(),
        Word::Part => format!("{{wildcards.part}}/{}", stage.jobs()),
    }
}

/// Returns a text as Python reads it.
fn python(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::graph::stages;
    use crate::plan::graph::tests::all;

    #[test]
    fn each_stage_is_a_rule_after_all_jobs_of_the_one_before() {
        let text = snakefile(&stages(&all()), Path::new("/site/it's one"));
        assert!(text.contains("PROJECT = config.get(\"project\", \"/site/it's one\")"), "{text}");
        let fillings = text.split("\nrule ").find(|rule| rule.starts_with("fillings:")).unwrap();
        assert!(fillings.contains("done(\"estimates\")") && fillings.contains("mem_mb=5120"), "{fillings}");
        let command = "shell: \"{PROGRAM:q} --threads 4 fill {PROJECT:q} --part {wildcards.part}/3 --memory 4294967296\"";
        assert!(fillings.contains(command), "{fillings}");
    }
}
