//! The node tree: which nodes of the default scene place something, and where.

use super::{
    animations::AnimatedPose, buffers::Buffers, instancing::Instances, lights::PunctualLights,
    nodes::Contents, translations::Translations, visibility::Hidden,
};
use crate::{error::LoadError, scene::MAX_INSTANCES};
use glam::DMat4;
use gltf::{Document, Node};

/// A node with a mesh, a camera or a light, and its transform.
pub(super) struct Placement<'a> {
    pub(super) node: usize,
    /// Relative to the offset of the file.
    pub(super) world: DMat4,
    /// Whether only its camera counts.
    pub(super) is_hidden: bool,
    /// The instances of its mesh; `None` for a single placement.
    instances: Option<Instances<'a>>,
}

/// Where a node places its mesh.
pub(super) struct Place {
    pub(super) node: usize,
    pub(super) world: DMat4,
    /// The same without the node's transform, which does not move a skinned mesh: its joints do.
    pub(super) without_node: DMat4,
}

impl Placement<'_> {
    /// How many times it places its mesh.
    pub(super) fn count(&self) -> usize {
        self.instances.as_ref().map_or(1, |instances| instances.count)
    }

    /// Where it places its mesh the `i`th time.
    pub(super) fn at(&self, i: usize, buffers: &Buffers<'_>) -> Result<Place, LoadError> {
        let (world, mut without_node) = match &self.instances {
            Some(instances) => {
                let instance = instances.transform(i, buffers)?;
                (self.world * instance, instance)
            }
            None => (self.world, DMat4::IDENTITY),
        };
        without_node.w_axis -= buffers.budget().offset().vector().extend(0.0);
        Ok(Place {
            node: self.node,
            world,
            without_node,
        })
    }
}

/// What the nodes place, and their transforms.
pub(super) struct Tree<'a> {
    /// In the order of the tree.
    pub(super) placements: Vec<Placement<'a>>,
    /// The global transforms of all nodes, if the file has skins; `None` for nodes that contain themselves.
    pub(super) globals: Vec<Option<DMat4>>,
}

impl<'a> Tree<'a> {
    /// Reads the default scene, else the first one, else all root nodes.
    pub(super) fn of(
        contents: &Contents<'_>,
        punctual: &PunctualLights,
        buffers: &mut Buffers<'a>,
    ) -> Result<Self, LoadError> {
        let document = contents.document;
        let offset = buffers.budget().offset().vector();
        let has_joints = document.skins().len() > 0;
        let mut walk = Walk::new(contents, has_joints, buffers)?;
        let mut placements = Vec::new();
        let scene = document.default_scene().or_else(|| document.scenes().next());
        walk.start(match scene {
            Some(scene) => scene.nodes().map(|node| node.index()).collect(),
            None => roots(document),
        });
        while let Some(met) = walk.next() {
            let (node, mut world) = (met.node, met.world);
            let i = node.index();
            if !met.is_first {
                return Err(contains_itself(i, buffers));
            }
            let is_shown = !met.is_hidden && (node.mesh().is_some() || punctual.is_at(i));
            if is_shown || node.camera().is_some() {
                let instances = match node.mesh() {
                    Some(_) if is_shown => contents.instancing.at(i, document, buffers)?,
                    _ => None,
                };
                world.w_axis -= offset.extend(0.0);
                placements.push(Placement {
                    node: i,
                    world,
                    is_hidden: met.is_hidden,
                    instances,
                });
            }
        }
        if has_joints {
            // Joints may be outside the scene.
            walk.start(roots(document));
            while walk.next().is_some() {}
        }
        check_instances(&placements, buffers)?;
        Ok(Self {
            placements,
            globals: walk.globals,
        })
    }
}

/// The error about a node that is met again.
pub(super) fn contains_itself(node: usize, buffers: &Buffers<'_>) -> LoadError {
    buffers.refused(format!("nodes[{node}] has two parents or contains itself"))
}

