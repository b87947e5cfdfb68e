//! The paper's calibration: Gauss–Newton on the squared norm.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | V, I | `reading`, `intensity` | what the sensor shows, how strong the model's field is |
//! | β = s ∘ V + b | `field()` | the calibrated field, eq. (5) |
//! | r = \|β\|² − I² | `residual` | E = Σ r², eq. (4) |
//! | J = (2 β ∘ V, 2 β) | `row` | derivative of r by (s, b) |
//!
//! The step is x ← x − (JᵀJ + λ D²)⁻¹ Jᵀr with D² = diag(JᵀJ). With λ = 0 it is the paper's. A step
//! that does not lower E is taken back and tried again shorter, with λ > 0 (Levenberg 1944, Marquardt
//! 1963): near the optimum it never is, but from a start of half the scale or a bias of the size of
//! the field the paper's step may overshoot.
//!
//! Everything is computed with readings counted from the data sheet's zero, in units of the largest of
//! their axis, and with fields in units of the strongest: all of s, b, V, I, r are then of order one, a
//! wrong bias is not mistaken for a wrong scale, and f32 has digits to spare.

use nalgebra::{RealField, SMatrix, SVector};

use super::descent::{Descent, MAX_PASSES, Pass, Problem, descend};
use super::error::{CalibrationError, Unknown};
use super::symmetric::Spectrum;
use super::{
    Calibration, DataSheet, NormError, Sample, Start, UNKNOWNS, field, joined, linear, norm_error,
    number, parted, shown,
};

/// Two samples for each unknown: with fewer, the residuals say little about the noise.
pub const MIN_SAMPLES: u32 = 2 * UNKNOWNS as u32;
/// Above this condition of the scaled JᵀJ, the combination of unknowns known least is uncertain by 100
/// times what the best one is: 1 % of noise then is the whole of it.
pub const MAX_CONDITION: f64 = 1e4;

/// A scale of fewer sigmas may as well be zero.
const SIGNIFICANT: f64 = 3.0;

/// Finds scale and bias of each axis, B = s ∘ V + b, with the least E = Σ (|B|² − |B_IGRF|²)².
///
/// E is blind to signs: (s, b) → (−s, −b) of any axis changes nothing. The result has s > 0; whether
/// an axis is wired the other way round is to be found out by other means (dB/dt ≈ −ω × B).
///
/// With noise σ on each axis |B|² is too large by 3 σ² on average, and the optimum a little off the
/// truth; that is inherent to E and not in the covariance.
///
/// # Errors
/// [`CalibrationError`]: samples that are too few, not finite, or from too few directions; a start from
/// which no solution is found; an axis that does not answer.
pub fn calibrate<T, I>(samples: I, start: &Start<T>) -> Result<Calibration<T>, CalibrationError>
where
    T: RealField + Copy,
    I: IntoIterator<Item = Sample<T>>,
    I::IntoIter: Clone,
{
    let samples = samples.into_iter();
    let (Start::DataSheet(DataSheet { zero, .. }) | Start::Linear { zero }) = *start;
    let units = Units::of(samples.clone(), zero)?;
    let scaled = samples.clone().map(move |sample| units.scaled(sample));
    let start = match start {
        Start::DataSheet(data_sheet) => units.start(data_sheet)?,
        Start::Linear { .. } => linear::start(scaled.clone())?,
    };
    let found = descend(&Walk(&scaled), start)?;

    supported(&found.pass.normal)?;
    if !found.converged {
        return Err(CalibrationError::NotConverged { passes: MAX_PASSES });
    }
    let x = positive_scales(&found.x);
    units.calibration(samples, &scaled, x, &found, &Spectrum::of(&Walk(&scaled).pass(&x).normal))
}

/// Whether the directions tell all unknowns apart.
pub(super) fn supported<T: RealField + Copy, const N: usize>(
    normal: &SMatrix<T, N, N>,
) -> Result<(), CalibrationError> {
    let spectrum = Spectrum::of(normal);
    let (condition, limit) = (spectrum.condition(), number(MAX_CONDITION));
    // A NaN fails the comparison.
    if condition <= limit {
        return Ok(());
    }
    Err(CalibrationError::PoorGeometry {
        condition: shown(condition),
        limit: shown(limit),
        weakest: Unknown::at(spectrum.weakest()),
    })
}

