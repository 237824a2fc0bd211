//! The BVH in the output of `octray info`.

use super::info::count;
use crate::{
    accel::{Bvh, BvhStats},
    error::in_bytes,
};
use serde::Serialize;

/// Statistics of a BVH.
#[derive(Debug, Serialize)]
pub(super) struct BvhInfo {
    /// The build quality: "best".
    build: &'static str,
    /// How triangles are stored: "whole" or "indexed".
    layout: &'static str,
    /// What is outside of instances.
    #[serde(flatten)]
    outside: Level,
    /// Of all levels.
    bytes: usize,
    build_s: f64,
    /// The level over instances. `None` without instances.
    instances: Option<Upper>,
    /// The hierarchies of all prototypes together.
    prototypes: Option<Lower>,
}

#[derive(Debug, Serialize)]
struct Level {
    /// The largest of several.
    depth: usize,
    nodes: usize,
    triangle_blocks: usize,
    sphere_blocks: usize,
    /// Numbers of leaf blocks that hold 1, 2, ... 8 primitives.
    leaf_sizes: [usize; 8],
    /// Numbers of nodes that have 1, 2, ... 8 children.
    child_counts: [usize; 8],
}

/// Its leaves are the instances.
#[derive(Debug, Serialize)]
struct Upper {
    depth: usize,
    nodes: usize,
    child_counts: [usize; 8],
    bytes: usize,
}

#[derive(Debug, Serialize)]
struct Lower {
    #[serde(flatten)]
    level: Level,
    bytes: usize,
}

impl BvhInfo {
    pub fn new(bvh: &Bvh) -> Self {
        let stats = bvh.stats();
        let (upper, lower) = bvh.instanced_stats().unzip();
        Self {
            build: stats.quality.name(),
            layout: stats.layout.name(),
            outside: Level::new(stats),
            bytes: stats.memory_bytes,
            build_s: stats.build_time.as_secs_f64(),
            instances: upper.map(|stats| Upper {
                depth: stats.depth,
                nodes: stats.nodes,
                child_counts: stats.child_counts,
                bytes: stats.memory_bytes,
            }),
            prototypes: lower.map(|stats| Lower {
                level: Level::new(&stats),
                bytes: stats.memory_bytes,
            }),
        }
    }

    /// Names and values for the text. A scene without anything outside of instances has no lines of that.
    pub fn lines(&self) -> Vec<(String, String)> {
        let mut lines = vec![
            ("BVH", in_bytes(self.bytes as u64)),
            ("  build", self.build.into()),
            ("  layout", self.layout.into()),
            ("  build time", format!("{:.1} ms", self.build_s * 1e3)),
        ];
        let Level {
            triangle_blocks,
            sphere_blocks,
            ..
        } = self.outside;
        if self.instances.is_none() || triangle_blocks + sphere_blocks > 0 {
            lines.extend(self.outside.lines());
        }
        if let Some(upper) = &self.instances {
            lines.extend([
                ("BVH of instances", in_bytes(upper.bytes as u64)),
                ("  depth", count(upper.depth)),
                ("  nodes", count(upper.nodes)),
                ("  node sizes", by_size(upper.child_counts, "children")),
            ]);
        }
        if let Some(lower) = &self.prototypes {
            lines.push(("BVHs of meshes", in_bytes(lower.bytes as u64)));
            lines.extend(lower.level.lines());
        }
        let owned = |(name, value): (&str, String)| (name.to_owned(), value);
        lines.into_iter().map(owned).collect()
    }
}

impl Level {
    fn new(stats: &BvhStats) -> Self {
        Self {
            depth: stats.depth,
            nodes: stats.nodes,
            triangle_blocks: stats.triangle_blocks,
            sphere_blocks: stats.sphere_blocks,
            leaf_sizes: stats.leaf_sizes,
            child_counts: stats.child_counts,
        }
    }

    fn lines(&self) -> [(&'static str, String); 6] {
        [
            ("  depth", count(self.depth)),
            ("  nodes", count(self.nodes)),
            ("  triangle blocks", count(self.triangle_blocks)),
            ("  sphere blocks", count(self.sphere_blocks)),
            ("  leaf sizes", by_size(self.leaf_sizes, "primitives")),
            ("  node sizes", by_size(self.child_counts, "children")),
        ]
    }
}

/// `12 x 1, 3 x 2 primitives`.
fn by_size(counts: [usize; 8], parts: &str) -> String {
    let sizes = (1..).zip(counts).filter(|&(_, number)| number > 0);
    let listed: Vec<String> = sizes
        .map(|(size, number)| format!("{} x {size}", count(number)))
        .collect();
    if listed.is_empty() {
        return "none".into();
    }
    format!("{} {parts}", listed.join(", "))
}

#[cfg(test)]
mod tests;
