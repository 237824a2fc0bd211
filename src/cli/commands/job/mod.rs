//! `octray job`: writes the tasks of a farm as files. octray itself starts nothing and uses no network.
//!
//! ```text
//! commands.txt   one call of octray per line: frames, or tiles
//! merge.txt      one call of `octray merge` for each picture that has tiles
//! ...            files of the engine, which runs all lines of the first, then those of the second
//! ```

mod engines;

use super::render::save_poses;
use crate::{
    cli::{
        CliError, load,
        plan::{
            Engine, FOCUS, Frame, InputKind, InputPlan, Job, JobPlan, StartView, aov_path, explained,
            has_number, is_for_meshes, of_frame, stem,
        },
        report,
        write::AovKind,
    },
    error::{clip, clip_path},
    whole_file,
};
use std::{
    env, fs,
    io::{self, Write as _},
    path::{Path, PathBuf},
};

/// The most lines of `commands.txt`.
const MOST_TASKS: u64 = 100_000;
/// Columns and rows of a single picture's tiles.
const USUAL_TILES: u32 = 4;

/// The calls that the engine runs.
struct Work {
    /// Calls that render, in any order.
    commands: Vec<String>,
    /// Calls that merge, after all others.
    merges: Vec<String>,
    /// Calls of a task.
    chunk: usize,
    /// The working directory of all calls.
    directory: String,
    folder: PathBuf,
    name: String,
}

impl Work {
    fn tasks(&self) -> usize {
        self.commands.len().div_ceil(self.chunk)
    }
}

/// Writes the job's files, all of them or none.
///
/// # Errors
/// [`CliError`]: a picture that has no tiles, a folder that is not empty, a name that no line of a script can hold, an option
/// that all tasks of a scene would refuse; scenes that were skipped, also if there is a job for the others.
pub fn run(plan: &JobPlan) -> Result<(), CliError> {
    let skipped = &plan.render.skipped;
    for (path, error) in skipped {
        report::skipped(path, error);
    }
    if !plan.render.jobs.is_empty() || skipped.is_empty() {
        write_job(plan)?;
    }
    report::end(skipped.len())
}

fn write_job(plan: &JobPlan) -> Result<(), CliError> {
    let work = work(plan)?;
    let files = engines::files(&work, plan.engine)?;
    let start = engines::start(&work, plan.engine)?;
    let mut made = Made::default();
    let written = made.write(&work, &files).and_then(|()| save_poses(&plan.render));
    if written.is_err() {
        made.remove();
    }
    written?;
    if !plan.quiet && report::notes_to_terminal() {
        let tasks = work.tasks();
        report::note(&format!("{tasks} tasks; start them with: {start}\n"));
    }
    Ok(())
}

fn work(plan: &JobPlan) -> Result<Work, CliError> {
    let jobs = &plan.render.jobs;
    let frames = || {
        jobs.iter()
            .flat_map(|job| job.frames.iter().map(move |frame| (job, frame)))
    };
    let count = frames().count();
    if count == 0 {
        return Err(CliError::Failed("all pictures exist: nothing to do".into()));
    }
    if let Some((_, frame)) =
        frames().find(|(_, frame)| frame.output.is_animation() || !frame.output.is_file())
    {
        return Err(CliError::Usage(format!(
            "{}: a job makes pictures in files; name frames such as a-##.png",
            frame.output.name()
        )));
    }
    for job in jobs.iter().filter(|job| !job.frames.is_empty()) {
        check_file(plan, job)?;
    }
    let settings = &plan.render.looks.mesh.settings;
    let usual = (count == 1).then(|| [settings.width, settings.height].map(|side| side.min(USUAL_TILES)));
    let (mut commands, mut merges) = (Vec::new(), Vec::new());
    let chunk = match plan.tiles.or(usual) {
        None => {
            check_existing(plan)?;
            for job in jobs {
                commands.extend(frame_commands(plan, job)?);
            }
            1
        }
        Some(grid) => {
            check_tiles(plan, grid, count)?;
            let mut numbers = 1..;
            for job in jobs {
                let options = options(plan, job);
                for frame in &job.frames {
                    let tiles = Tiles {
                        plan,
                        job,
                        options: &options,
                        frame,
                        number: numbers.next().filter(|_| count > 1),
                    };
                    tiles.add(grid, &mut commands, &mut merges)?;
                }
            }
            plan.chunk as usize
        }
    };
    let directory = env::current_dir()
        .map_err(|error| CliError::Failed(format!("cannot find the current directory: {error}")))?;
    let directory = text(&directory)?.to_owned();
    // Not all engines need it in a line, but none takes control characters.
    line([directory.as_str()])?;
    let name = jobs.first().map(|job| stem(&job.input.path).to_string_lossy());
    Ok(Work {
        commands,
        merges,
        chunk,
        directory,
        folder: plan.folder.clone(),
        name: name.unwrap_or_default().into_owned(),
    })
}

