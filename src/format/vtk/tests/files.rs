//! Writes VTK files in every form.

use base64::{Engine as _, engine::general_purpose::STANDARD};
use std::io::Write as _;

/// How a file stores numbers.
#[derive(Clone, Copy, Debug)]
pub enum Form {
    /// An XML file: the format of arrays, with the encoding of appended data.
    Xml(&'static str, Binary),
    /// A legacy file of this version.
    Legacy { version: &'static str, is_binary: bool },
}

/// How an XML file stores binary numbers.
#[derive(Clone, Copy, Debug, Default)]
pub struct Binary {
    pub is_big: bool,
    pub is_wide: bool,
    pub is_compressed: bool,
}

/// An array of points or cells.
pub struct Array {
    pub name: &'static str,
    pub kind: &'static str,
    pub components: usize,
    pub values: Vec<f64>,
}

/// A piece of an unstructured grid.
#[derive(Default)]
pub struct Grid {
    pub points: Vec<[f64; 3]>,
    /// The type and the points of each.
    pub cells: Vec<(u8, Vec<u32>)>,
    pub of_points: Vec<Array>,
    pub of_cells: Vec<Array>,
}

/// Every form.
pub fn forms() -> Vec<Form> {
    let mut forms = Vec::new();
    for format in ["ascii", "binary", "raw", "base64"] {
        for bits in 0..8 {
            let binary = Binary {
                is_big: bits & 1 != 0,
                is_wide: bits & 2 != 0,
                is_compressed: bits & 4 != 0,
            };
            if format != "ascii" || bits == 0 {
                forms.push(Form::Xml(format, binary));
            }
        }
    }
    for version in ["2.0", "4.2", "5.1"] {
        forms.extend([false, true].map(|is_binary| Form::Legacy { version, is_binary }));
    }
    forms
}

/// The bytes of numbers.
pub fn bytes(kind: &str, values: &[f64], is_big: bool) -> Vec<u8> {
    let mut bytes = Vec::new();
    for &value in values {
        let mut number = match kind {
            "UInt8" => vec![value as u8],
            "Int32" => (value as i32).to_le_bytes().to_vec(),
            "Int64" => (value as i64).to_le_bytes().to_vec(),
            "Float32" => (value as f32).to_le_bytes().to_vec(),
            _ => value.to_le_bytes().to_vec(),
        };
        if is_big {
            number.reverse();
        }
        bytes.extend(number);
    }
    bytes
}

/// The numbers of a header, and the data that follow it.
fn encoded(binary: Binary, data: &[u8]) -> (Vec<u8>, Vec<u8>) {
    const BLOCK: usize = 64;
    let (mut header, mut stored) = (vec![data.len()], data.to_vec());
    if binary.is_compressed {
        stored.clear();
        header = vec![data.len().div_ceil(BLOCK), BLOCK, data.len() % BLOCK];
        for block in data.chunks(BLOCK) {
            let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
            encoder.write_all(block).expect("memory");
            let block = encoder.finish().expect("memory");
            header.push(block.len());
            stored.extend(block);
        }
    }
    let mut head = Vec::new();
    for number in header {
        let mut number = number.to_le_bytes()[..if binary.is_wide { 8 } else { 4 }].to_vec();
        if binary.is_big {
            number.reverse();
        }
        head.extend(number);
    }
    (head, stored)
}

fn base64(binary: Binary, data: &[u8]) -> String {
    let (head, stored) = encoded(binary, data);
    if binary.is_compressed {
        STANDARD.encode(head) + &STANDARD.encode(stored)
    } else {
        STANDARD.encode([head, stored].concat())
    }
}

fn words(values: &[f64]) -> String {
    values.iter().map(|value| format!("{value} ")).collect()
}

/// The number and the points of all cells, and where each ends.
fn lists(cells: &[(u8, Vec<u32>)]) -> [Vec<f64>; 2] {
    let mut ends = Vec::new();
    let mut points = Vec::new();
    for (_, cell) in cells {
        points.extend(cell.iter().map(|&point| f64::from(point)));
        ends.push(points.len() as f64);
    }
    [points, ends]
}

impl Grid {
    fn flat(&self) -> Vec<f64> {
        self.points.concat()
    }

    /// The file.
    pub fn write(&self, form: Form) -> Vec<u8> {
        match form {
            Form::Xml(format, binary) => document(&[self], format, binary),
            Form::Legacy { version, is_binary } => self.legacy(version, is_binary),
        }
    }

    fn piece(&self, put: &mut impl FnMut(&str, &str, usize, &[f64]) -> String) -> String {
        let [points, ends] = lists(&self.cells);
        let types: Vec<f64> = self.cells.iter().map(|(cell, _)| f64::from(*cell)).collect();
        let mut all = |arrays: &[Array]| -> String {
            let arrays = arrays.iter();
            arrays
                .map(|array| put(array.name, array.kind, array.components, &array.values))
                .collect()
        };
        let [of_points, of_cells] = [all(&self.of_points), all(&self.of_cells)];
        let coordinates = put("Points", "Float32", 3, &self.flat());
        let cells = put("connectivity", "Int64", 1, &points) + &put("offsets", "Int32", 1, &ends);
        let types = put("types", "UInt8", 1, &types);
        format!(
            "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\"><PointData>{of_points}</PointData>\
             <CellData>{of_cells}</CellData><Points>{coordinates}</Points><Cells>{cells}{types}</Cells></Piece>\n",
            self.points.len(),
            self.cells.len()
        )
    }

    fn legacy(&self, version: &str, is_binary: bool) -> Vec<u8> {
        let coding = if is_binary { "BINARY" } else { "ASCII" };
        let mut file =
            format!("# vtk DataFile Version {version}\nany title\n{coding}\nDATASET UNSTRUCTURED_GRID\n")
                .into_bytes();
        let mut put = |head: String, kind: &str, values: &[f64]| {
            file.extend(head.into_bytes());
            file.push(b'\n');
            if is_binary {
                file.extend(bytes(kind, values, true));
            } else {
                file.extend(words(values).into_bytes());
            }
            file.push(b'\n');
        };
        let count = self.points.len();
        put(format!("POINTS {count} float"), "Float32", &self.flat());
        let [points, ends] = lists(&self.cells);
        let cells = self.cells.len();
        if version == "5.1" {
            let ends: Vec<f64> = std::iter::once(0.0).chain(ends).collect();
            put(
                format!("CELLS {} {}\nOFFSETS vtktypeint64", cells + 1, points.len()),
                "Int64",
                &ends,
            );
            put("CONNECTIVITY vtktypeint64".into(), "Int64", &points);
        } else {
            let counted = |(_, cell): &(u8, Vec<u32>)| {
                let points = cell.iter().map(|&point| f64::from(point));
                std::iter::once(cell.len() as f64)
                    .chain(points)
                    .collect::<Vec<f64>>()
            };
            let all: Vec<f64> = self.cells.iter().flat_map(counted).collect();
            put(format!("CELLS {cells} {}", all.len()), "Int32", &all);
        }
        let types: Vec<f64> = self.cells.iter().map(|(cell, _)| f64::from(*cell)).collect();
        put(format!("CELL_TYPES {cells}"), "Int32", &types);
        for (section, arrays, count) in [
            ("POINT_DATA", &self.of_points, count),
            ("CELL_DATA", &self.of_cells, cells),
        ] {
            if arrays.is_empty() {
                continue;
            }
            put(
                format!("{section} {count}\nFIELD FieldData {}", arrays.len()),
                "",
                &[],
            );
            for Array {
                name,
                kind,
                components,
                values,
            } in arrays
            {
                let known = [("UInt8", "unsigned_char"), ("Int32", "int"), ("Float32", "float")];
                let known = known.into_iter().find(|(xml, _)| xml == kind);
                let legacy = known.map_or("double", |(_, legacy)| legacy);
                put(
                    format!("{name} {components} {} {legacy}", values.len() / components),
                    kind,
                    values,
                );
            }
        }
        file
    }
}

/// An XML file of pieces.
pub fn document(grids: &[&Grid], format: &str, binary: Binary) -> Vec<u8> {
    let mut appended: Vec<u8> = Vec::new();
    let mut put = |name: &str, kind: &str, components: usize, values: &[f64]| {
        let start =
            format!("<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=");
        let data = bytes(kind, values, binary.is_big);
        match format {
            "ascii" => format!("{start}\"ascii\">\n{}\n</DataArray>", words(values)),
            "binary" => format!("{start}\"binary\">\n  {}\n</DataArray>", base64(binary, &data)),
            _ => {
                let offset = appended.len();
                if format == "raw" {
                    let (head, stored) = encoded(binary, &data);
                    appended.extend([head, stored].concat());
                } else {
                    appended.extend(base64(binary, &data).into_bytes());
                }
                format!("{start}\"appended\" offset=\"{offset}\"/>")
            }
        }
    };
    let pieces: String = grids.iter().map(|grid| grid.piece(&mut put)).collect();
    let order = if binary.is_big {
        "BigEndian"
    } else {
        "LittleEndian"
    };
    let header = if binary.is_wide { "UInt64" } else { "UInt32" };
    let compressor = if binary.is_compressed {
        " compressor=\"vtkZLibDataCompressor\""
    } else {
        ""
    };
    let mut file = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"{order}\" \
         header_type=\"{header}\"{compressor}>\n<UnstructuredGrid>\n{pieces}</UnstructuredGrid>\n"
    )
    .into_bytes();
    if matches!(format, "raw" | "base64") {
        file.extend(format!("<AppendedData encoding=\"{format}\">\n_").into_bytes());
        file.extend(appended);
        file.extend(b"\n</AppendedData>\n");
    }
    file.extend(b"</VTKFile>\n");
    file
}
