//! Properties of every kind, at small counts.

use super::{Generated, Kind, MAX_COUNT, Options, Shape, generate, write_ply};
use std::collections::HashMap;

fn small(kind: Kind) -> Generated {
    let count = Some(match kind {
        Kind::Interior => 40_000,
        _ => 5_000,
    });
    generate(kind, Options { seed: 7, count }).unwrap()
}

/// Returns all bytes of the scene's files.
fn bytes(generated: &Generated) -> Vec<u8> {
    let mut out = Vec::new();
    generated.write_scn(&mut out).unwrap();
    for part in &generated.parts {
        if let Shape::Mesh(mesh) = &part.shape {
            write_ply(mesh, &mut out).unwrap();
        }
    }
    out
}

#[test]
fn every_kind_comes_close_to_its_count_and_stays_in_view() {
    for kind in Kind::ALL {
        let generated = small(kind);
        let (name, count) = (kind.name(), generated.count);
        generated.view.camera().unwrap();
        let scene = generated.into_scene().unwrap();
        let made = if matches!(kind, Kind::Flake | Kind::Spheres) {
            scene.spheres().radius.len()
        } else {
            scene.triangles().corners.len()
        };
        assert!(
            made <= count && made * 10 >= count * 8,
            "{name}: {made} of {count}"
        );
        assert_eq!(scene.degenerate_triangles(), 0, "{name}");
        let bounds = scene.bounds();
        let half_length = if kind == Kind::Interior { 3.5 } else { 2.0 };
        assert!(bounds.max_abs() < half_length, "{name}: {bounds:?}");
        assert!(
            bounds.lower.z >= -0.5 && bounds.upper.z < 2.2,
            "{name}: {bounds:?}"
        );
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_seed_others() {
    for kind in Kind::ALL {
        assert_eq!(bytes(&small(kind)), bytes(&small(kind)));
        let count = Some(kind.min_count().max(2_000));
        let [a, b] = [1, 2].map(|seed| bytes(&generate(kind, Options { seed, count }).unwrap()));
        assert_ne!(a, b, "{}", kind.name());
    }
}

/// Returns the FNV-1a hash.
fn fingerprint(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// Removes a line. The fingerprints are of the scene, which a comment in a header does not change.
fn without(line: &[u8], bytes: &[u8]) -> Vec<u8> {
    let lines = bytes.split_inclusive(|&byte| byte == b'\n');
    lines.filter(|other| *other != line).collect::<Vec<_>>().concat()
}

#[test]
fn scenes_are_the_same_on_every_machine_and_in_every_version() {
    let found = Kind::ALL.map(|kind| {
        let bytes = without(b"comment up z\n", &bytes(&small(kind)));
        format!("{} {:016x}", kind.name(), fingerprint(&bytes))
    });
    assert_eq!(found, FINGERPRINTS);
}

/// Changing these needs a line in the changelog: figures measured on the scenes no longer compare then.
const FINGERPRINTS: [&str; 7] = [
    "flake f362daeff0745d51",
    "terrain ba0864d419f66527",
    "interior 8c0d6fabc3aaf9c4",
    "blobs ffe208057427e6be",
    "figure 3fd187b2a6ad70b8",
    "spheres dbc3a0fd4583b9cf",
    "pipes 7715850a01e9fdfb",
];

#[test]
fn blobs_and_figure_are_closed() {
    for kind in [Kind::Blobs, Kind::Figure] {
        for part in small(kind).parts {
            let Shape::Mesh(mesh) = part.shape else { continue };
            if !part.name.is_empty() {
                continue;
            }
            let mut balance: HashMap<(u32, u32), i32> = HashMap::new();
            for [a, b, c] in mesh.triangles {
                for (from, to) in [(a, b), (b, c), (c, a)] {
                    *balance.entry((from.min(to), from.max(to))).or_default() +=
                        if from < to { 1 } else { -1 };
                }
            }
            assert!(balance.values().all(|&sum| sum == 0), "{}", kind.name());
        }
    }
}

#[test]
fn normals_are_unit_vectors() {
    for kind in Kind::ALL {
        for part in small(kind).parts {
            let Shape::Mesh(mesh) = part.shape else { continue };
            assert!(mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5));
        }
    }
}

#[test]
fn the_smallest_count_works_and_others_out_of_range_are_refused() {
    for kind in Kind::ALL {
        let with = |count| {
            generate(
                kind,
                Options {
                    seed: 0,
                    count: Some(count),
                },
            )
        };
        assert!(with(kind.min_count()).unwrap().into_scene().is_ok());
        assert!(with(kind.min_count() - 1).is_err());
        assert!(with(MAX_COUNT + 1).is_err());
    }
}
