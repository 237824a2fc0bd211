//! Usage lines and examples of the help texts.

/// Text of builds with a window, nothing in others.
#[cfg(feature = "viewer")]
macro_rules! with_window {
    ($text:literal) => {
        $text
    };
}
#[cfg(not(feature = "viewer"))]
macro_rules! with_window {
    ($text:literal) => {
        ""
    };
}

pub const ALL: &str = concat!(
    "\
Examples:
  octray scenes/reflections.scn                   reflections.png, 512x512, from viewpoint 1
  octray a.scn -o big.png --size 3840x2160        a large picture
  octray a.scn --view 3 --samples 16              another viewpoint, 16 samples per pixel
  octray a.scn --eye -3,2,1.5 --target 0,0,0.5    a view of your own
  octray a.scn --camera gate --fov 30             a camera of the scene, zoomed in
  octray a.scn -o a.exr                           linear floats instead of 8 bits
  octray a.scn -o - | magick - a.webp             a PNG into a pipe
  octray bunny.ply --ground                       a mesh, framed and lit, on a ground plane
",
    with_window!("\x20 octray view a.scn                               a window to look around in\n"),
    "\x20 octray info a.scn                               what is in a scene
  octray bench a.scn                              how fast this machine traces it
  octray bench --all --quick                      how fast it traces generated scenes
  octray verify --seconds 60                      check every tracing method on this machine

`octray SCENE` is short for `octray render SCENE`; `octray render --help` lists its options. For a scene \
with the name of a command, write a path such as ./info, or the command before it.

a.scn, bunny.ply and other files outside of scenes/ stand for your own.

Environment: OCTRAY_ISA=portable, avx2 or avx512 selects an instruction set, by default the best of \
this CPU. Pictures are the same with all of them.

Exit codes: 0 success; 1 failure (the input, the disk, a limit); 2 usage error; ",
    with_window!("3 no display; "),
    "5 a comparison or verification differs. octray dies from SIGINT, SIGTERM and SIGHUP; shells report 130, 143 and \
129."
);

pub const RENDER: &str = "\
Examples:
  octray render a.scn -o a.jpg --size 1920x1080 --samples 9
  octray render a.scn --eye -3,2,1.5 --target 0,0,0.5 --up 0,0,1 --fov 30
  octray render bunny.ply --ground --smooth-angle 40 -o bunny.png
  octray render part.stl --from top --ortho fit     a drawing's view of a mesh
  octray render a.scn --crop 0,0,256,128 -o corner.png
  octray render a.scn --samples 32 --pattern sobol --filter blackman-harris --srgb
  octray render a.scn --background transparent --aov depth,normal,heat
  octray render a.scn -q --json stats.json          rays, times and memory as JSON
  octray render a.scn b.scn -o {stem}.jpg           several scenes, one picture each
  octray render a.scn --turntable 48 -o t-##.png    48 frames around the scene
  octray render a.scn --turntable 48 -o t-##.png --frames 1-24
                                                    the first half of them
  octray render models/*.glb --sheet 8 --size 256x256 --keep-going
  octray render bunny.ply --turntable 100 -o r_#.png --aov depth --save-poses transforms.json
                                                    a data set
  octray render a.scn --turntable 50 -o turn.gif    an animation; also .apng and .y4m
  octray render gears.scn -o gears.gif              all frames of an animated scene
  octray render gears.scn --frames 1-24 -o g-##.png
  octray render a.scn --turntable 250 -o - | ffmpeg -i - -pix_fmt yuv420p turn.mp4
  octray render a.scn --compare a.png --tolerance 2 -o new.png
                                                    exits with 5 if the picture differs
  octray render - -o bunny.png < bunny.ply          a mesh or a scene from standard input

Config file: defaults for the options of `octray render` and `octray job`, in TOML. It is octray/config.toml in \
$XDG_CONFIG_HOME or ~/.config; --config names another one, and --no-config reads none. A key is the long name of an \
option, with its hyphens; there are no sections. A switch is true or false, and a list is [1, 2, 3] or, as on the command \
line, \"1,2,3\". The command line wins. Defaults of options for meshes, such as `ground`, are skipped for scenes. \
`config`, `no-config`, `force`, `help` and `version` are refused.

Example of a config file:
  size = \"1920x1080\"
  samples = \"auto:64\"
  from = \"front\"
  ground = true                                     # for meshes
  output = \"pictures/{stem}.png\"
  max-memory = \"8G\"";

pub const JOB: &str = "\
Examples:
  octray job a.scn --size 8000x4000 --tiles 8x4 -o a.exr --for parallel --into farm
  sh farm/run.sh                                  renders 32 tiles and merges them
  octray job a.ply --turntable 240 -o t-###.png --chunk 10 --for slurm --into farm
  sh farm/submit.sh                               an array of 24 tasks
  octray job a.scn -o a.png --for openjd --into farm
  openjd run farm/template.yaml                   or submit the template to a farm";

pub const MERGE: &str = "\
Examples:
  octray a.scn --size 512x512 --crop 0,0,512,256 -o top.png
  octray a.scn --size 512x512 --crop 0,256,512,512 -o bottom.png
  octray merge top.png bottom.png -o a.png";

pub const COMPLETIONS: &str = "\
Examples:
  mkdir -p ~/.local/share/bash-completion/completions
  octray completions bash > ~/.local/share/bash-completion/completions/octray
  octray completions zsh > _octray          in a directory of $fpath
  mkdir -p ~/.config/fish/completions
  octray completions fish > ~/.config/fish/completions/octray.fish";

#[cfg(feature = "viewer")]
pub const VIEW_KEYS: &str = "\
In the window, drag with the left button to orbit, with the right button (or the wheel) to move nearer; \
press ? for all keys, q to quit.";

pub const MAN: &str = "\
Examples:
  octray man > octray.1
  octray man render > octray-render.1
  octray man render | man -l -                read it";

pub const RENDER_USAGE: &str = "octray [render] [OPTIONS] <SCENE>...";

pub const USAGE: &str = "octray [render] [OPTIONS] <SCENE>...\n       octray <COMMAND> ...";
