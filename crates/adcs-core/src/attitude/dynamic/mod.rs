//! Attitude, rate, gyro bias, residual dipole and inertia from what the satellite's own dynamics know.
//!
//! In the MEKF the gyro carries the attitude, and with it the gyro's noise. Here Euler's equations carry
//! it, and the gyro is one more measurement. What the equations need and nobody knows is estimated along:
//!
//! | states | meaning | flies |
//! |---|---|---|
//! | θ, ω | attitude error (Body), rate | always |
//! | β | gyro bias | always |
//! | M | residual dipole, the largest torque on a small satellite | always |
//! | p | six parameters of the inertia tensor | [`Blocks::inertia`] |
//! | T | slowly varying torque of unknown cause | [`Blocks::torque`] |
//! | S₁, S₂ | what M changes by in the shadow, with a short and with a long lag | [`Blocks::shadow`] |
//! | b | bias of the magnetometer | [`Blocks::field_bias`] |
//!
//! | step | equation | code |
//! |---|---|---|
//! | predict | Euler's equations by Runge–Kutta, Φ to third order | `plant`, `linear` |
//! | covariance | P⁺ = Φ P Φᵀ + Q by 3 × 3 blocks | `covariance` |
//! | gyro | z = ω + β | [`DynamicFilter::cycle`] |
//! | field, Sun | as in the MEKF | `mekf::measurement` |
//! | size of T | σ² follows the mean of T̂² + P_TT, its own expectation | `torque_noise` |
//!
//! The filter never stands alone: it starts from the MEKF's estimate, is watched beside it, and where it
//! is not consistent with its innovations or with the MEKF, it says so and starts again (`watch`).
//!
//! Derivation and tuning: docs/filters.

mod block;
mod covariance;
mod linear;
mod output;
mod parameters;
mod plant;
mod torque_noise;
mod tracked;
mod watch;

use nalgebra::{Matrix3, RealField, Vector3, convert};

pub use self::block::Blocks;
pub use self::output::{DynamicEstimate, DynamicEvent, DynamicOutput};
pub use self::parameters::{DynamicError, DynamicParameters, TorqueNoise};

use self::block::{Block, FIELD_UNIT_T, TORQUE_UNIT_N_M};
use self::covariance::{Covariance, Row};
use self::plant::{Inertia, Motion, Surroundings};
use self::torque_noise::TorqueSize;
use self::tracked::{ProcessNoise, Tracked};
use self::watch::{Seen, Watch};
use crate::attitude::mekf::{
    self, FieldNoise, FieldPair, FilterEstimate, Gates, Innovation, SunPair,
};
use crate::environment::earth::MU_M3_S2;
use crate::frames::{Body, Eci, Rotation, Vector};

/// Longest step of the integration, s. Third order at 0.2 rad/s leaves 1e-5 of Φ.
const LONGEST_STEP_S: f64 = 0.5;

/// The filter with accepted parameters.
#[derive(Debug, Clone, Copy)]
pub struct DynamicFilter<T = f32> {
    parameters: DynamicParameters<T>,
    field_noise_t: T,
}

/// What one cycle leaves for the next. `Default` is power-on: no estimate.
#[derive(Debug, Clone, Copy)]
pub struct DynamicState<T: RealField + Copy = f32> {
    tracked: Option<Tracked<T>>,
    torque_size: Option<TorqueSize<T>>,
    /// The model's field at the last cycle, Eci, T.
    field_before: Option<Vector3<T>>,
    sunlit: Option<bool>,
    /// How much of what the shadow does has been done, 0 to 1.
    shadow: [T; 2],
    watch: Watch<T>,
}

impl<T: RealField + Copy> Default for DynamicState<T> {
    fn default() -> Self {
        Self {
            tracked: None,
            torque_size: None,
            field_before: None,
            sunlit: None,
            shadow: [T::zero(); 2],
            watch: Watch::new(),
        }
    }
}

