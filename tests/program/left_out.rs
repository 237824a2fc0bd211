//! Warnings about what a mesh's materials ask for and a picture does not show.

use crate::program::Folder;

/// A square with texture coordinates, and its library with these statements.
fn square(folder: &Folder, statements: &str) {
    let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
    let mesh = format!("mtllib a.mtl\nusemtl a\n{corners}f 1/1 2/2 3/3 4/4\n");
    folder.write("a.obj", &mesh);
    folder.write("a.mtl", &format!("newmtl a\n{statements}\n"));
}

#[test]
fn alpha_of_a_texture() {
    let folder = Folder::new();
    let save = |alpha: u8| {
        let image = image::RgbaImage::from_pixel(2, 2, image::Rgba([255, 0, 0, alpha]));
        image.save(folder.path("t.png")).unwrap();
    };
    save(254);
    square(&folder, "map_Kd t.png");
    let run = folder.run_line("a.obj -s 8x8");
    assert_eq!(run.stderr, "warning: a.obj: left out: alpha of texture `t.png`\n");
    square(&folder, "map_Kd t.png\nmap_d t.png");
    folder.run_line("a.obj -s 8x8").succeeded();
    save(255);
    square(&folder, "map_Kd t.png");
    folder.run_line("a.obj -s 8x8").succeeded();
    // Ambient light takes the diffuse colour.
    square(&folder, "map_Ka t.png\nmap_Kd t.png");
    folder.run_line("a.obj -s 8x8").succeeded();
    square(
        &folder,
        "map_Ka b.png\nmap_Kd t.png\nmap_Ns c.png\nnewmtl b\nmap_ns c.png",
    );
    let run = folder.run_line("a.obj -s 8x8");
    let expected = "warning: a.mtl: left out: textures `map_Ns`, `map_ns`, `map_Ka`\n";
    assert_eq!(run.stderr, expected);
}

#[test]
fn a_library_of_another_name() {
    let folder = Folder::new();
    square(&folder, "");
    folder.write("a.obj", "mtllib b.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n");
    let run = folder.run_line("a.obj -s 8x8");
    let expected = "warning: b.mtl: file not found; its materials are missing; did you mean `a.mtl`?\n";
    assert_eq!(run.stderr, expected);
}
