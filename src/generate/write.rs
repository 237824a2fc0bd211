//! Writes generated scenes as `.scn` files and binary little-endian PLY meshes.

use super::{Generated, Shape};
use crate::scene::TriangleMesh;
use std::io::{self, Write};

/// The comment of a generated scene.
const SCN_MARK: &str = "// made by: octray generate ";
/// The comment of a generated mesh.
const PLY_MARK: &str = "comment made by octray\n";

/// Whether a file that begins so was generated.
#[cfg(feature = "cli")]
pub(crate) fn is_generated(head: &[u8]) -> bool {
    let has = |mark: &str| head.windows(mark.len()).any(|bytes| bytes == mark.as_bytes());
    has(SCN_MARK) || (head.starts_with(b"ply\n") && has(PLY_MARK))
}

impl Generated {
    /// Returns the arguments of `octray` for the scene's own view.
    #[must_use]
    pub fn render_arguments(&self) -> String {
        let view = &self.view;
        let list = |p: glam::DVec3| format!("{},{},{}", p.x, p.y, p.z);
        format!(
            "--eye={} --target={} --fov={}",
            list(view.eye),
            list(view.target),
            view.fov_degrees
        )
    }

    /// Writes the scene file. Reading it back gives the same numbers, bit for bit.
    ///
    /// # Errors
    /// Errors of `out`.
    pub fn write_scn(&self, out: &mut impl Write) -> io::Result<()> {
        let name = self.kind.name();
        writeln!(out, "// {name}: {}", self.kind.summary())?;
        writeln!(
            out,
            "{SCN_MARK}{name} --seed {} --count {}",
            self.seed, self.count
        )?;
        writeln!(out, "// octray {name}.scn {}\n", self.render_arguments())?;
        for light in &self.lights {
            let p = light.position;
            writeln!(out, "light {} {} {} {}", p.x, p.y, p.z, light.intensity)?;
        }
        for part in &self.parts {
            writeln!(out, "\nmaterial {}", part.material)?;
            if let Some(file) = self.mesh_file_name(part) {
                writeln!(out, "ply_file {file}")?;
            }
            if let Shape::Spheres(spheres) = &part.shape {
                for sphere in spheres {
                    let c = sphere.center;
                    writeln!(out, "sphere {} {} {} {}", c.x, c.y, c.z, sphere.radius)?;
                }
            }
        }
        Ok(())
    }
}

/// Writes a mesh as binary little-endian PLY: float positions and normals, triangles with int indices.
///
/// # Errors
/// Errors of `out`; [`io::ErrorKind::InvalidInput`] if the arrays of the mesh differ in length.
pub fn write_ply(mesh: &TriangleMesh, out: &mut impl Write) -> io::Result<()> {
    let vertices = mesh.x.len();
    let has_normals = !mesh.normals.is_empty();
    if mesh.y.len() != vertices || mesh.z.len() != vertices || (has_normals && mesh.normals.len() != vertices)
    {
        return Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "the arrays of the mesh differ in length",
        ));
    }
    writeln!(
        out,
        "ply\nformat binary_little_endian 1.0\n{PLY_MARK}comment up z"
    )?;
    writeln!(out, "element vertex {vertices}")?;
    let names: &[&str] = if has_normals {
        &["x", "y", "z", "nx", "ny", "nz"]
    } else {
        &["x", "y", "z"]
    };
    for name in names {
        writeln!(out, "property float {name}")?;
    }
    writeln!(out, "element face {}", mesh.triangles.len())?;
    writeln!(out, "property list uchar int vertex_indices\nend_header")?;

    let mut normals = mesh.normals.iter();
    for ((x, y), z) in mesh.x.iter().zip(&mesh.y).zip(&mesh.z) {
        for value in [x, y, z] {
            out.write_all(&value.to_le_bytes())?;
        }
        if let Some(normal) = normals.next() {
            for value in normal.to_array() {
                out.write_all(&value.to_le_bytes())?;
            }
        }
    }
    for triangle in &mesh.triangles {
        out.write_all(&[3])?;
        for index in triangle {
            out.write_all(&index.to_le_bytes())?;
        }
    }
    Ok(())
}
