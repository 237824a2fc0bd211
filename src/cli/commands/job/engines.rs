//! The files that each engine reads.

use super::{Work, line, text};
use crate::cli::{CliError, plan::Engine};

/// A file's name and its text.
pub type File = (&'static str, String);

const COMMANDS: &str = "commands.txt";
const MERGES: &str = "merge.txt";
/// The longest default value of a parameter in Open Job Description, characters.
const LONGEST_STRING: usize = 1024;

/// All files of the job.
///
/// # Errors
/// [`CliError::Usage`] for names that no script can hold.
pub fn files(work: &Work, engine: Engine) -> Result<Vec<File>, CliError> {
    let mut files = vec![(COMMANDS, lines(&work.commands))];
    if !work.merges.is_empty() {
        files.push((MERGES, lines(&work.merges)));
    }
    match engine {
        Engine::Parallel => files.push(("run.sh", parallel(work)?)),
        Engine::Slurm => {
            files.push(("task.sh", task(work, "progress")));
            files.push(("tasks.sbatch", tasks_sbatch(work)?));
            if !work.merges.is_empty() {
                files.push(("merge.sbatch", merge_sbatch(work)?));
            }
            files.push(("submit.sh", submit(work)?));
        }
        Engine::OpenJd => {
            files.push(("task.sh", task(work, "openjd_progress")));
            files.push(("template.yaml", template(work)?));
        }
    }
    Ok(files)
}

/// The command that starts the job.
///
/// # Errors
/// [`CliError::Usage`] for names that no script can hold.
pub fn start(work: &Work, engine: Engine) -> Result<String, CliError> {
    let (words, file): (&[&str], _) = match engine {
        Engine::Parallel => (&["sh"], "run.sh"),
        Engine::Slurm => (&["sh"], "submit.sh"),
        Engine::OpenJd => (&["openjd", "run"], "template.yaml"),
    };
    let file = path(work, file)?;
    line(words.iter().copied().chain([file.as_str()]))
}

fn lines(lines: &[String]) -> String {
    lines.iter().map(|line| format!("{line}\n")).collect()
}

fn path(work: &Work, name: &str) -> Result<String, CliError> {
    let path = text(&work.folder.join(name))?.to_owned();
    // Not an option of `sh` or `sbatch`.
    Ok(if path.starts_with('-') {
        format!("./{path}")
    } else {
        path
    })
}

/// A path as a word of a shell script.
fn quoted(path: &str) -> Result<String, CliError> {
    line([path])
}

fn file(work: &Work, name: &str) -> Result<String, CliError> {
    quoted(&path(work, name)?)
}

fn parallel(work: &Work) -> Result<String, CliError> {
    let merge = if work.merges.is_empty() {
        String::new()
    } else {
        format!("sh -e {}\n", file(work, MERGES)?)
    };
    Ok(format!(
        "#!/bin/sh\n\
         # Renders by GNU parallel, one task at a time on each machine, and merges. What fails is tried on another machine.\n\
         # After a failure, or to render what was removed, run it again.\n\
         # Options of parallel may follow, such as: --sshlogin one,two --workdir \"$PWD\"\n\
         set -eu\n\
         cd {directory}\n\
         PARALLEL_SHELL=/bin/sh\n\
         export PARALLEL_SHELL\n\
         parallel --jobs 1 --retries 3 --joblog {log} --resume --resume-failed \"$@\" < {commands}\n\
         # The next call looks for all pictures again.\n\
         [ ! -e {log} ] || mv {log} {done}\n\
         {merge}",
        directory = quoted(&work.directory)?,
        log = file(work, "joblog.txt")?,
        done = file(work, "joblog.done.txt")?,
        commands = file(work, COMMANDS)?,
    ))
}

/// Runs a task's lines of the commands, and prints the progress in percent after each picture.
fn task(work: &Work, progress: &str) -> String {
    let (chunk, count, tasks) = (work.chunk, work.commands.len(), work.tasks());
    format!(
        "#!/bin/sh\n\
         # Runs task $1 of {tasks}, from the directory that paths are relative to.\n\
         set -eu\n\
         commands=$(dirname \"$0\")/{COMMANDS}\n\
         first=$((($1 - 1) * {chunk} + 1))\n\
         last=$(($1 * {chunk}))\n\
         [ \"$last\" -le {count} ] || last={count}\n\
         line=$first\n\
         while [ \"$line\" -le \"$last\" ]; do\n    \
             command=$(sed -n \"${{line}}p\" \"$commands\")\n    \
             # A call for several pictures ends in their number, and prints a line of JSON for each that it renders.\n    \
             pictures=${{command##*# }}\n    \
             {{ sh -c \"$command\" || echo \"failed $?\"; }} | {{\n        \
                 made=0\n        \
                 while IFS= read -r text; do\n            \
                     case $text in\n                \
                         'failed '*) exit \"${{text#failed }}\" ;;\n                \
                         '{{'*)\n                    \
                             made=$((made + 1))\n                    \
                             [ \"$made\" -ge \"$pictures\" ] || echo \"{progress}: $((made * 100 / pictures))\" ;;\n                \
                         *) printf '%s\\n' \"$text\" ;;\n            \
                     esac\n        \
                 done\n    \
             }}\n    \
             line=$((line + 1))\n    \
             echo \"{progress}: $(((line - first) * 100 / (last - first + 1)))\"\n\
         done\n"
    )
}

fn tasks_sbatch(work: &Work) -> Result<String, CliError> {
    Ok(format!(
        "#!/bin/sh\n\
         #SBATCH --job-name=octray\n\
         #SBATCH --array=1-{}\n\
         #SBATCH --requeue\n\
         set -eu\n\
         sh {} \"$SLURM_ARRAY_TASK_ID\"\n",
        work.tasks(),
        file(work, "task.sh")?
    ))
}

fn merge_sbatch(work: &Work) -> Result<String, CliError> {
    Ok(format!(
        "#!/bin/sh\n\
         #SBATCH --job-name=octray-merge\n\
         #SBATCH --requeue\n\
         set -eu\n\
         sh -e {}\n",
        file(work, MERGES)?
    ))
}

/// Slurm runs a job in the folder where it was submitted, and cancels jobs that depend on a failed one.
fn submit(work: &Work) -> Result<String, CliError> {
    let folder = path(work, "")?;
    // After a backslash Slurm replaces nothing.
    if folder.contains('\\') {
        let why =
            format!("--into {folder}: Slurm takes no \\ in the names of its logs; name another directory");
        return Err(CliError::Usage(why));
    }
    // A % is Slurm's own in names of logs.
    let log = |name: &str| folder.replace('%', "%%") + name;
    let tasks = format!(
        "sbatch --parsable --output={} \"$@\" {}",
        quoted(&log("%A_%a.log"))?,
        file(work, "tasks.sbatch")?
    );
    let merge = if work.merges.is_empty() {
        String::new()
    } else {
        format!(
            "sbatch --dependency=\"afterok:${{tasks%%;*}}\" --kill-on-invalid-dep=yes --output={} \"$@\" {}\n",
            quoted(&log("merge.log"))?,
            file(work, "merge.sbatch")?
        )
    };
    Ok(format!(
        "#!/bin/sh\n\
         # Submits the tasks, and the merge that waits for them. Options of sbatch may follow, such as: --partition=night\n\
         # After a failure, run it again: whole pictures stay.\n\
         set -eu\n\
         cd {}\n\
         tasks=$({tasks})\n\
         echo \"tasks: $tasks\"\n\
         {merge}",
        quoted(&work.directory)?
    ))
}

/// A template of version 2023-09. Default paths must be within the template's directory, so the working directory is a
/// string. JSON strings are valid YAML.
fn template(work: &Work) -> Result<String, CliError> {
    if work.directory.chars().count() > LONGEST_STRING {
        return Err(CliError::Usage(format!(
            "the name of the current directory is longer than {LONGEST_STRING} characters, the most that Open Job Description takes"
        )));
    }
    let string = |text: &str| serde_json::Value::from(text).to_string();
    let plain = |c: char| {
        if c.is_ascii_alphanumeric() || "-_.".contains(c) {
            c
        } else {
            '-'
        }
    };
    let name: String = work.name.chars().map(plain).take(100).collect();
    let merge = if work.merges.is_empty() {
        String::new()
    } else {
        format!(
            r#"  - name: Merge
    dependencies:
      - dependsOn: Render
    script:
      actions:
        onRun:
          command: sh
          args: ["{{{{Task.File.Merge}}}}", "{{{{Param.Directory}}}}", "{{{{Param.Job}}}}"]
      embeddedFiles:
        - name: Merge
          type: TEXT
          data: |
            set -eu
            cd "$1"
            sh -e "$2/{MERGES}"
"#
        )
    };
    Ok(format!(
        r#"specificationVersion: jobtemplate-2023-09
name: {name}
parameterDefinitions:
  - name: Directory
    type: STRING
    default: {directory}
    description: Where all paths of the job begin that are not absolute.
  - name: Job
    type: PATH
    objectType: DIRECTORY
    dataFlow: IN
    default: .
    description: The directory of this template, with the commands.
steps:
  - name: Render
    parameterSpace:
      taskParameterDefinitions:
        - name: Task
          type: INT
          range: "1-{tasks}"
    script:
      actions:
        onRun:
          command: sh
          args: ["{{{{Task.File.Run}}}}", "{{{{Param.Directory}}}}", "{{{{Param.Job}}}}", "{{{{Task.Param.Task}}}}"]
      embeddedFiles:
        - name: Run
          type: TEXT
          data: |
            set -eu
            cd "$1"
            sh "$2/task.sh" "$3"
{merge}"#,
        name = string(&format!("octray {name}")),
        directory = string(&work.directory),
        tasks = work.tasks(),
    ))
}
