//! Every argument of every command.

use super::generate::GenerateArgs;
use super::picture_args::PictureArgs;
use super::{
    batch_args::{CompareArgs, SeriesArgs},
    config::ConfigArgs,
    shell::{CompletionsArgs, ManArgs},
    value::{self, Size},
    verify::VerifyArgs,
    version,
};
use crate::{
    accel::BuildQuality,
    course,
    render::{Mode, RenderError, Settings},
};
use clap::{Args, CommandFactory, Parser, Subcommand, ValueEnum};
use glam::DVec3;
use std::{
    ffi::{OsStr, OsString},
    path::{Path, PathBuf},
};

const EXAMPLES: &str = "\
Examples:
  octray cow.scn                                  cow.png, 512x512, the course's first view
  octray cow.scn -o big.png --size 3840x2160      a large picture
  octray cow.scn --view 3 --samples 16            another view, 4x4 samples a pixel
  octray cow.scn --eye -3,2,1.5 --target 0,0,0.5  a view of your own
  octray garden.scn --camera gate --fov 30        a camera of the scene's own, closer
  octray cow.scn -o cow.exr                       linear floats instead of 8 bits
  octray cow.scn -o - | magick - cow.webp         a PNG into a pipe
  octray bunny.ply --ground                       a mesh, framed and lit, on a ground
  octray view cow.scn                             a window to look around in
  octray info cow.scn                             what is in a scene
  octray bench cow.scn                            how fast this machine traces it
  octray bench --all --quick                      how fast it traces scenes of many kinds
  octray verify --seconds 60                      whether all ways of tracing agree, on this machine

`octray SCENE` is short for `octray render SCENE`, whose options `octray render --help` lists. A scene whose \
name is that of a command needs a path, such as ./info, or the command's name before it.

Exit codes: 0 done; 1 the scene, the disk or a limit failed; 2 usage; 3 there is no display; 4 this CPU
cannot run this build; 5 a comparison or verification differs; 130 interrupted.";

const RENDER_EXAMPLES: &str = "\
Examples:
  octray render cow.scn -o cow.jpg --size 1920x1080 --samples 9
  octray render cow.scn --eye -3,2,1.5 --target 0,0,0.5 --up 0,0,1 --fov 30
  octray render cow.scn --crop 0,0,256,128 -o corner.png
  octray render cow.scn --samples 16 --pattern sobol --filter blackman-harris --srgb
  octray render cow.scn --background transparent --aov depth,normal,heat
  octray render cow.scn --quiet --stats=json 2> stats.json
  octray render a.scn b.scn -o out/{stem}.jpg       several scenes, each with its own picture
  octray render cow.scn --turntable 48 -o t-##.png  48 pictures around the cow
  octray render cow.scn --turntable 48 -o t-##.png --frames 1-24
                                                    the half of them
  octray render cow.scn --compare cow.png --tolerance 2 -o new.png
                                                    exits with 5 if the picture has changed
  generate-scene | octray render - -o made.png      a scene from a program";

const COMPLETIONS_EXAMPLES: &str = "\
Examples:
  octray completions bash > ~/.local/share/bash-completion/completions/octray
  octray completions zsh > _octray          in a folder of $fpath
  octray completions fish > ~/.config/fish/completions/octray.fish";

#[cfg(feature = "viewer")]
const VIEW_KEYS: &str = "\
In the window: drag with the left button to turn, with the right one (or the wheel) to come nearer;
press ? to see all keys, q to quit.";

const MAN_EXAMPLES: &str = "\
Examples:
  octray man > octray.1
  octray man render > octray-render.1
  octray man render | man -l -                read it at once";

const RENDER_USAGE: &str = "octray [render] [OPTIONS] <SCENE>...";

const USAGE: &str = "octray [render] [OPTIONS] <SCENE>...\n       octray <COMMAND> ...";

