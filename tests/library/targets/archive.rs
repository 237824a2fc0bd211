//! ZIP archives for 3MF files.

use rawzip::{CompressionMethod, ZipArchiveWriter, path::EntryPath};
use std::io::Write;

/// What names the first model part.
pub const RELATIONSHIPS: &str = "<Relationships><Relationship Target=\"/3D/3dmodel.model\" \
    Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>";

/// An archive of parts that are not compressed.
pub fn stored<'a>(parts: impl IntoIterator<Item = (&'a str, &'a [u8])>) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = ZipArchiveWriter::new(&mut bytes);
    for (name, part) in parts {
        let method = CompressionMethod::STORE;
        let (mut entry, config) = writer
            .new_file(EntryPath::verbatim(name.as_bytes()))
            .compression_method(method)
            .start()
            .expect("a name");
        let mut data = config.wrap(&mut entry);
        data.write_all(part).expect("memory");
        let (_, written) = data.finish().expect("memory");
        entry.finish(written).expect("memory");
    }
    writer.finish().expect("memory");
    bytes
}

/// A 3MF file of one model part.
pub fn of_model(model: &[u8]) -> Vec<u8> {
    stored([
        ("_rels/.rels", RELATIONSHIPS.as_bytes()),
        ("3D/3dmodel.model", model),
    ])
}
