//! Attitude and gyro bias from gyro, field and Sun (multiplicative extended Kalman filter).
//!
//! The gyro carries the attitude from instant to instant; field and Sun correct it, and with it what the
//! gyro shows at rest. The attitude is a quaternion, its *error* three small angles in Body:
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | q̂ | `r_bi` | estimated attitude, Eci to Body |
//! | β̂ | `bias_b` | estimated gyro bias, Body, rad/s |
//! | θ | first three states | attitude error, Body, rad: A = (I − [θ×]) Â |
//! | Δβ | last three states | β − β̂, Body, rad/s |
//! | P | `covariance` | E of (θ, Δβ)(θ, Δβ)ᵀ |
//!
//! | step | equation | code |
//! |---|---|---|
//! | predict | ω̂ = ω_gyro − β̂, q̂⁺ = exp(−ω̂ Δt/2) ⊗ q̂, P⁺ = Φ P Φᵀ + Q | [`Mekf::predict`], `propagation` |
//! | field | b = h + h × θ, h = Â r | [`Mekf::update_field`], `measurement`, `update` |
//! | Sun | the same across the line of sight | [`Mekf::update_sun`] |
//! | reset | q̂⁺ = (1, −θ/2) ⊗ q̂ normalised, β̂⁺ = β̂ + Δβ, θ = Δβ = 0 | after each update |
//!
//! [`Mekf::cycle`] does them in this order and adds what keeps the filter honest: it starts by itself
//! (`start`), refuses measurements that contradict the estimate, doubts the estimate when they go on
//! doing so (`monitor`), and has no estimate rather than a wrong one.
//!
//! Derivation and tuning: docs/filters. Source: Lefferts, Markley & Shuster (1982); Markley &
//! Crassidis (2014), §6.2.

mod gyro;
mod inputs;
pub(in crate::attitude) mod measurement;
pub(in crate::attitude) mod monitor;
mod output;
mod parameters;
mod propagation;
mod start;
mod tracked;
mod update;

use nalgebra::{Matrix3, RealField, Vector3};

use crate::frames::{Body, Eci, Rotation, Vector};
use crate::parameter::{self, OutOfRange};
use crate::reading::Reading;

pub use self::gyro::GyroSampling;
pub use self::inputs::{FieldPair, GivenStart, Inputs, SunPair};
pub use self::output::{Event, FilterEstimate, Innovation, Lost, Output, Source};
pub use self::parameters::{FieldNoise, Gates, Limits, MekfParameters};

use self::gyro::HeldRate;
use self::monitor::{Monitor, is_covariance};
use self::propagation::ProcessNoise;
use self::start::Alignment;
use self::tracked::Tracked;
use self::update::{Correction, absorb};

/// The filter with accepted parameters.
#[derive(Debug, Clone, Copy)]
pub struct Mekf<T = f32> {
    parameters: MekfParameters<T>,
    /// σ of the field, each axis, all parts together, T.
    field_noise_t: T,
}

/// What one cycle leaves for the next. `Default` is power-on: no estimate.
#[derive(Debug, Clone, Copy)]
pub struct MekfState<T: RealField + Copy = f32> {
    tracked: Option<Tracked<T>>,
    gyro: Option<HeldRate<T>>,
    /// The last bias that was believed, Body, rad/s: where to start again after a gap.
    believed_bias_b: Vector3<T>,
    monitor: Monitor<T>,
}

impl<T: RealField + Copy> Default for MekfState<T> {
    fn default() -> Self {
        Self {
            tracked: None,
            gyro: None,
            believed_bias_b: Vector3::zeros(),
            monitor: Monitor::new(),
        }
    }
}

impl<T: RealField + Copy> Mekf<T> {
    /// Accepts parameters.
    ///
    /// # Errors
    /// [`OutOfRange`] with the parameter, its value and its range.
    pub fn new(parameters: &MekfParameters<T>) -> Result<Self, OutOfRange> {
        parameters.check()?;
        Ok(Self { parameters: *parameters, field_noise_t: parameters.field_noise.sigma_t() })
    }

    /// Starts from an attitude that is given, whatever the state was. It is believed as far as its σ
    /// goes, and given up when field and Sun agree on another.
    ///
    /// # Errors
    /// [`OutOfRange`] when a σ or the bias is out of range; the state is then as before.
    pub fn begin(&self, state: &mut MekfState<T>, start: &GivenStart<T>) -> Result<(), OutOfRange> {
        let GivenStart { r_bi, attitude_sigma_rad, gyro_bias, gyro_bias_sigma_rad_s } = *start;
        let [x, y, z] = gyro_bias.to_array();
        parameter::check(&[
            ("attitude_sigma_rad", attitude_sigma_rad, 1e-6, core::f64::consts::PI),
            ("gyro_bias_sigma_rad_s", gyro_bias_sigma_rad_s, 1e-9, 1.0),
            ("gyro_bias[0], rad/s", x, -1.0, 1.0),
            ("gyro_bias[1], rad/s", y, -1.0, 1.0),
            ("gyro_bias[2], rad/s", z, -1.0, 1.0),
        ])?;
        let attitude = Matrix3::from_diagonal_element(attitude_sigma_rad * attitude_sigma_rad);
        let bias_variance = gyro_bias_sigma_rad_s * gyro_bias_sigma_rad_s;
        state.begin(Tracked::new(r_bi, &attitude, gyro_bias.xyz, bias_variance));
        Ok(())
    }

