//! The residual dipole that is fed forward: while stage II trusts it, and for a while as it was then.

use super::{Known, Steering};
use crate::frames::{Body, Vector};
use crate::time::Utc;

/// For how long the residual dipole is fed forward as it was last trusted, s: an orbit. The magnet does
/// not change because a filter doubts itself, and without feed-forward it turns a satellite that points
/// over within minutes.
const KEPT_S: f64 = 6_000.0;

/// The residual dipole as it was last trusted, and when, Body, A·m². `Default` is never.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LastTrusted(Option<(Utc, Vector<Body>)>);

/// What is known of the residual dipole in one round, Body, A·m².
#[derive(Debug, Clone, Copy)]
pub(super) struct Residual {
    /// The residual dipole.
    pub dipole: Vector<Body>,
    /// What is fed forward against it.
    pub fed: Vector<Body>,
}

impl LastTrusted {
    /// Takes in what stage II says of it; `None` when nothing is fed forward.
    pub(super) fn residual(
        &mut self,
        steering: &Steering,
        known: &Known<'_>,
        now: Utc,
    ) -> Option<Residual> {
        let forward = steering.feed_forward?;
        let estimate = known.determination.and_then(|it| it.dynamic.estimate.as_ref());
        let trusted = estimate.filter(|it| it.trusted).and_then(|it| {
            let (dipole, sigma) = (it.residual_dipole, it.residual_dipole_sigma_am2);
            let fed = forward.dipole(dipole, sigma, &steering.round)?;
            Some(Residual { dipole, fed })
        });
        if let Some(Residual { dipole, .. }) = trusted {
            self.0 = Some((now, dipole));
            return trusted;
        }
        let (at, dipole) = self.0?;
        let is_recent = (0.0..=KEPT_S).contains(&now.seconds_since(at));
        let fed = forward.dipole(dipole, Vector::zero(), &steering.round)?;
        is_recent.then_some(Residual { dipole, fed })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::super::{Law, RateFrom, SteeringState};
    use super::*;
    use crate::attitude::dynamic::{DynamicEstimate, DynamicOutput};
    use crate::attitude::mekf;
    use crate::attitude::selection::{Determination, Reason};
    use crate::control::allocation::{Allocation, TorquerParameters};
    use crate::control::b_dot::{BDot, BDotGain};
    use crate::control::feed_forward::FeedForward;
    use crate::frames::Rotation;
    use crate::reading::Reading;
    use crate::schedule::{Phase, Round};

    const RESIDUAL_AM2: [f32; 3] = [-0.3, 0.2, 0.1];

    /// A filter that knows the residual dipole, and says whether it is to be trusted.
    fn knowing(trusted: bool) -> Determination {
        let [x, y, z] = RESIDUAL_AM2;
        let estimate = DynamicEstimate {
            r_bi: Rotation::identity(),
            attitude_covariance: Matrix3::identity(),
            omega_bi: Vector::zero(),
            rate_covariance: Matrix3::identity(),
            gyro_bias: Vector::zero(),
            gyro_bias_sigma_rad_s: Vector::zero(),
            residual_dipole: Vector::new(x, y, z),
            residual_dipole_sigma_am2: Vector::new(0.01, 0.01, 0.01),
            inertia_kg_m2: Matrix3::identity(),
            torque: Vector::zero(),
            torque_sigma_n_m: 0.0,
            trusted,
            gyro_doubtful: false,
        };
        Determination {
            attitude: None,
            rate: None,
            reason: Reason::DynamicNotTrusted,
            mekf: mekf::Output::none(None),
            dynamic: DynamicOutput { estimate: Some(estimate), ..DynamicOutput::none(None) },
        }
    }

    #[test]
    fn a_residual_dipole_that_was_trusted_is_fed_forward_for_an_orbit_more() {
        let steering = Steering {
            rate: RateFrom::Gyro,
            cut_hold: false,
            feed_forward: Some(FeedForward::new(0.03).unwrap()),
            round: Round { on_s: 10.0, off_s: 2.5 },
        };
        let torquers =
            TorquerParameters { max_dipole_am2: 0.6, alignment_xyzw: [0.0, 0.0, 0.0, 1.0] };
        let allocation = Allocation::new(&torquers).unwrap();
        let law = Law::BDot(BDot::new(BDotGain::Plain { gain_am2_s_per_t: 1e5 }).unwrap());
        let mut state = SteeringState::default();
        let mut dipole = |seconds: i64, determination: Option<Determination>| {
            // At rest: what is commanded is what is fed forward.
            let known = Known {
                orbit: None,
                sun: None,
                omega_bi: Reading::Fresh(Vector::zero()),
                field_b: Reading::Fresh(Vector::new(3e-5, 0.0, 0.0)),
                determination: determination.as_ref(),
                reference_field: None,
                gains: None,
            };
            let at = (Utc::from_micros_since_2000(seconds * 1_000_000), Phase::Measuring);
            state.cycle(&law, &steering, &allocation, at, &known).command.dipole.to_array()
        };
        let fed = RESIDUAL_AM2.map(|m| m * -1.25);
        assert_eq!(dipole(0, Some(knowing(false))), [0.0; 3], "never trusted");
        assert_eq!(dipole(10, Some(knowing(true))), fed);
        for (seconds, unsure) in [(20, Some(knowing(false))), (4_000, None), (6_009, None)] {
            assert_eq!(dipole(seconds, unsure), fed, "{seconds} s");
        }
        assert_eq!(dipole(6_020, None), [0.0; 3], "too long ago");
        assert_eq!(dipole(5, None), [0.0; 3], "a clock that was set back");
    }
}