/// A fast CPU ray tracer for scenes of triangle meshes and spheres.
#[derive(Debug, Parser)]
#[command(
    name = "octray",
    version = version::short(),
    long_version = version::long(),
    propagate_version = true,
    override_usage = USAGE,
    after_long_help = EXAMPLES,
    max_term_width = 110
)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene into a picture
    #[command(override_usage = RENDER_USAGE, after_long_help = RENDER_EXAMPLES)]
    Render(RenderArgs),
    /// Look around a scene in a window, ray traced live
    #[cfg(feature = "viewer")]
    #[command(after_long_help = VIEW_KEYS)]
    View(ViewArgs),
    /// Show what is in a scene and what its BVH is made of
    Info(InfoArgs),
    /// Time ways of tracing against each other on the same rays, on one thread
    Bench(BenchArgs),
    /// Check that every way of tracing finds what brute force finds, on random scenes and rays
    Verify(VerifyArgs),
    /// Make up a scene of any size, from a seed
    Generate(GenerateArgs),
    /// Print a script that completes octray's arguments in a shell
    #[command(after_help = COMPLETIONS_EXAMPLES)]
    Completions(CompletionsArgs),
    /// Print octray's manual page, or that of a command
    #[command(after_help = MAN_EXAMPLES)]
    Man(ManArgs),
}

#[derive(Args, Debug)]
pub struct RenderArgs {
    /// The scene (.scn), or a mesh: .ply, .obj, .stl, .gltf or .glb; or several; - for a scene from standard input
    #[arg(required = true, value_name = "SCENE")]
    pub scenes: Vec<PathBuf>,

    /// The picture: .png, .ppm, .qoi, .jpg, .bmp, .tiff or .exr (linear floats); - for a PNG to standard
    /// output; {stem} stands for the scene's name [default: {stem}.png, in the current folder]
    #[arg(short, long, value_name = "FILE", help_heading = "Picture")]
    pub output: Option<PathBuf>,

    /// Width and height, pixels
    #[arg(long, value_name = "WxH", value_parser = value::size, default_value = "512x512", help_heading = "Picture")]
    pub size: Size,

    #[command(flatten)]
    pub picture: PictureArgs,

    #[command(flatten)]
    pub camera: CameraArgs,

    #[command(flatten)]
    pub mesh: MeshArgs,

    #[command(flatten)]
    pub trace: TraceArgs,

    /// Samples for each pixel: 1, 4, 9, 16, ...
    #[arg(id = "samples", long, value_name = "N", value_parser = value::samples, default_value = "1", help_heading = "Rendering")]
    pub samples_per_axis: u32,

    #[command(flatten)]
    pub series: SeriesArgs,

    #[command(flatten)]
    pub comparison: CompareArgs,

    /// Print rays, times and memory to standard error, as text or as one JSON object
    #[arg(long, value_enum, value_name = "FORMAT", num_args = 0..=1, require_equals = true, default_missing_value = "text", help_heading = "Messages")]
    pub stats: Option<StatsFormat>,

    /// No progress bar, no closing line, no warnings
    #[arg(long, help_heading = "Messages")]
    pub quiet: bool,

    #[command(flatten)]
    pub config: ConfigArgs,
}

/// How rays are traced and shaded.
#[derive(Args, Debug)]
pub struct TraceArgs {
    /// How many threads render [default: as many as the machine has]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096), help_heading = "Rendering")]
    pub threads: Option<u32>,

    /// Which code traces the rays; both make the same picture
    #[arg(long, value_enum, default_value_t = ModeArg::Packet, help_heading = "Rendering")]
    pub mode: ModeArg,

    /// How much time building the BVH may take; the picture is the same
    #[arg(long, value_enum, value_name = "QUALITY", default_value_t = BuildArg::Auto, help_heading = "Rendering")]
    pub build: BuildArg,

    /// Let light through everything
    #[arg(long, help_heading = "Rendering")]
    pub no_shadows: bool,

    /// A ray of this level returns the background, so 1 traces camera rays only
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), default_value_t = course::MAX_DEPTH, help_heading = "Rendering")]
    pub max_depth: u32,
}

impl TraceArgs {
    /// The settings for pictures of that size.
    pub fn settings(&self, size: Size, samples_per_axis: u32) -> Result<Settings, RenderError> {
        let settings = Settings {
            width: size.width,
            height: size.height,
            samples_per_axis,
            max_depth: self.max_depth,
            shadows: !self.no_shadows,
            mode: match self.mode {
                ModeArg::Packet => Mode::Packet,
                ModeArg::Scalar => Mode::Scalar,
            },
            threads: self.threads.map(|threads| threads as usize),
            ..Settings::default()
        };
        settings.validate()?;
        Ok(settings)
    }
}

