//! Colours and dash patterns: Okabe and Ito's colours for kinds, a dark-to-light sequence for
//! ordered quantities.

/// Red, green, blue, 0..255.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Colour(pub u8, pub u8, pub u8);

pub const BLACK: Colour = Colour(0, 0, 0);
pub const INK: Colour = Colour(34, 34, 34);
pub const GREY: Colour = Colour(110, 110, 110);
pub const GRID: Colour = Colour(230, 230, 230);
pub const WHITE: Colour = Colour(255, 255, 255);

/// Okabe and Ito's colours, safe for colour-blind readers.
const KINDS: [Colour; 7] = [
    Colour(0x00, 0x72, 0xB2),
    Colour(0xD5, 0x5E, 0x00),
    Colour(0x00, 0x9E, 0x73),
    Colour(0xCC, 0x79, 0xA7),
    Colour(0xE6, 0x9F, 0x00),
    Colour(0x56, 0xB4, 0xE9),
    BLACK,
];

/// Dash patterns: drawn and skipped lengths in turn, page units; empty for a solid line. So many
/// lines can be told apart in a black-and-white print.
const DASHES: [&[f64]; 12] = [
    &[],
    &[34.0, 16.0],
    &[9.0, 12.0],
    &[34.0, 13.0, 9.0, 13.0],
    &[64.0, 16.0],
    &[34.0, 13.0, 9.0, 13.0, 9.0, 13.0],
    &[34.0, 34.0],
    &[9.0, 28.0],
    &[64.0, 13.0, 9.0, 13.0],
    &[64.0, 13.0, 22.0, 13.0],
    &[34.0, 13.0, 9.0, 13.0, 9.0, 13.0, 9.0, 13.0],
    &[64.0, 13.0, 9.0, 13.0, 9.0, 13.0],
];

/// Colours of generations of grains: light for grains that never broke, and darker in print for
/// each of the next four generations.
const GENERATIONS: [Colour; 7] = [
    Colour(0xDA, 0xD5, 0xCB),
    Colour(0xE6, 0x9F, 0x00),
    Colour(0xD5, 0x5E, 0x00),
    Colour(0x00, 0x72, 0xB2),
    Colour(0x2B, 0x2B, 0x2B),
    Colour(0x00, 0x9E, 0x73),
    Colour(0xCC, 0x79, 0xA7),
];

/// Anchors of a perceptually even sequence (viridis without its light yellow end, which does not print).
const SEQUENCE: [Colour; 6] = [
    Colour(0x44, 0x01, 0x54),
    Colour(0x41, 0x44, 0x87),
    Colour(0x2A, 0x78, 0x8E),
    Colour(0x22, 0xA8, 0x84),
    Colour(0x5F, 0xC0, 0x50),
    Colour(0xB5, 0xC4, 0x1F),
];

/// Colour of the i-th kind; repeats after seven.
pub fn kind(i: usize) -> Colour {
    KINDS[i % KINDS.len()]
}

/// Dash pattern of the i-th kind; repeats after twelve.
pub fn dash(i: usize) -> &'static [f64] {
    DASHES[i % DASHES.len()]
}

/// Number of generations with a colour of their own; later ones share the last.
pub const GENERATION_COLOURS: usize = GENERATIONS.len();

/// Colour of a generation.
pub fn generation(i: usize) -> Colour {
    GENERATIONS[i.min(GENERATIONS.len() - 1)]
}

/// Colour at t in 0..1 of the sequence (0 dark, 1 light).
pub fn sequence(t: f64) -> Colour {
    let t = if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.0 };
    let at = t * (SEQUENCE.len() - 1) as f64;
    let i = (at as usize).min(SEQUENCE.len() - 2);
    mix(SEQUENCE[i], SEQUENCE[i + 1], at - i as f64)
}

/// Linear mix, t = 0 gives `a`.
pub fn mix(a: Colour, b: Colour, t: f64) -> Colour {
    let m = |a: u8, b: u8| (f64::from(a) + (f64::from(b) - f64::from(a)) * t).round().clamp(0.0, 255.0) as u8;
    Colour(m(a.0, b.0), m(a.1, b.1), m(a.2, b.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn luminance(c: Colour) -> f64 {
        0.2126 * f64::from(c.0) + 0.7152 * f64::from(c.1) + 0.0722 * f64::from(c.2)
    }

    #[test]
    fn sequence_grows_lighter() {
        let l: Vec<f64> = (0..=20).map(|i| luminance(sequence(f64::from(i) / 20.0))).collect();
        assert!(l.windows(2).all(|w| w[1] > w[0]), "{l:?}");
        assert_eq!(sequence(f64::NAN), sequence(0.0));
    }

    #[test]
    fn lines_of_one_colour_are_told_apart_by_their_dashes() {
        let all: Vec<&[f64]> = (0..DASHES.len()).map(dash).collect();
        for (i, one) in all.iter().enumerate() {
            assert!(one.len() % 2 == 0 && all[..i].iter().all(|other| other != one), "{one:?}");
            // a pattern must not be much longer than the legend's sample of 128 units
            assert!(one.iter().sum::<f64>() < 150.0, "{one:?}");
        }
    }

    #[test]
    fn first_five_generations_differ_in_grey() {
        let l: Vec<f64> = (0..5).map(|i| luminance(generation(i))).collect();
        assert!(l.windows(2).all(|w| w[0] - w[1] > 10.0), "{l:?}");
    }
}
