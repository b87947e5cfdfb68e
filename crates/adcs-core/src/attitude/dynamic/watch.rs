//! Whether the estimate deserves belief: by its own innovations, and beside the MEKF.
//!
//! | sign | what it means | what follows |
//! |---|---|---|
//! | a measurement above its gate | it, or the estimate, is wrong | not used |
//! | several in a row of one sensor that the MEKF accepts and this filter does not | this filter is wrong | starts again from the MEKF |
//! | gyro alone above its gate | the gyro is wrong: field and Sun bear the dynamics out | goes on without it; the MEKF, which the gyro carries, is no judge meanwhile |
//! | attitude contradicts the MEKF's, χ² of the difference | one of both is wrong | not trusted; after [`PATIENCE_S`] starts again |
//! | mean NIS too large | noise, or torque, is larger than believed | not trusted, until the torque's σ has grown |
//!
//! The MEKF is the judge because it assumes less: no inertia, no torque, no torquers.

use nalgebra::{Matrix3, RealField, convert};

use super::block::Block;
use super::tracked::Tracked;
use crate::attitude::mekf::monitor::Channel;
use crate::attitude::mekf::{self, FilterEstimate, Gates, Innovation, MekfParameters};

/// A difference to the MEKF above this χ² (3 degrees of freedom) is no chance: once in 1e6. In eclipse the
/// MEKF's error wanders within minutes, so that a flight draws some hundred times; at once in 1e3 five of a
/// hundred flights of eight orbits were handed to a MEKF that was 8 deg off and to the gyro's noise, and turned
/// over.
const DIFFERENCE_GATE: f64 = 30.66;

/// How long the MEKF may contradict before the estimate is given up, s: a part of an eclipse, in which
/// the MEKF's own error wanders as slowly.
const PATIENCE_S: f64 = 300.0;

/// The weakest field of a low orbit, T: there an error of the magnetometer turns the MEKF furthest.
const WEAKEST_FIELD_T: f64 = 2e-5;

/// The attitude's difference from the MEKF's, χ² with 3 degrees of freedom. What a calibration leaves
/// lasts; the MEKF, which takes it for noise, is wrong by `lasting` rad however many fields it averages.
fn difference<T: RealField + Copy>(
    tracked: &Tracked<T>,
    kinematic: &FilterEstimate<T>,
    lasting: T,
) -> T {
    // q_mekf = (1, −θ/2) ⊗ q_dynamic.
    let between = (kinematic.r_bi * tracked.motion.r_bi.inverse()).hamilton();
    let two: T = if between.w < T::zero() { convert(2.0) } else { convert(-2.0) };
    let theta = between.imag() * two;
    let of_kinematic = kinematic.covariance.fixed_view::<3, 3>(0, 0).into_owned();
    let sum = of_kinematic
        + tracked.covariance.block(Block::Attitude, Block::Attitude)
        + Matrix3::from_diagonal_element(lasting * lasting);
    let chi2 = sum.cholesky().map(|factor| theta.dot(&factor.solve(&theta)));
    chi2.unwrap_or_else(|| T::max_value().unwrap_or_else(T::one))
}

/// Counts what this filter (`here`) refuses and the MEKF (`there`) accepts, of one sensor.
fn compare<T>(alone: &mut u8, here: Option<Innovation<T>>, there: Option<Innovation<T>>) {
    if let (Some(here), Some(there)) = (here, there) {
        *alone = match (here.accepted, there.accepted) {
            (true, _) => 0,
            (false, true) => alone.saturating_add(1),
            (false, false) => *alone,
        };
    }
}

/// What this filter made of the measurements of one cycle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen<T> {
    pub(super) gyro: Option<Innovation<T>>,
    pub(super) field: Option<Innovation<T>>,
    pub(super) sun: Option<Innovation<T>>,
}

/// What was seen of late.
#[derive(Debug, Clone, Copy)]
pub(super) struct Watch<T> {
    gyro: Channel<T>,
    field: Channel<T>,
    sun: Channel<T>,
    /// Fields in a row that the MEKF accepted and this filter did not.
    field_alone: u8,
    /// The same of the Sun.
    sun_alone: u8,
    /// How long the MEKF has contradicted, s.
    differs_s: T,
}

impl<T: RealField + Copy> Watch<T> {
    pub(super) fn new() -> Self {
        Self {
            gyro: Channel::new(3.0),
            field: Channel::new(3.0),
            sun: Channel::new(2.0),
            field_alone: 0,
            sun_alone: 0,
            differs_s: T::zero(),
        }
    }

