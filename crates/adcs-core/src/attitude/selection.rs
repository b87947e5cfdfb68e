//! Stage II as it flies: both filters beside each other, and which of them the satellite believes.
//!
//! | dynamics-aided | MEKF | attitude | rate |
//! |---|---|---|---|
//! | trusted | any | dynamics-aided | dynamics-aided |
//! | none or not trusted | filtered | MEKF | gyro less the MEKF's bias |
//! | none or not trusted | field and Sun of this instant | two vectors | gyro less the last bias that was believed |
//! | none or not trusted | none | none | gyro as it shows, if it speaks |
//! | | | none | across the field, from the magnetometer, if the gyro is silent |
//!
//! The first row that applies decides. What sensors are missing is in the inputs; that a sensor's word is
//! not believed is found by the filters' gates and watches. Why the row before was not taken is in
//! [`Determination::reason`], for telemetry.

use nalgebra::{Matrix3, RealField};
use serde::{Deserialize, Serialize};

use super::dynamic::{
    DynamicError, DynamicEstimate, DynamicFilter, DynamicInputs, DynamicOutput, DynamicParameters,
    DynamicState,
};
use super::field_slope::FieldSlope;
use super::mekf::{self, FilterEstimate, Mekf, MekfState};
use crate::frames::{Body, Eci, Rotation, Vector};

/// Stage II as it is stored and uplinked.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EstimatorParameters<T = f32> {
    /// Sensors, dynamics and tuning of both filters.
    pub dynamics: DynamicParameters<T>,
    /// Which filters fly.
    pub flies: Flies,
}

/// Both filters with accepted parameters.
#[derive(Debug, Clone, Copy)]
pub struct Estimator<T = f32> {
    mekf: Mekf<T>,
    dynamic: DynamicFilter<T>,
    flies: Flies,
    field_sigma_t: T,
    gyro_sigma_rad_s: T,
}

/// Which filters fly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Flies {
    /// The MEKF alone.
    Mekf,
    /// Both; the dynamics-aided filter is used where it is trusted.
    Both,
}

/// What one cycle leaves for the next. `Default` is power-on.
#[derive(Debug, Clone, Copy)]
pub struct EstimatorState<T: RealField + Copy = f32> {
    /// The MEKF's.
    pub mekf: MekfState<T>,
    /// The dynamics-aided filter's.
    pub dynamic: DynamicState<T>,
    field_slope: FieldSlope<T>,
    /// The last gyro bias that was believed, Body, rad/s.
    bias: Vector<Body, T>,
}

impl<T: RealField + Copy> Default for EstimatorState<T> {
    fn default() -> Self {
        Self {
            mekf: MekfState::default(),
            dynamic: DynamicState::default(),
            field_slope: FieldSlope::default(),
            bias: Vector::zero(),
        }
    }
}

/// Where the attitude comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AttitudeSource {
    /// The dynamics-aided filter.
    Dynamic,
    /// The MEKF.
    Mekf,
    /// Field and Sun of this instant alone.
    TwoVectors,
}

/// Where the rate comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RateSource {
    /// The dynamics-aided filter.
    Dynamic,
    /// The gyro (for some seconds its last sample), less the bias that the MEKF knows now.
    GyroLessBias,
    /// The gyro, less the last bias that was believed; none if there never was one.
    Gyro,
    /// The magnetometer alone: nothing is known of the rate along the field.
    AcrossField,
}

/// Why a better estimate was not used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reason {
    /// There is no better one.
    Best,
    /// The dynamics-aided filter does not fly.
    DynamicNotFlown,
    /// The dynamics-aided filter has no estimate.
    DynamicNotStarted,
    /// The dynamics-aided filter's estimate contradicts its innovations or the MEKF.
    DynamicNotTrusted,
    /// The MEKF starts, or starts again.
    MekfStarts,
    /// The MEKF withholds its estimate: everything that was measured of late contradicts it.
    MekfWithheld,
    /// The MEKF lost its estimate.
    MekfLost(mekf::Lost),
    /// The MEKF has not started: field and Sun have not been there together.
    MekfNotStarted,
}

/// The attitude that the satellite believes.
#[derive(Debug, Clone, Copy)]
pub struct Attitude<T: RealField + Copy = f32> {
    /// The attitude.
    pub r_bi: Rotation<Body, Eci, T>,
    /// Covariance of its error, Body, rad².
    pub covariance: Matrix3<T>,
    /// Where it comes from.
    pub source: AttitudeSource,
}

impl<T: RealField + Copy> Attitude<T> {
    /// σ of the attitude about each Body axis, rad.
    pub fn sigma_rad(&self) -> Vector<Body, T> {
        Vector::from_xyz(self.covariance.diagonal().map(|variance| variance.max(T::zero()).sqrt()))
    }
}

/// The rate that the satellite believes.
#[derive(Debug, Clone, Copy)]
pub struct Rate<T: RealField + Copy = f32> {
    /// Rate of Body relative to Eci, rad/s.
    pub omega_bi: Vector<Body, T>,
    /// σ, the largest of the three axes (across the field, of those), rad/s.
    pub sigma_rad_s: T,
    /// Where it comes from.
    pub source: RateSource,
}

/// What one cycle made of its inputs.
#[derive(Debug, Clone, Copy)]
pub struct Determination<T: RealField + Copy = f32> {
    /// The attitude to be used, when there is one.
    pub attitude: Option<Attitude<T>>,
    /// The rate to be used, when there is one.
    pub rate: Option<Rate<T>>,
    /// Why not a better one.
    pub reason: Reason,
    /// What the MEKF said.
    pub mekf: mekf::Output<T>,
    /// What the dynamics-aided filter said.
    pub dynamic: DynamicOutput<T>,
}

