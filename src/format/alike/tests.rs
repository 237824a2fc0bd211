//! Tests of `alike`.

#[test]
fn what_looks_alike() {
    let folder = [
        "bunny.ply",
        "Bunny.obj",
        "buny.ply",
        "cow.ply",
        "bunny_small.ply",
        "a",
    ];
    let alike = |wanted: &str| super::most_alike(wanted, folder.iter().map(ToString::to_string));
    assert_eq!(alike("bunnny.ply"), ["bunny.ply", "buny.ply"]);
    assert_eq!(alike("BUNNY.STL"), ["Bunny.obj", "bunny.ply"]);
    assert_eq!(alike("cwo.ply"), ["cow.ply"]);
    assert_eq!(alike("bunny"), ["Bunny.obj", "bunny.ply"]);
    assert!(alike("bunny.mtl").is_empty() && alike("bunny.png").is_empty());
    assert!(alike("x").is_empty());
    assert!(alike("dragon.glb").is_empty());
    assert!(alike(&"x".repeat(300)).is_empty());
}