    /// One cycle: predict, correct, and look whether the estimate still deserves belief.
    pub fn cycle(&self, state: &mut MekfState<T>, inputs: &Inputs<T>) -> Output<T> {
        let lost = self.predict(state, inputs.gyro, inputs.dt_s).err().map(Event::Lost);
        let pair = inputs.field.filter(FieldPair::is_plausible).zip(inputs.sun);
        if let Some((field, sun)) = &pair {
            state.monitor.judge_pair(self.agree(field, sun));
        }
        if let Some(event) = self.need_of_alignment(state)
            && self.align_with(state, pair, event, 1)
        {
            return self.output(state, Source::TwoVectors, lost.or(Some(event)));
        }

        let field = inputs.field.and_then(|pair| self.update_field(state, &pair));
        let sun = inputs.sun.and_then(|pair| self.update_sun(state, &pair));
        let restarted = state.monitor.is_in_doubt(self.doubt())
            && self.align_with(state, pair, Event::Restarted, self.doubt());

        let (source, event) = if restarted {
            (Source::TwoVectors, Some(Event::Restarted))
        } else {
            let lost = lost.or_else(|| self.check(state).err().map(Event::Lost));
            (self.source(state, field, sun), lost)
        };
        Output { field, sun, ..self.output(state, source, event) }
    }

    /// Carries the estimate over `dt_s` with the gyro.
    ///
    /// A missing gyro is replaced by its last sample for [`Limits::coast_s`], σ growing with what
    /// the rate may have done meanwhile. Without an estimate only the gyro's sample is noted.
    ///
    /// # Errors
    /// [`Lost`] when the step or the gap is too long to be bridged; the state then has no estimate.
    pub fn predict(
        &self,
        state: &mut MekfState<T>,
        gyro: Reading<Vector<Body, T>>,
        dt_s: T,
    ) -> Result<(), Lost> {
        // A NaN fails both comparisons.
        let is_time = dt_s >= T::zero() && dt_s <= self.parameters.limits.step_s;
        if !is_time {
            state.gyro = None;
            return state.lose(Lost::Time);
        }
        let rate = gyro::over_step(&self.parameters, &mut state.gyro, gyro, dt_s);
        if dt_s == T::zero() {
            return Ok(());
        }
        let Some(rate) = rate else { return state.lose(Lost::Gyro) };
        if let Some(tracked) = &mut state.tracked {
            let walk = self.parameters.bias_walk_rad_s_per_sqrt_s;
            let noise = ProcessNoise::new(rate.variance_rad2, walk * walk, dt_s);
            tracked.propagate(rate.rate_b, dt_s, &noise);
        }
        Ok(())
    }

    /// Corrects the estimate with a field. `None` when there is no estimate, or the field is none of
    /// the Earth's.
    pub fn update_field(
        &self,
        state: &mut MekfState<T>,
        field: &FieldPair<T>,
    ) -> Option<Innovation<T>> {
        let tracked = state.tracked.as_mut().filter(|_| field.is_plausible())?;
        let expected = tracked.r_bi * field.eci;
        let variance = self.field_noise_t * self.field_noise_t;
        let rows = measurement::field(expected.xyz, field.body.xyz, variance);
        let correction = absorb(&tracked.covariance, &rows);
        let gate = self.parameters.gates.field_nis;
        let innovation = state.monitor.judge_field(nis(&correction), gate);
        if let Some(correction) = correction.filter(|_| innovation.accepted) {
            tracked.correct(&correction);
        }
        Some(innovation)
    }

    /// Corrects the estimate with a direction of the Sun. `None` when there is no estimate.
    pub fn update_sun(&self, state: &mut MekfState<T>, sun: &SunPair<T>) -> Option<Innovation<T>> {
        let tracked = state.tracked.as_mut()?;
        let expected = (tracked.r_bi * sun.eci).vector();
        let sigma = sun.sigma_rad(self.parameters.sun_noise_rad);
        let variance = sigma * sigma;
        let correction = measurement::direction(expected.xyz, sun.body.vector().xyz, variance)
            .and_then(|rows| absorb(&tracked.covariance, &rows));
        let innovation = state.monitor.judge_sun(nis(&correction), self.parameters.gates.sun_nis);
        if let Some(correction) = correction.filter(|_| innovation.accepted) {
            tracked.correct(&correction);
        }
        Some(innovation)
    }

    /// How many contradictions in a row put the estimate in doubt.
    fn doubt(&self) -> u8 {
        self.parameters.gates.contradictions_in_a_row
    }

    /// Whether the attitude has to be solved for before anything can be linear in its error.
    fn need_of_alignment(&self, state: &MekfState<T>) -> Option<Event> {
        let limit = self.parameters.limits.linear_rad;
        match &state.tracked {
            None => Some(Event::Started),
            Some(tracked) => {
                (tracked.largest_attitude_variance() > limit * limit).then_some(Event::Realigned)
            }
        }
    }

