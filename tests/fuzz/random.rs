//! A small generator of numbers, the same on every machine and in every release (SplitMix64).

/// Numbers from a seed.
pub struct Random(u64);

impl Random {
    /// The generator of a case: its seed and its number.
    pub fn of(seed: u64, number: usize) -> Random {
        let mut random = Random(seed ^ (number as u64).wrapping_mul(0xD134_2543_DE82_EF95));
        random.number();
        random
    }

    /// Any number of 64 bits.
    pub fn number(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number from 0 to below `end`, 0 where that is 0.
    pub fn below(&mut self, end: usize) -> usize {
        (self.number() % (end.max(1) as u64)) as usize
    }

    /// Whether it happens, at so many of a hundred.
    pub fn happens(&mut self, percent: usize) -> bool {
        self.below(100) < percent
    }

    /// One of several.
    pub fn pick<'a, T: ?Sized>(&mut self, of: &[&'a T]) -> &'a T {
        of[self.below(of.len())]
    }

    /// One byte.
    pub fn byte(&mut self) -> u8 {
        self.number() as u8
    }
}

#[test]
fn numbers_come_again() {
    let numbers = |number| [0; 3].map(|_: u8| 0).map(|_| Random::of(7, number).number());
    assert_eq!(numbers(1), numbers(1));
    assert_ne!(numbers(1), numbers(2));
    // The first number of the published generator from the state 0.
    assert_eq!(Random(0).number(), 0xE220_A839_7B1D_CDAF);
}
