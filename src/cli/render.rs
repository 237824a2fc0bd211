//! `octray render`: load, build, render, write.

use super::{
    CliError,
    args::{RenderArgs, StatsFormat},
    faults::{self, Faults},
    input::{self, Input},
    interrupt::Interrupt,
    output::Output,
    progress::Bar,
    report::{Memory, Primitives, Rays, Report, SCHEMA, Seconds},
};
use crate::{
    accel::Bvh,
    error::escape,
    render::{FrameStats, Mode, Renderer, Settings},
    scene::Scene,
    simd,
};
use std::{
    io::{self, IsTerminal, Write},
    path::PathBuf,
    time::{Duration, Instant},
};

/// Renders a scene into a picture. `start` is when the program began.
///
/// # Errors
/// [`CliError`]. The output is as it was before.
pub fn run(args: &RenderArgs, start: Instant) -> Result<(), CliError> {
    let settings = args.trace.settings(args.size, args.samples_per_axis)?;
    let output = Output::prepare(&output_path(args), &args.scene, settings.width, settings.height)?;
    let talkative = !args.quiet && io::stderr().is_terminal();

    let interrupt = Interrupt::install()?;
    let aspect = f64::from(settings.width) / f64::from(settings.height);
    let load = || input::load(&args.scene, &args.camera, &args.mesh, aspect);
    let (input, load_time) = interrupt.exit_at_once_during(|| timed(load))?;
    let Input { scene, camera, notes } = input?;
    let faults = faults::of(&scene);
    if !args.quiet {
        let notes = notes.into_iter().chain(faults.warning(&args.scene));
        for note in notes {
            let _ = writeln!(io::stderr(), "octray: warning: {}", escape(&note));
        }
    }
    let quality = args
        .trace
        .build
        .quality(expected_rays(&settings, &scene), scene.primitive_count());
    let (bvh, build_time) = interrupt.exit_at_once_during(|| timed(|| Bvh::build_with(&scene, quality)))?;

    let bar = Bar::new(talkative, &interrupt);
    let mut picture = output.new_picture();
    let mut renderer = Renderer::new(&scene, &bvh);
    let frame = picture.render(&mut renderer, &camera, &settings, &|progress| {
        bar.report(progress)
    });
    bar.clear();
    let frame = frame?;
    interrupt.check()?;

    let (written, write_time) = timed(|| output.write(&picture, &interrupt));
    written?;

    let times = Times {
        load: load_time,
        build: build_time,
        write: write_time,
        total: start.elapsed(),
    };
    let closing = match args.stats {
        Some(StatsFormat::Json) => {
            report(args, &settings, &scene, &faults, &bvh, &frame, &output, &times).json()
        }
        Some(StatsFormat::Text) => {
            report(args, &settings, &scene, &faults, &bvh, &frame, &output, &times).text()
        }
        None if talkative => format!(
            "{}: {}x{} in {:.2} s\n",
            output.name(),
            settings.width,
            settings.height,
            times.total.as_secs_f64()
        ),
        None => String::new(),
    };
    // The picture is written: that nobody reads standard error is no failure.
    let _ = io::stderr().write_all(closing.as_bytes());
    Ok(())
}

/// Camera rays, and shadow rays as if each hit something; what mirrors add is not known beforehand.
fn expected_rays(settings: &Settings, scene: &Scene) -> f64 {
    let samples = f64::from(settings.samples_per_axis).powi(2);
    let lights = if settings.shadows {
        scene.lights().x.len()
    } else {
        0
    };
    f64::from(settings.width) * f64::from(settings.height) * samples * (1.0 + lights as f64)
}

/// The scene's name with .png, in the current folder, unless another is asked for.
fn output_path(args: &RenderArgs) -> PathBuf {
    args.output.clone().unwrap_or_else(|| {
        let mut name = args.scene.file_stem().unwrap_or("octray".as_ref()).to_owned();
        name.push(".png");
        name.into()
    })
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
    args: &RenderArgs,
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
        scene: args.scene.display().to_string(),
        output: output.name().to_owned(),
        width: settings.width,
        height: settings.height,
        samples: u64::from(settings.samples_per_axis).pow(2),
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
            triangles: scene.triangles().v0.len(),
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
    }
}
