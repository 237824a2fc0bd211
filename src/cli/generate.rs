//! `octray generate`: a made-up scene as files.

use super::{
    CliError,
    interrupt::Interrupt,
    whole_file::{self, Guarded},
};
use crate::generate::{Generated, Kind, Options, Shape, generate, write_ply};
use clap::{
    Args,
    builder::{PossibleValue, PossibleValuesParser, TypedValueParser},
};
use std::{
    fmt::Write as _,
    fs,
    io::{self, BufWriter},
    path::{Path, PathBuf},
};

/// What `octray generate` takes.
#[derive(Args, Debug)]
pub struct GenerateArgs {
    /// What to make
    #[arg(value_parser = kind_parser())]
    pub kind: Kind,
    /// Folder for KIND.scn and its meshes; made if it is missing
    #[arg(short, long, value_name = "FOLDER", default_value = ".")]
    pub output: PathBuf,
    /// Another seed makes another scene of the same kind
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    /// Spheres (flake, spheres: exactly) or triangles (the others: at most, and nearly) [default: 100000 spheres;
    /// terrain and blobs 1000000, interior 370000, pipes 192000, figure 70000 triangles]
    #[arg(long, value_name = "N")]
    pub count: Option<usize>,
}

fn kind_parser() -> impl TypedValueParser<Value = Kind> {
    PossibleValuesParser::new(Kind::ALL.map(|kind| PossibleValue::new(kind.name()).help(kind.summary())))
        .try_map(|name| {
            Kind::ALL
                .into_iter()
                .find(|kind| kind.name() == name)
                .ok_or("not a kind")
        })
}

/// Writes the scene and its meshes, each whole or not at all, and returns what to tell the user.
///
/// # Errors
/// [`CliError`]: a count out of its limits, or a file that cannot be written.
pub fn run(args: &GenerateArgs) -> Result<String, CliError> {
    let interrupt = Interrupt::install()?;
    let options = Options {
        seed: args.seed,
        count: args.count,
    };
    let generated = interrupt.exit_at_once_during(|| generate(args.kind, options))?;
    let generated = generated.map_err(|error| CliError::Failed(error.to_string()))?;
    let folder = &args.output;
    fs::create_dir_all(folder)
        .map_err(|error| CliError::writing(&format!("to the folder {}", folder.display()), &error))?;

    let mut told = String::new();
    // The meshes first: a scene file that is there can be loaded.
    for part in &generated.parts {
        if let (Shape::Mesh(mesh), Some(name)) = (&part.shape, generated.mesh_file_name(part)) {
            let path = folder.join(name);
            write_whole(&path, &interrupt, |out| write_ply(mesh, out))?;
            let _ = writeln!(told, "{}: {} triangles", path.display(), mesh.triangles.len());
        }
    }
    let path = folder.join(format!("{}.scn", args.kind.name()));
    write_whole(&path, &interrupt, |out| generated.write_scn(out))?;
    let _ = writeln!(
        told,
        "{}: {} spheres, {} lights",
        path.display(),
        sphere_count(&generated),
        generated.lights.len()
    );
    let _ = writeln!(
        told,
        "render it with: octray {} {}",
        quoted(&path),
        generated.render_arguments()
    );
    Ok(told)
}

fn sphere_count(generated: &Generated) -> usize {
    let balls = |shape: &Shape| match shape {
        Shape::Spheres(balls) => balls.len(),
        Shape::Mesh(_) => 0,
    };
    generated.parts.iter().map(|part| balls(&part.shape)).sum()
}

/// A path as a shell takes it.
pub(super) fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let plain = |c: char| c.is_alphanumeric() || "/\\._-:+,".contains(c);
    if text.chars().all(plain) {
        text
    } else {
        format!("'{}'", text.replace('\'', "'\\''"))
    }
}

/// Writes a file whole or not at all.
fn write_whole(
    path: &Path,
    interrupt: &Interrupt,
    write: impl FnOnce(&mut BufWriter<Guarded<'_>>) -> io::Result<()>,
) -> Result<(), CliError> {
    let written = whole_file::write(path, interrupt, write);
    interrupt.check()?;
    written.map_err(|error| CliError::writing(&path.display().to_string(), &error))
}

#[cfg(test)]
mod tests {
    use super::{GenerateArgs, run};
    use clap::Parser;
    use std::fs;

    #[derive(Parser)]
    struct Alone {
        #[command(flatten)]
        args: GenerateArgs,
    }

    fn parse(words: &[&str]) -> Result<GenerateArgs, clap::Error> {
        Alone::try_parse_from([&["generate"], words].concat()).map(|alone| alone.args)
    }

    #[test]
    fn files_appear_and_the_command_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("made here");
        let place = folder.to_str().unwrap();
        let args = parse(&["terrain", "-o", place, "--count", "200", "--seed", "3"]).unwrap();
        let told = run(&args).unwrap();
        assert!(told.contains("made here/terrain.scn' --eye="), "{told}");
        let mut names: Vec<_> = fs::read_dir(&folder)
            .unwrap()
            .map(|f| f.unwrap().file_name())
            .collect();
        names.sort();
        assert_eq!(names, ["terrain.ply", "terrain.scn"]);
        let text = fs::read_to_string(folder.join("terrain.scn")).unwrap();
        assert!(text.contains("\nply_file terrain.ply\n"), "{text}");
    }

    #[test]
    fn what_cannot_be_made_is_refused() {
        assert!(parse(&["teapot"]).is_err());
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().to_str().unwrap();
        let args = parse(&["blobs", "-o", place, "--count", "3"]).unwrap();
        let text = run(&args).unwrap_err().text().unwrap();
        assert!(text.contains("expected 1000 to"), "{text}");
    }
}
