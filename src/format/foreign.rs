//! Files that are neither scenes nor meshes that octray reads, known by their first bytes or their extension: their errors say
//! what they are.

use super::reason::Reason;
use crate::error::LoadError;
use std::path::Path;

const KINDS: [(&[u8], &str); 15] = [
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"GIF87a", "a GIF picture"),
    (b"GIF89a", "a GIF picture"),
    (b"II*\0", "a TIFF picture"),
    (b"MM\0*", "a TIFF picture"),
    (b"\x76\x2f\x31\x01", "an EXR picture"),
    (b"RIFF", "a WebP picture or another RIFF file"),
    (b"#?RADIANCE", "an HDR picture"),
    (b"%PDF-", "a PDF document"),
    (b"\x7fELF", "a program"),
    (b"\x1f\x8b", "compressed by gzip (gunzip unpacks it)"),
    (b"\x28\xb5\x2f\xfd", "compressed by Zstandard (unzstd unpacks it)"),
    (b"\xfd7zXZ\0", "compressed by xz (unxz unpacks it)"),
    (b"BZh9", "compressed by bzip2 (bunzip2 unpacks it)"),
];

/// A kind of models that octray does not read.
struct Model {
    /// What files begin with.
    starts: &'static [&'static [u8]],
    extensions: &'static [&'static str],
    name: &'static str,
    /// A format that octray reads, and a program that writes it.
    advice: [&'static str; 2],
}

const fn model(
    starts: &'static [&'static [u8]],
    extensions: &'static [&'static str],
    name: &'static str,
    advice: [&'static str; 2],
) -> Model {
    Model {
        starts,
        extensions,
        name,
        advice,
    }
}

const BLENDER: [&str; 2] = ["glTF (.glb)", "Blender"];
const FREECAD: [&str; 2] = ["glTF (.glb)", "FreeCAD"];
const CLOUD: [&str; 2] = ["PLY", "CloudCompare or PDAL"];

const MODELS: [Model; 23] = [
    model(
        &[b"BLENDER-v", b"BLENDER_v", b"BLENDER17-"],
        &["blend"],
        "a Blender file",
        BLENDER,
    ),
    model(&[b"Kaydara FBX Binary"], &["fbx"], "an FBX file", BLENDER),
    model(
        &[b"PXR-USDC"],
        &["usd", "usda", "usdc", "usdz"],
        "a USD file",
        BLENDER,
    ),
    model(&[b"ISO-10303-21;"], &["step", "stp"], "a STEP file", FREECAD),
    model(&[], &["iges", "igs"], "an IGES file", FREECAD),
    model(
        &[b"DBRep_DrawableShape", b"CASCADE Topology"],
        &["brep", "brp"],
        "an Open CASCADE file",
        FREECAD,
    ),
    model(&[], &["dxf"], "a DXF drawing", FREECAD),
    model(&[], &["dwg"], "a DWG drawing", FREECAD),
    model(
        &[],
        &["sldasm", "sldprt"],
        "a SolidWorks file",
        ["glTF (.glb)", "SolidWorks"],
    ),
    model(&[], &["amf"], "an AMF file", ["3MF", "PrusaSlicer"]),
    model(&[], &["dae"], "COLLADA", BLENDER),
    model(&[], &["3ds"], "a 3D Studio file", BLENDER),
    model(&[], &["wrl", "x3d"], "VRML or X3D", BLENDER),
    model(
        &[],
        &["pvd", "pvtp", "pvtu", "vti", "vtm", "vtmb", "vtr", "vts"],
        "a VTK file of another type than .vtk, .vtp and .vtu",
        [".vtp", "ParaView's filter Extract Surface"],
    ),
    model(
        &[b"\x89HDF\r\n\x1a\n"],
        &["h5", "hdf", "hdf5", "vtkhdf"],
        "an HDF5 file",
        [".vtp", "ParaView's filter Extract Surface"],
    ),
    model(&[b"$MeshFormat"], &["msh"], "a Gmsh mesh", ["STL or PLY", "Gmsh"]),
    model(&[], &["svg"], "an SVG drawing", BLENDER),
    model(&[b"# .PCD v"], &["pcd"], "a PCD point cloud", CLOUD),
    model(&[b"LASF"], &["las", "laz"], "a LAS point cloud", CLOUD),
    model(&[b"ASTM-E57"], &["e57"], "an E57 point cloud", CLOUD),
    model(&[], &["xyz"], "an XYZ point cloud", CLOUD),
    model(&[], &["pts", "ptx"], "a PTS point cloud", CLOUD),
    model(
        &[],
        &["ksplat", "splat", "spz"],
        "a file of Gaussian splats",
        ["PLY", "SuperSplat"],
    ),
];

impl Model {
    fn fault(&self) -> String {
        let Self { name, advice, .. } = self;
        let [format, program] = advice;
        format!(
            "this is {name}, which octray does not read; convert it to {format}, for example with {program}"
        )
    }
}

/// The error about the contents of such a file, which ends with what is `expected`.
pub(super) fn fault(bytes: &[u8], expected: &str) -> Option<String> {
    if let Some((_, kind)) = KINDS.iter().find(|(start, _)| bytes.starts_with(start)) {
        return Some(format!("this is {kind}, {expected}"));
    }
    let is_start = |model: &&Model| model.starts.iter().any(|start| bytes.starts_with(start));
    MODELS.iter().find(is_start).map(Model::fault)
}

/// The error about a model of another program, known by its file's extension.
pub(super) fn fault_by_name(path: &Path) -> Option<String> {
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    let is_named = |model: &&Model| model.extensions.contains(&&*extension);
    MODELS.iter().find(is_named).map(Model::fault)
}

/// Refuses a file that is neither a scene nor a mesh that octray reads, by its contents.
pub(super) fn refuse(bytes: &[u8], path: &Path, expected: &str) -> Result<(), LoadError> {
    // USDZ is a ZIP archive, as 3MF.
    let by_name = || fault_by_name(path).filter(|_| bytes.starts_with(super::mesh::ZIP));
    match fault(bytes, expected).or_else(by_name) {
        Some(message) => Err(Reason::unsupported(message).of_file(path)),
        None => Ok(()),
    }
}