/// Arguments of `octray view`.
#[cfg(feature = "viewer")]
#[derive(Args, Debug)]
pub struct ViewArgs {
    /// The scene (.scn), or a mesh: .ply, .obj, .stl, .gltf or .glb
    pub scene: PathBuf,

    /// Width and height of the window, pixels
    #[arg(long, value_name = "WxH", value_parser = value::size, default_value = "512x512")]
    pub size: Size,

    #[command(flatten)]
    pub camera: CameraArgs,

    #[command(flatten)]
    pub mesh: MeshArgs,

    #[command(flatten)]
    pub trace: TraceArgs,

    /// Time for a frame while the camera moves, milliseconds; what takes longer is traced more coarsely, but takes up to
    /// three times as long before it gets coarser than a quarter of the window's sides
    #[arg(long, value_name = "MS", value_parser = clap::value_parser!(u32).range(1..=10_000), default_value_t = 16)]
    pub budget: u32,

    /// Orbit for so many seconds, print how fast that was, and end
    #[arg(long, value_name = "SECONDS", value_parser = value::seconds)]
    pub benchmark: Option<f64>,

    /// Write the benchmark's figures as JSON to a file, or to standard output (-)
    #[arg(long, value_name = "FILE", requires = "benchmark")]
    pub json: Option<PathBuf>,
}

/// Which way to look.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Camera")]
pub struct CameraArgs {
    /// One of the scene's cameras, by its name [default: the first one; else --view 1]
    #[arg(long, value_name = "NAME", conflicts_with_all = ["view", "eye"])]
    pub camera: Option<String>,

    /// One of the course's viewpoints
    #[arg(long, value_name = "1..6", value_parser = clap::value_parser!(u32).range(1..=6), conflicts_with = "eye")]
    pub view: Option<u32>,

    /// Where the camera stands, instead of the scene's camera or a viewpoint
    #[arg(long, value_name = "x,y,z", value_parser = value::vector, allow_hyphen_values = true)]
    pub eye: Option<DVec3>,

    /// What the camera looks at [default: what the scene's camera does; 0,0,0.5 with --eye or --view; a mesh's middle]
    #[arg(long, value_name = "x,y,z", value_parser = value::vector, allow_hyphen_values = true)]
    pub target: Option<DVec3>,

    /// Which way is up [default: as the scene's camera has it; 0,0,1 with --eye or --view]
    #[arg(long, value_name = "x,y,z", value_parser = value::vector, allow_hyphen_values = true)]
    pub up: Option<DVec3>,

    /// Vertical field of view, degrees [default: that of the scene's camera; 45 with --eye or --view]
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub fov: Option<f64>,
}

/// How a mesh is shown that comes without a scene.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Meshes")]
pub struct MeshArgs {
    /// Which axis of the mesh points up [default: y for .obj, .gltf and .glb, z for .ply and .stl]
    #[arg(long, value_enum, value_name = "AXIS")]
    pub up_axis: Option<UpArg>,

    /// Put the mesh on a ground
    #[arg(long)]
    pub ground: bool,

    /// If the mesh has no normals, smooth it where faces meet at no more than this angle, degrees
    #[arg(long, value_name = "DEG", value_parser = value::angle)]
    pub smooth_angle: Option<f64>,

    /// Light the mesh as it is lit when seen from this direction [default: that of the eye]
    #[arg(long, value_name = "x,y,z", value_parser = value::vector, allow_hyphen_values = true)]
    pub lit_from: Option<DVec3>,
}

/// See [`UpAxis`](crate::format::mesh::UpAxis).
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum UpArg {
    /// As in glTF
    Y,
    /// As in scenes
    Z,
}

/// See [`Mode`](crate::render::Mode).
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ModeArg {
    /// SIMD packets, batched shading
    Packet,
    /// One ray at a time
    Scalar,
}

/// See [`BuildQuality`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BuildArg {
    /// Fast where few rays are to come for many primitives, else best
    Auto,
    /// The BVH that is built soonest
    Fast,
    /// The BVH that is traced fastest
    Best,
}

