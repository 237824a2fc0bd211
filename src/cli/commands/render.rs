//! `octray render`: load, build, render, write, report.

mod ahead;
mod labels;
mod moving;
mod nothing;
mod poses;
mod rays;

use super::stages;
use crate::{
    accel::Bvh,
    cli::{
        CliError,
        load::{
            self, Input, Legend,
            faults::{self, Faults},
            memory,
        },
        plan::{
            Frame, Job, JsonTarget, Look, RenderPlan, SavedPoses, SheetPlan, explained, is_standard_stream,
            objection,
        },
        process::Interrupt,
        report::{self, RenderBar, RenderReport, Times, Verdicts, Written},
        write::{Animation, ColorBar, Inputs, Output, Sheet, json_line, write_json},
    },
    error::clip_path,
    render::Renderer,
    scene::{Camera, Scene},
};
use ahead::Ahead;
use labels::Labels;
use moving::{SceneAtTime, check_cameras};
pub use poses::save as save_poses;
use rays::expected_rays;
use std::{
    path::{Path, PathBuf},
    thread,
    time::{Duration, Instant},
};

/// The state of a call.
struct Call<'a> {
    plan: &'a RenderPlan,
    interrupt: &'a Interrupt,
    /// Whether progress and closing lines are shown.
    verbose: bool,
    /// When the program began or the previous picture was done.
    since: Instant,
    /// Files that are read, as far as they are known.
    inputs: Inputs,
    verdicts: Verdicts,
    /// The pictures of this scene.
    written: Written,
    /// The picture that all others go into.
    sheet: Option<Sheet>,
    labels: Labels,
    /// The cameras of all pictures.
    saved_poses: Option<SavedPoses>,
    /// Whether depth beyond the range of its file was reported.
    warned_of_depth: bool,
    /// Whether no picture of this scene is checked for showing nothing: one did, or it is no mesh.
    warned_of_nothing: bool,
    /// How many scenes were skipped.
    skipped: usize,
    /// Lines of JSON for a file.
    json: String,
}

/// A scene that is ready to be rendered.
struct Loaded<'a> {
    path: &'a Path,
    scene: &'a Scene,
    bvh: &'a Bvh,
    faults: &'a Faults,
    legend: Option<&'a Legend>,
    look: &'a Look,
}

/// Time that loading and building took; zero after the scene's first picture.
#[derive(Default)]
struct Spent {
    load: Duration,
    build: Duration,
}

/// Renders scenes into pictures. `start` is when the program began.
///
/// # Errors
/// [`CliError`]. The first error ends the call: pictures already written stay, the others are left as they were.
pub fn run(plan: &RenderPlan, start: Instant) -> Result<(), CliError> {
    render(plan, start).map_err(|error| explained(error, &plan.defaults))
}

fn render(plan: &RenderPlan, start: Instant) -> Result<(), CliError> {
    let interrupt = Interrupt::install()?;
    let mut call = Call {
        plan,
        interrupt: &interrupt,
        verbose: !plan.quiet && report::notes_to_terminal(),
        since: start,
        inputs: plan.inputs.clone(),
        verdicts: Verdicts::default(),
        written: Written::default(),
        sheet: plan.new_sheet()?,
        labels: Labels::new(plan),
        saved_poses: None,
        warned_of_depth: false,
        warned_of_nothing: false,
        skipped: 0,
        json: String::new(),
    };
    if !plan.quiet {
        report::warnings(plan.notes.iter().cloned());
    }
    for (path, error) in &plan.skipped {
        call.skip(path, error);
    }
    call.look_ahead()?;
    let jobs = plan.jobs.iter().enumerate();
    let rendered = thread::scope(|scope| {
        let mut ahead = Ahead::new(scope);
        jobs.map(|(i, job)| (job, &plan.jobs[i..]))
            .try_for_each(|(job, left)| call.render_job(job, left, &mut ahead))
    });
    // Also after a failure, for the pictures that were written.
    let json = match &plan.json {
        Some(target @ JsonTarget::File(_)) if !call.json.is_empty() => {
            let allowed = call.inputs.check_json(Some(target));
            allowed.and_then(|()| write_json(target, &call.json))
        }
        _ => Ok(()),
    };
    rendered?;
    json?;
    call.finish()
}

