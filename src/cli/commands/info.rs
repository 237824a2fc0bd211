//! `octray info`: describes a scene and its BVH.

use crate::{
    accel::{BuildQuality, Bvh},
    cli::{
        CliError,
        load::{self, memory},
        plan::InfoPlan,
        process::Interrupt,
        report::{self, info::Info},
        write::{Inputs, json_line, write_json},
    },
};
use std::time::Instant;

/// Prints what is in a scene.
///
/// # Errors
/// [`CliError`].
pub fn run(plan: &InfoPlan) -> Result<(), CliError> {
    Interrupt::install()?;
    let start = Instant::now();
    let mut files = Vec::new();
    let bare = load::load_bare(&plan.path, plan.memory, &mut files)?;
    let (scene, animations, scalars) = (bare.scene, bare.animations, bare.scalars);
    let load_time = start.elapsed();
    let mut inputs = Inputs::default();
    inputs.add(&plan.path, "the scene");
    inputs.add_scene(&plan.path, &files, Some(&scene));
    inputs.check_json(plan.json.as_ref())?;
    let faults = scene.mesh_faults();
    memory::check_build(&scene, BuildQuality::Best)?;
    let bvh = Bvh::build(&scene);
    let name = plan.path.to_string_lossy().into_owned();
    let info = Info::new(name, &scene, faults, &bvh, load_time);
    let info = info.with_animations(animations).with_scalars(scalars);
    match &plan.json {
        Some(target) => write_json(target, &json_line(&info)),
        None => report::print(&info.text()),
    }
}
