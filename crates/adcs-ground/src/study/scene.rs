//! What is flown, and what the filters are told wrongly.

/// How the satellite moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// From a tumble of 5 to 9.5 deg/s, despun by B-dot from the raw sensors.
    Tumble,
    /// In the Orbit frame, held there by a cross-product law that is fed the truth.
    Nadir(PointingGains),
}

/// Gains of the cross-product law of the nadir scenes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointingGains {
    /// N·m/rad.
    pub stiffness: f64,
    /// N·m·s/rad.
    pub damping: f64,
}

impl PointingGains {
    /// Below what makes a magnetic loop unstable (2e-7 to 3e-7 N·m/rad): the body turns by little more
    /// than the orbit's own rate, 0.08 deg/s, and hardly anything ties the angle about the field to it.
    pub const SOFT: Self = Self { stiffness: 1.2e-7, damping: 1.5e-4 };

    /// So stiff that the loop keeps the body moving, by 0.17 deg/s on average.
    pub const STIFF: Self = Self { stiffness: 3e-6, damping: 5e-4 };
}

/// One set of flights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scene {
    /// What it is called on the command line.
    pub name: &'static str,
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

const SOFT: Motion = Motion::Nadir(PointingGains::SOFT);
const STIFF: Motion = Motion::Nadir(PointingGains::STIFF);

impl Scene {
    /// The paper's noise and an unmodelled torque of 3e-8 N·m over 300 s, inertia 5 % wrong, 2 orbits.
    const fn of(name: &'static str, motion: Motion) -> Self {
        Self {
            name,
            motion,
            torque_n_m: 3e-8,
            correlation_s: 300.0,
            inertia_error: 0.05,
            dipole_jump_am2: 0.0,
            orbits: 2.0,
        }
    }

    /// All scenes.
    pub const ALL: [Self; 9] = [
        Self::of("tumble", Motion::Tumble),
        Self::of("nadir", SOFT),
        Self::of("nadir-stiff", STIFF),
        Self { torque_n_m: 3e-7, ..Self::of("tumble-torque", Motion::Tumble) },
        Self { torque_n_m: 3e-7, ..Self::of("nadir-torque", SOFT) },
        Self { dipole_jump_am2: 0.03, ..Self::of("tumble-dipole", Motion::Tumble) },
        Self { dipole_jump_am2: 0.03, ..Self::of("nadir-dipole", SOFT) },
        Self { inertia_error: 0.10, ..Self::of("tumble-inertia", Motion::Tumble) },
        Self { inertia_error: 0.10, ..Self::of("nadir-inertia", SOFT) },
    ];

    /// The scene of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|scene| scene.name == name)
    }

    /// What is special about it, in words.
    pub fn story(&self) -> String {
        let motion = match self.motion {
            Motion::Tumble => "B-dot from 5 to 9.5 deg/s",
            Motion::Nadir(PointingGains::SOFT) => "nadir, soft law on the truth",
            Motion::Nadir(_) => "nadir, stiff law on the truth",
        };
        let torque = format!("unknown torque {:.0e} N m", self.torque_n_m);
        let inertia = format!("inertia {:.0} % wrong", 100.0 * self.inertia_error);
        let jump = if self.dipole_jump_am2 == 0.0 {
            String::new()
        } else {
            format!(", dipole jumps by {} A m2 in eclipse", self.dipole_jump_am2)
        };
        format!("{motion}; {torque}, {inertia}{jump}")
    }
}
