//! SPROUT as the studies fly it: preset A2 in its orbit, with the sensors of the paper.

use adcs_sim::noise::Gaussian;
use adcs_sim::rigid_body::Inertia;
use anyhow::{Context as _, Result};
use nalgebra::Matrix3;
use sgp4_lite::Elements;

/// SPROUT on 2015-11-19 (CelesTrak).
const TLE: [&str; 2] = [
    "1 39770U 14029E   15323.12177538  .00004189  00000-0  50368-3 0  9997",
    "2 39770  97.8736  57.8959 0010514  58.6984 301.5230 14.84437654 80617",
];
/// Its period, s.
pub const ORBIT_S: f64 = 86_400.0 / 14.844_376_54;
/// Preset A2 (docs/paper), kg·m².
pub const INERTIA_KG_M2: [[f64; 3]; 3] =
    [[0.05184, 0.00058, -0.00077], [0.00058, 0.05416, 0.00069], [-0.00077, 0.00069, 0.05978]];
/// The paper, section 5.1, A·m².
pub const RESIDUAL_DIPOLE_AM2: [f64; 3] = [-0.3211, -0.2094, -0.0201];
/// Of each torquer, the paper, A·m².
pub const MAX_DIPOLE_AM2: f64 = 0.6;
/// The paper's gain, A·m²·s/T.
pub const B_DOT_GAIN: f64 = 1e5;
/// The Sun counts as shining from this fraction of its disc on.
pub const LIT: f64 = 0.5;

/// Noise of one gyro sample, each axis, rad/s.
pub const GYRO_NOISE_RAD_S: f64 = 0.163 * DEG;
/// Walk of the gyro bias, each axis, rad/s per √s.
pub const BIAS_WALK_RAD_S_PER_SQRT_S: f64 = 1e-4 * DEG;
/// Noise of the magnetometer, each axis, T.
pub const FIELD_NOISE_T: f64 = 500e-9;
/// Noise of the Sun's direction across the line of sight, rad.
pub const SUN_NOISE_RAD: f64 = 0.664 * DEG;
/// A degree, rad.
pub const DEG: f64 = core::f64::consts::PI / 180.0;

/// Its mean elements.
///
/// # Errors
/// None: the lines are good.
pub fn elements() -> Result<Elements> {
    Elements::from_tle(TLE[0], TLE[1]).context("the TLE of the studies")
}

/// How far an inertia tensor may be from the drawing's. A product counts in shares of the mean moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum InertiaError {
    /// Every moment and product by just this share, signs at random.
    Signs(f64),
    /// Every moment and product uniformly within this share.
    Within(f64),
}

impl InertiaError {
    /// The drawing's tensor with errors, kg·m²; it may be that of no body.
    pub fn drawn(self, noise: &mut Gaussian) -> Matrix3<f64> {
        let drawing = Matrix3::from_fn(|r, c| INERTIA_KG_M2[r][c]);
        let mean = drawing.trace() / 3.0;
        let mut tensor = drawing;
        for (r, c) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)] {
            let size = if r == c { drawing[(r, c)] } else { mean };
            let error = match self {
                Self::Signs(share) => share * size * noise.sample().signum(),
                Self::Within(share) => share * size * noise.symmetric(),
            };
            tensor[(r, c)] += error;
            tensor[(c, r)] = tensor[(r, c)];
        }
        tensor
    }

    /// The first that some body can have.
    ///
    /// # Errors
    /// When errors of this size leave none.
    pub fn body(self, noise: &mut Gaussian) -> Result<Inertia> {
        const TRIES: usize = 1000;
        let mut last = None;
        for _ in 0..TRIES {
            let tensor = self.drawn(noise);
            let rows = [0, 1, 2].map(|r| [0, 1, 2].map(|c| tensor[(r, c)]));
            match Inertia::new(rows) {
                Ok(inertia) => return Ok(inertia),
                Err(error) => last = Some(error),
            }
        }
        Err(last.map_or_else(|| anyhow::anyhow!("no inertia"), anyhow::Error::from))
    }
}
