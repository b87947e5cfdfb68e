//! How small errors grow over a step of the plant: Φ to third order.
//!
//! For the errors θ (attitude), δω (rate) and those of the constants, frozen in the middle of the step,
//! which is right to second order where its start would be to first, with b = A B, r = A r̂, d = m + M, g = 3μ/r³:
//!
//! | derivative | equation |
//! |---|---|
//! | θ̇ by θ, by δω | −[ω×], I |
//! | δω̇ by θ | J⁻¹ ([d×][b×] + g ([r×]J − [Jr×]) [r×]) |
//! | δω̇ by δω | J⁻¹ ([Jω×] − [ω×]J) |
//! | δω̇ by M; by Sᵢ, of which the share sᵢ acts | −J⁻¹ [b×]; sᵢ times that |
//! | δω̇ by T | J⁻¹ |
//! | δω̇ by the parameters p of J | J⁻¹ (g [r×] N(r) − [ω×] N(ω) − N(ω̇)), N(v) p = (∂J/∂p p) v |
//!
//! With S = h ∂(θ̇, δω̇)/∂(θ, δω): Φ = I + S + S²/2 + S³/6 for attitude and rate, and
//! Γ = h (I + S/2 + S²/6) times the column for a constant.

use nalgebra::{Matrix3, Matrix6, RealField, Vector3, convert};

use super::block::{Block, Blocks, COUNT, TORQUE_UNIT_N_M};
use super::covariance::Transition;
use super::plant::{Motion, Plant, Surroundings};

/// N(v) of the moments: diag(v) times the mean moment.
fn by_moments<T: RealField + Copy>(v: &Vector3<T>, mean_moment: T) -> Matrix3<T> {
    Matrix3::from_diagonal(&(v * mean_moment))
}

/// N(v) of the products xy, xz, yz, times the mean moment.
#[rustfmt::skip]
fn by_products<T: RealField + Copy>(v: &Vector3<T>, mean_moment: T) -> Matrix3<T> {
    let zero = T::zero();
    Matrix3::new(
        v.y,  v.z,  zero,
        v.x,  zero, v.z,
        zero, v.x,  v.y,
    ) * mean_moment
}

/// The tensor that six parameters add to the given one.
#[rustfmt::skip]
pub(super) fn tensor_of<T: RealField + Copy>(
    moments: &Vector3<T>,
    products: &Vector3<T>,
    mean_moment: T,
) -> Matrix3<T> {
    Matrix3::new(
        moments.x,  products.x, products.y,
        products.x, moments.y,  products.z,
        products.y, products.z, moments.z,
    ) * mean_moment
}

/// Φ of a step of `dt_s` with `motion` in its middle.
pub(super) fn transition<T: RealField + Copy>(
    plant: &Plant<'_, T>,
    motion: &Motion<T>,
    mean_moment: T,
    blocks: Blocks,
    dt_s: T,
) -> Transition<T> {
    let Surroundings { field, up, gradient } = plant.surroundings;
    let (tensor, inverse) = (&plant.inertia.tensor, &plant.inertia.inverse);
    let omega = &motion.omega;
    let q = motion.r_bi.hamilton();
    let (b, r) = ((q * field).cross_matrix(), q * up);
    let (dipole_x, omega_x, r_x) =
        (plant.torques.dipole.cross_matrix(), omega.cross_matrix(), r.cross_matrix());

    let of_gradient = (r_x * tensor - (tensor * r).cross_matrix()) * r_x * *gradient;
    let rate_by_attitude = inverse * (dipole_x * b + of_gradient);
    let rate_by_rate = inverse * ((tensor * omega).cross_matrix() - omega_x * tensor);

    let mut s = Matrix6::zeros();
    s.fixed_view_mut::<3, 3>(0, 0).copy_from(&(omega_x * -dt_s));
    s.fixed_view_mut::<3, 3>(0, 3).copy_from(&Matrix3::from_diagonal_element(dt_s));
    s.fixed_view_mut::<3, 3>(3, 0).copy_from(&(rate_by_attitude * dt_s));
    s.fixed_view_mut::<3, 3>(3, 3).copy_from(&(rate_by_rate * dt_s));
    let square = s * s;
    let (half, sixth): (T, T) = (convert(0.5), convert(1.0 / 6.0));
    let phi = Matrix6::identity() + s + square * half + s * square * sixth;
    let gamma = (Matrix6::identity() + s * half + square * sixth) * dt_s;
    let [phi_aa, phi_ar, phi_ra, phi_rr] = quarters(&phi);
    let [_, gamma_ar, _, gamma_rr] = quarters(&gamma);

    let mut transition = Transition { attitude: [None; COUNT], rate: [None; COUNT] };
    let mut set = |block: Block, attitude: Matrix3<T>, rate: Matrix3<T>| {
        if let (Some(to_attitude), Some(to_rate)) =
            (transition.attitude.get_mut(block as usize), transition.rate.get_mut(block as usize))
        {
            (*to_attitude, *to_rate) = (Some(attitude), Some(rate));
        }
    };
    set(Block::Attitude, phi_aa, phi_ra);
    set(Block::Rate, phi_ar, phi_rr);
    let mut set_constant = |block: Block, rate_by_it: Matrix3<T>| {
        set(block, gamma_ar * rate_by_it, gamma_rr * rate_by_it);
    };
    set_constant(Block::Dipole, inverse * -b);
    if blocks.shadow {
        let [soon, late] = plant.torques.shadow;
        set_constant(Block::ShadowSoon, inverse * b * -soon);
        set_constant(Block::ShadowLate, inverse * b * -late);
    }
    if blocks.torque {
        set_constant(Block::Torque, inverse * convert::<f64, T>(TORQUE_UNIT_N_M));
    }
    if blocks.inertia {
        let omega_dot = plant.acceleration(&q.into_inner(), omega);
        let by = |n: fn(&Vector3<T>, T) -> Matrix3<T>| {
            inverse
                * (r_x * n(&r, mean_moment) * *gradient
                    - omega_x * n(omega, mean_moment)
                    - n(&omega_dot, mean_moment))
        };
        set_constant(Block::Moments, by(by_moments));
        set_constant(Block::Products, by(by_products));
    }
    transition
}

