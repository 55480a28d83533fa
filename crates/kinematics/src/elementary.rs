//! Elementary functions, the same bits on every machine.
//!
//! Owns which functions the crates of motion may call. Those of std call the system's C library, whose last digits
//! differ between releases and processors; one digit is enough for two recordings of one program to part. These are
//! compiled in. (Square roots and roundings are exact everywhere and stay with std; six sines at once are in
//! [`crate::trig`].) Clippy refuses the others in `kinematics`, `motion` and `force`; nalgebra is built to use the
//! same.

/// Sine and cosine of an angle in radians.
#[inline]
pub fn sin_cos(angle: f64) -> (f64, f64) {
    libm::sincos(angle)
}

/// Sine of an angle in radians.
#[inline]
pub fn sin(angle: f64) -> f64 {
    libm::sin(angle)
}

/// Cosine of an angle in radians.
#[inline]
pub fn cos(angle: f64) -> f64 {
    libm::cos(angle)
}

/// Tangent of an angle in radians.
#[inline]
pub fn tan(angle: f64) -> f64 {
    libm::tan(angle)
}

/// The angle in [-pi/2, pi/2] with this sine; NaN outside of [-1, 1].
#[inline]
pub fn asin(sine: f64) -> f64 {
    libm::asin(sine)
}

/// The angle in [0, pi] with this cosine; NaN outside of [-1, 1].
#[inline]
pub fn acos(cosine: f64) -> f64 {
    libm::acos(cosine)
}

/// The angle of the point (x, y) from the positive x axis, in [-pi, pi].
#[inline]
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// e to the power of `x`.
#[inline]
pub fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// The natural logarithm.
#[inline]
pub fn ln(x: f64) -> f64 {
    libm::log(x)
}

/// The cube root.
#[inline]
pub fn cbrt(x: f64) -> f64 {
    libm::cbrt(x)
}

/// The length of (x, y), without overflow on the way.
#[inline]
pub fn hypot(x: f64, y: f64) -> f64 {
    libm::hypot(x, y)
}

/// `x` times itself.
#[inline]
pub const fn square(x: f64) -> f64 {
    x * x
}

/// `x` times itself times itself.
#[inline]
pub const fn cube(x: f64) -> f64 {
    x * x * x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the functions must give, bit for bit, whatever machine runs this. The arguments are such that C libraries
    /// differ on some of them.
    #[test]
    fn the_bits_are_those_of_the_first_machine() {
        let arguments = [0.1, 0.7, 1.3, 2.9, 10.5, 1234.567, 1e-5, 3e7];
        let mut bits = Vec::new();
        for x in arguments {
            let (s, c) = sin_cos(x);
            let small = x / (1.0 + x);
            bits.extend([s, c, sin(x), cos(x), tan(x), asin(small), acos(small)]);
            bits.extend([
                atan2(x, 2.0),
                atan2(-x, -0.3),
                exp(-x / 50.0),
                exp(small),
                ln(x),
            ]);
            bits.extend([cbrt(x), hypot(x, 0.3), square(x), cube(x)]);
        }
        let mut sum = 0xcbf2_9ce4_8422_2325_u64;
        for number in &bits {
            for byte in number.to_bits().to_le_bytes() {
                sum = (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
            }
        }
        let first: Vec<String> = bits[16..32]
            .iter()
            .map(|x| format!("{:016x}", x.to_bits()))
            .collect();
        assert_eq!(first.join(" "), FIRST);
        assert_eq!(format!("{sum:016x}"), SUM);
    }

    const FIRST: &str = "3fe49d6e694619b8 3fe87996529f9d93 3fe49d6e694619b8 3fe87996529f9d93 \
                         3feaf406c2fc78ae 3fdb293373caab52 3ff257ae77518244 3fd58c148aa9c5d6 \
                         bfff9c6b238c6435 3fef8e1c6fe8cc04 3ff826d3af899600 bfd6d3c324e13f50 \
                         3fec69b5a72f1a99 3fe85ed7614b038c 3fdf5c28f5c28f5b 3fd5f3b645a1cabf";
    const SUM: &str = "d719fda42988f3bc";

    #[test]
    fn they_are_close_to_those_of_the_system() {
        for k in 1..2000 {
            let x = f64::from(k) * 0.0137;
            let near = |a: f64, b: f64| (a - b).abs() <= 4e-16 * b.abs().max(1e-3);
            assert!(near(sin(x), x.sin()) && near(cos(x), x.cos()), "{x}");
            assert!(near(exp(-x), (-x).exp()) && near(ln(x), x.ln()), "{x}");
            assert!(
                near(cbrt(x), x.cbrt()) && near(hypot(x, 2.0), x.hypot(2.0)),
                "{x}"
            );
            assert!(near(atan2(x, 3.0), x.atan2(3.0)), "{x}");
        }
    }
}
