use super::{default_command::with_default_command, render::RenderArgs, values::Size, *};
use crate::{accel::BuildQuality, bench::Method, cli::plan::Build};
use glam::DVec3;
use std::path::PathBuf;

fn parse(arguments: &[&str]) -> Result<Command, clap::Error> {
    let arguments = std::iter::once("octray").chain(arguments.iter().copied());
    Cli::try_parse_from(with_default_command(arguments.map(OsString::from).collect())).map(|cli| cli.command)
}

fn parse_render(arguments: &[&str]) -> RenderArgs {
    match parse(arguments) {
        Ok(Command::Render(args)) => *args,
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
fn the_build_pays_for_itself() {
    assert_eq!(parse_render(&["a.scn"]).trace.build, Build::Auto);
    assert_eq!(
        parse_render(&["a.scn", "--build", "fast"]).trace.build,
        Build::Quality(BuildQuality::Fast)
    );
    assert_eq!(Build::Auto.quality(1e6, 10_000_000), BuildQuality::Fast);
    assert_eq!(Build::Auto.quality(1e6, 10_000), BuildQuality::Best);
    assert_eq!(
        Build::Quality(BuildQuality::Best).quality(1.0, 10_000_000),
        BuildQuality::Best
    );
    assert_eq!(
        Build::Quality(BuildQuality::Ploc).quality(1.0, 10_000_000),
        BuildQuality::Ploc
    );
}

#[cfg(feature = "viewer")]
#[test]
fn what_the_window_prints_makes_its_picture() {
    use crate::cli::plan::Style;
    for options in [
        &[][..],
        &["--samples=auto"],
        &["--samples=auto:7", "--filter=box", "--linear"],
        &["--samples=1"],
        &["--samples=10", "--srgb", "--no-shadows"],
        &["--samples=16", "--pattern=stratified", "--max-depth=7"],
        &["--pattern=sobol", "--filter=tent"],
        &["--pattern=grid", "--filter=blackman-harris"],
        &["--edges"],
        &["--edges=0.7", "--edge-color=white", "--linear"],
        &["--edges=12.25", "--edge-color=0180fe", "--srgb"],
    ] {
        for style in [None, Some(Style::Plain), Some(Style::Studio), Some(Style::Clay)] {
            let mut arguments = vec!["view", "--size=20x10", "a"];
            arguments.extend(match style {
                Some(Style::Plain) => Some("--style=plain"),
                Some(Style::Clay) => Some("--style=clay"),
                _ => None,
            });
            arguments.extend(options);
            let Ok(Command::View(view)) = parse(&arguments) else {
                panic!("{arguments:?}");
            };
            let shown = view.looks().unwrap();
            let shown = shown.of(style.is_some());
            let printed = spelled(&shown.settings, shown.picture.transfer, style);
            let arguments: Vec<&str> = ["render", "--size=20x10", "a"]
                .into_iter()
                .chain(printed.split_whitespace())
                .collect();
            let looks = parse_render(&arguments);
            let looks = looks.looks(looks.size(None)).unwrap();
            assert_eq!(looks.of(style.is_some()), shown, "{printed}");
        }
    }
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
    assert_eq!(args.methods, [Method::Scalar, Method::Packet, Method::Render]);
    assert_eq!(
        args.size,
        Size {
            width: 1024,
            height: 1024
        }
    );
}
