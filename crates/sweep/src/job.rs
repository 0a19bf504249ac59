//! A sweep as a job of the Open Job Description (specification 2023-09), which render farms run.

use crate::plan::Sweep;
use serde_json::{Value, json};

/// Name of the template in a job's folder.
pub const TEMPLATE_FILE: &str = "template.json";
/// Name of the sweep in a job's folder.
pub const SWEEP_FILE: &str = "sweep.toml";
/// Most parts of a job: most tasks of a step that farms take.
pub const MAX_PARTS: u64 = 1024;

/// Returns the template of a job: a step whose tasks make `parts` parts of a sweep, and one that makes its table and contact
/// sheet when all are done. The sweep is the file [`SWEEP_FILE`] beside it unless another one is given as the job's parameter.
/// A task that is run again goes on with what is missing.
pub fn template(sweep: &Sweep, name: &str, parts: u64) -> String {
    let parts = parts.clamp(1, MAX_PARTS.min(sweep.count()));
    let sweeping = |more: &[&str]| -> Vec<Value> {
        let common = [
            "sweep",
            "{{Param.Sweep}}",
            "-o",
            "{{Param.Output}}",
            "--yes",
            "--quiet",
        ];
        common.iter().chain(more).map(|word| json!(word)).collect()
    };
    let part = format!("{{{{Task.Param.Part}}}}/{parts}");
    let run = |arguments: Vec<Value>| json!({ "actions": { "onRun": { "command": "{{Param.Program}}", "args": arguments } } });
    let template = json!({
        "specificationVersion": "jobtemplate-2023-09",
        "name": name,
        "description": format!("{} variants in {parts} parts, by greenstick {}", sweep.count(), env!("CARGO_PKG_VERSION")),
        "parameterDefinitions": [
            {
                "name": "Program",
                "type": "STRING",
                "default": "greenstick",
                "description": "The program, by its name or its path on the workers.",
            },
            {
                "name": "Sweep",
                "type": "PATH",
                "objectType": "FILE",
                "dataFlow": "IN",
                "default": SWEEP_FILE,
                "description": "The sweep.",
            },
            {
                "name": "Output",
                "type": "PATH",
                "objectType": "DIRECTORY",
                "dataFlow": "OUT",
                "default": "variants",
                "description": "The folder of the results, which all workers write to.",
            },
        ],
        "steps": [
            {
                "name": "Variants",
                "parameterSpace": {
                    "taskParameterDefinitions": [
                        { "name": "Part", "type": "INT", "range": format!("1-{parts}") },
                    ],
                },
                "script": run(sweeping(&["--part", &part])),
            },
            {
                "name": "Table",
                "dependencies": [{ "dependsOn": "Variants" }],
                "script": run(sweeping(&[])),
            },
        ],
    });
    format!("{template:#}\n")
}
