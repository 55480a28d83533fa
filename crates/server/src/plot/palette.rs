//! The colours of curves.

/// Red, green and blue.
pub(super) type Rgb = [u8; 3];

/// Six colours for six joints that differ for every kind of colour vision, and one more. Found by a search for the
/// largest smallest difference among colours that stand out on white.
pub(super) const COLORS: [Rgb; 7] = [
    [34, 0, 255],
    [238, 68, 17],
    [34, 187, 153],
    [85, 0, 119],
    [204, 119, 255],
    [119, 0, 34],
    [120, 120, 120],
];

#[cfg(test)]
mod tests {
    use super::*;

    type Matrix = [[f64; 3]; 3];

    /// Colour vision: normal, without red, green and blue receptors (Machado, Oliveira and Fernandes, 2009).
    const VISION: [Matrix; 4] = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ],
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ],
        [
            [1.255528, -0.076749, -0.178779],
            [-0.078411, 0.930809, 0.147602],
            [0.004733, 0.691367, 0.303900],
        ],
    ];

    fn times(matrix: &Matrix, v: [f64; 3]) -> [f64; 3] {
        matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
    }

    /// Linear light of a colour as somebody sees it.
    fn seen(rgb: Rgb, vision: &Matrix) -> [f64; 3] {
        let linear = rgb.map(|c| {
            let c = f64::from(c) / 255.0;
            match c <= 0.04045 {
                true => c / 12.92,
                false => ((c + 0.055) / 1.055).powf(2.4),
            }
        });
        times(vision, linear).map(|c| c.clamp(0.0, 1.0))
    }

    /// The colour in CIE L*a*b*, in which distances are differences that people see.
    fn lab(light: [f64; 3]) -> [f64; 3] {
        let xyz = times(
            &[
                [0.4124, 0.3576, 0.1805],
                [0.2126, 0.7152, 0.0722],
                [0.0193, 0.1192, 0.9505],
            ],
            light,
        );
        let f = |t: f64| match t > 0.008856 {
            true => t.cbrt(),
            false => 7.787 * t + 16.0 / 116.0,
        };
        let [x, y, z] = [f(xyz[0] / 0.9505), f(xyz[1]), f(xyz[2] / 1.089)];
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    #[test]
    fn six_colours_differ_for_every_kind_of_colour_vision() {
        for vision in &VISION {
            for (index, a) in COLORS[..6].iter().enumerate() {
                for b in &COLORS[index + 1..6] {
                    let (one, other) = (lab(seen(*a, vision)), lab(seen(*b, vision)));
                    let difference: f64 = (0..3).map(|i| (one[i] - other[i]).powi(2)).sum();
                    // A difference of 2 is just seen, one of 40 is unmistakable.
                    assert!(
                        difference.sqrt() > 40.0,
                        "{a:?} {b:?}: {}",
                        difference.sqrt()
                    );
                }
            }
        }
    }
}