/// A complete state from somewhere else, Body: see [`DynamicState::linearise_at`].
#[derive(Debug, Clone, Copy)]
pub struct Truth<T: RealField + Copy> {
    /// The attitude.
    pub r_bi: Rotation<Body, Eci, T>,
    /// Rate, rad/s.
    pub omega: Vector3<T>,
    /// Gyro bias, rad/s.
    pub bias: Vector3<T>,
    /// Residual dipole, A·m².
    pub dipole: Vector3<T>,
    /// Inertia tensor, kg·m².
    pub inertia: Matrix3<T>,
    /// Torque of unknown cause, N·m.
    pub torque: Vector3<T>,
}

impl<T: RealField + Copy> DynamicState<T> {
    /// Whether the covariance of all states has a Cholesky factor; `None` without an estimate. For
    /// campaigns: it costs more than a cycle.
    pub fn covariance_is_positive(&self) -> Option<bool> {
        self.tracked.as_ref().map(|tracked| tracked.covariance.is_positive())
    }

    /// Replaces what is estimated by the truth and keeps the covariance, which then is the one that a
    /// filter without any error of linearisation would have: called every cycle in a simulation, it
    /// makes of the filter the posterior Cramér–Rao bound on these measurements.
    ///
    /// Source: Taylor (1979), IEEE Trans. Autom. Control 24, 343–344.
    pub fn linearise_at(&mut self, truth: &Truth<T>, parameters: &DynamicParameters<T>) {
        let Some(tracked) = &mut self.tracked else { return };
        let more = (truth.inertia - parameters.inertia()) / parameters.mean_moment();
        tracked.motion = Motion { r_bi: truth.r_bi, omega: truth.omega };
        tracked.bias = truth.bias;
        tracked.dipole = truth.dipole;
        tracked.moments = more.diagonal();
        tracked.products = Vector3::new(more.m12, more.m13, more.m23);
        tracked.torque = truth.torque / convert::<f64, T>(TORQUE_UNIT_N_M);
        tracked.shadow_dipole = [Vector3::zeros(); 2];
        tracked.field_bias = Vector3::zeros();
        self.watch = Watch::new();
    }
}

/// What the world says in one cycle.
#[derive(Debug, Clone, Copy)]
pub struct DynamicInputs<T: RealField + Copy = f32> {
    /// What the MEKF is given.
    pub sensors: mekf::Inputs<T>,
    /// The model's field at the satellite, now, T.
    pub reference_field: Option<Vector<Eci, T>>,
    /// Where the satellite is, m.
    pub position: Option<Vector<Eci, T>>,
    /// What the torquers carried since the last cycle, A·m².
    pub torquer_dipole: Vector<Body, T>,
    /// Whether the Sun shines on the satellite; `None` when that is not known.
    pub sunlit: Option<bool>,
}

impl<T: RealField + Copy> DynamicFilter<T> {
    /// Accepts parameters.
    ///
    /// # Errors
    /// [`DynamicError`] with the parameter, its value and its range.
    pub fn new(parameters: &DynamicParameters<T>) -> Result<Self, DynamicError> {
        parameters.check()?;
        // What the calibration leaves is what the states of the bias are for.
        let noise = &parameters.sensors.field_noise;
        let field_noise_t = match parameters.blocks.field_bias {
            true => FieldNoise { calibration_t: T::zero(), ..*noise }.sigma_t(),
            false => noise.sigma_t(),
        };
        Ok(Self { parameters: *parameters, field_noise_t })
    }

    /// One cycle: predict, correct, and look whether the estimate still deserves belief. `kinematic` is
    /// what the MEKF made of the same instant.
    pub fn cycle(
        &self,
        state: &mut DynamicState<T>,
        inputs: &DynamicInputs<T>,
        kinematic: &mekf::Output<T>,
    ) -> DynamicOutput<T> {
        let carried = self.predict(state, inputs);
        state.field_before = inputs.reference_field.map(|field| field.xyz);
        if !carried {
            state.tracked = None;
        }
        let lost = (!carried).then_some(DynamicEvent::Lost);
        self.cross_shadow(state, inputs.sunlit, inputs.sensors.dt_s);

        let Some(tracked) = &mut state.tracked else {
            let started = self.start(state, inputs, kinematic);
            return DynamicOutput { event: lost.or(started.event), ..started };
        };
        let gyro = self.possible_rate(inputs).map(|gyro| self.update_gyro(tracked, &gyro));
        let field = inputs.sensors.field.filter(FieldPair::is_plausible);
        let field = field.map(|pair| self.update_field(tracked, &pair));
        let sun = inputs.sensors.sun.and_then(|pair| self.update_sun(tracked, &pair));
        if !tracked.is_sound() {
            state.tracked = None;
            return DynamicOutput::none(Some(DynamicEvent::Lost));
        }
        if let Some(size) = &mut state.torque_size {
            size.follow(&self.parameters.torque, tracked, inputs.sensors.dt_s);
        }
        let gates = &self.parameters.sensors.gates;
        let seen = Seen { gyro, field, sun };
        state.watch.see(&self.parameters.sensors, &seen, kinematic, tracked, inputs.sensors.dt_s);
        let contradicted = state.watch.gives_up(gates);
        if contradicted {
            state.tracked = None;
        }
        let event = contradicted.then_some(DynamicEvent::Contradicted);
        DynamicOutput { gyro, field, sun, ..self.output(state, event) }
    }

