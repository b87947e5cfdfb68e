//! Calibration without keeping a single reading.
//!
//! |B|² = m(V)ᵀ θ(x), m = (1, x, y, z, x², xy, xz, y², yz, z²) of V
//!
//! so that with the weight w = 1 / 4I², which makes the residuals scatter alike (they are then the
//! errors of the norm, but for their squares),
//!
//! Q(x) = Σ w (|B|² − I²)² = θᵀ A θ − 2 θᵀ u + v,  A = Σ w m mᵀ, u = Σ w I² m, v = Σ w I⁴
//!
//! for *any* x. A consists of 35 different sums, as m mᵀ of monomials up to the fourth degree; u of ten. A
//! reading is forgotten when it has been added; Gauss–Newton runs over the sums, at any time,
//! for scale and bias alone (N = 6) or with cross-axis terms (N = 9). With a factor below one the past
//! fades, and the calibration follows a sensor that changes.
//!
//! **Without the shift by noise.** Noise makes the minimum of Q a wrong one: equal scales, seen from all
//! directions, come out too small by 3.5 σ² Σ w I² / Σ w I⁴. With A and u free of noise on average (`moments`),
//!
//! Q_σ = θᵀ A_σ θ − 2 θᵀ u_σ + v
//!
//! has the mean of a Q without noise, whatever x is, and so its least value at the truth. σ is told, or
//! follows from what is left: Q (x) n / (n − N) = Q (x) − Q_σ (x).
//!
//! **Covariance.** r = |B|² − I² has the variance 4 σ² |Mᵀβ|², β = B(V): an axis of twice the scale is
//! twice as noisy. With j = ∂r/∂x
//!
//! P = (Σ w j jᵀ)⁻¹ (Σ w² 4 σ² |Mᵀβ|² j jᵀ) (Σ w j jᵀ)⁻¹,
//!
//! whose middle is of the sixth degree: 84 sums more.
//!
//! **Rounding.** The cost is a small difference of large numbers: 3e-5 of them for a noise of 100 nT. In f32
//! that still tells the noise to some percent. Of a sensor with less noise the sums' own roundings are what is not
//! known: they are counted in, in the noise and in the covariance.

use nalgebra::{ComplexField, RealField, SMatrix, SVector, convert_unchecked};

use super::descent::{MAX_PASSES, Pass, Problem, descend};
use super::error::CalibrationError;
use super::evidence::Evidence;
use super::extended::from_zero;
use super::gauss_newton::{answering, supported};
use super::moments::{OF_FOUR, OF_SIX, OF_TWO, monomials, squares, times};
use super::parameters::{Correction, Parameters};
use super::quadratic::{ByNoise, Quadratic, monomial_slopes, noise_gain};
use super::symmetric::{Spectrum, sigmas};
use super::twostep::first_step;
use super::{DataSheet, Sample, number, shown};
use crate::rolled::{product, product_transposed, transposed_product};

/// Steps of the correction for noise. Each leaves a part of some σ²/I² of the error: four are plenty.
const NOISE_STEPS: u32 = 6;

/// How uncertain a sum of n alike terms is, in parts of itself, epsilons and √n: its partial sums S k/n were
/// rounded by up to half an epsilon of them each, with √(1/12) · √(1/3) · 0.7 in the root mean square.
const SUM_ROUNDINGS: f64 = 0.12;

/// The sums so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sums<T: RealField + Copy> {
    data_sheet: DataSheet<T>,
    unit: T,
    /// What the noise was told to be, in `unit`.
    noise: Option<T>,
    /// Σ w m mᵀ.
    fourth: SVector<T, OF_FOUR>,
    /// Σ w I² m.
    second: SVector<T, OF_TWO>,
    /// Σ w I⁴.
    v: T,
    /// Σ w² of the monomials up to the sixth degree.
    sixth: SVector<T, OF_SIX>,
    /// Samples, faded ones as fractions.
    weight: T,
    samples: u32,
}

