//! Tests of `defaults`.

use super::*;
use std::path::Path;

fn default(name: &str) -> ConfigDefault {
    ConfigDefault {
        id: name.replace('-', "_"),
        name: name.to_owned(),
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