    /// Carries the estimate over the step; false when it cannot be carried.
    fn predict(&self, state: &mut DynamicState<T>, inputs: &DynamicInputs<T>) -> bool {
        let DynamicState { tracked: Some(tracked), torque_size, field_before, .. } = state else {
            return true;
        };
        let dt_s = inputs.sensors.dt_s;
        let limit = self.parameters.sensors.limits.step_s;
        // A NaN fails both comparisons.
        let is_time = dt_s >= T::zero() && dt_s <= limit;
        if !is_time || !inputs.torquer_dipole.is_finite() {
            return false;
        }
        let (Some(before), Some(now)) = (*field_before, inputs.reference_field) else {
            return false;
        };
        let half: T = convert(0.5);
        let surroundings = surroundings((before + now.xyz) * half, inputs.position);
        let noise = self.process_noise(torque_size.as_ref());
        // At most limit / LONGEST_STEP_S, which the parameters bound by 120.
        let (mut left, longest) = (dt_s, convert(LONGEST_STEP_S));
        for _ in 0..MAX_STEPS {
            if left <= T::zero() {
                break;
            }
            let step = if left > longest { longest } else { left };
            let dipole = inputs.torquer_dipole.xyz;
            if tracked.propagate(&self.parameters, &surroundings, dipole, &noise, step).is_none() {
                return false;
            }
            left -= step;
        }
        true
    }

    fn process_noise(&self, size: Option<&TorqueSize<T>>) -> ProcessNoise<T> {
        let unit: T = convert(TORQUE_UNIT_N_M);
        let DynamicParameters { sensors, torque, dipole_walk_am2_per_sqrt_s: walk, .. } =
            &self.parameters;
        let bias = sensors.bias_walk_rad_s_per_sqrt_s;
        let white = self.parameters.white_torque_n_m_sqrt_s;
        let allowance = if self.parameters.blocks.inertia {
            T::zero()
        } else {
            self.parameters.inertia_allowance * self.parameters.mean_moment()
        };
        ProcessNoise {
            bias: bias * bias,
            dipole: *walk * *walk,
            torque_sigma: size.map_or(torque.start_n_m / unit, TorqueSize::sigma),
            correlation_s: torque.correlation_s,
            white_torque: white * white,
            inertia_error: allowance * allowance,
        }
    }

    /// In and out of the shadow the panels' currents change, and the dipole with them: by what has been
    /// learned, or by something.
    fn cross_shadow(&self, state: &mut DynamicState<T>, sunlit: Option<bool>, dt_s: T) {
        let before = state.sunlit;
        state.sunlit = sunlit.or(before);
        let Some(now) = state.sunlit else { return };
        let target = if now { T::zero() } else { T::one() };
        for (shadow, lag) in state.shadow.iter_mut().zip(self.parameters.shadow_lags_s) {
            // Without a lag, and before anything is known of the past, at once.
            let share = match before {
                Some(_) if lag > dt_s => dt_s / lag,
                _ => T::one(),
            };
            *shadow += (target - *shadow) * share;
        }
        let Some(tracked) = &mut state.tracked else { return };
        if self.parameters.blocks.shadow {
            tracked.shadow = state.shadow;
        } else if before.is_some_and(|before| before != now) {
            let step = self.parameters.dipole_step_am2;
            let more = Matrix3::from_diagonal_element(step * step);
            tracked.covariance.add(Block::Dipole, &more);
        }
    }

