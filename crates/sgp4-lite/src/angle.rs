//! Angles carried as sine and cosine, so that small changes cost a polynomial and not a sine.

/// Below this change, in radians, short polynomials are exact to rounding: the first neglected
/// terms are d⁵/120 = 7e-18 and d⁶/720 = 1e-21. Short-period terms are that small.
const TINY_TURN_RAD: f64 = 1.0 / 1024.0;

/// Below this change, longer ones are: then the first neglected terms are d¹¹/11! = 3e-18 and
/// d¹²/12! = 3e-20.
const SMALL_TURN_RAD: f64 = 1.0 / 8.0;

/// Sine and cosine of one angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SinCos {
    pub sin: f64,
    pub cos: f64,
}

impl SinCos {
    /// Sine and cosine of an angle in radians.
    pub fn of(angle_rad: f64) -> Self {
        let (sin, cos) = libm::sincos(angle_rad);
        Self { sin, cos }
    }

    /// Sine and cosine of the sum of two angles.
    pub fn plus(self, other: Self) -> Self {
        Self {
            sin: self.sin * other.cos + self.cos * other.sin,
            cos: self.cos * other.cos - self.sin * other.sin,
        }
    }

    /// Sine and cosine of the angle after it has grown by `d_rad`.
    pub fn turned_by(self, d_rad: f64) -> Self {
        self.plus(Self::of_often_small(d_rad))
    }

    /// [`SinCos::of`], fast when the angle is small.
    fn of_often_small(d: f64) -> Self {
        let d2 = d * d;
        if d.abs() < TINY_TURN_RAD {
            Self {
                // d − d³/3!
                sin: d - d * d2 * (1.0 / 6.0),
                // 1 − d²/2! + d⁴/4!
                cos: 1.0 - d2 * (0.5 - d2 * (1.0 / 24.0)),
            }
        } else if d.abs() < SMALL_TURN_RAD {
            // d − d³/3! + d⁵/5! − d⁷/7! + d⁹/9!
            let cubic =
                1.0 / 6.0 - d2 * (1.0 / 120.0 - d2 * (1.0 / 5040.0 - d2 * (1.0 / 362_880.0)));
            // 1 − d²/2! + d⁴/4! − d⁶/6! + d⁸/8! − d¹⁰/10!
            let quartic =
                1.0 / 24.0 - d2 * (1.0 / 720.0 - d2 * (1.0 / 40_320.0 - d2 * (1.0 / 3_628_800.0)));
            Self { sin: d - d * d2 * cubic, cos: 1.0 - d2 * (0.5 - d2 * quartic) }
        } else {
            Self::of(d)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One rounding of the sum, which is below 8, and four of numbers below 1.
    const TOLERANCE: f64 = 4.5e-16 + 4.0 * 1.2e-16;

    #[test]
    fn turning_agrees_with_the_sine_of_the_sum() {
        for step in -2000..2000 {
            let (angle, turn) = (f64::from(step) * 0.003, f64::from(step) * 1e-4);
            let turned = SinCos::of(angle).turned_by(turn);
            let direct = SinCos::of(angle + turn);
            assert!((turned.sin - direct.sin).abs() < TOLERANCE, "sin at {angle} + {turn}");
            assert!((turned.cos - direct.cos).abs() < TOLERANCE, "cos at {angle} + {turn}");
        }
    }
}
