//! `octray render`: load, build, render, write.

use super::{
    CliError,
    aov::AovArg,
    args::{RenderArgs, StatsFormat},
    batch::{self, Job, Shot, Verdicts},
    camera_args::MeshArgs,
    faults::{self, Faults},
    input::{self, Input},
    interrupt::Interrupt,
    memory,
    output::Output,
    picture::Picture,
    progress::Bar,
    report::{Memory, Primitives, Rays, Report, SCHEMA, Seconds},
    turntable::turned,
};
use crate::{
    accel::Bvh,
    error::escape,
    render::{FrameStats, Mode, Renderer, Settings},
    scene::{Camera, Scene},
    simd,
};
use std::{
    io::{self, IsTerminal, Write},
    path::Path,
    time::{Duration, Instant},
};

/// What all pictures of a call have in common.
struct Call<'a> {
    args: &'a RenderArgs,
    settings: &'a Settings,
    interrupt: &'a Interrupt,
    talkative: bool,
}

/// A scene that is ready to be rendered.
struct Loaded<'a> {
    job: &'a Job<'a>,
    scene: &'a Scene,
    bvh: &'a Bvh,
    faults: &'a Faults,
}

/// What the next picture has taken already.
struct Spent<'a> {
    load: Duration,
    build: Duration,
    /// When the picture before was done.
    since: &'a mut Instant,
}

/// Renders scenes into pictures. `start` is when the program began.
///
/// # Errors
/// [`CliError`]. The first one ends the call: pictures that are written stay, the others are as they were before.
pub fn run(args: &RenderArgs, start: Instant) -> Result<(), CliError> {
    let mut settings = args.trace.settings(args.size)?;
    args.picture.apply(&mut settings)?;
    args.sampling.apply(&mut settings)?;
    settings.validate()?;
    let window = settings.window();
    let size = (window.width(), window.height());
    let jobs = batch::plan(args, size)?;
    // All of them before the first is loaded: else the last one's fault would be told after the others' pictures.
    for job in &jobs {
        input::check(job.scene, &args.camera, &args.mesh)?;
    }
    let interrupt = Interrupt::install()?;
    let call = Call {
        args,
        settings: &settings,
        interrupt: &interrupt,
        talkative: !args.quiet && io::stderr().is_terminal(),
    };
    let mut since = start;
    let mut verdicts = Verdicts::default();
    for job in &jobs {
        memory::check_threads(args.trace.threads)?;
        let limit = args.memory.beside(size, job.pixel_bytes(args))?;
        render_scene(&call, job, limit, &mut since, &mut verdicts)?;
    }
    verdicts.finish()
}

/// Renders the pictures of one scene, which may take so many bytes of memory. `since` is when the picture before was done.
fn render_scene(
    call: &Call<'_>,
    job: &Job<'_>,
    memory_limit: u64,
    since: &mut Instant,
    verdicts: &mut Verdicts,
) -> Result<(), CliError> {
    let Call {
        args,
        settings,
        interrupt,
        ..
    } = *call;
    let aspect = f64::from(settings.width) / f64::from(settings.height);
    let mesh = MeshArgs {
        turning: args.series.turntable.is_some(),
        ..args.mesh.clone()
    };
    let load = || input::load(job.scene, &args.camera, &mesh, aspect, memory_limit);
    let (input, load_time) = interrupt.exit_at_once_during(|| timed(load))?;
    let Input {
        mut scene,
        camera,
        rig,
        notes,
        ..
    } = input?;
    let faults = faults::of(&scene);
    if !args.quiet {
        let empty = (scene.primitive_count() == 0).then(|| {
            format!(
                "{}: there is nothing in the scene to be seen",
                job.scene.display()
            )
        });
        for note in notes.into_iter().chain(faults.warning(job.scene)).chain(empty) {
            let _ = writeln!(io::stderr(), "octray: warning: {}", escape(&note));
        }
    }
    let rays = expected_rays(args, settings, &scene, job.shots.len());
    let quality = args.trace.build.quality(rays, scene.primitive_count());
    memory::check_build(&scene, quality)?;
    let (bvh, build_time) = interrupt.exit_at_once_during(|| timed(|| Bvh::build_with(&scene, quality)))?;

    let mut spent = Spent {
        load: load_time,
        build: build_time,
        since,
    };
    let camera_of = |shot: &Shot| match shot.turn {
        Some((number, count)) => Camera::new(&turned(&camera.view(), number, count)),
        None => Ok(camera),
    };
    // A renderer holds on to its scene: where the lights go with the view, each picture has one of its own.
    let together = if rig.is_some() { 1 } else { job.shots.len().max(1) };
    for shots in job.shots.chunks(together) {
        if let (Some(rig), [shot]) = (&rig, shots) {
            let view = camera_of(shot)?.view();
            let lights = rig.lights(view.eye - view.target);
            scene.take_lights(lights.map_err(|error| CliError::Failed(error.to_string()))?);
        }
        let loaded = Loaded {
            job,
            scene: &scene,
            bvh: &bvh,
            faults: &faults,
        };
        let mut renderer = Renderer::new(&scene, &bvh);
        for shot in shots {
            call.render_shot(
                &loaded,
                &mut renderer,
                shot,
                &camera_of(shot)?,
                &mut spent,
                verdicts,
            )?;
        }
    }
    Ok(())
}

