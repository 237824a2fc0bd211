//! Traces one scene by brute force and by every implementation, and compares the results bit for bit.

use super::{Found, Group, Implementations, Random};
use crate::{
    accel::Bvh,
    ray::{Ray, T_MAX},
    reference::brute::Shapes,
    scene::Scene,
};

/// Counts the rays traced and what they found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Rays; every implementation traces each twice, for the closest hit and for occlusion.
    pub rays: u64,
    /// Rays that hit something before their end.
    pub hits: u64,
    /// Rays that are occluded: all that hit something, unless surfaces let light pass.
    pub blocked: u64,
    /// The counts of each implementation under test, from its own results.
    pub implementations: Vec<ImplementationCounts>,
}

/// Counts the results of one implementation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ImplementationCounts {
    /// Its name.
    pub name: String,
    /// Rays traced.
    pub rays: u64,
    /// Rays that hit something.
    pub hits: u64,
    /// Rays that were occluded.
    pub blocked: u64,
}

impl Counts {
    /// Adds the counts of another scene.
    pub fn add(&mut self, other: &Self) {
        self.rays += other.rays;
        self.hits += other.hits;
        self.blocked += other.blocked;
        for theirs in &other.implementations {
            match self
                .implementations
                .iter_mut()
                .find(|ours| ours.name == theirs.name)
            {
                Some(ours) => {
                    ours.rays += theirs.rays;
                    ours.hits += theirs.hits;
                    ours.blocked += theirs.blocked;
                }
                None => self.implementations.push(theirs.clone()),
            }
        }
    }
}

/// A ray for which an implementation disagrees with brute force.
#[derive(Clone, Debug)]
pub struct Difference {
    /// Index among the scene's rays, from 0.
    pub ray_i: u64,
    /// Index within the group, from 0, and the size of the group.
    pub in_group: (usize, usize),
    /// The group as it was traced.
    pub group: Group,
    /// What brute force found.
    pub expected: Found,
    /// What each implementation found.
    pub found: Vec<(String, Found)>,
}

impl Difference {
    /// Returns the ray.
    #[must_use]
    pub fn ray(&self) -> Ray {
        self.group.rays[self.in_group.0]
    }
}

/// Traces `rays` random rays through `scene` with every implementation, or fewer if `stop` returns true.
///
/// # Errors
/// Returns the first ray for which an implementation differs from brute force, bit for bit.
///
/// # Panics
/// If an implementation does not return one result per ray.
pub fn check_equivalence(
    scene: &Scene,
    bvh: &Bvh,
    implementations: &Implementations,
    random: &mut Random,
    rays: u64,
    counts: &mut Counts,
    stop: &dyn Fn() -> bool,
) -> Result<(), Box<Difference>> {
    let shapes = Shapes::new(scene);
    let mut implementations = implementations(scene, bvh);
    *counts = Counts {
        implementations: implementations
            .iter()
            .map(|implementation| ImplementationCounts {
                name: implementation.name().to_owned(),
                rays: 0,
                hits: 0,
                blocked: 0,
            })
            .collect(),
        ..Counts::default()
    };
    let mut expected = Vec::new();
    let mut results = vec![Vec::new(); implementations.len()];
    while counts.rays < rays && !stop() {
        let most = (rays - counts.rays).min(1 << 20) as usize;
        let group = group(random, scene, &shapes, most);
        expected.clear();
        expected.extend(group.rays.iter().map(|ray| {
            let hit = shapes.closest_hit(ray);
            // Where surfaces are whole, a hit before the ray's end is what occludes it.
            let is_blocked = hit.is_hit() && (!scene.has_cut_outs() || shapes.occluded(ray));
            Found {
                hit,
                blocked: is_blocked,
            }
        }));
        for ((implementation, found), counts) in implementations
            .iter_mut()
            .zip(&mut results)
            .zip(&mut counts.implementations)
        {
            implementation.trace(&group, found);
            assert_eq!(found.len(), group.rays.len(), "one result per ray");
            counts.rays += found.len() as u64;
            counts.hits += found.iter().filter(|found| found.hit.is_hit()).count() as u64;
            counts.blocked += found.iter().filter(|found| found.blocked).count() as u64;
        }
        let differs = |i: &usize| results.iter().any(|found| !found[*i].same(&expected[*i]));
        if let Some(i) = (0..group.rays.len()).find(differs) {
            let found = implementations.iter().zip(&results);
            return Err(Box::new(Difference {
                ray_i: counts.rays + i as u64,
                in_group: (i, group.rays.len()),
                expected: expected[i],
                found: found
                    .map(|(implementation, found)| (implementation.name().to_owned(), found[i]))
                    .collect(),
                group,
            }));
        }
        counts.rays += group.rays.len() as u64;
        counts.hits += expected.iter().filter(|found| found.hit.is_hit()).count() as u64;
        counts.blocked += expected.iter().filter(|found| found.blocked).count() as u64;
    }
    Ok(())
}

/// Makes a group of random rays. Some end exactly at what they would hit, or one ulp before or behind it.
fn group(random: &mut Random, scene: &Scene, shapes: &Shapes, most: usize) -> Group {
    let group = Group::random(random, scene, most);
    let mut rays = group.rays;
    for ray in &mut rays {
        if !random.one_in(32) {
            continue;
        }
        let hit = shapes.closest_hit(&Ray { t_max: T_MAX, ..*ray });
        if hit.is_hit() {
            ray.t_max = random.pick(&[hit.t, hit.t.next_up(), hit.t.next_down()]);
        }
    }
    Group::new(group.shared, rays)
}
