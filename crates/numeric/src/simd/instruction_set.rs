//! Which instruction set the machine at hand has.

use pulp::Scalar;
#[cfg(target_arch = "aarch64")]
use pulp::aarch64::Neon;
#[cfg(target_arch = "x86_64")]
use pulp::x86::{V3, V4};

/// An instruction set that this machine has: the tokens inside exist nowhere else.
#[derive(Debug, Clone, Copy)]
pub enum InstructionSet {
    /// One pose at a time.
    Plain(Scalar),
    /// Two poses: 64-bit ARM.
    #[cfg(target_arch = "aarch64")]
    Neon(Neon),
    /// Four poses: x86-64 with AVX2 and fused products.
    #[cfg(target_arch = "x86_64")]
    Avx2(V3),
    /// Eight poses: x86-64 with AVX-512.
    #[cfg(target_arch = "x86_64")]
    Avx512(V4),
}

impl InstructionSet {
    /// Those this machine has, the plainest first.
    pub fn all() -> Vec<Self> {
        let mut sets = vec![Self::Plain(Scalar)];
        #[cfg(target_arch = "aarch64")]
        sets.extend(Neon::try_new().map(Self::Neon));
        #[cfg(target_arch = "x86_64")]
        {
            sets.extend(V3::try_new().map(Self::Avx2));
            sets.extend(V4::try_new().map(Self::Avx512));
        }
        sets
    }

    /// The one for a number of poses: the widest, but not AVX-512 if half its lanes would stay empty.
    ///
    /// AVX2 and AVX-512 round alike, so the choice does not show in the results.
    #[must_use]
    pub fn for_poses(poses: usize) -> Self {
        let sets = Self::all();
        let fits = |set: &&Self| set.lanes() <= 4 || poses > set.lanes() / 2;
        let widest = sets.iter().rev().find(fits);
        widest.copied().unwrap_or(Self::Plain(Scalar))
    }

    /// What its makers call it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain(_) => "none",
            #[cfg(target_arch = "aarch64")]
            Self::Neon(_) => "NEON",
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(_) => "AVX2",
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(_) => "AVX-512",
        }
    }

    /// Number of poses in a lane.
    #[must_use]
    pub fn lanes(self) -> usize {
        match self {
            Self::Plain(_) => 1,
            #[cfg(target_arch = "aarch64")]
            Self::Neon(_) => 2,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(_) => 4,
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(_) => 8,
        }
    }
}