/// A calibration from sums.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recursive<T: RealField + Copy, const N: usize> {
    /// The result.
    pub parameters: Parameters<T, N>,
    /// Its covariance, from the residuals; of noise that is new in every sample, and of nothing else.
    pub covariance: SMatrix<T, N, N>,
    /// Root mean square of (|B|² − |B_IGRF|²) / 2 |B_IGRF|: the error of the norm, but for its square.
    pub norm_error_rms: T,
    /// Noise of an axis of the sensor that would leave these residuals, in units of a reading.
    pub noise: T,
    /// Condition of JᵀJ with its columns scaled to equal length.
    pub condition: T,
    /// What the fit left, for the comparison with others; readings that faded count in part.
    pub evidence: Evidence,
}

impl<T: RealField + Copy, const N: usize> Recursive<T, N> {
    /// Standard deviations of the unknowns.
    pub fn sigma(&self) -> Parameters<T, N> {
        Parameters(sigmas(&self.covariance))
    }

    /// What the flight software takes behind a driver that turns readings into field by this data sheet,
    /// and the standard deviations of that.
    pub fn correction(&self, driver: DataSheet<T>) -> (Correction<T>, Correction<T>) {
        let (_, transform) = from_zero(&self.parameters, -driver.zero);
        let covariance = product_transposed(&product(&transform, &self.covariance), &transform);
        let sigma = Recursive { covariance, ..*self }.sigma();
        let sigma = Correction {
            scale: sigma.scale().map(|scale| scale / driver.sensitivity),
            cross_axis: sigma.cross_axis(),
            bias: sigma.bias(),
        };
        (self.parameters.correction(driver), sigma)
    }

    /// With more unknowns, of zero.
    fn widened<const M: usize>(&self) -> Recursive<T, M> {
        let Self { norm_error_rms, noise, condition, evidence, .. } = *self;
        let parameters =
            SVector::from_fn(|i, _| self.parameters.0.get(i).copied().unwrap_or(T::zero()));
        let covariance =
            SMatrix::from_fn(|i, j| self.covariance.get((i, j)).copied().unwrap_or(T::zero()));
        Recursive {
            parameters: Parameters(parameters),
            covariance,
            norm_error_rms,
            noise,
            condition,
            evidence,
        }
    }
}

impl<T: RealField + Copy> Sums<T> {
    /// Sums of nothing, for a sensor by this data sheet in fields of about `strength`.
    ///
    /// # Errors
    /// [`CalibrationError`] when one of these is no number that a sensor or a field can have.
    pub fn new(data_sheet: DataSheet<T>, strength: T) -> Result<Self, CalibrationError> {
        let DataSheet { sensitivity, zero } = data_sheet;
        let positive = |x: T| x.is_finite() && x > T::zero();
        if !positive(sensitivity) {
            return Err(CalibrationError::Sensitivity { found: shown(sensitivity) });
        }
        if !zero.is_finite() {
            return Err(CalibrationError::Zero { found: shown(zero) });
        }
        if !positive(strength) {
            return Err(CalibrationError::Intensity { sample: 0, found: shown(strength) });
        }
        Ok(Self {
            data_sheet,
            unit: strength,
            noise: None,
            fourth: SVector::zeros(),
            second: SVector::zeros(),
            v: T::zero(),
            sixth: SVector::zeros(),
            weight: T::zero(),
            samples: 0,
        })
    }

    /// The same with the noise of an axis told, in units of a reading, as far as the shift by it is
    /// concerned. Otherwise it is that which the residuals show; to take for noise what is none, a
    /// current nearby for instance, would shift the result.
    ///
    /// The covariance is that of the residuals in any case.
    ///
    /// # Errors
    /// [`CalibrationError::Noise`] when it is not finite and positive, or zero.
    pub fn with_noise(self, noise: T) -> Result<Self, CalibrationError> {
        let usable = noise.is_finite() && noise >= T::zero();
        if !usable {
            return Err(CalibrationError::Noise { found: shown(noise) });
        }
        Ok(Self { noise: Some(noise * self.data_sheet.sensitivity / self.unit), ..self })
    }

