//! The periodic optimal law: an attitude held with magnets alone, planned with the field that is to come.
//!
//! Magnets give no torque about the field, but the field turns: what cannot be done now can be done a
//! quarter of an orbit later. The cross-product law does not know that and must stay slower than the field
//! turns. This law looks ahead. With the error x = (e, ω_e) in the axes of the target,
//!
//! ```text
//! ė   = ω_e
//! ω̇_e = −ω_t × ω_e + V(t) m + J⁻¹ d,   V = −J⁻¹ [B(t) ×]
//! ```
//!
//! it minimises ∫ |e|²/e₀² + |ω_e|²/ω₀² + |m|²/m₀² dt over the next one and a half to two orbits, with the
//! field that SGP4 and IGRF predict. The solution is a backward sweep of the Riccati equation; what the
//! cycle needs of it are a few numbers for each minute or two:
//!
//! ```text
//! m = −(1/m₀² + h Vᵀ P₂₂ V)⁻¹ Vᵀ (P₂₁ e + P₂₂ ω_e + W₂ d)
//! ```
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | e, ω_e | [`Motion`] | twice the vector part of the error quaternion, and the rate of Body relative to the target; both in the target's axes |
//! | ω_t | [`Ahead::omega_t`] | rate of the target against Eci, in its own axes, rad/s |
//! | B | [`Ahead::field`] | flux density in the target's axes, T |
//! | J | `inertia_kg_m2` | inertia tensor, kg·m², as if Body were on target |
//! | d | | torque that is known: estimated and from models, in the target's axes, N·m |
//! | P, W | [`Gains`] | cost to go: xᵀ P x + 2 xᵀ W d |
//! | h | `round_s` | how long a command stands, s |
//!
//! **Why in the target's axes.** For a body whose moments are nearly equal, ω̇_e above has no other terms
//! at any attitude: the body may be upside down and the equations are still linear. One law takes the
//! satellite from any attitude and holds it. What unequal moments add on target (gyroscopic and gravity
//! gradient) comes in through d.
//!
//! | file | what |
//! |---|---|
//! | `model` | one step of the linear equations: Φ, Γ, Γ_d |
//! | `sweep` | one step of the Riccati equation, backwards |
//! | `plan` | the sweep in slices, and the gains of the last good one |
//! | `law` | from the gains to a dipole |
//! | `parameters` | weights, steps, inertia |
//!
//! Source: Wisniewski & Markley (1999), IFAC World Congress, "Optimal magnetic attitude control" (the
//! periodic Riccati equation for magnetic actuation); Anderson & Moore (1990), §2.4 and §4.3 (discrete
//! regulator, known disturbances).

mod law;
mod model;
mod parameters;
mod plan;
mod sweep;

pub use self::law::{Motion, PeriodicLaw};
pub use self::model::Ahead;
pub use self::parameters::{PeriodicError, PeriodicParameters};
pub use self::plan::{NODES, Plan, PlanStatus};
pub use self::sweep::Gains;
