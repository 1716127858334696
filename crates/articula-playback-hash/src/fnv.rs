//! The hash FNV-1a of 64 bits.

pub(crate) struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv {
    pub(crate) fn bytes(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    pub(crate) fn floats(&mut self, values: &[f32]) {
        values
            .iter()
            .for_each(|v| self.bytes(&v.to_bits().to_le_bytes()));
    }

    pub(crate) fn finish(self) -> u64 {
        self.0
    }
}