impl Call<'_> {
    /// Renders, writes and compares one picture.
    fn render_shot(
        &self,
        loaded: &Loaded<'_>,
        renderer: &mut Renderer<'_>,
        shot: &Shot,
        camera: &Camera,
        spent: &mut Spent<'_>,
        verdicts: &mut Verdicts,
    ) -> Result<(), CliError> {
        let Self {
            args,
            settings,
            interrupt,
            talkative,
        } = *self;
        let Loaded {
            job,
            scene,
            bvh,
            faults,
        } = *loaded;
        let output = &shot.output;
        let bar = Bar::new(talkative, interrupt);
        let mut picture = output.new_picture(&args.picture);
        let progress = &|progress| bar.report(progress);
        let frame = picture.render(renderer, camera, settings, progress);
        let frame = frame.and_then(|frame| {
            let aovs = shot.aovs.render(renderer, scene, camera, settings, progress)?;
            Ok((frame, aovs))
        });
        let pixels_done = bar.clear();
        if args.keep_partial && interrupt.requested() {
            return Err(keep_partial(args, output, &picture, pixels_done, interrupt));
        }
        let (frame, aovs) = frame?;
        interrupt.check()?;

        let (written, write_time) = timed(|| {
            if let Some(aovs) = &aovs {
                shot.aovs.write(aovs, &mut picture, interrupt)?;
            }
            output.write(&picture, interrupt)
        });
        written?;

        // Loading and building count for the scene's first picture.
        let times = Times {
            load: std::mem::take(&mut spent.load),
            build: std::mem::take(&mut spent.build),
            write: write_time,
            total: spent.since.elapsed(),
        };
        *spent.since = Instant::now();
        let report = || {
            let mut report = report(job.scene, settings, scene, faults, bvh, &frame, output, &times);
            report.aov = aovs.as_ref().and_then(|aovs| shot.aovs.report(aovs));
            report
        };
        let closing = match args.stats {
            Some(StatsFormat::Json) => report().json(),
            Some(StatsFormat::Text) => report().text(),
            None if talkative => format!(
                "{}: {}x{} in {:.2} s\n",
                output.name(),
                settings.window().width(),
                settings.window().height(),
                times.total.as_secs_f64()
            ),
            None => String::new(),
        };
        // The picture is written: that nobody reads standard error is no failure.
        let _ = io::stderr().write_all(closing.as_bytes());
        if let Some(comparison) = &shot.comparison {
            verdicts.add(comparison.run(&picture, output.name(), interrupt)?, args.quiet);
        }
        Ok(())
    }
}

/// Saves an unfinished picture after a signal. Another signal ends that, too.
fn keep_partial(
    args: &RenderArgs,
    output: &Output,
    picture: &Picture,
    pixels_done: u64,
    interrupt: &Interrupt,
) -> CliError {
    interrupt.forget();
    if let Some(partial) = output.partial() {
        let text = match partial.write(picture, interrupt) {
            Ok(()) => format!(
                "interrupted: {} has {pixels_done} of {} pixels, the others are black",
                partial.name(),
                picture.pixel_count()
            ),
            Err(error) => error.text().unwrap_or_default(),
        };
        if !args.quiet && !text.is_empty() {
            // The exit code says that it was interrupted.
            let _ = writeln!(io::stderr(), "octray: {text}");
        }
    }
    CliError::Interrupted
}

/// Camera rays, and shadow rays as if each hit something; what mirrors add is not known beforehand.
fn expected_rays(args: &RenderArgs, settings: &Settings, scene: &Scene, pictures: usize) -> f64 {
    // What rays cost depends on the BVH, so that of a part is to be that of the whole.
    let (window, pictures) = if args.picture.aovs.contains(&AovArg::Heat) {
        let whole = Settings {
            crop: None,
            ..*settings
        };
        (whole.window(), args.series.turntable.unwrap_or(1) as usize)
    } else {
        (settings.window(), pictures)
    };
    let samples = f64::from(settings.samples);
    let lights = if settings.shadows {
        scene.lights().x.len()
    } else {
        0
    };
    f64::from(window.width()) * f64::from(window.height()) * pictures as f64 * samples * (1.0 + lights as f64)
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, Duration) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed())
}

/// Wall-clock times that are not in [`FrameStats`].
struct Times {
    load: Duration,
    build: Duration,
    write: Duration,
    total: Duration,
}

#[allow(clippy::too_many_arguments, reason = "all that a report tells of")]
fn report(
    path: &Path,
    settings: &Settings,
    scene: &Scene,
    faults: &Faults,
    bvh: &Bvh,
    frame: &FrameStats,
    output: &Output,
    times: &Times,
) -> Report {
    let render = frame.elapsed.as_secs_f64();
    let rays = frame.rays;
    Report {
        schema: SCHEMA,
        scene: path.display().to_string(),
        output: output.name().to_owned(),
        width: settings.window().width(),
        height: settings.window().height(),
        samples: u64::from(settings.samples),
        max_depth: settings.max_depth,
        shadows: settings.shadows,
        mode: match settings.mode {
            Mode::Packet => "packet",
            Mode::Scalar => "scalar",
        },
        build: bvh.stats().quality.name(),
        isa: simd::isa(),
        threads: settings
            .threads
            .unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from)),
        primitives: Primitives {
            triangles: scene.triangles().corners.len(),
            spheres: scene.spheres().radius.len(),
            degenerate_triangles: scene.degenerate_triangles(),
            duplicate_triangles: faults.duplicate,
            inverted_triangles: faults.inverted,
        },
        rays: Rays {
            camera: rays.camera,
            shadow: rays.shadow,
            reflection: rays.reflection,
            total: rays.total(),
        },
        seconds: Seconds {
            load: times.load.as_secs_f64(),
            build: times.build.as_secs_f64(),
            render,
            write: times.write.as_secs_f64(),
            total: times.total.as_secs_f64(),
        },
        rays_per_s: if render > 0.0 {
            rays.total() as f64 / render
        } else {
            0.0
        },
        memory_bytes: Memory {
            scene: scene.memory_bytes(),
            bvh: bvh.stats().memory_bytes,
        },
        aov: None,
    }
}