    /// How many readings went in.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Takes a reading in; the sums stay as they are when it is refused.
    ///
    /// # Errors
    /// [`CalibrationError`]: a reading that is not finite, or a strength that is not positive.
    pub fn add(
        &mut self,
        Sample { reading, intensity }: Sample<T>,
    ) -> Result<(), CalibrationError> {
        let sample = self.samples;
        if !reading.iter().all(T::is_finite) || !intensity.is_finite() {
            return Err(CalibrationError::NotFinite { sample });
        }
        if intensity <= T::zero() {
            return Err(CalibrationError::Intensity { sample, found: shown(intensity) });
        }
        let DataSheet { sensitivity, zero } = self.data_sheet;
        let reading = reading.map(|value| (value - zero) * sensitivity / self.unit);
        let strength = intensity / self.unit;
        let squared = strength * strength;
        let quarter = number::<T>(0.25);
        let w = quarter / squared;
        let m = monomials(reading);
        let next = Self {
            fourth: self.fourth + m.fixed_rows::<OF_FOUR>(0) * w,
            second: self.second + m.fixed_rows::<OF_TWO>(0) * quarter,
            v: self.v + squared * quarter,
            sixth: self.sixth + m * (w * w),
            weight: self.weight + T::one(),
            samples: self.samples.saturating_add(1),
            ..*self
        };
        if !next.is_finite() {
            return Err(CalibrationError::OutOfRange);
        }
        *self = next;
        Ok(())
    }

    fn is_finite(&self) -> bool {
        let sums: [&[T]; 3] =
            [self.fourth.as_slice(), self.second.as_slice(), self.sixth.as_slice()];
        self.v.is_finite() && sums.iter().all(|sums| sums.iter().all(T::is_finite))
    }

    /// Lets the past fade: it counts for `factor` (0 to 1) of what it did.
    pub fn fade(&mut self, factor: T) {
        let usable = factor >= T::zero() && factor <= T::one();
        if usable {
            self.fourth *= factor;
            self.second *= factor;
            self.v *= factor;
            self.sixth *= factor * factor;
            self.weight *= factor;
        }
    }

    /// Scale and bias (`N` = 6), or cross-axis terms too (`N` = 9), from the data sheet on.
    ///
    /// # Errors
    /// [`CalibrationError`]: what the readings so far cannot support. The sums stay.
    pub fn calibration<const N: usize>(&self) -> Result<Recursive<T, N>, CalibrationError> {
        const { assert!(N == 6 || N == 9, "sums know scale, bias and cross-axis terms") };
        let needed = 2 * N as u32;
        let enough = self.weight >= number(f64::from(needed));
        if !enough {
            return Err(CalibrationError::TooFew { found: self.samples, needed });
        }
        let quadratic = Quadratic::of(&self.fourth, &self.second, self.v);
        let mut found = first_step(&quadratic).and_then(|start| descend(&quadratic, start));
        if !found.as_ref().is_ok_and(|found| found.converged) {
            let data_sheet = |i, _| if i < 3 { T::one() } else { T::zero() };
            found = descend(&quadratic, SVector::<T, N>::from_fn(data_sheet));
        }
        let found = found?;
        supported(&found.pass.normal)?;
        if !found.converged {
            return Err(CalibrationError::NotConverged { passes: MAX_PASSES });
        }
        let mut x = Parameters(found.x).with_positive_scales();
        // The minimum is near: its derivatives do for all steps.
        let spectrum = Spectrum::of(&quadratic.pass(&x.0).normal);
        let by_noise = ByNoise::of(&self.fourth, &self.second);
        let mut variance = T::zero();
        for _ in 0..NOISE_STEPS {
            let pass = quadratic.pass(&x.0);
            variance = match self.noise {
                Some(noise) => noise * noise,
                None => self.variance(pass.cost, &by_noise, &x, variance),
            };
            let gradient = pass.gradient - by_noise.gradient(&x, variance);
            x = Parameters(x.0 + spectrum.step(&gradient, T::zero()));
        }
        let mut pass = quadratic.pass(&x.0);
        let part = T::default_epsilon() * number::<T>(SUM_ROUNDINGS) * self.weight.sqrt();
        let rounding = quadratic.rounding(&x, part);
        // Noise below what the sums can tell is taken to be as large as that.
        pass.cost = pass.cost.max(rounding.cost);
        let variance = self.variance(pass.cost, &by_noise, &x, variance);
        self.finished(&pass, &x, variance, &rounding.gradient)
    }

