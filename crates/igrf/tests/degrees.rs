//! Every degree against a plain evaluation: closed-form Legendre polynomials, angles, and the
//! official file read here a second time.

use igrf::{Coefficients, DecimalYear, Error, HIGHEST_DEGREE, REFERENCE_RADIUS_KM};

/// nT. Both sides work in f64; the closed form loses three digits by cancellation in degree 13.
const TOLERANCE_NT: f64 = 1e-7;

/// Gauss coefficients g[n][m], h[n][m] of one date.
struct Gauss {
    g: [[f64; 14]; 14],
    h: [[f64; 14]; 14],
}

impl Gauss {
    fn at(year: f64) -> Self {
        let mut gauss = Self { g: [[0.0; 14]; 14], h: [[0.0; 14]; 14] };
        for line in include_str!("../data/igrf14coeffs.txt").lines().skip(4) {
            let fields: Vec<_> = line.split_whitespace().collect();
            let (n, m): (usize, usize) = (fields[1].parse().unwrap(), fields[2].parse().unwrap());
            let values: Vec<f64> = fields[3..].iter().map(|field| field.parse().unwrap()).collect();
            let node = (((year - 1900.0) / 5.0) as usize).min(25);
            let years = year - 1900.0 - 5.0 * node as f64;
            let rate =
                if node == 25 { values[26] } else { (values[node + 1] - values[node]) / 5.0 };
            let target = if fields[0] == "g" { &mut gauss.g } else { &mut gauss.h };
            target[n][m] = values[node] + rate * years;
        }
        gauss
    }

    /// B_r, B_θ, B_φ by the textbook sums (Alken et al. 2021, eq. 1, differentiated).
    fn field_nt(&self, degree: usize, r_km: f64, theta: f64, phi: f64) -> [f64; 3] {
        let mut field = [0.0; 3];
        for n in 1..=degree {
            let scale = (REFERENCE_RADIUS_KM / r_km).powi(n as i32 + 2);
            for m in 0..=n {
                let (sin, cos) = (m as f64 * phi).sin_cos();
                let along = self.g[n][m] * cos + self.h[n][m] * sin;
                let across = self.h[n][m] * cos - self.g[n][m] * sin;
                let (p, dp_dtheta) = schmidt_legendre(n, m, theta);
                field[0] += scale * (n + 1) as f64 * along * p;
                field[1] -= scale * along * dp_dtheta;
                field[2] -= scale * m as f64 * across * p / theta.sin();
            }
        }
        field
    }
}

/// Schmidt semi-normalised P_n^m(cos θ) and its derivative by θ, from
/// P_n(u) = 2⁻ⁿ Σ_k (−1)^k C(n,k) C(2n−2k,n) uⁿ⁻²ᵏ.
fn schmidt_legendre(n: usize, m: usize, theta: f64) -> (f64, f64) {
    let (sin, cos) = theta.sin_cos();
    // The `order`-th derivative of P_n.
    let derivative = |order: usize| -> f64 {
        (0..=n / 2)
            .filter(|k| n - 2 * k >= order)
            .map(|k| {
                let power = n - 2 * k;
                let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
                sign * binomial(n, k) * binomial(2 * n - 2 * k, n) / (1u64 << n) as f64
                    * falling(power, order)
                    * cos.powi((power - order) as i32)
            })
            .sum()
    };
    let both = if m == 0 { 1.0 } else { 2.0 };
    let norm = (both / falling(n + m, 2 * m)).sqrt();
    let p = sin.powi(m as i32) * derivative(m);
    let by_sine = if m == 0 { 0.0 } else { m as f64 * sin.powi(m as i32 - 1) * cos };
    let dp = by_sine * derivative(m) - sin.powi(m as i32 + 1) * derivative(m + 1);
    (norm * p, norm * dp)
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |product, i| product * (n - i) as f64 / (i + 1) as f64)
}

/// n (n−1) … , `count` factors.
fn falling(n: usize, count: usize) -> f64 {
    (0..count).map(|i| (n - i) as f64).product()
}

#[test]
fn every_degree_is_the_textbook_sum() {
    for year in [2011.3, 2015.88, 2023.0, 2025.0, 2029.9] {
        let gauss = Gauss::at(year);
        let full = Coefficients::<f64>::at(DecimalYear(year)).unwrap();
        for degree in 1..=HIGHEST_DEGREE {
            let coefficients = full.with_degree(degree).unwrap();
            for step in 0..24 {
                let theta: f64 = 0.05 + 0.127 * f64::from(step);
                let phi = -3.0 + 1.9 * f64::from(step);
                let r_km = 6_371.2 + 97.0 * f64::from(step);
                let expected = gauss.field_nt(degree.into(), r_km, theta, phi);
                let position = igrf::GeocentricPosition {
                    radius_km: r_km,
                    colatitude_rad: theta,
                    longitude_rad: phi,
                };
                let field = coefficients.field_geocentric_nt(position).unwrap();
                let found = [field.radial_nt, field.theta_nt, field.phi_nt];
                for (found, expected) in found.into_iter().zip(expected) {
                    assert!(
                        (found - expected).abs() <= TOLERANCE_NT,
                        "{year}, degree {degree}, point {step}: {found} instead of {expected}"
                    );
                }
            }
        }
    }
}

#[test]
fn degree_one_is_a_dipole() {
    let gauss = Gauss::at(2020.0);
    let dipole = Coefficients::<f64>::at(DecimalYear(2020.0)).unwrap().with_degree(1).unwrap();
    // Over the north pole a dipole's field is vertical: B_z = 2 g(1,0) (a/r)³.
    let [x, y, z] = dipole.field_ecef_nt([0.0, 0.0, REFERENCE_RADIUS_KM]).unwrap();
    assert!((z - 2.0 * gauss.g[1][0]).abs() <= TOLERANCE_NT);
    assert!((x + gauss.g[1][1]).abs() <= TOLERANCE_NT);
    assert!((y + gauss.h[1][1]).abs() <= TOLERANCE_NT);
}

#[test]
fn degrees_beyond_the_model_are_refused() {
    let coefficients = Coefficients::<f32>::at(DecimalYear(2020.0)).unwrap();
    for requested in [0, 14, 255] {
        assert_eq!(
            coefficients.with_degree(requested),
            Err(Error::Degree { requested, highest: 13 })
        );
    }
    let eight = coefficients.with_degree(8).unwrap();
    assert_eq!(eight.degree(), 8);
    assert_eq!(eight.with_degree(9), Err(Error::Degree { requested: 9, highest: 8 }));
}
