//! Tests of `defaults`.

use super::*;
use std::path::Path;

fn default(name: &str) -> ConfigDefault {
    ConfigDefault {
        id: name.replace('-', "_"),
        name: name.to_owned(),
        words: None,
        at: SourcePos::in_text(Path::new("c.toml"), b"a = 1\nb = 2\n", 6),
    }
}

#[test]
fn an_error_names_the_file_of_its_option() {
    let defaults = [default("focus"), default("frames"), default("animation-time")];
    let said = |text: &str| explained(CliError::Usage(text.into()), &defaults).text().unwrap();
    assert_eq!(
        said("--frames: too many, or --focus"),
        "--frames: too many, or --focus; --frames is set in c.toml:2:1"
    );
    let turned = explained(
        CliError::Usage("several frames would be written to a.png".into()),
        &defaults,
    );
    assert!(
        turned
            .text()
            .unwrap()
            .ends_with("; --frames is set in c.toml:2:1")
    );
    for other in [
        "there is no animation `a`",
        "--frames-per-second: no",
        "--animation needs a file",
        "frames",
        "",
    ] {
        assert_eq!(said(other), other);
    }
}

#[test]
fn an_error_about_a_camera_or_a_value_names_the_file() {
    let camera = ConfigDefault {
        words: Some("nope".into()),
        ..default("camera")
    };
    let sky = ConfigDefault {
        words: Some("a.hdr".into()),
        ..default("environment")
    };
    let options = ["ortho", "aperture", "focus", "eye", "up"].map(default);
    let defaults = [&options[..], &[camera, sky]].concat();
    let name = |error: CliError| {
        let text = explained(error, &defaults).text().unwrap_or_default();
        let (_, name) = text.split_once("; --")?;
        name.strip_suffix(" is set in c.toml:2:1").map(str::to_owned)
    };
    use crate::scene::CameraError as Of;
    for (error, option) in [
        (Of::ViewHeight(-1.0), "ortho"),
        (Of::Aperture(-1.0), "aperture"),
        (Of::Focus(0.0), "focus"),
        (Of::EyeOnTarget, "eye"),
        (Of::UpParallel, "up"),
    ] {
        assert_eq!(name(error.into()).as_deref(), Some(option), "{error}");
    }
    for (text, option) in [
        ("no camera `nope`: the scene defines none", Some("camera")),
        ("a.hdr: file not found", Some("environment")),
        ("cannot write a.hdr: it is full", Some("environment")),
        ("nope, a.hdr.png: file not found", None),
        ("cannot read a.hdr", None),
    ] {
        let said = name(CliError::Failed(text.into()));
        assert_eq!(said.as_deref(), option, "{text}");
    }
    let own = crate::error::LoadError::whole_file(Path::new("a.scn"), Of::Focus(0.0).to_string());
    assert_eq!(name(own.into()), None);
}

#[test]
fn an_error_that_tells_nothing_is_that_of_the_default_that_makes_it() {
    let defaults = ["size", "output", "json"].map(default);
    let said = |text: &str| CliError::Usage(text.into());
    let without = |option: &str, planned: fn() -> Result<(), CliError>| {
        let planned = |id: &str| Some(if id == option { planned() } else { Err(said("no")) });
        explained_plan(said("no"), &defaults, planned).text()
    };
    let json = Some("no; --json is set in c.toml:2:1".to_owned());
    assert_eq!(without("json", || Ok(())), json);
    assert_eq!(without("json", || Err(CliError::Usage("other".into()))), json);
    assert_eq!(without("fov", || Ok(())), said("no").text());
}