/// Loads a scene whose contents decide whether its tasks take their options: `--focus` needs a lens, `--animation` an animation
/// of that name. To keep going, tasks of other scenes are made all the same.
fn check_file(plan: &JobPlan, job: &Job) -> Result<(), CliError> {
    let (camera, mesh) = (&job.input.camera, &job.input.mesh);
    let needs_lens = camera.focus.is_some() && !camera.defaults.contains(&FOCUS) && !camera.has_lens(None);
    // What is played was found already.
    let needs_animation = mesh.moment.is_some() && mesh.playback.is_none();
    if (needs_lens || needs_animation) && !plan.render.keep_going {
        load::load_and_list(&job.input, job.scene_memory, &mut Vec::new())
            .map_err(|error| explained(error, &plan.render.defaults))?;
    }
    Ok(())
}

fn check_tiles(plan: &JobPlan, [columns, rows]: [u32; 2], pictures: usize) -> Result<(), CliError> {
    let settings = &plan.render.looks.mesh.settings;
    let (width, height) = (settings.width, settings.height);
    if columns > width || rows > height {
        return Err(CliError::Usage(format!(
            "--tiles {columns}x{rows}: a picture of {width}x{height} has fewer pixels than tiles"
        )));
    }
    let tasks = u64::from(columns) * u64::from(rows) * pictures as u64;
    if tasks > MOST_TASKS {
        return Err(CliError::Usage(format!(
            "--tiles {columns}x{rows}: {tasks} tiles, expected at most {MOST_TASKS}"
        )));
    }
    Ok(())
}

/// Says which pictures exist: tasks without tiles leave them as they are.
fn check_existing(plan: &JobPlan) -> Result<(), CliError> {
    let frames = || plan.render.jobs.iter().flat_map(|job| &job.frames);
    let (existing, count) = (frames().filter(|frame| frame.exists()).count(), frames().count());
    if existing == 0 {
        return Ok(());
    }
    let what = format!("{existing} of {count} pictures exist");
    if plan.options.iter().any(|option| option == FORCE) {
        return Err(CliError::Usage(format!(
            "{FORCE}: {what}, and the tasks of a job leave them; remove them first"
        )));
    }
    if !plan.quiet {
        report::warnings([format!("{what} and stay; remove them to render them again")]);
    }
    Ok(())
}

/// Whether a scene has only one frame. Beside an animated scene, a still one has a number, too.
fn is_still(plan: &JobPlan, job: &Job) -> bool {
    job.whole == 1 && plan.render.orbit.is_none() && plan.render.poses.is_none()
}

/// The options of a scene's tasks. The frames per second matter only where they decide what a frame shows.
fn options(plan: &JobPlan, job: &Job) -> Vec<String> {
    // What does not apply is a default of the config file: on the command line it was refused.
    let input = &job.input;
    let applies = |option: &&String| match option.split('=').next() {
        _ if input.kind == InputKind::Scene && is_for_meshes(option) => false,
        Some("--environment" | "--environment-rotate") => input.mesh.environment.is_some(),
        Some("--animation" | "--animation-time") => input.mesh.moment.is_some(),
        Some(FOCUS) => !input.camera.defaults.contains(&FOCUS) || has_lens(input, job.scene_memory),
        Some("--ortho") => input.camera.fits_ortho || *option != "--ortho=fit",
        _ => true,
    };
    let mut options: Vec<String> = plan.options.iter().filter(applies).cloned().collect();
    let is_played = input.mesh.playback.is_some();
    options.extend(is_played.then(|| format!("--fps={}", plan.render.fps)));
    options
}

/// Whether there is a lens to focus: of the options, or of the scene's own camera.
fn has_lens(input: &InputPlan, memory: u64) -> bool {
    let camera = &input.camera;
    let is_own = !matches!(camera.start, StartView::Eye(_) | StartView::Classic(_));
    if camera.aperture.is_some() || input.kind != InputKind::Scene || !is_own {
        return camera.has_lens(None);
    }
    // What cannot be loaded is refused by the tasks.
    let loaded = load::load_and_list(input, memory, &mut Vec::new());
    loaded.is_ok_and(|loaded| camera.has_lens(Some(&loaded.scene)))
}

