//! `octray generate`: a procedural scene as files.

use super::check_room;
use crate::{
    cli::{
        CliError, load::memory, plan::GeneratePlan, process::Interrupt, report::quoted, write::is_foreign,
    },
    error::clip_path,
    generate::{Generated, MAX_COUNT, Part, Shape, generate, write_ply},
    whole_file,
};
use std::{fmt::Write as _, fs, io, path::Path};

/// Peak memory of a primitive while it is generated, bytes: measured.
const PRIMITIVE_BYTES: u64 = 80;

/// Writes the scene and its meshes, each whole or not at all, and returns what to tell the user.
///
/// # Errors
/// [`CliError`]: a count out of its limits, or a file that cannot be written.
pub fn run(plan: &GeneratePlan) -> Result<String, CliError> {
    let interrupt = Interrupt::install()?;
    let count = plan.options.count.unwrap_or_else(|| plan.kind.default_count());
    check_room(
        "the scene",
        count.min(MAX_COUNT) as u64 * PRIMITIVE_BYTES,
        memory::limit(None),
    )?;
    let generated = generate(plan.kind, plan.options).map_err(|error| CliError::Failed(error.to_string()))?;
    let folder = &plan.folder;
    fs::create_dir_all(folder).map_err(|error| CliError::making(folder, &error))?;

    let scene = folder.join(format!("{}.scn", plan.kind.name()));
    let mesh_path = |part: &Part| Some(folder.join(generated.mesh_file_name(part)?));
    if !plan.force {
        let mut files = generated
            .parts
            .iter()
            .filter_map(mesh_path)
            .chain([scene.clone()]);
        if let Some(file) = files.find(|file| is_foreign(file)) {
            return Err(CliError::Failed(format!(
                "{} exists and was not made by `octray generate`; name another directory with -o or replace it with --force",
                clip_path(&file)
            )));
        }
    }

    let mut told = String::new();
    // The meshes first, so that a scene file that exists can be loaded.
    for part in &generated.parts {
        if let (Shape::Mesh(mesh), Some(path)) = (&part.shape, mesh_path(part)) {
            let written = whole_file::write(&path, |out| write_ply(mesh, out));
            finished(&path, &interrupt, written)?;
            let _ = writeln!(told, "{}: {} triangles", clip_path(&path), mesh.triangles.len());
        }
    }
    let written = whole_file::write(&scene, |out| generated.write_scn(out));
    finished(&scene, &interrupt, written)?;
    let _ = writeln!(
        told,
        "{}: {} spheres, {} lights",
        clip_path(&scene),
        sphere_count(&generated),
        generated.lights.len()
    );
    let _ = writeln!(
        told,
        "render it with: octray {} {}",
        quoted(&scene),
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

/// Whether a file was written and no signal came.
fn finished(path: &Path, interrupt: &Interrupt, written: io::Result<()>) -> Result<(), CliError> {
    interrupt.check()?;
    written.map_err(|error| CliError::writing(&clip_path(path), &error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::{Kind, Options};

    fn plan(kind: Kind, folder: &Path, seed: u64, count: usize) -> GeneratePlan {
        GeneratePlan {
            kind,
            options: Options {
                seed,
                count: Some(count),
            },
            folder: folder.to_owned(),
            force: false,
        }
    }

    #[test]
    fn files_appear_and_the_command_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("made here");
        let told = run(&plan(Kind::Terrain, &folder, 3, 200)).unwrap();
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
    fn too_small_counts_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let text = run(&plan(Kind::Blobs, folder.path(), 0, 3)).unwrap_err().text();
        assert!(text.unwrap().contains("expected 1000 to"));
    }
}
