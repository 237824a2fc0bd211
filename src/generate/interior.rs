//! The inside of a hall: two rows of fluted columns, curtains, railings, potted plants, and beams under an open roof.
//! Mixes large and tiny triangles, near and far, like a modelled interior.

use super::{
    Content, Part, Shape, View, light,
    mesh::{MeshBuilder, side},
    random::{Noise, Random, lerp, smoothstep},
};
use glam::DVec3;
use std::f64::consts::TAU;

/// Half the length (x) of the hall, scene units.
const HALF_LENGTH: f64 = 3.2;
/// Half the width (y) of the hall, scene units.
const HALF_WIDTH: f64 = 1.5;
const HEIGHT: f64 = 2.0;
/// The rows of columns are at y = ± this.
const ROW_Y: f64 = 0.95;
const COLUMNS_PER_ROW: usize = 6;

/// Shares of the triangles; plants get the rest.
const COLUMN_SHARE: f64 = 0.22;
const CURTAIN_SHARE: f64 = 0.40;
const RAILING_SHARE: f64 = 0.16;

pub(super) fn make(seed: u64, count: usize) -> Content {
    let mut random = Random::new(seed);
    let mut hall = MeshBuilder::default();
    shell(&mut hall);
    columns(&mut hall, COLUMN_SHARE * count as f64);
    railings(&mut hall, RAILING_SHARE * count as f64);
    curtains(&mut hall, CURTAIN_SHARE * count as f64, seed);
    let floor = floor();
    let left = count.saturating_sub(hall.triangle_count() + floor.triangle_count());
    plants(&mut hall, left, &mut random);

    let part = |name, material, mesh: MeshBuilder| Part {
        name,
        material,
        shape: Shape::Mesh(mesh.finish()),
    };
    Content {
        parts: vec![part("floor", 3, floor), part("", 1, hall)],
        lights: vec![
            light(1.5, 0.6, 6.0, 0.7),
            light(-2.6, -0.2, 1.7, 0.45),
            light(2.2, 0.3, 1.8, 0.3),
        ],
        view: View {
            eye: DVec3::new(-2.9, -0.35, 0.85),
            target: DVec3::new(0.0, 0.1, 0.75),
            fov_degrees: 60.0,
        },
    }
}

fn floor() -> MeshBuilder {
    let mut floor = MeshBuilder::default();
    let (x, y) = (HALF_LENGTH, HALF_WIDTH);
    floor.quad([(-x, -y), (x, -y), (x, y), (-x, y)].map(|(x, y)| DVec3::new(x, y, 0.0)));
    floor
}

/// Adds the walls, the edges of the roof and the beams across its opening.
fn shell(hall: &mut MeshBuilder) {
    let (x, y, z) = (HALF_LENGTH, HALF_WIDTH, HEIGHT);
    let thick = 0.1;
    hall.cuboid(DVec3::new(-x, y, 0.0), DVec3::new(x, y + thick, z));
    hall.cuboid(DVec3::new(-x, -y - thick, 0.0), DVec3::new(x, -y, z));
    hall.cuboid(DVec3::new(-x - thick, -y, 0.0), DVec3::new(-x, y, z));
    hall.cuboid(DVec3::new(x, -y, 0.0), DVec3::new(x + thick, y, z));
    for side in [-1.0, 1.0] {
        let (near, far) = (side * 0.6, side * y);
        hall.cuboid(
            DVec3::new(-x, near.min(far), z),
            DVec3::new(x, near.max(far), z + thick),
        );
    }
    for i in 0..9 {
        let at = lerp((f64::from(i) + 0.5) / 9.0, -x, x);
        hall.cuboid(
            DVec3::new(at - 0.05, -0.6, z - 0.02),
            DVec3::new(at + 0.05, 0.6, z + thick),
        );
    }
}

fn column_x(i: usize) -> f64 {
    lerp(
        (i as f64 + 0.5) / COLUMNS_PER_ROW as f64,
        -HALF_LENGTH,
        HALF_LENGTH,
    )
}

fn columns(hall: &mut MeshBuilder, triangles: f64) {
    const FLUTES: f64 = 16.0;
    let each = triangles / (2 * COLUMNS_PER_ROW) as f64;
    let rows = side(each / 4.0, 4);
    for i in 0..2 * COLUMNS_PER_ROW {
        let x = column_x(i / 2);
        let y = if i % 2 == 0 { ROW_Y } else { -ROW_Y };
        hall.tube(2 * rows, rows, |u, v| {
            // Base and capital are wide; the shaft is fluted and tapers.
            let shaft = smoothstep(0.04, 0.10, v) * (1.0 - smoothstep(0.86, 0.94, v));
            let flute = 1.0 - 0.09 * shaft * libm::fabs(libm::sin(0.5 * FLUTES * TAU * u));
            let radius = lerp(shaft, 0.17, 0.125 - 0.02 * v) * flute;
            let (sin, cos) = libm::sincos(TAU * u);
            DVec3::new(x + radius * cos, y + radius * sin, HEIGHT * v)
        });
    }
}

