//! What is flown, and what the filters are told wrongly.

/// How the satellite moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// From a tumble of 5 to 9.5 deg/s, despun by B-dot from the raw sensors.
    Tumble,
    /// In the Orbit frame, held there by a cross-product law that is fed the truth.
    Nadir(PointingGains),
}

/// Gains of the cross-product law of the nadir scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointingGains {
    /// N·m/rad.
    pub stiffness: f64,
    /// N·m·s/rad.
    pub damping: f64,
}

impl PointingGains {
    /// A stiff loop: the magnetic torques keep the body moving at 0.17 deg/s on average, as in the
    /// independent study (0.19 deg/s).
    pub const STIFF: Self = Self { stiffness: 3e-6, damping: 5e-4 };

    /// A soft loop, below what makes a magnetic loop unstable (2e-7 to 3e-7 N·m/rad): 0.08 deg/s, little
    /// more than the orbit's own. Hardly anything then ties the angle about the field to the rate.
    pub const SOFT: Self = Self { stiffness: 1.2e-7, damping: 1.5e-4 };
}

/// One set of flights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scene {
    /// How the satellite moves.
    pub motion: Motion,
    /// σ of the torque that nobody models, each axis, N·m.
    pub torque_n_m: f64,
    /// Its correlation time, s.
    pub correlation_s: f64,
    /// How wrong the filters' inertia is: each moment by this share of itself, each product by this
    /// share of the mean moment, signs at random.
    pub inertia_error: f64,
    /// What the residual dipole changes by in eclipse, each axis, signs at random, A·m².
    pub dipole_jump_am2: f64,
    /// How long, orbits.
    pub orbits: f64,
}

impl Scene {
    /// The paper's noise and an unmodelled torque of 3e-8 N·m over 300 s, inertia 5 % wrong, 2 orbits.
    pub const fn of(motion: Motion) -> Self {
        Self {
            motion,
            torque_n_m: 3e-8,
            correlation_s: 300.0,
            inertia_error: 0.05,
            dipole_jump_am2: 0.0,
            orbits: 2.0,
        }
    }
}
