//! The orbit in every cycle for the price of SGP4 once a minute.

use core::num::NonZeroU16;

use nalgebra::Vector3;

use super::{OrbitModel, OrbitState};
use crate::environment::earth::MU_M3_S2;
use crate::frames::Vector;
use crate::nodes::{Grid, NodePair};
use crate::time::Utc;

/// The spacing of the nodes for low orbits, s: the position moves by less than a metre, a
/// thousandth of SGP4's own error.
pub const SPACING_S: NonZeroU16 = NonZeroU16::new(60).unwrap();

/// By how much SGP4's velocity differs from the change of its position, m/s: the first number, and
/// the second times the eccentricity. SGP4 neglects terms of order J₂ e v in both, not the same
/// ones. Measured over inclinations from 0 to 98 deg and eccentricities up to 0.2 (a test repeats
/// it).
const VELOCITY_MISMATCH_M_S: [f64; 2] = [0.11, 10.0];

/// SGP4 at nodes of equal spacing, a cubic between them.
///
/// Position and velocity are known at both nodes, which is what a cubic Hermite polynomial needs.
/// With u from 0 to 1 between nodes h apart:
///
/// r(u) = r₀ + u (h v₀ + u (c₂ + u c₃)),
/// c₂ = 3 Δ − 2 h v₀ − h v₁, c₃ = h v₀ + h v₁ − 2 Δ, Δ = r₁ − r₀
///
/// The nodes stand at fixed multiples of the spacing from the epoch of the elements, and hence the
/// state at an instant is the same, to the last bit, whatever was asked for before. A call
/// evaluates SGP4 twice after a jump in time, once when `now` has passed a node, and otherwise not
/// at all: 1,500 instructions on a Cortex-M4F.
///
/// | spacing | position | velocity |
/// |---|---|---|
/// | 30 s | 0.07 m | 0.03 m/s |
/// | 60 s | 0.4 m | 0.04 m/s |
/// | 120 s | 6 m | 0.17 m/s |
/// | 300 s | 240 m | 2.5 m/s |
///
/// These are the largest differences from SGP4 itself in orbits of 400 and 615 km with eccentricity
/// 0.001; [`position_error_bound_m`] gives a bound for others. In an eccentric orbit SGP4's
/// velocity does not quite fit its positions (5 m at 60 s and eccentricity 0.1): a shorter spacing
/// helps.
#[derive(Debug, Clone)]
pub struct InterpolatedOrbit {
    model: OrbitModel,
    grid: Grid,
}

/// The nodes in use: what an [`InterpolatedOrbit`] carries from one call to the next. `Default` has
/// none. Nodes of other elements or another spacing are noticed and not used.
#[derive(Debug, Clone, Copy, Default)]
pub struct OrbitNodes {
    held: Option<Held>,
}

#[derive(Debug, Clone, Copy)]
struct Held {
    /// Which elements, and which instants.
    of: (u32, Grid),
    pair: NodePair<OrbitState>,
    cubic: Cubic,
}

impl InterpolatedOrbit {
    /// The orbit with nodes every [`SPACING_S`].
    pub fn new(model: OrbitModel) -> Self {
        Self::with_spacing(model, SPACING_S)
    }

    /// The orbit with nodes every `spacing_s` seconds.
    pub fn with_spacing(model: OrbitModel, spacing_s: NonZeroU16) -> Self {
        let grid = Grid::new(model.epoch(), spacing_s);
        Self { model, grid }
    }

    /// The model at the nodes.
    pub fn model(&self) -> &OrbitModel {
        &self.model
    }

    /// Position and velocity at `now`.
    ///
    /// # Errors
    /// Those of [`OrbitModel::state`], at the node before or after `now`: up to one spacing earlier
    /// than the model itself would fail. The nodes are then left as they were.
    pub fn state(&self, nodes: &mut OrbitNodes, now: Utc) -> Result<OrbitState, sgp4_lite::Error> {
        let (index, u) = self.grid.place(now);
        let of = (self.model.identity(), self.grid);
        let held = nodes.held.filter(|held| held.of == of);
        if let Some(held) = held.filter(|held| held.pair.index == index) {
            return Ok(held.cubic.at(u as f32));
        }
        let pair = NodePair::at(index, held.map(|held| held.pair), |node| {
            self.model.state(self.grid.instant(node))
        })?;
        let cubic = Cubic::between(&pair.left, &pair.right, self.grid.spacing_s());
        nodes.held = Some(Held { of, pair, cubic });
        Ok(cubic.at(u as f32))
    }
}

