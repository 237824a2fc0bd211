//! Adding spheres, one or many at once.

use super::{
    SceneBuilder, WHITE,
    mesh::{append, append_padded, check_colors, expect_length, first_where, reserve, reserve_for_append},
    usable, usable_point,
};
use crate::{
    error::SceneError,
    scene::{MaterialId, is_usable},
};
use glam::Vec3;
use rayon::{iter::repeat_n, prelude::*};

/// Many spheres as a structure of arrays.
#[derive(Clone, Debug, Default)]
pub struct SphereCloud {
    /// Centres, scene units; the four arrays of numbers have equal lengths.
    pub x: Vec<f32>,
    /// Centres, scene units.
    pub y: Vec<f32>,
    /// Centres, scene units.
    pub z: Vec<f32>,
    /// Radii, scene units, above 0.
    pub radius: Vec<f32>,
    /// One base colour per sphere, as [`Spheres::color`](crate::scene::Spheres::color), or empty.
    pub colors: Vec<[f32; 3]>,
}

impl SceneBuilder {
    /// Adds a sphere.
    ///
    /// # Errors
    /// [`SceneError::NotUsable`], [`SceneError::NotPositive`], [`SceneError::UnknownMaterial`] or
    /// [`SceneError::TooMany`].
    pub fn add_sphere(&mut self, center: Vec3, radius: f32, material: MaterialId) -> Result<(), SceneError> {
        usable_point(center)?;
        check_radius(radius)?;
        self.check_material(material)?;
        self.check_limits([0, 1, 0], self.vectors())?;
        let all = &mut self.spheres;
        all.center_x.push(center.x);
        all.center_y.push(center.y);
        all.center_z.push(center.z);
        all.radius.push(radius);
        all.material.push(material);
        if !all.color.is_empty() {
            all.color.push(WHITE);
        }
        Ok(())
    }

    /// Adds many spheres. The arrays are moved into the scene if it has no spheres yet.
    ///
    /// # Errors
    /// As [`SceneBuilder::add_sphere`]; also [`SceneError::ArrayLength`], [`SceneError::OutOfRange`] if a channel of a
    /// colour is not from 0 to 1, [`SceneError::OverLimit`] or [`SceneError::NoMemory`]. The scene is unchanged then.
    pub fn add_spheres(&mut self, spheres: SphereCloud, material: MaterialId) -> Result<(), SceneError> {
        self.check_material(material)?;
        check(&spheres)?;
        let SphereCloud {
            x,
            y,
            z,
            radius,
            colors,
        } = spheres;
        let (base, count) = (self.spheres.radius.len(), radius.len());
        let has_colors = !colors.is_empty() || !self.spheres.color.is_empty();
        let new_colors = if has_colors {
            base + count - self.spheres.color.len()
        } else {
            0
        };
        self.check_limits([0, count, 0], self.vectors() + new_colors)?;
        let all = &mut self.spheres;
        reserve(&mut all.material, count, "spheres")?;
        if base > 0 || colors.is_empty() {
            reserve(&mut all.color, new_colors, "spheres")?;
        }
        let mut columns = [
            (&mut all.center_x, x),
            (&mut all.center_y, y),
            (&mut all.center_z, z),
            (&mut all.radius, radius),
        ];
        for (to, from) in &mut columns {
            reserve_for_append(to, from, "spheres")?;
        }
        for (to, from) in columns {
            append(to, from);
        }
        if has_colors {
            append_padded(&mut all.color, colors, [base, base + count], WHITE);
        }
        all.material.par_extend(repeat_n(material, count));
        Ok(())
    }
}

fn check_radius(radius: f32) -> Result<(), SceneError> {
    usable("radius", radius)?;
    if radius <= 0.0 {
        return Err(SceneError::NotPositive {
            what: "radius",
            value: radius,
        });
    }
    Ok(())
}

fn check(spheres: &SphereCloud) -> Result<(), SceneError> {
    let count = spheres.x.len();
    expect_length("y coordinates", spheres.y.len(), count)?;
    expect_length("z coordinates", spheres.z.len(), count)?;
    expect_length("radii", spheres.radius.len(), count)?;
    for (what, coordinates) in [("x", &spheres.x), ("y", &spheres.y), ("z", &spheres.z)] {
        let unusable = first_where(coordinates, |&value| !is_usable(value));
        unusable.map_or(Ok(()), |i| usable(what, coordinates[i]))?;
    }
    // Not `<= 0.0`, so that NaN is found.
    let unusable = first_where(&spheres.radius, |&radius| {
        !is_usable(radius) | !matches!(radius.partial_cmp(&0.0), Some(std::cmp::Ordering::Greater))
    });
    unusable.map_or(Ok(()), |i| check_radius(spheres.radius[i]))?;
    check_colors(&spheres.colors, count)
}

#[cfg(test)]
mod tests;
