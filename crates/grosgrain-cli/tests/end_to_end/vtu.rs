//! Frames as ParaView would read them.

use std::io::Read;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// A frame of the body or of the coarse mesh.
pub struct Vtu(String);

impl Vtu {
    pub fn read(path: &Path) -> Self {
        Self(std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display())))
    }

    /// The numbers of an array of doubles; requires that all are finite.
    pub fn numbers(&self, name: &str) -> Vec<f64> {
        let at = self.0.find(&format!("Name=\"{name}\"")).unwrap_or_else(|| panic!("no array {name}"));
        let open = at + self.0[at..].find('>').unwrap();
        let close = open + self.0[open..].find('<').unwrap();
        let numbers: Vec<f64> =
            decode(&self.0[open + 1..close]).chunks(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect();
        assert!(numbers.iter().all(|x| x.is_finite()), "{name} is not finite");
        numbers
    }

    /// The same, three by three.
    pub fn vectors(&self, name: &str) -> Vec<[f64; 3]> {
        self.numbers(name).chunks(3).map(|v| v.try_into().unwrap()).collect()
    }
}

/// Bytes of an inline array: base64 header of 64-bit numbers (blocks, their size, that of the last, sizes when compressed), then zlib blocks.
fn decode(text: &str) -> Vec<u8> {
    let text = text.trim();
    let number = |bytes: &[u8], at: usize| u64::from_le_bytes(bytes[8 * at..8 * at + 8].try_into().unwrap()) as usize;
    let blocks = number(&STANDARD.decode(&text[..12]).unwrap(), 0);
    let end = (8 * (3 + blocks)).div_ceil(3) * 4;
    let header = STANDARD.decode(&text[..end]).unwrap();
    let data = STANDARD.decode(&text[end..]).unwrap();
    let (mut from, mut bytes) = (0, Vec::new());
    for block in 0..blocks {
        let to = from + number(&header, 3 + block);
        flate2::read::ZlibDecoder::new(&data[from..to]).read_to_end(&mut bytes).unwrap();
        from = to;
    }
    bytes
}