    /// What the gyro shows, if it is within the range of one.
    fn possible_rate(&self, inputs: &DynamicInputs<T>) -> Option<Vector<Body, T>> {
        self.parameters.sensors.limits.possible_rate(inputs.sensors.gyro)
    }

    fn update_gyro(&self, tracked: &mut Tracked<T>, gyro: &Vector<Body, T>) -> Innovation<T> {
        let noise = self.parameters.sensors.gyro_noise_rad_s;
        let innovation = gyro.xyz - tracked.motion.omega - tracked.bias;
        let row = |axis: Vector3<T>| {
            Row::new(
                [(Block::Rate, axis), (Block::Bias, axis)],
                innovation.dot(&axis),
                noise * noise,
            )
        };
        let rows = [row(Vector3::x()), row(Vector3::y()), row(Vector3::z())];
        tracked.absorb(&rows, self.parameters.sensors.gates.field_nis)
    }

    fn update_field(&self, tracked: &mut Tracked<T>, field: &FieldPair<T>) -> Innovation<T> {
        let expected = tracked.motion.r_bi * field.eci;
        let variance = self.field_noise_t * self.field_noise_t;
        let unit: T = convert(FIELD_UNIT_T);
        let measured = field.body.xyz - tracked.field_bias * unit;
        let rows = mekf::measurement::field::<T, 3>(expected.xyz, measured, variance);
        let gate = self.parameters.sensors.gates.field_nis;
        if !self.parameters.blocks.field_bias {
            let rows =
                rows.map(|row| Row::new([(Block::Attitude, row.h)], row.innovation, row.variance));
            return tracked.absorb(&rows, gate);
        }
        let [x, y, z] = rows;
        let rows = [(x, Vector3::x()), (y, Vector3::y()), (z, Vector3::z())].map(|(row, axis)| {
            let h = [(Block::Attitude, row.h), (Block::FieldBias, axis * unit)];
            Row::new(h, row.innovation, row.variance)
        });
        tracked.absorb(&rows, gate)
    }

    fn update_sun(&self, tracked: &mut Tracked<T>, sun: &SunPair<T>) -> Option<Innovation<T>> {
        let expected = (tracked.motion.r_bi * sun.eci).vector();
        let noise = sun.sigma_rad(self.parameters.sensors.sun_noise_rad);
        let measured = sun.body.vector();
        let rows = mekf::measurement::direction::<T, 3>(expected.xyz, measured.xyz, noise * noise)?
            .map(|row| Row::new([(Block::Attitude, row.h)], row.innovation, row.variance));
        Some(tracked.absorb(&rows, self.parameters.sensors.gates.sun_nis))
    }

    /// Takes over the MEKF's estimate, when there is one; the rate is the gyro's of this instant, whose
    /// noise is independent of the MEKF's errors.
    fn start(
        &self,
        state: &mut DynamicState<T>,
        inputs: &DynamicInputs<T>,
        kinematic: &mekf::Output<T>,
    ) -> DynamicOutput<T> {
        let (Some(estimate), Some(gyro), Some(_)) =
            (&kinematic.estimate, self.possible_rate(inputs), inputs.reference_field)
        else {
            return DynamicOutput::none(None);
        };
        state.tracked = self.taken_over(estimate, gyro.xyz, state.shadow);
        let sound = state.tracked.as_ref().is_some_and(Tracked::is_sound);
        if !sound {
            state.tracked = None;
            return DynamicOutput::none(None);
        }
        state.torque_size = Some(TorqueSize::new(&self.parameters.torque));
        state.watch = Watch::new();
        self.output(state, Some(DynamicEvent::Started))
    }

