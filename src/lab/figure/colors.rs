//! Colors: maps whose steps look equal, and sets that those tell apart, too, who see no red or no green.

/// sRGB.
pub type Color = [u8; 3];

/// Between two colors: `t` = 0 the first, 1 the second.
pub fn mix(a: Color, b: Color, t: f64) -> Color {
    let t = t.clamp(0.0, 1.0);
    [0, 1, 2].map(|c| (f64::from(a[c]) + t * (f64::from(b[c]) - f64::from(a[c]))).round() as u8)
}

/// Darker below 1, towards white above.
pub fn shade(color: Color, light: f64) -> Color {
    if light <= 1.0 { mix([0; 3], color, light) } else { mix(color, [255; 3], light - 1.0) }
}

/// Which colors numbers have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Map {
    /// From dark blue over green to yellow: viridis, by S. van der Walt and N. Smith (CC0).
    Rising,
    /// From blue over white to red, with white in the middle: RdBu, by C. Brewer.
    Balanced,
}

const RISING: [Color; 17] = [
    [68, 1, 84],
    [72, 24, 106],
    [71, 45, 123],
    [66, 64, 134],
    [59, 82, 139],
    [51, 99, 141],
    [44, 114, 142],
    [38, 130, 142],
    [33, 145, 140],
    [31, 160, 136],
    [40, 174, 128],
    [63, 188, 115],
    [94, 201, 98],
    [132, 212, 75],
    [173, 220, 48],
    [216, 226, 25],
    [253, 231, 37],
];
const BALANCED: [Color; 9] = [
    [5, 48, 97],
    [42, 113, 178],
    [107, 172, 209],
    [194, 221, 236],
    [247, 246, 246],
    [251, 204, 180],
    [228, 128, 102],
    [186, 40, 50],
    [103, 0, 31],
];

impl Map {
    /// The color at `t`, from 0 to 1.
    pub fn at(self, t: f64) -> Color {
        let stops: &[Color] = match self {
            Map::Rising => &RISING,
            Map::Balanced => &BALANCED,
        };
        let s = t.clamp(0.0, 1.0) * (stops.len() - 1) as f64;
        let k = (s as usize).min(stops.len() - 2);
        mix(stops[k], stops[k + 1], s - k as f64)
    }
}

/// Colors of lines, which the color-blind can tell apart (P. Tol's bright scheme, darkened).
pub const LINES: [Color; 7] = [
    [59, 118, 175],
    [196, 112, 43],
    [47, 138, 76],
    [141, 74, 147],
    [155, 139, 28],
    [43, 138, 153],
    [85, 85, 85],
];

/// Colors of materials: after M. Okabe and K. Ito, muted.
pub const MATERIALS: [Color; 6] =
    [[204, 121, 110], [110, 118, 130], [86, 160, 211], [230, 170, 60], [60, 158, 130], [180, 130, 180]];

/// Intact, matrix failed, fibers failed, both: apart in lightness as well as in hue.
pub const FAILURE: [Color; 4] = [[205, 212, 222], [74, 144, 200], [240, 190, 30], [122, 24, 84]];

/// The same as in the paper's figures 8 to 10, of which those who see no red or no green confuse two.
pub const FAILURE_OF_THE_PAPER: [Color; 4] = [[88, 132, 204], [58, 172, 92], [246, 200, 52], [212, 52, 44]];

/// What is there and shows nothing: matter without the field that is drawn.
pub const PLAIN: Color = [168, 172, 178];

/// Tools, which have no particles.
pub const TOOL: Color = [128, 134, 142];

#[cfg(test)]
mod tests {
    use super::*;

    fn linear(color: Color) -> [f64; 3] {
        color.map(|c| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        })
    }

    fn apply(matrix: [[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
        matrix.map(|row| (0..3).map(|i| row[i] * v[i]).sum::<f64>())
    }

    /// CIE L*a*b* of linear sRGB under D65.
    fn lab(rgb: [f64; 3]) -> [f64; 3] {
        let xyz = apply(
            [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]],
            rgb.map(|c| c.clamp(0.0, 1.0)),
        );
        let f = |t: f64| if t > 0.008856 { t.cbrt() } else { 7.787 * t + 16.0 / 116.0 };
        let [x, y, z] = [xyz[0] / 0.9505, xyz[1], xyz[2] / 1.089].map(f);
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
        (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
    }

    /// Machado, Oliveira, Fernandes 2009: what who sees no green, no red and no blue sees, in linear sRGB.
    const BLIND: [[[f64; 3]; 3]; 3] = [
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
    ];

    /// The two colors of a set that are nearest to each other, for an eye.
    fn nearest(colors: &[Color], eye: Option<[[f64; 3]; 3]>) -> f64 {
        let seen = |c: &Color| lab(eye.map_or(linear(*c), |matrix| apply(matrix, linear(*c))));
        let seen: Vec<[f64; 3]> = colors.iter().map(seen).collect();
        let pairs = (0..seen.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        pairs.map(|(i, j)| apart(seen[i], seen[j])).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn kinds_of_failure_are_told_apart_by_every_eye() {
        for eye in BLIND.map(Some).into_iter().chain([None]) {
            let (ours, paper) = (nearest(&FAILURE, eye), nearest(&FAILURE_OF_THE_PAPER, eye));
            println!("nearest two: {ours:.1}, as in the paper {paper:.1}");
            assert!(ours > 25.0, "{eye:?}: {ours}");
        }
        // two of the paper's are the reason for a set of our own
        assert!(nearest(&FAILURE_OF_THE_PAPER, Some(BLIND[0])) < nearest(&FAILURE, Some(BLIND[0])));
    }

    #[test]
    fn the_map_rises_in_lightness_in_equal_steps() {
        let at = |i: usize| lab(linear(Map::Rising.at(i as f64 / 32.0)));
        let steps: Vec<f64> = (0..32).map(|i| at(i + 1)[0] - at(i)[0]).collect();
        assert!(steps.iter().all(|step| (0.5..5.0).contains(step)), "{steps:?}");
        // of the other, both ends are dark and the middle light
        let lightness = |t: f64| lab(linear(Map::Balanced.at(t)))[0];
        assert!(lightness(0.5) > 95.0 && (lightness(0.0) - lightness(1.0)).abs() < 5.0);
    }
}
