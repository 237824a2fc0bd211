//! The output of `octray verify`: counts, and a fault with the command that repeats it.

use super::{grouped, version};
use crate::{
    bench::machine,
    ray::Ray,
    verify::{Difference, Fault, FaultKind, Found, Outcome, Settings},
};
use serde::Serialize;
use std::{fmt::Write as _, time::Duration};

/// The counts as text.
pub fn text(settings: &Settings, outcome: &Outcome, took: Duration, stopped: bool) -> String {
    let (done, counts) = (&outcome.done, &outcome.counts);
    let small = done.scenes - done.large_scenes;
    let mut text = format!(
        "octray {}\nthis machine: {}, {}\nseed {}\n\n",
        version::long(),
        machine(),
        crate::isa(),
        settings.seed
    );
    let scenes = |count| {
        format!(
            "{} {}",
            grouped(count),
            if count == 1 { "scene" } else { "scenes" }
        )
    };
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "{} rays in {} of 1 to 64 primitives, {} rays in {} of up to 100 000\n",
        grouped(done.rays - done.large_rays),
        scenes(small),
        grouped(done.large_rays),
        scenes(done.large_scenes)
    );
    let _ = writeln!(text, "{:24}{:>18}{:>18}{:>18}", "", "rays", "hits", "occluded");
    let brute = ("brute force", counts.rays, counts.hits, counts.blocked);
    let others = counts
        .implementations
        .iter()
        .map(|e| (e.name.as_str(), e.rays, e.hits, e.blocked));
    for (name, rays, hits, blocked) in std::iter::once(brute).chain(others) {
        let (rays, hits, blocked) = (grouped(rays), grouped(hits), grouped(blocked));
        let _ = writeln!(text, "{name:24}{rays:>18}{hits:>18}{blocked:>18}");
    }
    let seconds = took.as_secs_f64();
    let per_second = grouped((done.rays as f64 / seconds.max(1e-9)) as u64);
    let verdict = match (&outcome.fault, stopped) {
        (Some(_), _) => "not all agree",
        (None, true) => "all agree so far; interrupted",
        (None, false) => "all agree, bit for bit",
    };
    let _ = writeln!(text, "\n{seconds:.1} s, {per_second} rays a second\n{verdict}");
    text
}

/// A fault, with the command that repeats it.
pub fn difference(fault: &Fault) -> String {
    let mut text = match &fault.kind {
        FaultKind::Panicked(message) => format!("tracing a scene panicked: {message}\n"),
        FaultKind::Differs(_) => "not all tracing methods agree\n".into(),
    };
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "scene {} of seed {}, {} primitives; octray {}",
        fault.scene,
        fault.seed,
        grouped(fault.primitives as u64),
        version::long().replace('\n', "; ")
    );
    if let FaultKind::Differs(difference) = &fault.kind {
        text += &ray_text(difference);
        let expected = ("brute force", difference.expected);
        for (name, found) in std::iter::once(expected).chain(
            difference
                .found
                .iter()
                .map(|(name, found)| (name.as_str(), *found)),
        ) {
            let mark = if found.same(&difference.expected) {
                ""
            } else {
                "  <-"
            };
            let _ = writeln!(text, "  {name:24}{}{mark}", found_text(&found));
        }
    }
    let _ = write!(
        text,
        "repeat it: octray verify --seed {} --scene {}",
        fault.seed, fault.scene
    );
    text
}

fn ray_text(difference: &Difference) -> String {
    let Ray {
        origin,
        direction,
        t_max,
    } = difference.ray();
    let (i, count) = difference.in_group;
    let mut text = format!(
        "ray {} of the scene, {i} of {count} traced together{}\n",
        difference.ray_i,
        if difference.group.shared {
            ", from one origin"
        } else {
            ""
        }
    );
    let vectors = [("origin", origin.to_array()), ("direction", direction.to_array())];
    for (name, [x, y, z]) in vectors {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "  {name:10}{} {} {}  ({x:e}, {y:e}, {z:e})",
            hex(x),
            hex(y),
            hex(z)
        );
    }
    let _ = writeln!(text, "  {:10}{}  ({t_max:e})", "t_max", hex(t_max));
    text
}

fn found_text(found: &Found) -> String {
    let hit = &found.hit;
    let primitive = if hit.is_hit() {
        hit.primitive.0.to_string()
    } else {
        "none".into()
    };
    format!(
        "t {}  u {}  v {}  primitive {primitive}  {}",
        hex(hit.t),
        hex(hit.u),
        hex(hit.v),
        if found.blocked { "occluded" } else { "not occluded" }
    )
}

fn hex(value: f32) -> String {
    format!("0x{:08x}", value.to_bits())
}

/// The counts as JSON.
#[derive(Debug, Serialize)]
pub struct Json {
    schema: u32,
    machine: String,
    isa: &'static str,
    version: &'static str,
    seed: u64,
    scenes: u64,
    rays: u64,
    large_scenes: u64,
    large_rays: u64,
    hits: u64,
    methods: Vec<JsonMethod>,
    seconds: f64,
    rays_per_s: f64,
    agree: bool,
    fault: Option<JsonFault>,
}

#[derive(Debug, Serialize)]
struct JsonMethod {
    method: String,
    rays: u64,
    hits: u64,
    occluded: u64,
}

#[derive(Debug, Serialize)]
struct JsonFault {
    seed: u64,
    scene: u64,
    text: String,
}

impl Json {
    /// The counts of a run of that duration.
    pub fn new(schema: u32, settings: &Settings, outcome: &Outcome, took: Duration) -> Self {
        let (done, counts) = (&outcome.done, &outcome.counts);
        let methods = counts.implementations.iter().map(|e| JsonMethod {
            method: e.name.clone(),
            rays: e.rays,
            hits: e.hits,
            occluded: e.blocked,
        });
        Self {
            schema,
            machine: machine(),
            isa: crate::isa(),
            version: env!("CARGO_PKG_VERSION"),
            seed: settings.seed,
            scenes: done.scenes,
            rays: done.rays,
            large_scenes: done.large_scenes,
            large_rays: done.large_rays,
            hits: counts.hits,
            methods: methods.collect(),
            seconds: took.as_secs_f64(),
            rays_per_s: done.rays as f64 / took.as_secs_f64().max(1e-9),
            agree: outcome.fault.is_none(),
            fault: outcome.fault.as_ref().map(|fault| JsonFault {
                seed: fault.seed,
                scene: fault.scene,
                text: difference(fault),
            }),
        }
    }
}
