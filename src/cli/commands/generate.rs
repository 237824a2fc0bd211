//! `octray generate`: a procedural scene as files.

use super::check_room;
use crate::{
    cli::{
        CliError,
        load::memory,
        plan::{GeneratePlan, JsonTarget},
        process::Interrupt,
        report::{self, SCHEMA, quoted_path},
        write::{is_foreign, json_line, write_json},
    },
    error::clip_path,
    generate::{GenerateError, Generated, Part, Shape, generate, write_ply},
    whole_file,
};
use serde::Serialize;
use std::{
    fmt::Write as _,
    fs, io,
    path::{Path, PathBuf},
};

/// Peak memory of a primitive while it is generated, bytes: measured.
const PRIMITIVE_BYTES: u64 = 80;

/// What was generated, as JSON.
#[derive(Serialize)]
struct Json {
    schema: u32,
    kind: &'static str,
    seed: u64,
    scene: String,
    meshes: Vec<JsonMesh>,
    spheres: usize,
    lights: usize,
    /// Options of `octray render` for a good view.
    render: String,
}

#[derive(Serialize)]
struct JsonMesh {
    file: String,
    triangles: usize,
}

/// Writes the scene, its meshes and the JSON, each whole or not at all, and prints what was written.
///
/// # Errors
/// [`CliError`]: a count out of its limits, or a file that cannot be written.
pub fn run(plan: &GeneratePlan) -> Result<(), CliError> {
    let (text, json) = write(plan)?;
    if plan.json != Some(JsonTarget::Stdout) {
        report::print(&text)?;
    }
    match &plan.json {
        Some(target) => write_json(target, &json_line(&json)),
        None => Ok(()),
    }
}

/// Writes the scene and its meshes, and returns what to print.
fn write(plan: &GeneratePlan) -> Result<(String, Json), CliError> {
    let interrupt = Interrupt::install()?;
    let count = plan.options.count.unwrap_or_else(|| plan.kind.default_count());
    let usage = |error: GenerateError| CliError::Usage(error.to_string());
    plan.kind.check_count(count).map_err(usage)?;
    check_room("the scene", count as u64 * PRIMITIVE_BYTES, memory::limit(None))?;
    let generated = generate(plan.kind, plan.options).map_err(usage)?;
    let folder = &plan.folder;
    fs::create_dir_all(folder).map_err(|error| CliError::making(folder, &error))?;

    let scene = folder.join(format!("{}.scn", plan.kind.name()));
    let mesh_path = |part: &Part| Some(folder.join(generated.mesh_file_name(part)?));
    let meshes = generated.parts.iter().filter_map(mesh_path);
    check_files(plan, &meshes.chain([scene.clone()]).collect::<Vec<_>>())?;

    let mut told = String::new();
    let mut json = Json {
        schema: SCHEMA,
        kind: plan.kind.name(),
        seed: plan.options.seed,
        scene: scene.to_string_lossy().into_owned(),
        meshes: Vec::new(),
        spheres: sphere_count(&generated),
        lights: generated.lights.len(),
        render: generated.render_arguments(),
    };
    // The meshes first, so that a scene file that exists can be loaded.
    for part in &generated.parts {
        if let (Shape::Mesh(mesh), Some(path)) = (&part.shape, mesh_path(part)) {
            let written = whole_file::write(&path, |out| write_ply(mesh, out));
            finished(&path, &interrupt, written)?;
            let triangles = mesh.triangles.len();
            let _ = writeln!(told, "{}: {triangles} triangles", clip_path(&path));
            json.meshes.push(JsonMesh {
                file: path.to_string_lossy().into_owned(),
                triangles,
            });
        }
    }
    let written = whole_file::write(&scene, |out| generated.write_scn(out));
    finished(&scene, &interrupt, written)?;
    let (spheres, lights) = (json.spheres, json.lights);
    let name = clip_path(&scene);
    let _ = writeln!(told, "{name}: {spheres} spheres, {lights} lights");
    let _ = writeln!(
        told,
        "render it with: octray {} {}",
        quoted_path(&scene),
        json.render
    );
    Ok((told, json))
}

/// Refuses to replace files that octray did not make, and to write the JSON into one of `files`.
fn check_files(plan: &GeneratePlan, files: &[PathBuf]) -> Result<(), CliError> {
    if !plan.force
        && let Some(file) = files.iter().find(|file| is_foreign(file))
    {
        return Err(CliError::Failed(format!(
            "{} exists and was not made by `octray generate`; name another directory with -o or replace it with --force",
            clip_path(file)
        )));
    }
    let Some(JsonTarget::File(json)) = &plan.json else {
        return Ok(());
    };
    let place = |path: &Path| fs::canonicalize(path).or_else(|_| std::path::absolute(path)).ok();
    match files.iter().find(|file| place(file) == place(json)) {
        Some(file) => Err(CliError::Usage(format!(
            "both the scene and the JSON would be written to {}",
            clip_path(file)
        ))),
        None => Ok(()),
    }
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
mod tests;