    /// Takes in one cycle of `dt_s`.
    pub(super) fn see(
        &mut self,
        sensors: &MekfParameters<T>,
        seen: &Seen<T>,
        kinematic: &mekf::Output<T>,
        tracked: &Tracked<T>,
        dt_s: T,
    ) {
        let gates = &sensors.gates;
        let note = |channel: &mut Channel<T>, seen: Option<Innovation<T>>, gate: T| {
            if let Some(seen) = seen {
                channel.judge(seen.nis, gate);
            }
        };
        note(&mut self.gyro, seen.gyro, gates.field_nis);
        note(&mut self.field, seen.field, gates.field_nis);
        note(&mut self.sun, seen.sun, gates.sun_nis);
        compare(&mut self.field_alone, seen.field, kinematic.field);
        compare(&mut self.sun_alone, seen.sun, kinematic.sun);
        if let Some(estimate) = kinematic.estimate.as_ref().filter(|it| it.consistent) {
            // A gyro that is wrong carries the MEKF astray; field and Sun together need no judge.
            let borne_out = self.gyro.contradicts(gates.contradictions_in_a_row)
                && seen.field.is_some_and(|field| field.accepted)
                && seen.sun.is_some_and(|sun| sun.accepted);
            let lasting = sensors.field_noise.calibration_t / convert(WEAKEST_FIELD_T);
            let agrees =
                borne_out || difference(tracked, estimate, lasting) <= convert(DIFFERENCE_GATE);
            // Cycles between the MEKF's do not count: it did not speak.
            self.differs_s = if agrees { T::zero() } else { self.differs_s + dt_s };
        }
    }

    /// Whether the estimate has to be given up.
    pub(super) fn gives_up(&self, gates: &Gates<T>) -> bool {
        self.field_alone.max(self.sun_alone) >= gates.contradictions_in_a_row
            || self.differs_s > convert(PATIENCE_S)
    }

    /// Whether innovations and MEKF bear the estimate out.
    pub(super) fn trusts(&self) -> bool {
        let alone = self.field_alone > 0 || self.sun_alone > 0;
        !alone
            && self.differs_s == T::zero()
            && self.field.is_consistent()
            && self.sun.is_consistent()
    }

    /// Whether the gyro has contradicted the dynamics `limit` times in a row.
    pub(super) fn gyro_is_doubtful(&self, limit: u8) -> bool {
        self.gyro.contradicts(limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::attitude::dynamic::block::Blocks;
    use crate::attitude::dynamic::tracked::tests::tracked;
    use crate::attitude::mekf::{Event, Lost, Source};
    use crate::frames::{Rotation, Vector};
    use nalgebra::{Matrix6, UnitQuaternion, Vector3};

    const GOOD: Option<Innovation<f64>> = Some(Innovation { nis: 2.5, accepted: true });
    const REFUSED: Option<Innovation<f64>> = Some(Innovation { nis: 1e3, accepted: false });
    const ALL_GOOD: Seen<f64> = Seen { gyro: GOOD, field: GOOD, sun: GOOD };

    /// A MEKF that accepts everything, `turn_rad` away from the estimate, known to 0.02 rad each as that
    /// is.
    fn kinematic(turn_rad: f64) -> mekf::Output<f64> {
        let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.6, 0.0, 0.8) * turn_rad);
        let estimate = FilterEstimate {
            r_bi: Rotation::from_hamilton(turn),
            attitude_sigma_rad: Vector::new(0.02, 0.02, 0.02),
            omega_bi: None,
            gyro_bias: Vector::zero(),
            gyro_bias_sigma_rad_s: Vector::new(1e-3, 1e-3, 1e-3),
            covariance: Matrix6::from_diagonal_element(4e-4),
            source: Source::FieldAndSun,
            consistent: true,
        };
        mekf::Output { estimate: Some(estimate), field: GOOD, sun: GOOD, event: None }
    }

    /// What the watch says after `cycles` of one second.
    fn after(cycles: u32, seen: &Seen<f64>, kinematic: &mekf::Output<f64>) -> Watch<f64> {
        let mut watch = Watch::new();
        let tracked = tracked(Blocks::ALL);
        for _ in 0..cycles {
            watch.see(&MekfParameters::default(), seen, kinematic, &tracked, 1.0);
        }
        watch
    }

    fn gives_up(watch: &Watch<f64>) -> bool {
        watch.gives_up(&Gates::default())
    }

    #[test]
    fn an_estimate_that_all_bear_out_is_trusted_and_kept() {
        let watch = after(1000, &ALL_GOOD, &kinematic(0.0));
        assert!(watch.trusts() && !gives_up(&watch) && !watch.gyro_is_doubtful(5));
        let watch = after(1000, &ALL_GOOD, &kinematic(0.05));
        assert!(watch.trusts(), "less than two sigma of the difference");
    }

    #[test]
    fn measurements_that_the_mekf_accepts_and_this_filter_does_not_end_it() {
        let seen = Seen { field: REFUSED, sun: None, ..ALL_GOOD };
        let watch = after(4, &seen, &kinematic(0.0));
        assert!(!gives_up(&watch) && !watch.trusts());
        assert!(gives_up(&after(5, &seen, &kinematic(0.0))));
    }