/// Calls for the frames of a scene: a chunk of consecutive frames each.
fn frame_commands(plan: &JobPlan, job: &Job) -> Result<Vec<String>, CliError> {
    let numbers: Vec<u32> = job
        .frames
        .iter()
        .filter_map(|frame| Some(frame.turn?.number))
        .collect();
    let mut words = options(plan, job);
    words.extend(job.frames.iter().find_map(|frame| force(plan, frame)));
    let output = |output: &str| format!("--output={output}");
    if let ([number], true) = (&numbers[..], is_still(plan, job)) {
        let name = of_frame(plan.output.as_deref(), *number);
        // In the task it would stand for a number, too.
        if has_number(Path::new(&name)) {
            return Err(CliError::Usage(format!(
                "{}: {} has one frame, and in a job the name of its picture has only one run of #; leave out the others",
                clip(plan.output.as_deref().unwrap_or_default()),
                clip_path(&job.input.path)
            )));
        }
        words.push(output(&name));
        return Ok(vec![render(&words, job)?]);
    }
    words.extend(plan.output.as_deref().map(output));
    if numbers.is_empty() {
        return Ok(vec![render(&words, job)?]);
    }
    let follows = |a: &u32, b: &u32| a + 1 == *b;
    let chunks = numbers
        .chunk_by(follows)
        .flat_map(|run| run.chunks(plan.chunk as usize));
    let commands = chunks.map(|chunk| {
        let range = match chunk {
            [first, .., last] => format!("--frames={first}-{last}"),
            _ => format!("--frames={}", chunk[0]),
        };
        let mut words = [&words[..], &[range]].concat();
        // The others have their scripts print the progress.
        if chunk.len() == 1 || plan.engine == Engine::Parallel {
            return render(&words, job);
        }
        words.push("--json=-".to_owned());
        Ok(format!("{} # {}", render(&words, job)?, chunk.len()))
    });
    commands.collect()
}

/// The tiles of one picture.
struct Tiles<'a> {
    plan: &'a JobPlan,
    job: &'a Job,
    options: &'a [String],
    frame: &'a Frame,
    /// The picture's number, if there are several.
    number: Option<u32>,
}

impl Tiles<'_> {
    fn add(
        &self,
        [columns, rows]: [u32; 2],
        commands: &mut Vec<String>,
        merges: &mut Vec<String>,
    ) -> Result<(), CliError> {
        let output = Path::new(self.frame.output.full_name());
        let format = self.frame.output.format();
        if format.is_lossy() {
            return Err(CliError::Usage(format!(
                "{}: {} loses detail in each tile; name a picture such as .png",
                self.frame.output.name(),
                format.name()
            )));
        }
        let extension = text(Path::new(output.extension().unwrap_or_default()))?;
        let settings = &self.plan.render.looks.mesh.settings;
        let edge = |i: u32, count: u32, side: u32| (u64::from(i) * u64::from(side) / u64::from(count)) as u32;
        let mut tiles = Vec::new();
        for y in 0..rows {
            for x in 0..columns {
                let [x0, x1] = [x, x + 1].map(|x| edge(x, columns, settings.width));
                let [y0, y1] = [y, y + 1].map(|y| edge(y, rows, settings.height));
                let number = self.number.map_or(String::new(), |number| format!("{number}-"));
                let tile = self
                    .plan
                    .folder
                    .join("tiles")
                    .join(format!("{number}{x0}-{y0}.{extension}"));
                let mut words = self.options.to_vec();
                words.extend(force(self.plan, self.frame));
                let turn = self.frame.turn.filter(|_| !is_still(self.plan, self.job));
                words.extend(turn.map(|turn| format!("--frames={}", turn.number)));
                words.push(format!("--crop={x0},{y0},{x1},{y1}"));
                words.push(format!("--output={}", text(&tile)?));
                commands.push(render(&words, self.job)?);
                tiles.push(tile);
            }
        }
        merges.push(merge(output, &tiles)?);
        for kind in self.frame.aovs.in_files() {
            let aov = |path: &Path| aov_path(path, AovKind::name(kind)).map(|path| path.path);
            let tiles: Vec<PathBuf> = tiles.iter().filter_map(|tile| aov(tile)).collect();
            if let Some(output) = aov(output) {
                merges.push(merge(&output, &tiles)?);
            }
        }
        Ok(())
    }
}

/// Replaces files that octray did not write.
const FORCE: &str = "--force";