/// The polynomial of one step. What is added to the node is less than 500 km, so that f32 is good
/// for a few centimetres and does the work in the FPU.
#[derive(Debug, Clone, Copy)]
struct Cubic {
    start: OrbitState,
    /// h v₀, c₂, c₃, m.
    position_m: [Vector3<f32>; 3],
    /// 2 c₂ / h, 3 c₃ / h, m/s.
    velocity_m_s: [Vector3<f32>; 2],
}

impl Cubic {
    fn between(left: &OrbitState, right: &OrbitState, spacing_s: f64) -> Self {
        let (h_v_0, h_v_1) = (left.velocity.xyz * spacing_s, right.velocity.xyz * spacing_s);
        let delta = right.position.xyz - left.position.xyz;
        let c_2 = delta * 3.0 - h_v_0 * 2.0 - h_v_1;
        let c_3 = h_v_0 + h_v_1 - delta * 2.0;
        let (twice, thrice) = (2.0 / spacing_s, 3.0 / spacing_s);
        Self {
            start: *left,
            position_m: [h_v_0.cast(), c_2.cast(), c_3.cast()],
            velocity_m_s: [(c_2 * twice).cast(), (c_3 * thrice).cast()],
        }
    }

    fn at(&self, u: f32) -> OrbitState {
        let [h_v_0, c_2, c_3] = self.position_m;
        let [twice_c_2_by_h, thrice_c_3_by_h] = self.velocity_m_s;
        let moved_m = (h_v_0 + (c_2 + c_3 * u) * u) * u;
        let gained_m_s = (twice_c_2_by_h + thrice_c_3_by_h * u) * u;
        OrbitState {
            position: self.start.position + Vector::from_xyz(moved_m.cast()),
            velocity: self.start.velocity + Vector::from_xyz(gained_m_s.cast()),
        }
    }
}

/// The most by which interpolation between nodes `spacing_s` apart can move the position, m.
///
/// | symbol | argument | meaning |
/// |---|---|---|
/// | h | `spacing_s` | spacing of the nodes, s |
/// | r_p | `perigee_radius_m` | least distance from the Earth's centre, m |
/// | e | `eccentricity` | 0 to 1 |
///
/// A cubic Hermite polynomial departs by at most h⁴/384 · max |r⁗|. On a Kepler orbit the fourth
/// derivative is greatest in the perigee, where r · v = 0 and v² = μ (1 + e) / r_p:
///
/// |r⁗| = μ² (1 + 3 e) / r_p⁵
///
/// 15 % are added for the Earth's flattening (J₂ changes the acceleration by 0.16 % at most, but
/// twice and three times as fast: 0.16 % · 3⁴). A difference δ between velocity and the change of
/// position at the nodes adds at most h δ √3/18, as it is nearly the same at both. Rounding adds
/// half a digit of f32 to each of u, the way since the node and two sums: 2 h v 2⁻²⁴, with v ≤ √(2
/// μ / r_p).
pub fn position_error_bound_m(spacing_s: f64, perigee_radius_m: f64, eccentricity: f64) -> f64 {
    const FLATTENING: f64 = 1.15;
    const SQRT_3_OVER_18: f64 = 0.096_225_044_864_937_63;
    let r_squared = perigee_radius_m * perigee_radius_m;
    let r_to_the_fifth = r_squared * r_squared * perigee_radius_m;
    let fourth_derivative = MU_M3_S2 * MU_M3_S2 * (1.0 + 3.0 * eccentricity) / r_to_the_fifth;
    let h_squared = spacing_s * spacing_s;
    let greatest_speed = libm::sqrt(2.0 * MU_M3_S2 / perigee_radius_m);
    h_squared * h_squared / 384.0 * FLATTENING * fourth_derivative
        + spacing_s * greatest_speed * f64::from(f32::EPSILON)
        + spacing_s * velocity_mismatch_m_s(eccentricity) * SQRT_3_OVER_18
}

