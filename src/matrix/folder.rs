//! The folder of a study: its record, the scenarios of its members, and what other programs need to run them.
//!
//! | file | holds |
//! | --- | --- |
//! | `study.json` | what varies, and the members |
//! | `members.csv` | number, case, variant and values of each |
//! | `scenarios/0001.yaml` | the scenario of a member |
//! | `runs/0001/` | its run folder |
//! | `logs/0001.txt` | what its run said |
//! | `commands.txt`, `slurm.sh`, `Snakefile` | the members as jobs of GNU parallel, Slurm, Snakemake |

use std::path::Path;

use super::members::Member;
use crate::csv::field;
use crate::error::{Error, Problem, ProblemKind};
use crate::output::RunFolder;
use crate::plain_file::{entries, read_to_string};
use crate::study::{StudyRecord, linked, scenario_of};

/// Makes the folder of a study, or brings that of an earlier call up to date, and holds it.
///
/// # Errors
/// `output-folder-not-empty` where it holds something else, `study-changed` where it holds members that are others now and `overwrite` is not
/// set, and when it cannot be written.
pub(super) fn lay_out(
    path: &Path,
    record: &StudyRecord,
    members: &[Member],
    overwrite: bool,
) -> Result<RunFolder, Error> {
    let file = |name: &str| path.join(name);
    if !file(StudyRecord::FILE).exists() {
        if let Some(problem) = RunFolder::inspect(path, false) {
            let remedy = "choose another `folder` in the study file, which may not hold anything but a study";
            return Err(Error::Problems(vec![problem.with_remedy(remedy)]));
        }
    } else if let Some(member) = StudyRecord::open(path).map(|_| changed(path, members))?.filter(|_| !overwrite) {
        let message = format!("the study in {} has other members than its file says now", path.display());
        let problem = Problem::error(ProblemKind::Output, "study-changed", "folder", message);
        let cause = format!(
            "member {member} differs: the study file, the base scenario, their folder or the program has changed"
        );
        let remedy = "choose another `folder`, or add --overwrite to run the members again that differ";
        return Err(Error::Problems(vec![problem.with_cause(cause).with_remedy(remedy)]));
    }
    if let Some(problem) = linked(path) {
        return Err(Error::Problems(vec![problem]));
    }
    let failed = |cause: std::io::Error| Error::Output { path: path.to_owned(), cause: cause.to_string() };
    std::fs::create_dir_all(file("logs")).map_err(failed)?;
    let folder = RunFolder::reopen(path)?;
    // First of all: what follows may be cut off, and goes on in a folder that has it.
    let text = serde_json::to_string_pretty(record).map_err(|cause| Error::Internal(cause.to_string()))?;
    folder.write(StudyRecord::FILE, (text + "\n").as_bytes())?;
    for member in members {
        let name = format!("scenarios/{:04}.yaml", member.record.number);
        if read_to_string(folder.file(&name)).ok().as_ref() != Some(&member.scenario) {
            // Snakemake's mark of the member before.
            let _ = std::fs::remove_file(folder.file(&format!("finished/{}", member.record.number)));
            folder.write(&name, member.scenario.as_bytes())?;
        }
    }
    for extra in extra_scenarios(path, members.len()) {
        std::fs::remove_file(path.join("scenarios").join(extra)).map_err(failed)?;
    }
    folder.write("members.csv", table(record).as_bytes())?;
    folder.write("commands.txt", commands(record).as_bytes())?;
    folder.write("slurm.sh", slurm(record).as_bytes())?;
    folder.write("Snakefile", snakefile(record).as_bytes())?;
    Ok(folder)
}

/// The first member whose scenario is another one than that of the folder; one more than there are where the folder has more.
fn changed(folder: &Path, members: &[Member]) -> Option<usize> {
    let differs = |member: &&Member| {
        let old = read_to_string(scenario_of(folder, member.record.number));
        old.is_ok_and(|old| old != member.scenario)
    };
    let other = members.iter().find(differs).map(|member| member.record.number);
    other.or_else(|| (!extra_scenarios(folder, members.len()).is_empty()).then_some(members.len() + 1))
}

/// Names of scenarios beyond so many members.
fn extra_scenarios(folder: &Path, members: usize) -> Vec<String> {
    let names = entries(&folder.join("scenarios")).unwrap_or_default();
    let names = names.iter().filter_map(|path| path.file_name()?.to_str().map(str::to_owned));
    let is_extra = |name: &String| {
        name.strip_suffix(".yaml").and_then(|name| name.parse::<usize>().ok()).is_some_and(|number| number > members)
    };
    names.filter(is_extra).collect()
}

fn table(record: &StudyRecord) -> String {
    let names: String = record.variables.iter().map(|variable| format!(",{}", field(&variable.name))).collect();
    let mut text = format!("number,case,variant{names}\n");
    for member in &record.members {
        let values: String =
            member.values.iter().map(|value| format!(",{}", field(value.as_deref().unwrap_or_default()))).collect();
        text += &format!("{},{},{}{values}\n", member.number, member.case, member.variant);
    }
    text
}

/// One command a line, as GNU parallel takes them: `parallel < commands.txt` in the folder of the study.
fn commands(record: &StudyRecord) -> String {
    record.members.iter().map(|member| format!("floodsim matrix . --only {} --threads 1\n", member.number)).collect()
}

fn slurm(record: &StudyRecord) -> String {
    format!(
        "#!/bin/bash\n\
         # The members of the study as an array of Slurm: `sbatch slurm.sh` in the folder of the study.\n\
         # A job that was cut off goes on where it was when it is submitted again.\n\
         #SBATCH --job-name=floodsim\n\
         #SBATCH --array=1-{}\n\
         #SBATCH --ntasks=1\n\
         #SBATCH --cpus-per-task=1\n\
         #SBATCH --output=logs/slurm-%a.txt\n\
         exec floodsim matrix . --only \"$SLURM_ARRAY_TASK_ID\" --threads \"${{SLURM_CPUS_PER_TASK:-1}}\"\n",
        record.members.len()
    )
}

fn snakefile(record: &StudyRecord) -> String {
    format!(
        "# The members of the study as jobs of Snakemake: `snakemake --cores all --keep-going` in the folder of the study.\n\
         # What a job leaves in runs/ is no output of Snakemake's, which would delete it where a job is cut off.\n\
         MEMBERS = range(1, {} + 1)\n\n\
         rule reduce:\n\
         \x20   input: expand(\"finished/{{member}}\", member=MEMBERS)\n\
         \x20   shell: \"floodsim reduce .\"\n\n\
         rule member:\n\
         \x20   output: touch(\"finished/{{member}}\")\n\
         \x20   threads: 1\n\
         \x20   shell: \"floodsim matrix . --only {{wildcards.member}} --threads {{threads}}\"\n",
        record.members.len()
    )
}
