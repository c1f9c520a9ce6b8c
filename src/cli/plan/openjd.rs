//! The jobs as a template of Open Job Description (revision 2023-09): one step for each stage, one task for each job.

use std::path::Path;

use serde_json::{Value, json};

use super::graph::{JobStage, Word};

/// The longest name of a job that the specification allows.
const LONGEST_NAME: usize = 64;

/// Returns the job template.
pub fn template(stages: &[JobStage], project: &Path, out: &Path) -> Value {
    let name = project.file_name().unwrap_or_default().to_string_lossy();
    let name: String = format!("Quadratura {name}").chars().take(LONGEST_NAME).collect();
    let folder = |name: &str, path: &Path, description: &str| json!({ "name": name, "type": "STRING", "default": path.display().to_string(), "description": description });
    json!({
        "specificationVersion": "jobtemplate-2023-09",
        "name": name,
        "description": "Written by `quadratura plan`. Each task leaves alone what is done, so that it may be run again.",
        "parameterDefinitions": [
            folder("Project", project, "The project folder, as the workers see it"),
            folder("Out", out, "The folder of frames and exports, as the workers see it"),
            { "name": "Program", "type": "STRING", "default": "quadratura" },
        ],
        "steps": stages.iter().map(step).collect::<Vec<_>>(),
    })
}

fn step(stage: &JobStage) -> Value {
    let jobs = stage.jobs();
    let word = |word: &Word| match word {
        Word::Same(word) => word.clone(),
        Word::Project => "{{Param.Project}}".to_owned(),
        Word::InPlan(folder) => format!("{{{{Param.Out}}}}/{folder}"),
        Word::Part => format!("{{{{Task.Param.Part}}}}/{jobs}"),
    };
    let words: Vec<String> = stage.words.iter().map(word).collect();
    let mut step = json!({
        "name": stage.name,
        "parameterSpace": {
            "taskParameterDefinitions": [{ "name": "Part", "type": "INT", "range": format!("1-{jobs}") }],
        },
        "hostRequirements": {
            "amounts": [
                { "name": "amount.worker.vcpu", "min": stage.cores },
                { "name": "amount.worker.memory", "min": stage.memory.div_ceil(1 << 20) },
            ],
        },
        "script": { "actions": { "onRun": { "command": "{{Param.Program}}", "args": words } } },
    });
    if let Some(after) = stage.after {
        step["dependencies"] = json!([{ "dependsOn": after }]);
    }
    step
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::graph::stages;
    use crate::plan::graph::tests::all;

    #[test]
    fn each_stage_is_a_step_with_a_task_for_each_job() {
        let template = template(&stages(&all()), Path::new("/site/it's one"), Path::new("/site/jobs"));
        let frames = &template["steps"][3];
        assert_eq!(frames["dependencies"][0]["dependsOn"], "fillings");
        assert_eq!(frames["parameterSpace"]["taskParameterDefinitions"][0]["range"], "1-3");
        let args = frames["script"]["actions"]["onRun"]["args"].as_array().unwrap();
        assert!(
            args.contains(&json!("{{Task.Param.Part}}/3")) && args.contains(&json!("{{Param.Out}}/frames"))
        );
        assert_eq!(frames["hostRequirements"]["amounts"][1]["min"], 5120);
        assert!(template["steps"][0].get("dependencies").is_none());
    }
}