/// Whether all axes answer to the field.
pub(super) fn answering<T: RealField + Copy>(
    scale: [T; 3],
    sigma: [T; 3],
) -> Result<(), CalibrationError> {
    for ((found, sigma), axis) in scale.into_iter().zip(sigma).zip(0..) {
        let answers = found > sigma * number(SIGNIFICANT);
        if !answers {
            let (found, sigma) = (shown(found), shown(sigma));
            return Err(CalibrationError::NoScale { axis, found, sigma });
        }
    }
    Ok(())
}

/// Zero, largest readings and strongest field: the units in which all is computed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Units<T> {
    pub(super) zero: T,
    pub(super) reading: [T; 3],
    pub(super) intensity: T,
    pub(super) samples: u32,
}

impl<T: RealField + Copy> Units<T> {
    /// Looks all samples over.
    pub(super) fn of(
        samples: impl Iterator<Item = Sample<T>>,
        zero: T,
    ) -> Result<Self, CalibrationError> {
        if !zero.is_finite() {
            return Err(CalibrationError::Zero { found: shown(zero) });
        }
        let mut found = Self { zero, reading: [T::zero(); 3], intensity: T::zero(), samples: 0 };
        let mut first = None;
        let mut varies = [false; 3];
        for Sample { reading, intensity } in samples {
            let sample = found.samples;
            if !reading.iter().all(T::is_finite) || !intensity.is_finite() {
                return Err(CalibrationError::NotFinite { sample });
            }
            if intensity <= T::zero() {
                return Err(CalibrationError::Intensity { sample, found: shown(intensity) });
            }
            let first = *first.get_or_insert(reading);
            for (((largest, varies), value), first) in
                found.reading.iter_mut().zip(&mut varies).zip(reading).zip(first)
            {
                *largest = largest.max((value - zero).abs());
                *varies |= value != first;
            }
            found.intensity = found.intensity.max(intensity);
            found.samples = found.samples.saturating_add(1);
        }
        found.at_least(MIN_SAMPLES)?;
        let constant = varies.iter().zip(first.unwrap_or(found.reading)).zip(0..);
        for ((varies, value), axis) in constant {
            if !varies {
                return Err(CalibrationError::Constant { axis, found: shown(value) });
            }
        }
        Ok(found)
    }

    /// Whether there are enough samples.
    pub(super) fn at_least(&self, needed: u32) -> Result<(), CalibrationError> {
        let found = self.samples;
        if found < needed { Err(CalibrationError::TooFew { found, needed }) } else { Ok(()) }
    }

    pub(super) fn scaled(&self, Sample { reading: [x, y, z], intensity }: Sample<T>) -> Sample<T> {
        let ([u_x, u_y, u_z], zero) = (self.reading, self.zero);
        Sample {
            reading: [(x - zero) / u_x, (y - zero) / u_y, (z - zero) / u_z],
            intensity: intensity / self.intensity,
        }
    }

    /// Units of the unknowns.
    fn of_unknowns(&self) -> SVector<T, UNKNOWNS> {
        let [x, y, z] = self.reading.map(|reading| self.intensity / reading);
        SVector::from([x, y, z, self.intensity, self.intensity, self.intensity])
    }

    pub(super) fn start(
        &self,
        &DataSheet { sensitivity, .. }: &DataSheet<T>,
    ) -> Result<SVector<T, UNKNOWNS>, CalibrationError> {
        let usable = sensitivity.is_finite() && sensitivity > T::zero();
        if !usable {
            return Err(CalibrationError::Sensitivity { found: shown(sensitivity) });
        }
        let x = joined([sensitivity; 3], [T::zero(); 3]);
        Ok(x.component_div(&self.of_unknowns()))
    }

