//! The commands, and the arguments that are theirs alone; those that several commands share have files of their own.

use super::{
    batch_args::{CompareArgs, SeriesArgs},
    bench_args::BenchArgs,
    camera_args::{CameraArgs, MeshArgs},
    config::ConfigArgs,
    generate::GenerateArgs,
    memory::MemoryArgs,
    picture_args::{PictureArgs, SampleArgs},
    shell::{CompletionsArgs, ManArgs},
    trace_args::TraceArgs,
    value::{self, Size},
    verify::VerifyArgs,
    version,
};
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

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
  octray render bunny.ply --ground --smooth-angle 40 -o bunny.png
  octray render cow.scn --crop 0,0,256,128 -o corner.png
  octray render cow.scn --samples 32 --pattern sobol --filter blackman-harris --srgb
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

    /// On Ctrl-C, save what there is of the picture under another name: a.partial.png for a.png
    #[arg(long, help_heading = "Picture")]
    pub keep_partial: bool,

    #[command(flatten)]
    pub picture: PictureArgs,

    #[command(flatten)]
    pub sampling: SampleArgs,

    #[command(flatten)]
    pub camera: CameraArgs,

    #[command(flatten)]
    pub mesh: MeshArgs,

    #[command(flatten)]
    pub trace: TraceArgs,

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
    pub memory: MemoryArgs,

    #[command(flatten)]
    pub config: ConfigArgs,
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

    /// Time for a frame while the camera moves, milliseconds; what takes longer is traced more coarsely, but a picture of
    /// all pixels may take twice as long, and one of a quarter of the window's sides three times
    #[arg(long, value_name = "MS", value_parser = clap::value_parser!(u32).range(1..=10_000), default_value_t = 16)]
    pub budget: u32,

    /// Orbit for so many seconds, print how fast that was, and end
    #[arg(long, value_name = "SECONDS", value_parser = value::seconds)]
    pub benchmark: Option<f64>,

    #[command(flatten)]
    pub memory: MemoryArgs,

    /// Write the benchmark's figures as JSON to a file, or to standard output (-)
    #[arg(long, value_name = "FILE", requires = "benchmark")]
    pub json: Option<PathBuf>,
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

    #[command(flatten)]
    pub memory: MemoryArgs,
}

#[cfg(test)]
mod tests {
    use super::{
        super::{bench_args::BenchMethod, default_command::with_default_command, trace_args::BuildArg},
        *,
    };
    use crate::accel::BuildQuality;
    use clap::CommandFactory;
    use glam::DVec3;
    use std::ffi::OsString;

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
        assert_eq!(BuildArg::Ploc.quality(1.0, 10_000_000), BuildQuality::Ploc);
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