    #[test]
    fn the_other_sensor_does_not_speak_for_the_one_that_contradicts() {
        // Wrong about the field's direction: the field sees nothing of it, the Sun does.
        for seen in [Seen { field: REFUSED, ..ALL_GOOD }, Seen { sun: REFUSED, ..ALL_GOOD }] {
            assert!(!gives_up(&after(4, &seen, &kinematic(0.0))));
            assert!(gives_up(&after(5, &seen, &kinematic(0.0))));
        }
    }

    #[test]
    fn measurements_that_both_refuse_do_not_end_it() {
        let seen = Seen { field: REFUSED, sun: None, ..ALL_GOOD };
        let mekf = mekf::Output { field: REFUSED, ..kinematic(0.0) };
        assert!(!gives_up(&after(100, &seen, &mekf)), "the sensor is wrong");
    }

    #[test]
    fn one_that_is_accepted_in_between_starts_the_count_again() {
        let (mut watch, tracked) = (Watch::new(), tracked(Blocks::ALL));
        for cycle in 0..40 {
            let sun = if cycle % 5 == 4 { GOOD } else { REFUSED };
            let seen = Seen { sun, field: None, ..ALL_GOOD };
            watch.see(&MekfParameters::default(), &seen, &kinematic(0.0), &tracked, 1.0);
            assert!(!gives_up(&watch));
        }
        assert!(!watch.trusts(), "but four of five are too many");
    }

    #[test]
    fn a_gyro_that_contradicts_alone_is_doubtful_and_the_estimate_is_not() {
        let seen = Seen { gyro: REFUSED, ..ALL_GOOD };
        assert!(!after(4, &seen, &kinematic(0.0)).gyro_is_doubtful(5));
        let watch = after(100, &seen, &kinematic(0.0));
        assert!(watch.gyro_is_doubtful(5) && watch.trusts() && !gives_up(&watch));
    }

    #[test]
    fn a_mekf_that_contradicts_takes_the_trust_at_once_and_the_estimate_after_its_patience() {
        // 0.2 rad are 7 sigma of the difference.
        let watch = after(1, &ALL_GOOD, &kinematic(0.2));
        assert!(!watch.trusts() && !gives_up(&watch));
        assert!(!gives_up(&after(300, &ALL_GOOD, &kinematic(0.2))));
        assert!(gives_up(&after(301, &ALL_GOOD, &kinematic(0.2))));
        // More than half a turn away is no agreement either.
        assert!(!after(1, &ALL_GOOD, &kinematic(6.0)).trusts());
    }

    #[test]
    fn a_mekf_that_a_doubtful_gyro_carries_is_no_judge_while_field_and_sun_speak() {
        let seen = Seen { gyro: REFUSED, ..ALL_GOOD };
        let watch = after(1000, &seen, &kinematic(0.2));
        assert!(watch.trusts() && !gives_up(&watch));
        // In eclipse it is: the field alone leaves a turn open.
        let seen = Seen { sun: None, ..seen };
        let watch = after(1000, &seen, &kinematic(0.2));
        assert!(!watch.trusts() && gives_up(&watch));
    }

    #[test]
    fn a_mekf_that_doubts_itself_or_is_silent_contradicts_nobody() {
        let mut doubting = kinematic(1.0);
        if let Some(estimate) = &mut doubting.estimate {
            estimate.consistent = false;
        }
        let event = Some(Event::Lost(Lost::Gyro));
        let silent = mekf::Output::none(event);
        for mekf in [doubting, silent] {
            let watch = after(1000, &ALL_GOOD, &mekf);
            assert!(watch.trusts() && !gives_up(&watch));
        }
    }

    #[test]
    fn innovations_larger_than_promised_take_the_trust_and_not_the_estimate() {
        // Three times the promised variance, below every gate.
        let large = |degrees_of_freedom: f64| {
            Some(Innovation { nis: 3.0 * degrees_of_freedom, accepted: true })
        };
        for seen in [Seen { field: large(3.0), ..ALL_GOOD }, Seen { sun: large(2.0), ..ALL_GOOD }] {
            let watch = after(100, &seen, &kinematic(0.0));
            assert!(!watch.trusts() && !gives_up(&watch));
        }
    }

    #[test]
    fn a_difference_is_measured_in_both_covariances() {
        // χ² = θ² / (0.02² + 0.02²), whichever sign the quaternion has.
        let tracked = tracked(Blocks::ALL);
        for turn in [0.03, -0.03] {
            let estimate = kinematic(turn).estimate.unwrap();
            let found = difference(&tracked, &estimate, 0.0);
            assert!((found - 0.03 * 0.03 / 8e-4).abs() < 1e-3, "{found}");
        }
    }
}