    /// The result, in the units of the samples.
    fn calibration<I: Iterator<Item = Sample<T>>>(
        &self,
        samples: I,
        scaled: &(impl Iterator<Item = Sample<T>> + Clone),
        x: SVector<T, UNKNOWNS>,
        found: &Descent<T, UNKNOWNS>,
        spectrum: &Spectrum<T, UNKNOWNS>,
    ) -> Result<Calibration<T>, CalibrationError> {
        let count = number::<T>(f64::from(self.samples));
        let units = self.of_unknowns();
        let inverse = spectrum.inverse();
        let freedom = count / (count - number(UNKNOWNS as f64));
        let covariance = inverse * scatter(scaled, &x) * inverse * freedom;
        let covariance = covariance.component_mul(&(units * units.transpose()));
        // s (V − V₀) + b = s V + (b − s V₀)
        let from_zero = SMatrix::<T, UNKNOWNS, UNKNOWNS>::from_fn(|i, j| match i {
            _ if i == j => T::one(),
            _ if i == j + 3 => -self.zero,
            _ => T::zero(),
        });
        let covariance = from_zero * covariance * from_zero.transpose();
        let (scale, bias) = parted(&(from_zero * x.component_mul(&units)));
        let squared = self.intensity * self.intensity;
        let calibration = Calibration {
            scale,
            bias,
            covariance,
            cost: found.pass.cost * squared * squared,
            residual_rms: (found.pass.cost / count).sqrt() * squared,
            norm_error: norm_error(samples, scale, bias),
            condition: spectrum.condition(),
            samples: self.samples,
            iterations: found.steps,
        };
        let (sigma, _) = calibration.sigma();
        answering(scale, sigma)?;
        if calibration.is_finite() { Ok(calibration) } else { Err(CalibrationError::OutOfRange) }
    }
}

impl<T: RealField + Copy> Calibration<T> {
    fn is_finite(&self) -> bool {
        let NormError { min, max, rms } = self.norm_error;
        let others = [self.cost, self.residual_rms, self.condition, min, max, rms];
        let all = self.scale.iter().chain(&self.bias).chain(&others).chain(self.covariance.iter());
        all.copied().all(|value| value.is_finite())
    }
}

/// The samples, walked through at each x.
struct Walk<'a, I>(&'a I);

impl<T, I> Problem<T, UNKNOWNS> for Walk<'_, I>
where
    T: RealField + Copy,
    I: Iterator<Item = Sample<T>> + Clone,
{
    fn pass(&self, x: &SVector<T, UNKNOWNS>) -> Pass<T, UNKNOWNS> {
        let mut sums = Pass::zero();
        for sample in self.0.clone() {
            let (residual, row) = linearised(&sample, x);
            sums.add(residual, &row);
        }
        sums
    }
}

/// Σ r² j jᵀ, j being a row of J: how much the gradient scatters with the noise.
///
/// A residual is about 2 |B| ε, so they do not scatter alike, and (JᵀJ)⁻¹ E / (n − 6) would not be the
/// covariance. (JᵀJ)⁻¹ (Σ r² j jᵀ) (JᵀJ)⁻¹ is, whatever the noise depends on.
///
/// Source: White (1980), Econometrica 48(4), 817–838; with n / (n − 6) for the six unknowns that took
/// their part of the residuals.
fn scatter<T: RealField + Copy>(
    samples: &(impl Iterator<Item = Sample<T>> + Clone),
    x: &SVector<T, UNKNOWNS>,
) -> SMatrix<T, UNKNOWNS, UNKNOWNS> {
    samples.clone().fold(SMatrix::zeros(), |sum, sample| {
        let (residual, row) = linearised(&sample, x);
        let row = row * residual;
        sum + row * row.transpose()
    })
}

/// r and a row of J.
fn linearised<T: RealField + Copy>(
    &Sample { reading, intensity }: &Sample<T>,
    x: &SVector<T, UNKNOWNS>,
) -> (T, SVector<T, UNKNOWNS>) {
    let (scale, bias) = parted(x);
    let [b_x, b_y, b_z] = field(reading, scale, bias);
    let residual = b_x * b_x + b_y * b_y + b_z * b_z - intensity * intensity;
    let [x, y, z] = reading;
    (residual, SVector::from([b_x * x, b_y * y, b_z * z, b_x, b_y, b_z]) * number::<T>(2.0))
}

/// (s, b), or of E's mirror images the one with s > 0.
fn positive_scales<T: RealField + Copy>(x: &SVector<T, UNKNOWNS>) -> SVector<T, UNKNOWNS> {
    let (mut scale, mut bias) = parted(x);
    for (scale, bias) in scale.iter_mut().zip(&mut bias) {
        if *scale < T::zero() {
            (*scale, *bias) = (-*scale, -*bias);
        }
    }
    joined(scale, bias)
}