impl<T: RealField + Copy> Estimator<T> {
    /// Accepts parameters.
    ///
    /// # Errors
    /// [`DynamicError`] with the parameter, its value and its range.
    pub fn new(parameters: &EstimatorParameters<T>) -> Result<Self, DynamicError> {
        let EstimatorParameters { dynamics, flies } = parameters;
        let sensors = &dynamics.sensors;
        Ok(Self {
            mekf: Mekf::new(sensors)?,
            dynamic: DynamicFilter::new(dynamics)?,
            flies: *flies,
            field_sigma_t: sensors.field_noise.sigma_t(),
            gyro_sigma_rad_s: sensors.gyro_noise_rad_s,
        })
    }

    /// The MEKF, for a start that is given ([`Mekf::begin`]).
    pub fn mekf(&self) -> &Mekf<T> {
        &self.mekf
    }

    /// One cycle of both filters, and what to believe.
    pub fn cycle(
        &self,
        state: &mut EstimatorState<T>,
        inputs: &DynamicInputs<T>,
    ) -> Determination<T> {
        let sensors = &inputs.sensors;
        let mekf = self.mekf.cycle(&mut state.mekf, sensors);
        let dynamic = match self.flies {
            Flies::Both => self.dynamic.cycle(&mut state.dynamic, inputs, &mekf),
            Flies::Mekf => DynamicOutput::none(None),
        };
        let field = sensors.field.map(|pair| pair.body);
        // A field is only handed in while the torquers rest.
        state.field_slope.cycle(field.is_some(), field, sensors.dt_s);
        let across_field = state.field_slope.rate();

        let trusted = dynamic.estimate.as_ref().filter(|it| it.trusted);
        let filtered = mekf.estimate.as_ref().filter(|it| it.source != mekf::Source::TwoVectors);
        let bias = trusted.map(|it| it.gyro_bias).or(filtered.map(|it| it.gyro_bias));
        state.bias = bias.unwrap_or(state.bias);
        if let Some(estimate) = trusted {
            let (attitude, rate) = of_dynamics(estimate);
            let (attitude, rate) = (Some(attitude), Some(rate));
            return Determination { attitude, rate, reason: Reason::Best, mekf, dynamic };
        }

        let gyro = sensors.gyro.value().filter(Vector::is_finite).map(|gyro| Rate {
            omega_bi: gyro - state.bias,
            sigma_rad_s: self.gyro_sigma_rad_s,
            source: RateSource::Gyro,
        });
        let across_field = across_field.map(|it| Rate {
            omega_bi: it.omega_bi,
            sigma_rad_s: it.sigma_per_tesla * self.field_sigma_t,
            source: RateSource::AcrossField,
        });
        let less_bias = filtered.and_then(|estimate| self.less_bias(estimate));
        let rate = less_bias.or(gyro).or(across_field);
        let attitude = mekf.estimate.as_ref().map(of_kinematics);
        let reason = self.reason(&mekf, &dynamic);
        Determination { attitude, rate, reason, mekf, dynamic }
    }

    /// The gyro less the bias that the MEKF knows now.
    fn less_bias(&self, estimate: &FilterEstimate<T>) -> Option<Rate<T>> {
        let bias_sigma = estimate.gyro_bias_sigma_rad_s.xyz.max();
        let sample = self.gyro_sigma_rad_s;
        Some(Rate {
            omega_bi: estimate.omega_bi?,
            sigma_rad_s: (bias_sigma * bias_sigma + sample * sample).sqrt(),
            source: RateSource::GyroLessBias,
        })
    }

    fn reason(&self, mekf: &mekf::Output<T>, dynamic: &DynamicOutput<T>) -> Reason {
        match (&mekf.estimate, mekf.event) {
            (Some(estimate), _) if estimate.source == mekf::Source::TwoVectors => {
                Reason::MekfStarts
            }
            (None, Some(mekf::Event::Lost(lost))) => Reason::MekfLost(lost),
            (None, Some(mekf::Event::Withheld)) => Reason::MekfWithheld,
            (None, _) => Reason::MekfNotStarted,
            (Some(_), _) if self.flies == Flies::Mekf => Reason::DynamicNotFlown,
            (Some(_), _) if dynamic.estimate.is_none() => Reason::DynamicNotStarted,
            (Some(_), _) => Reason::DynamicNotTrusted,
        }
    }
}

/// What the dynamics-aided filter says.
fn of_dynamics<T: RealField + Copy>(estimate: &DynamicEstimate<T>) -> (Attitude<T>, Rate<T>) {
    let attitude = Attitude {
        r_bi: estimate.r_bi,
        covariance: estimate.attitude_covariance,
        source: AttitudeSource::Dynamic,
    };
    let rate = Rate {
        omega_bi: estimate.omega_bi,
        sigma_rad_s: estimate.rate_covariance.diagonal().max().max(T::zero()).sqrt(),
        source: RateSource::Dynamic,
    };
    (attitude, rate)
}

/// The MEKF's attitude.
fn of_kinematics<T: RealField + Copy>(estimate: &FilterEstimate<T>) -> Attitude<T> {
    Attitude {
        r_bi: estimate.r_bi,
        covariance: estimate.covariance.fixed_view::<3, 3>(0, 0).into_owned(),
        source: match estimate.source {
            mekf::Source::TwoVectors => AttitudeSource::TwoVectors,
            _ => AttitudeSource::Mekf,
        },
    }
}
