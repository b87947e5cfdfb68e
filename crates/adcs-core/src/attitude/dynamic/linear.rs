//! How small errors grow over a step of the plant: Φ to third order.
//!
//! For the errors θ (attitude), δω (rate) and those of the constants, frozen at the start of the step,
//! with b = A B, r = A r̂, d = m + M, g = 3μ/r³:
//!
//! | derivative | equation |
//! |---|---|
//! | θ̇ by θ, by δω | −[ω×], I |
//! | δω̇ by θ | J⁻¹ ([d×][b×] + g ([r×]J − [Jr×]) [r×]) |
//! | δω̇ by δω | J⁻¹ ([Jω×] − [ω×]J) |
//! | δω̇ by M | −J⁻¹ [b×] |
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

/// Φ of a step of `dt_s` from `motion`.
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
        if let (Some(to_attitude), Some(to_rate)) = (
            transition.attitude.get_mut(block as usize),
            transition.rate.get_mut(block as usize),
        ) {
            (*to_attitude, *to_rate) = (Some(attitude), Some(rate));
        }
    };
    set(Block::Attitude, phi_aa, phi_ra);
    set(Block::Rate, phi_ar, phi_rr);
    let mut set_constant = |block: Block, rate_by_it: Matrix3<T>| {
        set(block, gamma_ar * rate_by_it, gamma_rr * rate_by_it);
    };
    set_constant(Block::Dipole, inverse * -b);
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