    /// Scale and bias, and cross-axis terms where the readings ask for them.
    ///
    /// The smaller model is kept unless the evidence against it is [very strong](super::VERY_STRONG); the
    /// cross-axis terms are zero then. How far they may be from it the larger model knows: the covariance is
    /// its, unless it could not be found. `evidence.unknowns` says which model it is.
    ///
    /// # Errors
    /// [`CalibrationError`]: why there is none with six unknowns, and none with nine.
    pub fn chosen(&self) -> Result<Recursive<T, 9>, CalibrationError> {
        match (self.calibration::<6>(), self.calibration::<9>()) {
            (Ok(six), Ok(nine)) if nine.evidence.beats(&six.evidence) => Ok(nine),
            (Ok(six), Ok(nine)) => Ok(Recursive { covariance: nine.covariance, ..six.widened() }),
            (Ok(six), Err(_)) => Ok(six.widened()),
            (Err(_), Ok(nine)) => Ok(nine),
            (Err(error), Err(_)) => Err(error),
        }
    }

    /// σ² that leaves this cost: Q n / (n − N) = σ² q₁ − σ⁴ q₂.
    fn variance<const N: usize>(
        &self,
        cost: T,
        by_noise: &ByNoise<T>,
        x: &Parameters<T, N>,
        before: T,
    ) -> T {
        let freedom = self.weight / (self.weight - number(N as f64));
        let slope = by_noise.cost(x, before);
        if slope > T::zero() { (cost * freedom / slope).max(T::zero()) } else { T::zero() }
    }

    /// In the units of the readings.
    #[inline(never)]
    fn finished<const N: usize>(
        &self,
        pass: &Pass<T, N>,
        x: &Parameters<T, N>,
        variance: T,
        rounding: &SVector<T, N>,
    ) -> Result<Recursive<T, N>, CalibrationError> {
        let spectrum = Spectrum::of(&pass.normal);
        let DataSheet { sensitivity, zero } = self.data_sheet;
        let units = SVector::<T, N>::from_fn(|i, _| match i {
            0..3 => sensitivity,
            3..6 => self.unit,
            _ => T::one(),
        });
        let slope = monomial_slopes(x);
        let middle = squares(&times(&self.sixth, &noise_gain(x)));
        let mut scatter = transposed_product(&slope, &product(&middle, &slope));
        scatter *= variance * number(4.0);
        scatter += SMatrix::from_diagonal(&rounding.component_mul(rounding));
        let inverse = spectrum.inverse();
        let covariance = product(&product(&inverse, &scatter), &inverse)
            .component_mul(&(units * units.transpose()));
        let (parameters, transform) = from_zero(&Parameters(x.0.component_mul(&units)), zero);
        let norm_error_rms = (pass.cost / self.weight).sqrt() * self.unit;
        let found = Recursive {
            parameters,
            covariance: product_transposed(&product(&transform, &covariance), &transform),
            norm_error_rms,
            noise: variance.sqrt() * self.unit / sensitivity,
            condition: spectrum.condition(),
            evidence: Evidence {
                samples: convert_unchecked::<T, f64>(self.weight) as u32,
                unknowns: N as u32,
                rms: convert_unchecked(norm_error_rms),
            },
        };
        let mut values = found.parameters.0.iter().chain(found.covariance.iter());
        if !values.all(ComplexField::is_finite) {
            return Err(CalibrationError::OutOfRange);
        }
        answering(found.parameters.scale(), found.sigma().scale())?;
        Ok(found)
    }
}
