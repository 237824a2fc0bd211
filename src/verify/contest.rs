//! One scene, traced by brute force and by all entrants.

use super::{Entrants, Found, Group, Random};
use crate::{
    accel::Bvh,
    ray::{Ray, T_MAX},
    reference::brute::Shapes,
    scene::Scene,
};

/// What was done and found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Rays; each was traced twice by everybody, to the nearest hit and to any.
    pub rays: u64,
    /// Rays that hit something before their end.
    pub hits: u64,
    /// Each entrant's name and what it counted by its own answers.
    pub entrants: Vec<EntrantCounts>,
}

/// What one way of tracing answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EntrantCounts {
    /// Its name.
    pub name: &'static str,
    /// Rays that it traced.
    pub rays: u64,
    /// How many of them hit something.
    pub hits: u64,
    /// How many of them were blocked.
    pub blocked: u64,
}

impl Counts {
    /// Adds those of another scene.
    pub fn add(&mut self, other: &Self) {
        self.rays += other.rays;
        self.hits += other.hits;
        for theirs in &other.entrants {
            match self.entrants.iter_mut().find(|ours| ours.name == theirs.name) {
                Some(ours) => {
                    ours.rays += theirs.rays;
                    ours.hits += theirs.hits;
                    ours.blocked += theirs.blocked;
                }
                None => self.entrants.push(theirs.clone()),
            }
        }
    }
}

/// A ray on which not all agree.
#[derive(Clone, Debug)]
pub struct Difference {
    /// Which of the scene's rays, from 0.
    pub ray_i: u64,
    /// Which of its group's, from 0, and how many those are.
    pub in_group: (usize, usize),
    /// The group, as it was traced.
    pub group: Group,
    /// What brute force found.
    pub expected: Found,
    /// What each entrant found.
    pub found: Vec<(&'static str, Found)>,
}

impl Difference {
    /// The ray.
    #[must_use]
    pub fn ray(&self) -> Ray {
        self.group.rays[self.in_group.0]
    }
}

/// Traces `rays` random rays through `scene` in every way, until `stop` says so.
///
/// # Errors
/// The first ray on which an entrant does not find what brute force finds, bit for bit.
///
/// # Panics
/// If an entrant does not answer for each ray.
pub fn contest(
    scene: &Scene,
    bvh: &Bvh,
    entrants: &Entrants,
    random: &mut Random,
    rays: u64,
    counts: &mut Counts,
    stop: &dyn Fn() -> bool,
) -> Result<(), Box<Difference>> {
    let shapes = Shapes::new(scene);
    let mut entrants = entrants(scene, bvh);
    *counts = Counts {
        entrants: entrants
            .iter()
            .map(|entrant| EntrantCounts {
                name: entrant.name(),
                rays: 0,
                hits: 0,
                blocked: 0,
            })
            .collect(),
        ..Counts::default()
    };
    let mut expected = Vec::new();
    let mut answers = vec![Vec::new(); entrants.len()];
    while counts.rays < rays && !stop() {
        let most = (rays - counts.rays).min(1 << 20) as usize;
        let group = group(random, scene, &shapes, most);
        expected.clear();
        expected.extend(group.rays.iter().map(|ray| {
            let hit = shapes.closest_hit(ray);
            // What blocks a ray is what it hits before its end: `brute::occluded` asks for just that.
            let blocked = hit.is_hit();
            Found { hit, blocked }
        }));
        for ((entrant, found), counts) in entrants.iter_mut().zip(&mut answers).zip(&mut counts.entrants) {
            entrant.trace(&group, found);
            assert_eq!(found.len(), group.rays.len(), "an answer for each ray");
            counts.rays += found.len() as u64;
            counts.hits += found.iter().filter(|found| found.hit.is_hit()).count() as u64;
            counts.blocked += found.iter().filter(|found| found.blocked).count() as u64;
        }
        let differs = |i: &usize| answers.iter().any(|found| !found[*i].same(&expected[*i]));
        if let Some(i) = (0..group.rays.len()).find(differs) {
            let found = entrants.iter().zip(&answers);
            return Err(Box::new(Difference {
                ray_i: counts.rays + i as u64,
                in_group: (i, group.rays.len()),
                expected: expected[i],
                found: found.map(|(entrant, found)| (entrant.name(), found[i])).collect(),
                group,
            }));
        }
        counts.rays += group.rays.len() as u64;
        counts.hits += expected.iter().filter(|found| found.blocked).count() as u64;
    }
    Ok(())
}

/// A group of rays, some of which end exactly at what they would hit, or a hair before or behind it.
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