impl Call<'_> {
    /// Finds the files that all scenes read, if an output of one might replace a file of the next. Loading twice is the price of
    /// replacing files in a call with several scenes.
    fn look_ahead(&mut self) -> Result<(), CliError> {
        let jobs = &self.plan.jobs;
        let json_exists = matches!(&self.plan.json, Some(JsonTarget::File(path)) if path.exists());
        let replaces = json_exists || jobs.iter().flat_map(Job::outputs).any(Output::exists);
        if jobs.len() == 1 || !replaces {
            return Ok(());
        }
        if jobs.iter().any(|job| is_standard_stream(&job.input.path)) {
            let why = "standard input cannot be one of several scenes if files are replaced: render it in a call of its own";
            return Err(CliError::Usage(why.into()));
        }
        let mut loaded = Ok(());
        for job in jobs {
            let mut files = Vec::new();
            let input = load::load_and_list(&job.input, job.scene_memory, &mut files);
            self.interrupt.check()?;
            let scene = input.as_ref().ok().map(|input| &input.scene);
            self.inputs.add_scene(&job.input.path, &files, scene);
            if !self.plan.keep_going {
                loaded = loaded.and(input.map(drop));
            }
        }
        self.check_inputs(jobs)?;
        // The files of a faulty scene are not known.
        loaded
    }

    /// Writes the sheet, and reports skipped scenes.
    fn finish(mut self) -> Result<(), CliError> {
        if let (Some(sheet), Some(plan)) = (self.sheet.take(), &self.plan.sheet)
            && plan.count > 0
        {
            let size = sheet.size();
            let (written, time) = timed(|| sheet.finish(&plan.output));
            written?;
            self.written.add(plan.output.name(), time);
            if self.verbose && !self.plan.stats {
                report::note(&self.written.line(size));
            }
        }
        if let Some(saved) = &self.saved_poses {
            self.plan.write_poses(saved, &self.inputs)?;
        }
        self.verdicts.finish()?;
        report::end(self.skipped)
    }

    /// Leaves the places of a job's pictures on the sheet empty.
    fn leave_empty(&mut self, job: &Job) {
        for frame in &job.frames {
            if let Some(sheet) = &mut self.sheet {
                sheet.add(&self.labels.of(&job.input.path, frame), None);
            }
        }
    }

    /// Reports why a scene is skipped.
    fn skip(&mut self, path: &Path, error: &CliError) {
        self.skipped += 1;
        report::skipped(path, error);
    }

    fn check_inputs(&self, jobs: &[Job]) -> Result<(), CliError> {
        let poses = self.plan.save_poses.clone().map(JsonTarget::File);
        for target in [self.plan.json.as_ref(), poses.as_ref()] {
            self.inputs.check_json(target)?;
        }
        objection(jobs, &self.inputs).map_or(Ok(()), |objection| Err(CliError::Usage(objection)))
    }

    /// Renders the pictures of one scene, the first of the remaining ones.
    fn render_job<'env>(
        &mut self,
        job: &Job,
        left: &'env [Job],
        ahead: &mut Ahead<'_, 'env>,
    ) -> Result<(), CliError> {
        let (input, files, load_time) = self.load(job, ahead);
        self.interrupt.check()?;
        let loaded = input.as_ref().ok().map(|input| &input.scene);
        self.inputs.add_scene(&job.input.path, &files, loaded);
        let input = match input {
            Err(error @ (CliError::Load(_) | CliError::Failed(_) | CliError::Memory(_)))
                if self.plan.keep_going =>
            {
                self.skip(job.input.name(), &explained(error, &self.plan.defaults));
                self.leave_empty(job);
                return Ok(());
            }
            input => input?,
        };
        let is_mesh = input.is_mesh();
        let look = self.plan.looks.of(is_mesh);
        let is_played = job.input.mesh.playback.is_some();
        self.warned_of_nothing = !is_mesh || is_played;
        let Input {
            scene,
            camera,
            rig,
            legend,
            poses,
            is_cloud,
            notes,
            ..
        } = input;
        self.check_inputs(left)?;
        self.check_frames(job, &scene, is_mesh)?;
        check_cameras(job, &scene)?;
        self.saved_poses = self.plan.poses_of(job, &scene, &camera)?;
        let faults = faults::of(&scene);
        // The triangles of tubes are not the user's, and the first pose may be flat.
        let warned = Some(&faults).filter(|_| !is_cloud && !is_played);
        self.warn(job.input.name(), &scene, warned, notes);
        if job.frames.is_empty() {
            return Ok(());
        }
        let quality = self.plan.build.quality(
            expected_rays((&scene, &camera), look, job),
            scene.primitive_count(),
        );
        memory::check_build(&scene, quality)?;
        let (bvh, build_time) = timed(|| stages::build(&scene, quality, self.verbose));
        let taken = (scene.memory_bytes() + bvh.stats().memory_bytes) as u64;
        ahead.start(left.get(1), job.scene_memory.saturating_sub(taken));

        let spent = Spent {
            load: load_time,
            build: build_time,
        };
        let scene = SceneAtTime {
            scene,
            bvh,
            camera,
            rig,
            legend,
            poses,
            quality,
        };
        self.render_frames(job, look, scene, &faults, spent)?;
        self.note_written(look);
        Ok(())
    }

    /// Renders the frames of a scene that is loaded.
    fn render_frames(
        &mut self,
        job: &Job,
        look: &Look,
        mut at_time: SceneAtTime,
        faults: &Faults,
        mut spent: Spent,
    ) -> Result<(), CliError> {
        let mut animation = self.animation(job, look)?;
        for frames in job.frames.chunks(at_time.frames_together(job.frames.len())) {
            if let [frame] = frames {
                spent.build += at_time.move_to(frame.turn, job)?;
                let view = self.plan.camera_of(frame.turn, &at_time.camera)?.view();
                at_time.light(&view)?;
            }
            let loaded = Loaded {
                path: &job.input.path,
                scene: &at_time.scene,
                bvh: &at_time.bvh,
                faults,
                legend: at_time.legend.as_ref(),
                look,
            };
            let mut renderer = Renderer::new(&at_time.scene, &at_time.bvh);
            for frame in frames {
                let camera = self.plan.camera_of(frame.turn, &at_time.camera)?;
                self.render_frame(
                    &loaded,
                    (&mut renderer, &camera),
                    frame,
                    &mut spent,
                    animation.as_mut(),
                )?;
            }
        }
        if let Some(animation) = animation {
            animation.finish()?;
        }
        Ok(())
    }

    /// The scene of a job, the files that it reads, and how long it took.
    fn load(
        &self,
        job: &Job,
        ahead: &mut Ahead<'_, '_>,
    ) -> (Result<Input, CliError>, Vec<PathBuf>, Duration) {
        if let Some((input, files, time)) = stages::waiting(&job.input, self.verbose, || ahead.take()) {
            return (Ok(input), files, time);
        }
        let mut files = Vec::new();
        let (input, time) = timed(|| stages::load(&job.input, job.scene_memory, &mut files, self.verbose));
        (input, files, time)
    }

    /// Reports the written pictures of a scene; a sheet comes last.
    fn note_written(&mut self, look: &Look) {
        if self.sheet.is_some() {
            return;
        }
        let written = std::mem::take(&mut self.written);
        if self.verbose && !self.plan.stats {
            let window = look.settings.window();
            report::note(&written.line((window.width(), window.height())));
        }
    }

    /// The animation of a job's frames, if its output is one.
    fn animation<'a>(&self, job: &'a Job, look: &Look) -> Result<Option<Animation<'a>>, CliError> {
        let Some(output) = job
            .frames
            .first()
            .map(|frame| &frame.output)
            .filter(|output| output.is_animation())
        else {
            return Ok(None);
        };
        let window = look.settings.window();
        let frames = (job.frames.len() as u32, self.plan.fps);
        let animation = Animation::begin(
            output,
            [window.width(), window.height()],
            frames,
            look.picture.backdrop.is_transparent(),
        );
        animation.map(Some)
    }

    fn warn(&self, path: &Path, scene: &Scene, faults: Option<&Faults>, notes: Vec<String>) {
        if self.plan.quiet {
            return;
        }
        let empty = scene.primitive_count() == 0 && scene.planes().is_empty();
        let empty = empty.then(|| format!("{}: the scene is empty", clip_path(path)));
        let faulty = faults.and_then(|faults| faults.warning(path));
        report::warnings(faulty.into_iter().chain(empty).chain(notes));
    }

    /// Renders, writes and compares one picture.
    fn render_frame(
        &mut self,
        loaded: &Loaded<'_>,
        (renderer, camera): (&mut Renderer<'_>, &Camera),
        frame: &Frame,
        spent: &mut Spent,
        animation: Option<&mut Animation<'_>>,
    ) -> Result<(), CliError> {
        let (plan, interrupt) = (self.plan, self.interrupt);
        let Look {
            settings,
            picture: options,
        } = loaded.look;
        let output = &frame.output;
        let bar = RenderBar::new(self.verbose, interrupt);
        let progress = &|progress| bar.report(progress);
        let mut picture = output.new_picture(options);
        let (stats, aovs) = bar.during(|| {
            let stats = picture.render(renderer, camera, settings, progress)?;
            let aovs = frame
                .aovs
                .render(renderer, loaded.scene, camera, settings, progress)?;
            Ok::<_, CliError>((stats, aovs))
        })?;
        interrupt.check()?;
        let legend = loaded.legend.filter(|_| options.has_color_bar);
        if let Some(bar) = legend.and_then(|legend| ColorBar::new(legend, [settings.width, settings.height]))
        {
            picture.draw(&bar, settings.window(), options.byte_transfer);
        }

        let (written, write_time) = timed(|| {
            if let Some(aovs) = &aovs {
                frame.aovs.write(aovs, &mut picture)?;
            }
            match (animation, &mut self.sheet) {
                (Some(animation), _) => animation.add(&picture),
                (None, Some(sheet)) => {
                    sheet.add(&self.labels.of(loaded.path, frame), Some(&picture));
                    Ok(())
                }
                (None, None) => output.write(&mut picture),
            }
        });
        written?;
        self.warn_of_depth(frame, aovs.as_ref());
        self.warn_of_nothing(loaded, (renderer, camera), frame, &stats);

        let Spent { load, build } = std::mem::take(spent);
        let times = Times {
            load,
            build,
            write: write_time,
            total: self.since.elapsed(),
        };
        self.since = Instant::now();
        self.report(|| {
            let aov = aovs.as_ref().and_then(|aovs| frame.aovs.report(aovs));
            let scene = (loaded.path, loaded.scene, loaded.faults);
            RenderReport::new(scene, loaded.bvh, output.full_name(), settings, &stats, &times).with(
                frame.turn.map(|turn| turn.number),
                aov,
                loaded.legend.cloned(),
            )
        })?;
        self.written.add(written_name(output), times.total);
        if let Some(comparison) = &frame.comparison {
            let verdict = comparison.run(&picture, output, options.byte_transfer)?;
            self.verdicts.add(verdict, plan.quiet);
        }
        Ok(())
    }

    /// Prints a picture's figures as text and as JSON, if they are wanted.
    fn report(&mut self, figures: impl Fn() -> RenderReport) -> Result<(), CliError> {
        if self.plan.stats {
            report::note(&figures().text());
        }
        match &self.plan.json {
            Some(target @ JsonTarget::Stdout) => write_json(target, &json_line(&figures()))?,
            Some(JsonTarget::File(_)) => self.json += &json_line(&figures()),
            None => {}
        }
        Ok(())
    }
}

impl RenderPlan {
    fn new_sheet(&self) -> Result<Option<Sheet>, CliError> {
        let window = self.looks.mesh.settings.window();
        let new = |plan: &SheetPlan| Sheet::new([window.width(), window.height()], plan.columns, plan.count);
        self.sheet.as_ref().map(new).transpose()
    }
}

/// A written picture, as the closing line names it.
fn written_name(output: &Output) -> &str {
    match (output.place() == Path::new("-"), output.is_animation()) {
        (true, true) => "an animation to standard output",
        (true, false) => "a PNG to standard output",
        (false, _) => output.name(),
    }
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, Duration) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed())
}