/// The option `--force`, if a killed task may leave AOVs without their picture in a format without octray's mark: the next
/// attempt must replace them. `octray job` itself refuses to run if such files exist.
fn force(plan: &JobPlan, frame: &Frame) -> Option<String> {
    let has_files = frame.aovs.in_files().next().is_some();
    let option = FORCE.to_owned();
    (has_files && !frame.output.format().has_mark() && !plan.options.contains(&option)).then_some(option)
}

/// A call of `octray render` that leaves whole pictures alone.
fn render(options: &[String], job: &Job) -> Result<String, CliError> {
    let scene = text(&job.input.path)?;
    let words = ["octray", "render", "--no-config", "--quiet", "--skip-existing"];
    let words = words.into_iter().chain(options.iter().map(String::as_str));
    line(words.chain(["--", scene]))
}

fn merge(output: &Path, tiles: &[PathBuf]) -> Result<String, CliError> {
    let output = format!("--output={}", text(output)?);
    let tiles: Vec<&str> = tiles.iter().map(|tile| text(tile)).collect::<Result<_, _>>()?;
    let words = ["octray", "merge", "--quiet", &output, "--"];
    line(words.into_iter().chain(tiles))
}

/// A line of a shell script.
fn line<'a>(words: impl IntoIterator<Item = &'a str>) -> Result<String, CliError> {
    let quoted: Result<Vec<String>, _> = words.into_iter().map(quote).collect();
    let line = quoted.map(|words| words.join(" ")).ok();
    line.filter(|line| !line.contains(char::is_control))
        .ok_or_else(|| CliError::Usage("a name with control characters cannot be written into a job".into()))
}

/// A word for the shell. Of an option only the value is quoted, which reads better.
fn quote(word: &str) -> Result<String, shlex::QuoteError> {
    // A file may be named `--$(command)=a.scn`.
    let is_option = |word: &str| {
        let is_plain = |c: char| matches!(c, 'a'..='z' | '0'..='9' | '-');
        word.starts_with("--") && word.chars().all(is_plain)
    };
    match word.split_once('=') {
        Some((option, value)) if is_option(option) => Ok(format!("{option}={}", shlex::try_quote(value)?)),
        _ => shlex::try_quote(word).map(Into::into),
    }
}

fn text(path: &Path) -> Result<&str, CliError> {
    path.to_str().ok_or_else(|| {
        CliError::Usage(format!(
            "{}: a name that is not UTF-8 cannot be written into a job",
            clip_path(path)
        ))
    })
}

/// What of a job's files is on the disk.
#[derive(Default)]
struct Made {
    files: Vec<PathBuf>,
    /// The innermost first.
    folders: Vec<PathBuf>,
}

impl Made {
    fn write(&mut self, work: &Work, files: &[engines::File]) -> Result<(), CliError> {
        self.folder(&work.folder)?;
        if !work.merges.is_empty() {
            self.folder(&work.folder.join("tiles"))?;
        }
        for (name, text) in files {
            let path = work.folder.join(name);
            write(&path, text)?;
            self.files.push(path);
        }
        Ok(())
    }

    fn folder(&mut self, folder: &Path) -> Result<(), CliError> {
        let is_new = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
        let new = folder.ancestors().take_while(is_new).map(Path::to_owned);
        self.folders.splice(0..0, new);
        make_folder(folder)
    }

    /// Removes it all, as far as that is possible. A folder with anything else in it stays.
    fn remove(&self) {
        for file in &self.files {
            let _ = fs::remove_file(file);
        }
        for folder in &self.folders {
            let _ = fs::remove_dir(folder);
        }
    }
}

/// Makes a folder, or accepts an empty one: an old job's tiles would be mistaken for this one's.
fn make_folder(folder: &Path) -> Result<(), CliError> {
    let failed =
        |error: &io::Error| CliError::writing(&format!("to the directory {}", clip_path(folder)), error);
    fs::create_dir_all(folder).map_err(|error| CliError::making(folder, &error))?;
    let mut found = fs::read_dir(folder).map_err(|error| failed(&error))?;
    match found.next() {
        None => Ok(()),
        Some(_) => Err(CliError::Failed(format!(
            "the directory {} is not empty; name a new one with --into",
            clip_path(folder)
        ))),
    }
}

fn write(path: &Path, text: &str) -> Result<(), CliError> {
    whole_file::write(path, |out| out.write_all(text.as_bytes()))
        .map_err(|error| CliError::writing(&clip_path(path), &error))
}
