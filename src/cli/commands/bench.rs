//! `octray bench`: compares tracing methods on the same rays.

use super::check_room;
use crate::{
    accel::Bvh,
    bench::{Measurement, Workload, compare, frame_times, quick_suite, suite},
    cli::{
        CliError,
        load::{self, Input},
        plan::{BenchPlan, BenchScenes, JsonTarget},
        process::Interrupt,
        report::{
            self,
            bench::{Json, frame_table, heading, means, table},
        },
        write::{Inputs, json_line, write_json},
    },
    error::clip,
    render::Settings,
    scene::{Camera, Scene},
};

/// Memory of a ray with the hits of two methods, bytes: measured.
const RAY_BYTES: f64 = 50.0;

/// Times tracing methods on the rays of a scene, or of a suite of scenes, on one thread.
///
/// # Errors
/// [`CliError`]; [`CliError::Differs`] if a method does not find the reference's hits.
pub fn run(plan: &BenchPlan) -> Result<(), CliError> {
    Interrupt::install()?;
    let bench = Bench {
        plan,
        quiet: plan.json == Some(JsonTarget::Stdout),
    };
    let mut results = Vec::new();
    match &plan.scenes {
        BenchScenes::One(input) => {
            let name = input.path.to_string_lossy().into_owned();
            let mut inputs = Inputs::default();
            inputs.add(&input.path, "the scene");
            inputs.check_json(plan.json.as_ref())?;
            let mut files = Vec::new();
            let Input { scene, camera, .. } = load::load_and_list(input, plan.memory, &mut files)?;
            inputs.add_scene(&input.path, &files, Some(&scene));
            inputs.check_json(plan.json.as_ref())?;
            bench.print(&heading(plan))?;
            let rows = bench.scene(&name, &scene, &camera)?;
            results.push((name, rows));
        }
        BenchScenes::Suite { quick } => {
            bench.print(&heading(plan))?;
            for suite_scene in if *quick { quick_suite() } else { suite() } {
                let (scene, camera) = suite_scene
                    .make()
                    .map_err(|error| CliError::Failed(error.to_string()))?;
                let rows = bench.scene(suite_scene.name, &scene, &camera)?;
                results.push((suite_scene.name.to_string(), rows));
            }
            if !plan.frames_only {
                bench.print(&means(&results))?;
            }
        }
    }
    if let Some(target) = &plan.json {
        write_json(target, &json_line(&Json::new(plan, &results)))?;
    }
    if results.iter().flat_map(|(_, rows)| rows).all(|row| row.agree) {
        Ok(())
    } else {
        Err(CliError::Differs(
            "some hits differ from the scalar reference's".into(),
        ))
    }
}

/// Benches the scenes one after the other.
struct Bench<'a> {
    plan: &'a BenchPlan,
    quiet: bool,
}

impl Bench<'_> {
    fn scene(&self, name: &str, scene: &Scene, camera: &Camera) -> Result<Vec<Measurement>, CliError> {
        self.print(&format!("\n{}\n", clip(name)))?;
        if !scene.planes().is_empty() && !self.quiet {
            report::warnings([format!(
                "{}: the rays of the bench ignore infinite planes",
                clip(name)
            )]);
        }
        let plan = self.plan;
        let Settings { width, height, .. } = plan.settings;
        let lights = scene.lights().len() as f64;
        let rays = f64::from(width) * f64::from(height) * (1.0 + lights) * f64::from(plan.repeat);
        let quality = plan.build.quality(rays, scene.primitive_count());
        if !plan.frames_only {
            // Camera, mirror, diffuse and ambient occlusion rays, and one to each light.
            let kept = f64::from(width) * f64::from(height) * (4.0 + lights);
            check_room("the rays", (kept * RAY_BYTES) as u64, plan.memory)?;
        }
        let bvh = Bvh::build_with(scene, quality);
        if plan.frames_only {
            self.print(&self.frames(scene, &bvh, camera)?)?;
            return Ok(Vec::new());
        }
        let workload = Workload::new(scene, &bvh, camera, width, height);
        let mut results = Vec::new();
        for set in workload.sets.iter().filter(|set| set.count > 0) {
            let rows = compare(scene, &bvh, set, &plan.methods, plan.repeat as usize);
            self.print(&table(&rows))?;
            results.extend(rows);
        }
        self.print(&self.frames(scene, &bvh, camera)?)?;
        Ok(results)
    }

    fn frames(&self, scene: &Scene, bvh: &Bvh, camera: &Camera) -> Result<String, CliError> {
        let all = std::thread::available_parallelism().map_or(1, usize::from);
        let threads: &[usize] = if all > 1 { &[1, all] } else { &[1] };
        let repeat = self.plan.repeat as usize;
        let frames = frame_times(scene, bvh, camera, &self.plan.settings, threads, repeat)?;
        Ok(frame_table(&frames))
    }

    fn print(&self, text: &str) -> Result<(), CliError> {
        if self.quiet { Ok(()) } else { report::print(text) }
    }
}