fn quarters<T: RealField + Copy>(m: &Matrix6<T>) -> [Matrix3<T>; 4] {
    [(0, 0), (0, 3), (3, 0), (3, 3)]
        .map(|(row, column)| m.fixed_view::<3, 3>(row, column).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::attitude::dynamic::plant::{Inertia, Torques};
    use crate::frames::Rotation;
    use nalgebra::{SVector, UnitQuaternion, Vector6};

    type Errors = SVector<f64, { 3 * COUNT }>;

    const SHADOW: [f64; 2] = [0.8, 0.3];
    const BLOCKS: Blocks = Blocks::ALL;
    const TENSOR: Matrix3<f64> =
        Matrix3::new(0.052, 6e-4, -8e-4, 6e-4, 0.054, 7e-4, -8e-4, 7e-4, 0.060);
    const MEAN_MOMENT: f64 = 0.0553;
    /// What the dipole below gives in the field below, at most, rad/s².
    const ACCELERATION: f64 = 6e-4;
    /// Largest difference of two moments of inertia over the third.
    const ASYMMETRY: f64 = 0.17;
    /// A hundred times what is there at 660 km, so that it counts beside the dipole.
    const GRADIENT: f64 = 100.0 * 3.4e-6;

    /// Attitudes (scaled axis) and rates, from rest to 0.16 rad/s, nine degrees per second.
    fn motions() -> [Motion<f64>; 4] {
        [
            ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
            ([0.3, -0.8, 1.2], [0.002, -0.003, 0.001]),
            ([-2.0, 0.4, 0.7], [0.06, 0.03, -0.14]),
            ([1.0, 1.1, -2.2], [-0.10, 0.12, 0.04]),
        ]
        .map(|(axis, omega)| Motion {
            r_bi: Rotation::from_hamilton(UnitQuaternion::from_scaled_axis(Vector3::from(axis))),
            omega: Vector3::from(omega),
        })
    }

    fn triple(errors: &Errors, block: Block) -> Vector3<f64> {
        errors.fixed_rows::<3>(3 * block as usize).into_owned()
    }

    fn surroundings() -> Surroundings<f64> {
        Surroundings {
            field: Vector3::new(1.8e-5, -2.9e-5, 2.2e-5),
            up: Vector3::new(0.48, -0.6, 0.64),
            gradient: GRADIENT,
        }
    }

    fn torques(errors: &Errors) -> Torques<f64> {
        let torque = Vector3::new(0.2, 0.1, -0.3) + triple(errors, Block::Torque);
        let of_shadow = triple(errors, Block::ShadowSoon) * SHADOW[0]
            + triple(errors, Block::ShadowLate) * SHADOW[1];
        Torques {
            dipole: Vector3::new(0.3, -0.5, 0.4) + triple(errors, Block::Dipole) + of_shadow,
            shadow: SHADOW,
            torque: torque * TORQUE_UNIT_N_M,
        }
    }

    /// The motion after the step when the states were wrong by `errors` before it.
    fn stepped(motion: &Motion<f64>, errors: &Errors, dt_s: f64) -> Motion<f64> {
        let of = |block| triple(errors, block);
        let more = tensor_of(&of(Block::Moments), &of(Block::Products), MEAN_MOMENT);
        let plant = Plant {
            inertia: &Inertia::new(TENSOR + more).unwrap(),
            surroundings: &surroundings(),
            torques: &torques(errors),
        };
        let turn = UnitQuaternion::from_scaled_axis(-of(Block::Attitude));
        let start = Motion {
            r_bi: Rotation::from_hamilton(turn * motion.r_bi.hamilton()),
            omega: motion.omega + of(Block::Rate),
        };
        plant.stepped(&start, dt_s)
    }

    /// (θ, δω) of `truth` beside `estimate`.
    fn error(truth: &Motion<f64>, estimate: &Motion<f64>) -> Vector6<f64> {
        let theta = -(truth.r_bi * estimate.r_bi.inverse()).hamilton().scaled_axis();
        let mut both = Vector6::zeros();
        both.fixed_rows_mut::<3>(0).copy_from(&theta);
        both.fixed_rows_mut::<3>(3).copy_from(&(truth.omega - estimate.omega));
        both
    }

    /// One triple's columns of Φ, by central differences of the plant's own step.
    fn numerical(motion: &Motion<f64>, block: Block, dt_s: f64) -> [Matrix3<f64>; 2] {
        // Leaves 1e-8 of the third derivative, and 1e-9 of rounding in the smallest columns.
        const STEP: f64 = 1e-4;
        let estimate = stepped(motion, &Errors::zeros(), dt_s);
        let mut columns = [Matrix3::zeros(); 2];
        for axis in 0..3 {
            let mut errors = Errors::zeros();
            errors[3 * block as usize + axis] = STEP;
            let plus = error(&stepped(motion, &errors, dt_s), &estimate);
            let minus = error(&stepped(motion, &-errors, dt_s), &estimate);
            let slope = (plus - minus) / (2.0 * STEP);
            columns[0].set_column(axis, &slope.fixed_rows::<3>(0));
            columns[1].set_column(axis, &slope.fixed_rows::<3>(3));
        }
        columns
    }

    fn analytic(motion: &Motion<f64>, dt_s: f64) -> Transition<f64> {
        let nothing = Errors::zeros();
        let midway = motion.midway(&stepped(motion, &nothing, dt_s));
        let plant = Plant {
            inertia: &Inertia::new(TENSOR).unwrap(),
            surroundings: &surroundings(),
            torques: &torques(&nothing),
        };
        transition(&plant, &midway, MEAN_MOMENT, BLOCKS, dt_s)
    }

    #[test]
    fn phi_is_the_numerical_jacobian_of_the_step() {
        for motion in motions() {
            for dt_s in [0.5, 0.05] {
                let phi = analytic(&motion, dt_s);
                // What a step turns by: every error of Φ is a power of it. The thousandth is for what
                // torques do to a satellite at rest.
                let a = motion.omega.norm() * dt_s + 1e-3;
                // What the middle of the step leaves when the rate changes.
                let acceleration = ACCELERATION + ASYMMETRY * motion.omega.norm_squared();
                let middle = acceleration * dt_s * dt_s / 12.0;
                // A torque is seen as constant over the step in Body, which leaves a²/4 of the rate
                // that it gives, and of its share of the turn a/3.
                let third = a * a * a / 6.0 + middle;
                let (second, first) = (a * a / 4.0 + middle, a / 3.0);
                for block in Block::ALL
                    .into_iter()
                    .filter(|block| !matches!(block, Block::Bias | Block::FieldBias))
                {
                    let (of_attitude, of_rate) = match block {
                        Block::Attitude => (third, second),
                        Block::Rate => (third, third),
                        _ => (first, second),
                    };
                    let found = [phi.attitude, phi.rate].map(|row| row[block as usize].unwrap());
                    let expected = numerical(&motion, block, dt_s);
                    for (row, share) in [of_attitude, of_rate].into_iter().enumerate() {
                        let difference = (found[row] - expected[row]).norm();
                        let tolerance = share * expected[row].norm() + 1e-9;
                        assert!(difference < tolerance, "{block:?} {row} {dt_s} {motion:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_does_not_fly_moves_nothing() {
        let motion = motions()[2];
        for (inertia, torque) in [(false, false), (true, false), (false, true)] {
            let blocks = Blocks { inertia, torque, ..Blocks::NONE };
            let plant = Plant {
                inertia: &Inertia::new(TENSOR).unwrap(),
                surroundings: &surroundings(),
                torques: &torques(&Errors::zeros()),
            };
            let phi = transition(&plant, &motion, MEAN_MOMENT, blocks, 0.5);
            for row in [phi.attitude, phi.rate] {
                assert_eq!(row[Block::Moments as usize].is_some(), inertia);
                assert_eq!(row[Block::Products as usize].is_some(), inertia);
                assert_eq!(row[Block::Torque as usize].is_some(), torque);
                assert!(row[Block::Bias as usize].is_none(), "the bias is the gyro's alone");
            }
        }
    }
}
