//! Instances: meshes that are stored once and placed any number of times.

use super::{
    QUOTES_HINT, Reader,
    arguments::Arguments,
    at::{self, Moved, MovedThing},
    mesh,
    meshes::Kind,
    placements,
    words::Word,
};
use crate::{
    error::{LoadError, clip_path},
    format::{files::load_error, reason::Reason},
    scene::{MAX_INSTANCES, MaterialId, Motion, PrototypeId, Transform},
};
use std::path::Path;

/// The key of a prototype: the number of the file, the material, and the bits of the radius of points.
pub(super) type PrototypeKey = (usize, Option<MaterialId>, u32);

impl Reader<'_> {
    /// `instance PATH ...`: a mesh of any format, stored once, with one placement or those of a file.
    pub(super) fn instance(&mut self, mut arguments: Arguments<'_, '_>) -> Result<(), LoadError> {
        let [word] = arguments.leading()?;
        arguments.hint = QUOTES_HINT;
        let placement = mesh::read_placement(&mut arguments, &mesh::INSTANCE_KEYS)?;
        let line = arguments.line;
        let file = placement.file.map(|(before, word)| {
            let path = self.path(&arguments, word, "placements")?;
            Ok((before, word, path))
        });
        let file = file.transpose()?;
        let path = self.path(&arguments, word, "mesh")?;
        let number = self.mesh_number(&path, self.material);
        let radius_bits = placement.point_radius.map_or(0, f32::to_bits);
        let key: PrototypeKey = (number, self.material, radius_bits);
        let prototype = if let Some(&prototype) = self.prototypes.get(&key) {
            prototype
        } else {
            let prototype = self.prototype(&arguments, word, &path, placement.point_radius)?;
            self.prototypes.insert(key, prototype);
            prototype
        };
        let mut moving = at::follows(line.rest).then(Vec::new);
        if let Some((before, word, path)) = file {
            let placed = (before, &placement.transform);
            self.read_placements(prototype, &path, placed, moving.as_mut())
                .map_err(|cause| {
                    let message = format!("cannot read placements from {}", path.display());
                    line.error_at(&word, message).caused_by(cause)
                })?;
        } else if let Some(moving) = &mut moving {
            moving.push(placement.transform);
        } else {
            let added = self.builder.add_instance(prototype, &placement.transform);
            added.map_err(|error| {
                line.error_at(&word, format!("cannot place {}: {error}", path.display()))
                    .with_kind((&error).into())
            })?;
        }
        if let Some(transforms) = moving {
            self.start_motion(&arguments, word, prototype, transforms);
        }
        Ok(())
    }

    /// Places a prototype by each row of a file, between two other transforms, or adds the placements to those that move.
    fn read_placements(
        &mut self,
        prototype: PrototypeId,
        path: &Path,
        (before, after): (Transform, &Transform),
        mut moving: Option<&mut Vec<Transform>>,
    ) -> Result<(), LoadError> {
        let (builder, budget) = (&mut self.builder, self.budget);
        let taken = budget.taken();
        let opened = self
            .files
            .mesh(path, budget)
            .and_then(|opened| opened.into_bytes(budget));
        let bytes = opened.map_err(|error| load_error(path, &error))?;
        if let Some(count) = placements::announced(&bytes) {
            let room = builder.check_instances(count);
            room.map_err(|error| Reason::from(error).of_file(path))?;
        }
        let read = placements::read(&bytes, path, budget, |rows| {
            let transform = before
                .then_transform(&Transform::from_rows(rows))
                .then_transform(after);
            let Some(moving) = &mut moving else {
                let added = builder.add_instance(prototype, &transform);
                return added.map_err(Reason::from);
            };
            if moving.len() >= MAX_INSTANCES {
                return Err(Reason::limit(format!("more than {MAX_INSTANCES} instances")));
            }
            // Twice, as the array grows.
            let taken = budget.take(2 * size_of::<Transform>());
            moving.push(transform);
            taken.map_err(Reason::from)
        });
        drop(bytes);
        budget.give_back_to(taken);
        if read? == 0 {
            self.add_mesh_note(format!("{}: no placements", clip_path(path)));
        }
        Ok(())
    }

    /// Waits for the keyframes of instances.
    fn start_motion(
        &mut self,
        arguments: &Arguments<'_, '_>,
        word: Word<'_>,
        prototype: PrototypeId,
        transforms: Vec<Transform>,
    ) {
        let what = MovedThing::Instances {
            prototype,
            transforms,
            motion: Motion::default(),
        };
        self.moved = Some(Moved::new(what, arguments.line, &word));
    }

    /// Stores a mesh.
    fn prototype(
        &mut self,
        arguments: &Arguments<'_, '_>,
        word: Word<'_>,
        path: &Path,
        point_radius: Option<f32>,
    ) -> Result<PrototypeId, LoadError> {
        let (line, material) = (arguments.line, self.material);
        let number = self.mesh_number(path, material);
        let mut loaded = self.load_mesh(arguments, word, path, (material, Kind::Any, false))?;
        self.see_light(number, loaded.as_ref(), material);
        mesh::note_faces(loaded.as_mut(), path, point_radius);
        let placement = mesh::Placement {
            point_radius,
            is_stored: true,
            ..mesh::Placement::AS_IT_IS
        };
        let start = self.builder.start_prototype();
        let placed = self.place(number, loaded, &placement, material);
        let ended = placed.and_then(|()| {
            let ended = self.builder.end_prototype(start);
            ended.map_err(Reason::from)
        });
        ended.map_err(|reason| mesh::cannot_load(line, word, path).caused_by(reason.of_file(path)))
    }
}