/// Adds balusters under a rail between the columns of both rows.
fn railings(hall: &mut MeshBuilder, triangles: f64) {
    const PER_GAP: usize = 11;
    let gaps = 2 * (COLUMNS_PER_ROW - 1);
    let each = triangles / (gaps * PER_GAP) as f64;
    let rows = side(each / 1.2, 5);
    let around = (rows * 3 / 5).max(4);
    for gap in 0..gaps {
        let y = if gap % 2 == 0 { ROW_Y } else { -ROW_Y };
        let (from, to) = (column_x(gap / 2) + 0.17, column_x(gap / 2 + 1) - 0.17);
        hall.cuboid(DVec3::new(from, y - 0.03, 0.36), DVec3::new(to, y + 0.03, 0.40));
        hall.cuboid(DVec3::new(from, y - 0.03, 0.02), DVec3::new(to, y + 0.03, 0.05));
        for i in 0..PER_GAP {
            let x = lerp((i as f64 + 0.5) / PER_GAP as f64, from, to);
            hall.tube(around, rows, |u, v| {
                let belly = libm::sin(TAU * v - 0.6) * 0.5 + 0.5;
                let radius = 0.010 + 0.016 * belly * (1.0 - v * 0.6);
                let (sin, cos) = libm::sincos(TAU * u);
                DVec3::new(x + radius * cos, y + radius * sin, lerp(v, 0.05, 0.36))
            });
        }
    }
}

/// Adds curtains between the columns: wavy sheets, gathered at one side.
fn curtains(hall: &mut MeshBuilder, triangles: f64, seed: u64) {
    let gaps = 2 * (COLUMNS_PER_ROW - 1);
    let rows = side(triangles / gaps as f64 / 3.0, 6);
    for gap in 0..gaps {
        let noise = Noise::new(seed.wrapping_add(1000 + gap as u64));
        let y = if gap % 2 == 0 { ROW_Y } else { -ROW_Y };
        let (from, to) = (column_x(gap / 2) + 0.14, column_x(gap / 2 + 1) - 0.14);
        let to_left = (gap / 2) % 2 == 0;
        hall.sheet(rows * 3 / 2, rows, |u, v| {
            // v = 0 is the roof; the curtain is narrowest at two thirds of the way down.
            let gather = 1.0 - 0.55 * smoothstep(0.05, 0.66, v) * (1.0 - 0.5 * smoothstep(0.66, 1.0, v));
            let across = if to_left { u * gather } else { 1.0 - u * gather };
            let fold = libm::sin(TAU * (7.0 * u + 0.4 * noise.at(DVec3::new(3.0 * u, 2.0 * v, 0.5))));
            let depth = 0.05 * fold + 0.05 * noise.fractal(DVec3::new(2.0 * u, 3.0 * v, 7.5), 4);
            DVec3::new(
                lerp(across, from, to),
                y + depth * (0.3 + 0.7 * v),
                lerp(v, HEIGHT - 0.02, 0.48),
            )
        });
    }
}

/// Adds pots along the walls and at the far end, each with a cloud of leaves of one or two triangles.
fn plants(hall: &mut MeshBuilder, triangles: usize, random: &mut Random) {
    const POTS: usize = 9;
    const POT_TRIANGLES: usize = 2 * 16 * 6;
    let leaves = triangles.saturating_sub(POTS * POT_TRIANGLES);
    for pot in 0..POTS {
        let base = match pot {
            0..4 => DVec3::new(column_x(pot) + 0.55, 1.25, 0.0),
            4..8 => DVec3::new(column_x(pot - 4) + 0.55, -1.25, 0.0),
            _ => DVec3::new(1.9, 0.15, 0.0),
        };
        if triangles > POTS * POT_TRIANGLES {
            hall.tube(16, 6, |u, v| {
                let radius = lerp(smoothstep(0.8, 1.0, v), 0.07 + 0.05 * v, 0.14);
                let (sin, cos) = libm::sincos(TAU * u);
                base + DVec3::new(radius * cos, radius * sin, 0.26 * v)
            });
        }
        let due = leaves * (pot + 1) / POTS - leaves * pot / POTS;
        let crown = base + DVec3::new(0.0, 0.0, 0.62);
        for i in 0..due.div_ceil(2) {
            let stem = crown + random.direction() * DVec3::new(0.24, 0.24, 0.38) * random.unit().sqrt();
            let along = (random.direction() + DVec3::new(0.0, 0.0, 0.4)) * random.range(0.015, 0.04);
            let broad = along.cross(random.direction()) * 0.35;
            let middle = stem + along * 0.5;
            let tip = stem + along;
            if 2 * i + 1 < due {
                hall.quad([stem, middle - broad, tip, middle + broad]);
            } else {
                hall.triangle([stem, middle - broad, tip]);
            }
        }
    }
}
