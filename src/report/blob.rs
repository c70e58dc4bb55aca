//! Numbers of the view as text: four bytes each, in base 64.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// Numbers that the page reads from one text, array after array.
#[derive(Default)]
pub struct Blob {
    bytes: Vec<u8>,
}

impl Blob {
    /// Adds numbers in single precision and gives the place of the first, counted in numbers.
    pub fn real(&mut self, values: impl Iterator<Item = f64>) -> usize {
        self.put(values.map(|x| (x as f32).to_le_bytes()))
    }

    /// Adds whole numbers and gives the place of the first, counted in numbers.
    pub fn whole(&mut self, values: impl Iterator<Item = u32>) -> usize {
        self.put(values.map(u32::to_le_bytes))
    }

    fn put(&mut self, values: impl Iterator<Item = [u8; 4]>) -> usize {
        let at = self.bytes.len() / 4;
        self.bytes.extend(values.flatten());
        at
    }

    /// All of it in base 64, little-endian.
    pub fn text(&self) -> String {
        STANDARD.encode(&self.bytes)
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// The numbers of a text, as they stand in it.
    pub fn words(text: &str) -> Vec<u32> {
        let bytes = STANDARD.decode(text).expect("base 64");
        bytes.as_chunks::<4>().0.iter().map(|c| u32::from_le_bytes(*c)).collect()
    }
}