impl BuildArg {
    /// What is built over so many primitives for so many rays.
    pub fn quality(self, rays: f64, primitives: usize) -> BuildQuality {
        match self {
            Self::Auto => BuildQuality::for_rays(rays, primitives),
            Self::Fast => BuildQuality::Fast,
            Self::Best => BuildQuality::Best,
        }
    }
}

/// How `--stats` prints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StatsFormat {
    /// A few lines to read
    Text,
    /// One JSON object
    Json,
}

#[derive(Args, Debug)]
pub struct InfoArgs {
    /// The scene (.scn), or a mesh: .ply, .obj, .stl, .gltf or .glb
    pub scene: PathBuf,

    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `octray bench`.
#[derive(Args, Debug)]
pub struct BenchArgs {
    /// The scene (.scn), or a mesh: .ply, .obj, .stl, .gltf or .glb
    #[arg(required_unless_present = "all", conflicts_with = "all")]
    pub scene: Option<PathBuf>,

    /// Instead of a scene: a suite of generated ones, from a few thousand triangles to ten million
    #[arg(long, conflicts_with_all = ["camera", "view", "eye", "target", "up", "fov", "up_axis", "ground", "smooth_angle"])]
    pub all: bool,

    /// With --all: smaller scenes
    #[arg(long, requires = "all", conflicts_with = "scene")]
    pub quick: bool,

    /// Camera rays across and down
    #[arg(long, value_name = "WxH", value_parser = value::size, default_value = "1024x1024")]
    pub size: Size,

    #[command(flatten)]
    pub camera: CameraArgs,

    #[command(flatten)]
    pub mesh: MeshArgs,

    /// How often each method runs; the median counts
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), default_value_t = 9)]
    pub repeat: u32,

    /// Which BVH is traced; auto counts camera and shadow rays of all runs
    #[arg(long, value_enum, value_name = "QUALITY", default_value_t = BuildArg::Best)]
    pub build: BuildArg,

    /// What to time, all by default; may be given several times or separated by commas
    #[arg(long = "method", value_name = "METHOD", value_enum, value_delimiter = ',')]
    pub methods: Vec<BenchMethod>,

    /// Instead of ways of tracing: time so many whole frames with one thread and with all, in turns
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), conflicts_with_all = ["methods", "json", "repeat"])]
    pub frames: Option<u32>,

    /// Write the results as JSON to a file, or to standard output (-)
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// What `octray bench` can time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum BenchMethod {
    /// The scalar reference over the BVH, one ray at a time
    Scalar,
    /// Packets of eight rays
    Packet,
    /// One ray against eight boxes at a time
    Single,
    /// What the renderer uses: up to 64 rays together, packets or single rays
    Render,
}

/// Puts `render` before arguments that do not begin with a command, so that `octray SCENE` works.
///
/// Only the first argument counts. A default command is done here and not by clap, whose usage errors for
/// optional subcommands mix both levels.
pub fn with_default_command(mut arguments: Vec<OsString>) -> Vec<OsString> {
    let render = match arguments.get(1) {
        Some(first) => !is_top_level(first),
        None => false,
    };
    if render {
        arguments.insert(1, "render".into());
    }
    arguments
}