    fn taken_over(
        &self,
        estimate: &FilterEstimate<T>,
        gyro: Vector3<T>,
        shadow: [T; 2],
    ) -> Option<Tracked<T>> {
        let parameters = &self.parameters;
        let bias = estimate.gyro_bias.xyz;
        let of = |row: usize, column: usize| {
            estimate.covariance.fixed_view::<3, 3>(row, column).into_owned()
        };
        let square = |sigma: T| Matrix3::from_diagonal_element(sigma * sigma);
        let mut covariance = Covariance::zeros(parameters.blocks);
        covariance.set(Block::Attitude, Block::Attitude, &of(0, 0));
        covariance.set(Block::Attitude, Block::Bias, &of(0, 3));
        covariance.set(Block::Bias, Block::Bias, &of(3, 3));
        // ω̂ = z − β̂: its error is that of the sample less that of the bias.
        let sample = square(parameters.sensors.gyro_noise_rad_s);
        covariance.set(Block::Rate, Block::Rate, &(of(3, 3) + sample));
        covariance.set(Block::Attitude, Block::Rate, &-of(0, 3));
        covariance.set(Block::Rate, Block::Bias, &-of(3, 3));
        covariance.set(Block::Dipole, Block::Dipole, &square(parameters.dipole_prior_am2));
        if parameters.blocks.inertia {
            covariance.set(Block::Moments, Block::Moments, &square(parameters.moment_prior));
            covariance.set(Block::Products, Block::Products, &square(parameters.product_prior));
        }
        if parameters.blocks.torque {
            let unit: T = convert(TORQUE_UNIT_N_M);
            covariance.set(
                Block::Torque,
                Block::Torque,
                &square(parameters.torque.start_n_m / unit),
            );
        }
        if parameters.blocks.shadow {
            let prior = square(parameters.dipole_step_am2);
            covariance.set(Block::ShadowSoon, Block::ShadowSoon, &prior);
            covariance.set(Block::ShadowLate, Block::ShadowLate, &prior);
        }
        if parameters.blocks.field_bias {
            let unit: T = convert(FIELD_UNIT_T);
            let prior = square(parameters.field_bias_prior_t / unit);
            covariance.set(Block::FieldBias, Block::FieldBias, &prior);
        }
        let [m_x, m_y, m_z] = parameters.dipole_am2;
        Some(Tracked {
            motion: Motion { r_bi: estimate.r_bi, omega: gyro - bias },
            bias,
            dipole: Vector3::new(m_x, m_y, m_z),
            moments: Vector3::zeros(),
            products: Vector3::zeros(),
            torque: Vector3::zeros(),
            shadow_dipole: [Vector3::zeros(); 2],
            field_bias: Vector3::zeros(),
            shadow: if parameters.blocks.shadow { shadow } else { [T::zero(); 2] },
            inertia: Inertia::new(parameters.inertia())?,
            covariance,
            blocks: parameters.blocks,
        })
    }

    fn output(&self, state: &DynamicState<T>, event: Option<DynamicEvent>) -> DynamicOutput<T> {
        let sigma = state.torque_size.as_ref().map_or_else(T::zero, TorqueSize::sigma);
        let Gates { contradictions_in_a_row, .. } = self.parameters.sensors.gates;
        let doubtful = state.watch.gyro_is_doubtful(contradictions_in_a_row);
        // Beyond it nothing is linear, and σ says little.
        let limit = self.parameters.sensors.limits.linear_rad;
        let estimate = state.tracked.as_ref().map(|tracked| {
            let known = tracked.covariance.variance(Block::Attitude).max() <= limit * limit;
            let trusted = known && state.watch.trusts();
            DynamicEstimate::new(tracked, sigma, trusted, doubtful)
        });
        DynamicOutput { estimate, ..DynamicOutput::none(event) }
    }
}

/// More steps than any accepted limit asks for.
const MAX_STEPS: u32 = 128;

fn surroundings<T: RealField + Copy>(
    field: Vector3<T>,
    position: Option<Vector<Eci, T>>,
) -> Surroundings<T> {
    let nowhere = Surroundings { field, up: Vector3::zeros(), gradient: T::zero() };
    let Some(position) = position else { return nowhere };
    // In units of 1e6 m, whose cube f32 holds without loss.
    let scale: T = convert(1e-6);
    let scaled = position.xyz * scale;
    let r = scaled.norm();
    let cube = r * r * r;
    if !(cube > T::zero() && cube.is_finite()) {
        return nowhere;
    }
    let gradient = convert::<f64, T>(3.0 * MU_M3_S2 * 1e-18) / cube;
    Surroundings { field, up: scaled / r, gradient }
}

#[cfg(test)]
mod tests;
