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

use self::block::{Block, TORQUE_UNIT_N_M};
use self::covariance::{Covariance, Row};
use self::plant::{Inertia, Motion, Surroundings};
use self::torque_noise::TorqueSize;
use self::tracked::{ProcessNoise, Tracked};
use self::watch::{Seen, Watch};
use crate::attitude::mekf::{self, FieldPair, FilterEstimate, Gates, Innovation, SunPair};
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
    watch: Watch<T>,
}

impl<T: RealField + Copy> Default for DynamicState<T> {
    fn default() -> Self {
        Self {
            tracked: None,
            torque_size: None,
            field_before: None,
            sunlit: None,
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
        let field_noise_t = parameters.sensors.field_noise.sigma_t();
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
        self.cross_shadow(state, inputs.sunlit);

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
        state.watch.see(gates, &seen, kinematic, tracked, inputs.sensors.dt_s);
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
        ProcessNoise {
            bias: bias * bias,
            dipole: *walk * *walk,
            torque_sigma: size.map_or(torque.start_n_m / unit, TorqueSize::sigma),
            correlation_s: torque.correlation_s,
        }
    }

    /// In and out of the shadow the panels' currents change, and the dipole with them.
    fn cross_shadow(&self, state: &mut DynamicState<T>, sunlit: Option<bool>) {
        let crossed = matches!((state.sunlit, sunlit), (Some(before), Some(now)) if before != now);
        state.sunlit = sunlit.or(state.sunlit);
        if let (true, Some(tracked)) = (crossed, &mut state.tracked) {
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
        let rows = mekf::measurement::field::<T, 3>(expected.xyz, field.body.xyz, variance)
            .map(|row| Row::new([(Block::Attitude, row.h)], row.innovation, row.variance));
        tracked.absorb(&rows, self.parameters.sensors.gates.field_nis)
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
        let tracked = self.taken_over(estimate, gyro.xyz).filter(Tracked::is_sound);
        let Some(tracked) = tracked else { return DynamicOutput::none(None) };
        state.tracked = Some(tracked);
        state.torque_size = Some(TorqueSize::new(&self.parameters.torque));
        state.watch = Watch::new();
        self.output(state, Some(DynamicEvent::Started))
    }

    fn taken_over(&self, estimate: &FilterEstimate<T>, gyro: Vector3<T>) -> Option<Tracked<T>> {
        let parameters = &self.parameters;
        let bias = estimate.gyro_bias.xyz;
        let of = |row: usize, column: usize| {
            estimate.covariance.fixed_view::<3, 3>(row, column).into_owned()
        };
        let square = |sigma: T| Matrix3::from_diagonal_element(sigma * sigma);
        let mut covariance = Covariance::zeros();
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
        let [m_x, m_y, m_z] = parameters.dipole_am2;
        Some(Tracked {
            motion: Motion { r_bi: estimate.r_bi, omega: gyro - bias },
            bias,
            dipole: Vector3::new(m_x, m_y, m_z),
            moments: Vector3::zeros(),
            products: Vector3::zeros(),
            torque: Vector3::zeros(),
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
mod tests {
    use super::*;
    use crate::attitude::mekf::{GivenStart, Mekf, MekfState};
    use crate::reading::{MissingReason, Reading};
    use nalgebra::{SMatrix, UnitQuaternion};

    const FIELD: [f64; 3] = [2e-5, -1e-5, 3e-5];
    const SUN: [f64; 3] = [0.6, 0.0, 0.8];

    fn parameters(inertia: bool, torque: bool) -> DynamicParameters<f64> {
        DynamicParameters { blocks: Blocks { inertia, torque }, ..Default::default() }
    }

    fn vector<F>([x, y, z]: [f64; 3]) -> Vector<F, f64> {
        Vector::new(x, y, z)
    }

    /// A satellite that stands still along Eci, in sunlight.
    fn inputs(dt_s: f64) -> DynamicInputs<f64> {
        let direction = |xyz| Vector::<Body, f64>::from_xyz(Vector3::from(xyz)).direction();
        DynamicInputs {
            sensors: mekf::Inputs {
                dt_s,
                gyro: Reading::Fresh(Vector::zero()),
                field: Some(FieldPair { body: vector(FIELD), eci: vector(FIELD) }),
                sun: Some(SunPair {
                    body: direction(SUN).unwrap(),
                    eci: vector(SUN).direction().unwrap(),
                    sigma_rad: None,
                }),
            },
            reference_field: Some(vector(FIELD)),
            position: Some(vector([7.0e6, 0.0, 0.0])),
            torquer_dipole: Vector::zero(),
            sunlit: Some(true),
        }
    }

    /// Both filters, one beside the other.
    struct Pair {
        mekf: Mekf<f64>,
        kinematic: MekfState<f64>,
        filter: DynamicFilter<f64>,
        state: DynamicState<f64>,
    }

    impl Pair {
        fn new(parameters: &DynamicParameters<f64>) -> Self {
            let mekf = Mekf::new(&parameters.sensors).unwrap();
            let mut kinematic = MekfState::default();
            let start = GivenStart {
                r_bi: Rotation::identity(),
                attitude_sigma_rad: 0.05,
                gyro_bias: Vector::zero(),
                gyro_bias_sigma_rad_s: 5e-3,
            };
            mekf.begin(&mut kinematic, &start).unwrap();
            let filter = DynamicFilter::new(parameters).unwrap();
            Self { mekf, kinematic, filter, state: DynamicState::default() }
        }

        fn cycle(&mut self, inputs: &DynamicInputs<f64>) -> DynamicOutput<f64> {
            let kinematic = self.mekf.cycle(&mut self.kinematic, &inputs.sensors);
            self.filter.cycle(&mut self.state, inputs, &kinematic)
        }

        fn covariance(&self) -> Covariance<f64> {
            self.state.tracked.unwrap().covariance
        }
    }

    #[test]
    fn the_start_knows_how_rate_attitude_and_bias_go_together() {
        let parameters = parameters(true, true);
        let mut pair = Pair::new(&parameters);
        // Some seconds, so that attitude and bias go with each other.
        let kinematic = (0..9).map(|_| pair.mekf.cycle(&mut pair.kinematic, &inputs(1.0).sensors));
        let kinematic = kinematic.last().unwrap();
        let output = pair.filter.cycle(&mut pair.state, &inputs(1.0), &kinematic);
        assert_eq!(output.event, Some(DynamicEvent::Started));

        // θ and Δβ as they are, δω = −Δβ − v with the sample's noise v.
        let estimate = kinematic.estimate.unwrap();
        let mut before = SMatrix::<f64, 9, 9>::zeros();
        before.fixed_view_mut::<6, 6>(0, 0).copy_from(&estimate.covariance);
        let noise = parameters.sensors.gyro_noise_rad_s;
        before.fixed_view_mut::<3, 3>(6, 6).fill_diagonal(noise * noise);
        let mut map = SMatrix::<f64, 9, 9>::zeros();
        map.fixed_view_mut::<3, 3>(0, 0).fill_diagonal(1.0);
        map.fixed_view_mut::<3, 3>(3, 3).fill_diagonal(-1.0);
        map.fixed_view_mut::<3, 3>(3, 6).fill_diagonal(-1.0);
        map.fixed_view_mut::<3, 3>(6, 3).fill_diagonal(1.0);
        let expected = map * before * map.transpose();
        let started = pair.covariance();
        let order = [Block::Attitude, Block::Rate, Block::Bias];
        for (i, row) in order.into_iter().enumerate() {
            for (j, column) in order.into_iter().enumerate() {
                let block: Matrix3<f64> = expected.fixed_view::<3, 3>(3 * i, 3 * j).into();
                assert!((started.block(row, column) - block).norm() < 1e-18, "{row:?} {column:?}");
            }
        }
        assert!(estimate.covariance.fixed_view::<3, 3>(0, 3).norm() > 1e-6, "they do");
        // Of the others nothing is known but their priors.
        let dipole = parameters.dipole_prior_am2;
        assert_eq!(started.variance(Block::Dipole), Vector3::repeat(dipole * dipole));
        assert_eq!(started.block(Block::Dipole, Block::Rate), Matrix3::zeros());
    }

    #[test]
    fn a_shadows_edge_makes_the_dipole_uncertain_and_nothing_else() {
        let step = DynamicParameters::<f64>::default().dipole_step_am2;
        for (before, now, more) in [
            (Some(true), Some(false), step * step),
            (Some(false), Some(true), step * step),
            (Some(true), Some(true), 0.0),
            (Some(true), None, 0.0),
            (None, Some(false), 0.0),
        ] {
            let mut pair = Pair::new(&parameters(true, true));
            pair.cycle(&inputs(1.0));
            pair.state.sunlit = before;
            let mut expected = pair.covariance();
            expected.add(Block::Dipole, &Matrix3::from_diagonal_element(more));
            pair.filter.cross_shadow(&mut pair.state, now);
            for row in Block::ALL {
                for column in Block::ALL {
                    let found = pair.covariance().block(row, column);
                    assert_eq!(found, expected.block(row, column), "{row:?} {column:?}");
                }
            }
        }
        // A cycle in which nobody knows is no edge.
        let mut pair = Pair::new(&parameters(true, true));
        pair.cycle(&inputs(1.0));
        for sunlit in [None, Some(true)] {
            pair.filter.cross_shadow(&mut pair.state, sunlit);
        }
        let prior = DynamicParameters::<f64>::default().dipole_prior_am2;
        assert_eq!(pair.covariance().variance(Block::Dipole).x, prior * prior);
    }

    #[test]
    fn each_set_of_blocks_flies() {
        for (inertia, torque) in [(false, false), (true, false), (false, true), (true, true)] {
            let mut pair = Pair::new(&parameters(inertia, torque));
            assert_eq!(pair.cycle(&inputs(1.0)).event, Some(DynamicEvent::Started));
            for _ in 0..300 {
                let output = pair.cycle(&inputs(1.0));
                assert_eq!(output.event, None);
                let accepted = [output.gyro, output.field, output.sun];
                assert!(accepted.iter().all(|seen| seen.unwrap().accepted));
                let estimate = output.estimate.unwrap();
                assert!(estimate.trusted && !estimate.gyro_doubtful);
                assert!(estimate.r_bi.angle_rad() < 1e-3);
            }
            let end = pair.state.tracked.unwrap();
            let moved = |state: Vector3<f64>| state != Vector3::zeros();
            assert_eq!([end.moments, end.products].map(moved), [inertia; 2]);
            assert_eq!(moved(end.torque), torque);
        }
    }

    #[test]
    fn a_long_step_is_many_short_ones() {
        let mut once = Pair::new(&parameters(true, true));
        once.cycle(&inputs(1.0));
        let mut often = Pair { state: once.state, ..Pair::new(&parameters(true, true)) };
        for pair in [&mut once, &mut often] {
            let tracked = pair.state.tracked.as_mut().unwrap();
            tracked.motion.omega = Vector3::new(0.06, 0.03, -0.14);
        }
        assert!(once.filter.predict(&mut once.state, &inputs(10.0)));
        for _ in 0..20 {
            assert!(often.filter.predict(&mut often.state, &inputs(0.5)));
        }
        let (once, often) = (once.state.tracked.unwrap(), often.state.tracked.unwrap());
        assert_eq!(once.motion.omega, often.motion.omega);
        let of = |tracked: &Tracked<f64>| tracked.covariance.block(Block::Rate, Block::Dipole);
        assert_eq!(of(&once), of(&often));
    }

    #[test]
    fn what_cannot_be_carried_is_lost_and_told() {
        type Change = fn(&mut DynamicInputs<f64>);
        let changes: [Change; 7] = [
            |inputs| inputs.sensors.dt_s = -1.0,
            |inputs| inputs.sensors.dt_s = f64::NAN,
            |inputs| inputs.sensors.dt_s = 10.1,
            |inputs| inputs.reference_field = None,
            |inputs| inputs.reference_field = Some(vector([f64::NAN, 0.0, 0.0])),
            |inputs| inputs.torquer_dipole = vector([0.0, f64::INFINITY, 0.0]),
            |inputs| inputs.torquer_dipole = vector([1e300, 1e300, 1e300]),
        ];
        for change in changes {
            let mut pair = Pair::new(&parameters(true, true));
            pair.cycle(&inputs(1.0));
            assert!(pair.cycle(&inputs(1.0)).estimate.is_some());
            let mut bad = inputs(1.0);
            change(&mut bad);
            assert_eq!(pair.cycle(&bad).event, Some(DynamicEvent::Lost));
            for _ in 0..3 {
                pair.cycle(&inputs(1.0));
            }
            assert!(pair.cycle(&inputs(1.0)).estimate.is_some(), "and started again");
        }
    }

    #[test]
    fn there_is_no_start_without_gyro_model_or_mekf() {
        type Change = fn(&mut DynamicInputs<f64>);
        let changes: [Change; 4] = [
            |inputs| inputs.sensors.gyro = Reading::Missing(MissingReason::Bus),
            |inputs| inputs.sensors.gyro = Reading::Fresh(vector([f64::NAN, 0.0, 0.0])),
            |inputs| inputs.sensors.gyro = Reading::Fresh(vector([0.0, 100.0, 0.0])),
            |inputs| inputs.reference_field = None,
        ];
        for change in changes {
            let mut pair = Pair::new(&parameters(true, true));
            let kinematic = pair.mekf.cycle(&mut pair.kinematic, &inputs(1.0).sensors);
            let mut bad = inputs(1.0);
            change(&mut bad);
            let output = pair.filter.cycle(&mut pair.state, &bad, &kinematic);
            assert!(output.estimate.is_none() && output.event.is_none());
        }
        let mut pair = Pair::new(&parameters(true, true));
        let nothing = mekf::Output { estimate: None, field: None, sun: None, event: None };
        assert!(pair.filter.cycle(&mut pair.state, &inputs(1.0), &nothing).estimate.is_none());
    }

    #[test]
    fn an_attitude_that_is_too_uncertain_for_linear_equations_is_not_trusted() {
        let mut pair = Pair::new(&parameters(true, true));
        assert!(pair.cycle(&inputs(1.0)).estimate.unwrap().trusted);
        // 30 deg about one axis; the limit is 20.
        let more = Matrix3::from_diagonal(&Vector3::new(0.0, 0.27, 0.0));
        pair.state.tracked.as_mut().unwrap().covariance.add(Block::Attitude, &more);
        assert!(!pair.filter.output(&pair.state, None).estimate.unwrap().trusted);
        // One Sun and one field later it is known again.
        assert!(pair.cycle(&inputs(1.0)).estimate.unwrap().trusted);
    }

    #[test]
    fn a_truth_from_somewhere_else_takes_the_estimates_place_and_keeps_its_covariance() {
        let parameters = parameters(true, true);
        let mut pair = Pair::new(&parameters);
        pair.cycle(&inputs(1.0));
        let before = pair.covariance();
        let truth = Truth {
            r_bi: Rotation::from_hamilton(UnitQuaternion::from_euler_angles(0.1, 0.2, 0.3)),
            omega: Vector3::new(0.01, 0.02, 0.03),
            bias: Vector3::new(1e-3, 2e-3, 3e-3),
            dipole: Vector3::new(0.1, 0.2, 0.3),
            inertia: parameters.inertia() + Matrix3::new(3., 1., 2., 1., 2., 3., 2., 3., 1.) * 1e-4,
            torque: Vector3::new(1e-7, 2e-7, 3e-7),
        };
        pair.state.linearise_at(&truth, &parameters);
        let output = pair.filter.output(&pair.state, None).estimate.unwrap();
        assert!((output.r_bi * truth.r_bi.inverse()).angle_rad() < 1e-15);
        assert_eq!(output.residual_dipole.xyz, truth.dipole);
        assert!((output.torque.xyz - truth.torque).norm() < 1e-20);
        // The tensor follows with the next step.
        pair.filter.predict(&mut pair.state, &inputs(0.5));
        let tensor = pair.state.tracked.unwrap().inertia.tensor;
        assert!((tensor - truth.inertia).norm() < 1e-16);
        let kept = Pair { state: pair.state, ..Pair::new(&parameters) }.covariance();
        assert_eq!(kept.variance(Block::Moments), before.variance(Block::Moments));
    }
}
