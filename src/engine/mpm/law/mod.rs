//! Constitutive laws of material points: the new stress from the old stress, a strain increment and the internal variables. Functions of plain values, without
//! arrays and files. Inside the laws tension is positive; output files have compression positive.
//!
//! Results come from + - * / and square roots alone, in the order in which they are written, so that they have the same bits on every machine.

use serde::{Deserialize, Serialize};

mod cam_clay;
mod cone;
pub mod dilatancy;
mod drucker_prager;
mod elastic;
mod evolution;
mod gap;
mod mohr_coulomb;
mod parameters;
mod registry;
mod surface;
pub mod tensor;
#[cfg(test)]
pub mod tests;

pub use cam_clay::CamClay;
pub use cone::Cone;
pub use drucker_prager::DruckerPrager;
pub use elastic::Elastic;
pub use evolution::Evolution;
pub use mohr_coulomb::MohrCoulomb;
pub use parameters::{Clay, Dilation, Parameters, Shear};
pub use registry::Law;
pub(crate) use registry::with_law;
pub use surface::YieldParameters;

/// Symmetric tensor of stress, Pa, or strain, -: components xx, yy, zz, xy, yz, zx, tension positive. Shear strains are those of the tensor, half the engineering
/// ones.
pub type Sym = [f64; 6];

/// The internal variables of a material point: what a law keeps from step to step besides the stress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InternalVariables {
    /// Accumulated plastic strain, -: the integral of sqrt(2/3 de_p:de_p), with volumetric and deviatoric plastic strain increments de_p. In Modified Cam-clay, whose
    /// hardening follows volume alone: the plastic compression of volume, which falls where the soil dilates ([`ConstitutiveLaw::PLASTIC_FALLS`]).
    pub plastic: f64,
    /// Opening of the gap in soil that was pulled apart: the volume strain since the soil no longer follows it, -, not negative.
    pub gap: f64,
}

/// A constitutive law.
///
/// # Example
/// A soil with the friction angle 30° and no cohesion is compressed axially at a constant cell pressure of 100 kPa, as in a
/// drained triaxial test. It fails at three times the cell pressure, (1 + sin φ)/(1 − sin φ).
///
/// ```
/// use comminute_engine::mpm::law::{Elastic, Evolution, InternalVariables, Law, MohrCoulomb, Parameters};
///
/// let law = Law::MohrCoulomb(MohrCoulomb::from(Parameters {
///     friction: Evolution::Constant(30_f64.to_radians()),
///     ..Parameters::of_elastic(Elastic::of_young(20e6, 0.3)) // Pa, -
/// }));
/// let cell = -100e3; // tension is positive
/// let (mut stress, mut internal) = ([cell, cell, cell, 0.0, 0.0, 0.0], InternalVariables::default());
/// for _ in 0..300 {
///     // the lateral strain at which the lateral stress stays, by bisection
///     let axial = -1e-4;
///     let after = |lateral: f64| law.update(stress, [lateral, lateral, axial, 0.0, 0.0, 0.0], internal);
///     let (mut low, mut high) = (0.0, -2.0 * axial);
///     for _ in 0..60 {
///         let middle = 0.5 * (low + high);
///         // wider means less lateral pressure
///         if after(middle).0[0] < cell { low = middle } else { high = middle }
///     }
///     (stress, internal) = after(0.5 * (low + high));
/// }
/// assert!((stress[2] / stress[0] - 3.0).abs() < 1e-6, "{stress:?}");
/// assert!(internal.plastic > 0.0);
/// ```
pub trait ConstitutiveLaw: Sized {
    /// Keys, without units, that the law reads from the table `[continuum]` of a material besides `law` and the moduli. All but `tension` and the evolutions are
    /// required.
    const KEYS: &'static [&'static str];

    /// Whether [`InternalVariables::plastic`] may fall and be negative: it is then no accumulated strain.
    const PLASTIC_FALLS: bool = false;

    /// Whether the elastic moduli depend on the stress ([`ConstitutiveLaw::stiffness`]).
    const STIFFENS: bool = false;

    /// The law with these parameters; it reads those of its keys.
    fn of(parameters: &Parameters) -> Self;

    /// Stress, Pa, and internal variables after the strain increment `dstrain`. `stress`, Pa, is that before, already rotated with the material
    /// ([`crate::mpm::rotate_jaumann`]).
    #[inline]
    fn update(&self, stress: Sym, dstrain: Sym, internal: InternalVariables) -> (Sym, InternalVariables) {
        if internal.gap > 0.0 {
            return gap::update_open(self, stress, dstrain, internal);
        }
        self.update_closed(stress, dstrain, internal)
    }

    /// The same for soil without a gap, or with one that its tension opens further: what the soil does not follow is added to the gap.
    fn update_closed(&self, stress: Sym, dstrain: Sym, internal: InternalVariables) -> (Sym, InternalVariables);

    /// The elastic part of the law; where it depends on the stress, at a stress of the law's own that its documentation names.
    fn elastic(&self) -> Elastic;

    /// Elastic moduli at a stress, Pa, and internal variables: no tangent of the law there is stiffer.
    fn stiffness(&self, _stress: &Sym, _internal: InternalVariables) -> Elastic {
        self.elastic()
    }

    /// Elastic energy per volume, J/m³, stored at a stress, Pa, and internal variables.
    fn elastic_energy(&self, stress: &Sym, _internal: InternalVariables) -> f64 {
        self.elastic().energy(stress)
    }

    /// Where the cone of failure touches the Mohr-Coulomb pyramid; `None` for laws without a cone.
    fn cone(&self) -> Option<Cone> {
        None
    }

    /// Friction angle, rad, and cohesion, Pa, at an accumulated plastic strain; `None` for laws that do not yield.
    fn shear_strength(&self, _plastic: f64) -> Option<[f64; 2]> {
        None
    }

    /// The line of failure in triaxial compression at an accumulated plastic strain; `None` for laws that do not yield.
    fn yield_line(&self, _plastic: f64) -> Option<YieldParameters> {
        None
    }

    /// Deviatoric stress q at failure in triaxial compression, Pa: axial less radial stress, compression positive. `cell`: cell pressure, Pa; `plastic`:
    /// accumulated plastic strain. `None` for laws that do not yield.
    fn q_compression(&self, _cell: f64, _plastic: f64) -> Option<f64> {
        None
    }

    /// Radial less axial stress at failure in triaxial extension, Pa, compression positive; arguments as in [`ConstitutiveLaw::q_compression`].
    fn q_extension(&self, _cell: f64, _plastic: f64) -> Option<f64> {
        None
    }

    /// The largest of [`ConstitutiveLaw::q_compression`], or of [`ConstitutiveLaw::q_extension`], over all plastic strains; `None` where there is no closed form.
    fn peak_q(&self, _cell: f64, _compression: bool) -> Option<f64> {
        None
    }
}