    /// Solves for the attitude from field and Sun, if they are there, have agreed with each other
    /// `times` in a row, and stand far enough apart. The bias stays where it may still be believed: as
    /// it is when the attitude alone had become uncertain, its mean after a gap, not at all when the
    /// filter was wrong.
    fn align_with(
        &self,
        state: &mut MekfState<T>,
        pair: Option<(FieldPair<T>, SunPair<T>)>,
        event: Event,
        times: u8,
    ) -> bool {
        let pair = pair.filter(|_| state.monitor.sensors_agree(times));
        let found = pair.and_then(|(field, sun)| self.align(&field, &sun));
        let Some(Alignment { r_bi, covariance }) = found else { return false };
        match (&mut state.tracked, event) {
            (Some(tracked), Event::Realigned) => {
                tracked.realign(r_bi, &covariance);
                state.monitor.restart();
            }
            _ => {
                let bias_b = match event {
                    Event::Restarted => Vector3::zeros(),
                    _ => state.believed_bias_b,
                };
                let prior = self.parameters.bias_prior_rad_s;
                state.begin(Tracked::new(r_bi, &covariance, bias_b, prior * prior));
            }
        }
        true
    }

    /// Gives the estimate up when it is none.
    fn check(&self, state: &mut MekfState<T>) -> Result<(), Lost> {
        let Some(tracked) = &state.tracked else { return Ok(()) };
        if !is_covariance(&tracked.covariance) {
            let lost = state.lose(Lost::Covariance);
            state.believed_bias_b = Vector3::zeros();
            return lost;
        }
        if tracked.largest_attitude_variance() > T::pi() * T::pi() {
            return state.lose(Lost::Uncertain);
        }
        Ok(())
    }

    fn source(
        &self,
        state: &MekfState<T>,
        field: Option<Innovation<T>>,
        sun: Option<Innovation<T>>,
    ) -> Source {
        let used = |innovation: Option<Innovation<T>>| innovation.is_some_and(|it| it.accepted);
        match (used(field), used(sun)) {
            (true, true) => Source::FieldAndSun,
            (true, false) => Source::Field,
            (false, true) => Source::Sun,
            (false, false) if state.gyro.is_some_and(|held| held.is_fresh()) => Source::Gyro,
            (false, false) => Source::HeldRate,
        }
    }

    /// The state as the rest of the satellite sees it.
    fn output(&self, state: &MekfState<T>, source: Source, event: Option<Event>) -> Output<T> {
        let MekfState { tracked, gyro, monitor, .. } = state;
        let consistent = monitor.is_consistent() && !monitor.is_in_doubt(self.doubt());
        let withheld = tracked.is_some() && !monitor.is_vouched_for(self.doubt());
        let event = event.or(withheld.then_some(Event::Withheld));
        let estimate = tracked.as_ref().filter(|_| !withheld).map(|tracked| {
            let (attitude_sigma, bias_sigma) = tracked.sigma();
            FilterEstimate {
                r_bi: tracked.r_bi,
                attitude_sigma_rad: Vector::from_xyz(attitude_sigma),
                omega_bi: gyro.map(|held| Vector::from_xyz(held.sample_b - tracked.bias_b)),
                gyro_bias: Vector::from_xyz(tracked.bias_b),
                gyro_bias_sigma_rad_s: Vector::from_xyz(bias_sigma),
                covariance: tracked.covariance,
                source,
                consistent,
            }
        });
        Output { estimate, ..Output::none(event) }
    }
}

/// A measurement that cannot be absorbed contradicts the estimate more than any number.
fn nis<T: RealField + Copy>(correction: &Option<Correction<T, 6>>) -> T {
    correction.as_ref().map_or_else(|| T::max_value().unwrap_or_else(T::one), |it| it.nis)
}

impl<T: RealField + Copy> MekfState<T> {
    /// Replaces what is estimated by the truth (attitude; gyro bias, Body, rad/s) and keeps the
    /// covariance: called every cycle in a simulation, it makes of the filter the posterior Cramér–Rao
    /// bound on these measurements.
    ///
    /// Source: Taylor (1979), IEEE Trans. Autom. Control 24, 343–344.
    pub fn linearise_at(&mut self, r_bi: Rotation<Body, Eci, T>, bias_b: Vector3<T>) {
        if let Some(tracked) = &mut self.tracked {
            (tracked.r_bi, tracked.bias_b) = (r_bi, bias_b);
        }
    }

    fn begin(&mut self, tracked: Tracked<T>) {
        self.believed_bias_b = tracked.bias_b;
        self.tracked = Some(tracked);
        self.monitor.restart();
    }

    /// Gives the attitude up but remembers the bias: it has not changed because time was lost.
    fn lose(&mut self, why: Lost) -> Result<(), Lost> {
        let Some(tracked) = self.tracked.take() else { return Ok(()) };
        self.believed_bias_b = tracked.bias_b;
        self.monitor.restart();
        Err(why)
    }
}