/// Whether clap should read the argument as a command: because it is one, or because it looks like a
/// misspelt one and no such scene exists, so that clap answers with the one that was meant.
fn is_top_level(argument: &OsStr) -> bool {
    let Some(argument) = argument.to_str() else {
        return false;
    };
    if matches!(argument, "help" | "-h" | "--help" | "-V" | "--version") {
        return true;
    }
    let may_be_misspelt = argument.bytes().all(|b| b.is_ascii_alphabetic()) && !Path::new(argument).exists();
    Cli::command().get_subcommands().any(|command| {
        let name = command.get_name();
        // Two letters: one wrong, or two swapped. Of a short name that would leave too little.
        let most = name.len().div_ceil(3).min(2);
        argument == name || (may_be_misspelt && strsim::levenshtein(argument, name) <= most)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(arguments: &[&str]) -> Result<Command, clap::Error> {
        let arguments = std::iter::once("octray").chain(arguments.iter().copied());
        Cli::try_parse_from(with_default_command(arguments.map(OsString::from).collect()))
            .map(|cli| cli.command)
    }

    fn parse_render(arguments: &[&str]) -> RenderArgs {
        match parse(arguments) {
            Ok(Command::Render(args)) => args,
            other => panic!("{arguments:?}: {other:?}"),
        }
    }

    #[test]
    fn clap_accepts_the_definition() {
        Cli::command().debug_assert();
    }

    #[test]
    fn render_is_the_default_command() {
        for arguments in [
            &["a.scn", "--view", "2"][..],
            &["render", "a.scn", "--view=2"],
            &["--view", "2", "a.scn"],
            &["--view", "2", "--", "a.scn"],
        ] {
            let args = parse_render(arguments);
            assert_eq!((args.scenes, args.camera.view), (vec!["a.scn".into()], Some(2)));
        }
        assert_eq!(parse_render(&["./info"]).scenes, [PathBuf::from("./info")]);
        assert_eq!(parse_render(&["render", "info"]).scenes, [PathBuf::from("info")]);
        assert!(matches!(parse(&["info", "render"]), Ok(Command::Info(_))));
    }

    #[test]
    fn coordinates_may_be_negative() {
        let args = parse_render(&[
            "a.scn",
            "--eye",
            "-1,2,3",
            "--target=-0.5,0,-1e3",
            "--up",
            "-0,0,1",
        ]);
        assert_eq!(args.camera.eye, Some(DVec3::new(-1.0, 2.0, 3.0)));
        assert_eq!(args.camera.target, Some(DVec3::new(-0.5, 0.0, -1000.0)));
    }

    #[test]
    fn one_option_says_where_the_camera_stands() {
        for arguments in [
            &["a.scn", "--view", "2", "--eye", "1,2,3"][..],
            &["a.scn", "--camera", "a", "--eye", "1,2,3"],
            &["a.scn", "--camera", "a", "--view=2"],
        ] {
            let error = parse(arguments).expect_err("a contradiction");
            assert_eq!(error.kind(), clap::error::ErrorKind::ArgumentConflict);
        }
        let args = parse_render(&["a.scn", "--camera", "a", "--fov", "30"]);
        assert_eq!(
            (args.camera.camera.as_deref(), args.camera.fov),
            (Some("a"), Some(30.0))
        );
    }

    #[test]
    fn stats_take_their_value_after_an_equals_sign_only() {
        assert_eq!(parse_render(&["--stats", "a.scn"]).stats, Some(StatsFormat::Text));
        assert_eq!(
            parse_render(&["a.scn", "--stats=json"]).stats,
            Some(StatsFormat::Json)
        );
        assert_eq!(parse_render(&["a.scn"]).stats, None);
    }

    #[test]
    fn the_build_pays_for_itself() {
        assert_eq!(parse_render(&["a.scn"]).trace.build, BuildArg::Auto);
        assert_eq!(
            parse_render(&["a.scn", "--build", "fast"]).trace.build,
            BuildArg::Fast
        );
        assert_eq!(BuildArg::Auto.quality(1e6, 10_000_000), BuildQuality::Fast);
        assert_eq!(BuildArg::Auto.quality(1e6, 10_000), BuildQuality::Best);
        assert_eq!(BuildArg::Best.quality(1.0, 10_000_000), BuildQuality::Best);
    }

    #[test]
    fn bench_takes_a_scene_or_the_suite() {
        let Ok(Command::Bench(args)) = parse(&["bench", "--all", "--quick"]) else {
            panic!("not bench");
        };
        assert!(args.all && args.quick && args.scene.is_none());
        for arguments in [
            &["bench"][..],
            &["bench", "a.scn", "--all"],
            &["bench", "a.scn", "--quick"],
            &["bench", "--all", "--view", "2"],
        ] {
            assert!(parse(arguments).is_err(), "{arguments:?}");
        }
    }

    #[test]
    fn bench_methods_may_be_listed() {
        let Ok(Command::Bench(args)) = parse(&[
            "bench",
            "a.scn",
            "--method",
            "scalar,packet",
            "--method",
            "render",
        ]) else {
            panic!("not bench");
        };
        assert_eq!(
            args.methods,
            [BenchMethod::Scalar, BenchMethod::Packet, BenchMethod::Render]
        );
        assert_eq!(
            args.size,
            Size {
                width: 1024,
                height: 1024
            }
        );
    }
}