/// The nodes without parents.
fn roots(document: &Document) -> Vec<usize> {
    let mut is_child = vec![false; document.nodes().len()];
    for child in document.nodes().flat_map(|node| node.children()) {
        is_child[child.index()] = true;
    }
    (0..is_child.len()).filter(|&i| !is_child[i]).collect()
}

/// A node that is met on a walk.
struct Met<'d> {
    node: Node<'d>,
    /// Its global transform.
    world: DMat4,
    /// Whether it is met for the first time: only then its children follow.
    is_first: bool,
    /// Whether it or a node above it is hidden.
    is_hidden: bool,
}

/// A walk through the nodes, parents first.
struct Walk<'d> {
    document: &'d Document,
    translations: &'d Translations,
    hidden: &'d Hidden,
    pose: &'d AnimatedPose,
    visited: Vec<bool>,
    /// The transforms of nodes that have children, and whether they are hidden; the first is the world's.
    parents: Vec<(DMat4, bool)>,
    /// A stack of nodes with their parents.
    waiting: Vec<(usize, usize)>,
    /// By node; empty if nobody needs them.
    globals: Vec<Option<DMat4>>,
}

impl<'d> Walk<'d> {
    fn new(contents: &Contents<'d>, keeps_globals: bool, buffers: &Buffers<'_>) -> Result<Self, LoadError> {
        let document = contents.document;
        let count = document.nodes().len();
        let mut globals = Vec::new();
        if keeps_globals {
            let room = buffers.budget().reserve(&mut globals, count);
            room.map_err(|error| buffers.no_room(error))?;
            globals.resize(count, None);
        }
        Ok(Self {
            document,
            translations: contents.translations,
            hidden: contents.hidden,
            pose: contents.pose,
            visited: vec![false; count],
            parents: vec![(DMat4::IDENTITY, false)],
            waiting: Vec::new(),
            globals,
        })
    }

    fn start(&mut self, roots: Vec<usize>) {
        self.waiting = roots.into_iter().rev().map(|node| (node, 0)).collect();
    }

    /// The next node, or `None` at the end.
    fn next(&mut self) -> Option<Met<'d>> {
        let (i, parent) = self.waiting.pop()?;
        let node = self.document.nodes().nth(i)?;
        let mut local = self.pose.local(&node).unwrap_or_else(|| {
            let columns = node.transform().matrix();
            DMat4::from_cols_array_2d(&columns.map(|column| column.map(f64::from)))
        });
        if let Some(translation) = self.translations.of_node(i)
            && !self.pose.has_translation(i)
        {
            local.w_axis = translation.extend(1.0);
        }
        let (above, is_below_hidden) = self.parents[parent];
        let world = above * local;
        let is_hidden = is_below_hidden || self.hidden.is_at(i);
        let is_first = !std::mem::replace(&mut self.visited[i], true);
        if is_first {
            if let Some(global) = self.globals.get_mut(i) {
                *global = Some(world);
            }
            // Children pushed in reverse come out in order.
            let first = self.waiting.len();
            let parent = self.parents.len();
            self.waiting
                .extend(node.children().map(|child| (child.index(), parent)));
            if self.waiting.len() > first {
                self.waiting[first..].reverse();
                self.parents.push((world, is_hidden));
            }
        }
        Some(Met {
            node,
            world,
            is_first,
            is_hidden,
        })
    }
}

/// Refuses more instances than the file's size allows: accessors of many nodes may be the same.
fn check_instances(placements: &[Placement<'_>], buffers: &Buffers<'_>) -> Result<(), LoadError> {
    let counts = placements
        .iter()
        .filter_map(|placement| Some(placement.instances.as_ref()?.count));
    let (count, size) = (counts.fold(0, usize::saturating_add), buffers.size());
    let most = size.saturating_mul(8).saturating_add(1 << 16).min(MAX_INSTANCES);
    if count > most {
        return Err(buffers.too_much(format!(
            "{count} instances, expected at most {most} from {size} bytes"
        )));
    }
    Ok(())
}