fn velocity_mismatch_m_s(eccentricity: f64) -> f64 {
    let [circular, per_eccentricity] = VELOCITY_MISMATCH_M_S;
    circular + per_eccentricity * eccentricity
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::time::MICROS_PER_SECOND;
    use proptest::prelude::*;
    use sgp4_lite::Elements;

    const SPROUT: [&str; 2] = [
        "1 39770U 14029E   15323.12177538  .00004189  00000-0  50368-3 0  9997",
        "2 39770  97.8736  57.8959 0010514  58.6984 301.5230 14.84437654 80617",
    ];

    fn elements() -> Elements {
        Elements::from_tle(SPROUT[0], SPROUT[1]).unwrap()
    }

    fn orbit() -> InterpolatedOrbit {
        InterpolatedOrbit::new(OrbitModel::new(&elements()).unwrap())
    }

    /// Largest difference from SGP4 in position (m) and velocity (m/s) over two days.
    fn worst(elements: &Elements, spacing_s: u16) -> (f64, f64) {
        let model = OrbitModel::new(elements).unwrap();
        let spacing_s = NonZeroU16::new(spacing_s).unwrap();
        let orbit = InterpolatedOrbit::with_spacing(model, spacing_s);
        let mut nodes = OrbitNodes::default();
        let differences = (0..40_000_i64).map(|step| {
            let now = orbit.model().epoch().plus_micros(step * 4_321_987);
            let truth = orbit.model().state(now).unwrap();
            let found = orbit.state(&mut nodes, now).unwrap();
            let position_m = (found.position - truth.position).norm();
            (position_m, (found.velocity - truth.velocity).norm())
        });
        differences.fold((0.0, 0.0), |(r, v): (f64, f64), (dr, dv)| (r.max(dr), v.max(dv)))
    }

    fn with(eccentricity: f64, rev_per_day: f64, inclination_deg: f64) -> Elements {
        let mut elements = elements();
        elements.eccentricity = eccentricity;
        elements.mean_motion_rev_per_day = rev_per_day;
        elements.inclination_deg = inclination_deg;
        elements.bstar_per_earth_radius = 1e-5;
        elements
    }

    #[test]
    fn the_position_is_within_a_metre_in_low_orbits_and_within_the_bound() {
        const BAR_M: f64 = 1.0;
        const BAR_M_S: f64 = 0.15;
        for (eccentricity, rev_per_day, inclination_deg) in [
            (0.001_05, 14.844, 97.87),
            (0.0001, 15.5, 51.64),
            (0.001, 16.0, 28.5),
            (0.001, 15.5, 0.1),
            (0.005, 14.5, 63.4),
        ] {
            let elements = with(eccentricity, rev_per_day, inclination_deg);
            let (position_m, velocity_m_s) = worst(&elements, SPACING_S.get());
            let bound_m = position_error_bound_m(60.0, perigee_radius_m(&elements), eccentricity);
            std::println!(
                "{rev_per_day} rev/day, e {eccentricity}, i {inclination_deg} deg: \
                 {position_m:.2} m (bound {bound_m:.2}), {velocity_m_s:.3} m/s"
            );
            assert!(position_m < BAR_M && position_m < bound_m);
            assert!(velocity_m_s < BAR_M_S);
        }
    }

    fn perigee_radius_m(elements: &Elements) -> f64 {
        let n_rad_s = elements.mean_motion_rev_per_day * core::f64::consts::TAU / 86_400.0;
        // 15 km: the short-period terms of J₂, and mean against osculating axis.
        libm::cbrt(MU_M3_S2 / (n_rad_s * n_rad_s)) * (1.0 - elements.eccentricity) - 15e3
    }

    #[test]
    fn the_bound_holds_at_other_spacings_and_eccentricities_and_is_not_idle() {
        for (eccentricity, rev_per_day, spacing_s) in [
            (0.001, 14.844, 120),
            (0.001, 14.844, 300),
            (0.02, 14.844, 30),
            (0.1, 12.5, 60),
            (0.2, 10.8, 60),
        ] {
            let elements = with(eccentricity, rev_per_day, 97.87);
            let (position_m, _) = worst(&elements, spacing_s);
            let perigee_m = perigee_radius_m(&elements);
            let bound_m = position_error_bound_m(spacing_s.into(), perigee_m, eccentricity);
            assert!(position_m < bound_m, "{position_m} m, bound {bound_m} m");
            assert!(position_m > 0.4 * bound_m, "{position_m} m, bound {bound_m} m");
        }
    }

    #[test]
    fn the_velocity_of_sgp4_fits_its_positions_as_well_as_the_bound_supposes() {
        let mut worst_share = 0.0_f64;
        for eccentricity in [0.0001, 0.001, 0.01, 0.1, 0.2] {
            for inclination_deg in [0.1, 28.5, 63.4, 97.9] {
                let rev_per_day = 15.0 * libm::pow(1.0 - eccentricity, 1.5);
                let model =
                    OrbitModel::new(&with(eccentricity, rev_per_day, inclination_deg)).unwrap();
                for step in 0..1_500 {
                    let now = model.epoch().plus_micros(step * 10 * MICROS_PER_SECOND);
                    let at = |micros| model.state(now.plus_micros(micros)).unwrap().position;
                    // Central differences of the fourth order over 1 s and 2 s.
                    let near = at(500_000) - at(-500_000);
                    let far = at(1_000_000) - at(-1_000_000);
                    let change = near * (4.0 / 3.0) - far * (1.0 / 6.0);
                    let mismatch_m_s = (change - model.state(now).unwrap().velocity).norm();
                    worst_share =
                        worst_share.max(mismatch_m_s / velocity_mismatch_m_s(eccentricity));
                }
            }
        }
        assert!(worst_share < 1.0 && worst_share > 0.8, "{worst_share}");
    }

    #[test]
    fn at_a_node_it_is_sgp4_itself_and_nothing_jumps_there() {
        /// 7.5 km/s over a microsecond, and rounding of 450 km in f32.
        const STEP_M: f64 = 0.1;
        let (orbit, mut nodes) = (orbit(), OrbitNodes::default());
        for node in [-3_i64, 0, 1, 1_000] {
            let now = orbit.model().epoch().plus_micros(60 * MICROS_PER_SECOND * node);
            let at = orbit.state(&mut nodes, now).unwrap();
            assert_eq!(at, orbit.model().state(now).unwrap());
            let before = orbit.state(&mut nodes, now.plus_micros(-1)).unwrap();
            assert!((at.position - before.position).norm() < STEP_M);
        }
    }

    #[test]
    fn nodes_of_other_elements_or_another_spacing_are_not_used() {
        let mut newer = elements();
        newer.mean_anomaly_deg += 1.0;
        let (old, newer) = (orbit(), OrbitModel::new(&newer).unwrap());
        let wider =
            InterpolatedOrbit::with_spacing(old.model().clone(), SPACING_S.saturating_add(60));
        for other in [InterpolatedOrbit::new(newer), wider] {
            let mut nodes = OrbitNodes::default();
            let now = old.model().epoch().plus_micros(12_345_678);
            old.state(&mut nodes, now).unwrap();
            let mixed = other.state(&mut nodes, now).unwrap();
            assert_eq!(mixed, other.state(&mut OrbitNodes::default(), now).unwrap());
        }
    }

    #[test]
    fn an_orbit_that_decays_is_an_error_and_comes_back_when_time_does() {
        let mut decaying = elements();
        decaying.mean_motion_rev_per_day = 16.4;
        decaying.bstar_per_earth_radius = 0.05;
        let orbit = InterpolatedOrbit::new(OrbitModel::new(&decaying).unwrap());
        let mut nodes = OrbitNodes::default();
        let epoch = orbit.model().epoch();
        let first = orbit.state(&mut nodes, epoch).unwrap();
        let late = epoch.plus_micros(90 * crate::time::MICROS_PER_DAY);
        assert!(orbit.state(&mut nodes, late).is_err());
        assert_eq!(orbit.state(&mut nodes, epoch), Ok(first));
    }

    proptest! {
        #[test]
        fn the_state_does_not_depend_on_what_was_asked_before(
            minutes in prop::collection::vec(-3_000_i64..3_000, 1..20),
            seconds in 0.0..60.0_f64,
        ) {
            let (orbit, mut nodes) = (orbit(), OrbitNodes::default());
            for minute in minutes {
                let micros = minute * 60 * MICROS_PER_SECOND + (seconds * 1e6) as i64;
                let now = orbit.model().epoch().plus_micros(micros);
                let fresh = orbit.state(&mut OrbitNodes::default(), now).unwrap();
                prop_assert_eq!(orbit.state(&mut nodes, now).unwrap(), fresh);
            }
        }
    }
}
