//! How a law is searched for in readings: the scales of a place, and the shapes that a law can take there.

/// What the loads of a session make of a place.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PlaceScale {
    /// Largest force, N.
    pub force_n: f64,
    /// Least and largest force, with their signs, N.
    pub force_range_n: [f64; 2],
    /// Largest displacement, m.
    pub displacement_m: f64,
    /// Longest time since a gauge zero, s; zero where no clock was recorded.
    pub time_s: f64,
    /// Largest change of temperature since a gauge zero, K; zero where none was recorded.
    pub warming_k: f64,
    /// Whether a clock was recorded: the order of readings is none.
    pub has_clock: bool,
    /// Whether times under load were recorded.
    pub has_holds: bool,
    /// Whether there is more than one repeat.
    pub has_repeats: bool,
    /// Compliance at the place that would add as much as the structure gives in the cell that shows the place best, rad/(N·m) for
    /// rotations and m/N for displacements; zero at places that are no springs.
    pub compliance: f64,
    /// Largest moment of the rigid joint, N·m.
    pub moment_nm: f64,
    /// Stiffness of the structure against a twist of the joint, N·m/rad; zero where the joint lies in no closed loop.
    pub loop_nm_per_rad: f64,
}

/// A share of the compliance of the structure that makes an effect clearly visible and still small, 1.
pub const VISIBLE_SHARE: f64 = 0.01;

/// Compliance of a joint times the stiffness of its loop beyond which it is a pin: beyond it readings carry no information.
const PIN: f64 = 12.0;

/// A joint, base or stand that gives this many times as much as the whole structure is the softest that is plausible.
const SOFTEST: f64 = 10.0;

/// How far beyond the shapes of a search a fit may go.
pub(super) const SHAPE_ROOM: f64 = 1.12;

impl PlaceScale {
    /// A compliance that makes an effect clearly visible and still small.
    #[must_use]
    pub fn visible(&self) -> f64 {
        VISIBLE_SHARE * self.compliance
    }

    /// A displacement that is clearly visible and still small, m; of a part in the unit of its answers.
    #[must_use]
    pub fn small_answer(&self) -> f64 {
        1e-3 * self.displacement_m
    }

    /// Plausible compliances.
    #[must_use]
    pub fn plausible_compliance(&self) -> [f64; 2] {
        let softest = if self.loop_nm_per_rad > 0.0 {
            // Compliance of the last shape, by as much as it holds for.
            PIN / self.loop_nm_per_rad * 1.07 * (1.0 + PIN)
        } else {
            SOFTEST * self.compliance
        };
        [0.0, softest]
    }

    /// Moments at which a law of a joint may begin, between shares of the largest.
    pub(super) fn moments(&self, [low, high]: [f64; 2]) -> [f64; 2] {
        [low / SHAPE_ROOM, high * SHAPE_ROOM].map(|share| share * self.moment_nm)
    }

    /// Compliances of a joint in a closed loop, from where the structure hardly minds the twist up to a pin; with the range of effects
    /// each stands for, and with their saturation. In no loop one is enough.
    pub(super) fn compliances(&self) -> Vec<Shape> {
        if self.loop_nm_per_rad == 0.0 {
            return vec![Shape::of_any_size(vec![self.visible()])];
        }
        let relative = [
            (0.03, [0.0, 2.1]),
            (0.15, [0.47, 1.7]),
            (0.6, [0.59, 1.38]),
            (2.5, [0.73, 1.14]),
            (PIN, [0.88, 1.07]),
        ];
        relative
            .into_iter()
            .map(|(product, scale)| Shape {
                values: vec![product / self.loop_nm_per_rad],
                scale,
                saturation: product,
                held: None,
            })
            .collect()
    }
}

/// One shape of a law: values at which its effect is computed, and how far its size may be scaled from there.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Values of the parameters.
    pub values: Vec<f64>,
    /// Smallest and largest multiple of the effect for which the shape holds.
    pub scale: [f64; 2],
    /// Compliance times the stiffness of the loop it sits in: the effect grows as s/(1 + s), not as s.
    pub saturation: f64,
    /// A parameter that a fit from this shape keeps within a share of its value.
    pub held: Option<(usize, f64)>,
}

impl Shape {
    /// A shape for effects of any positive size.
    pub(super) fn of_any_size(values: Vec<f64>) -> Self {
        Self {
            values,
            scale: [0.0, f64::INFINITY],
            saturation: 0.0,
            held: None,
        }
    }

    /// A shape for effects of any size and sign.
    pub(super) fn of_either_sign(values: Vec<f64>) -> Self {
        Self {
            scale: [f64::NEG_INFINITY, f64::INFINITY],
            ..Self::of_any_size(values)
        }
    }

    /// Factor on the size that makes the effect `scale` times as large.
    #[must_use]
    pub fn size_factor(&self, scale: f64) -> f64 {
        let s = self.saturation;
        // scale s/(1 + s) = s'/(1 + s'), solved for s'/s; an effect beyond a pin is cut to nearly a pin.
        scale / (1.0 + s - scale * s).max(0.05)
    }
}

/// What readings were taken of, and which quantity was set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TestObject {
    /// A robot, loaded by forces.
    Robot,
    /// A part without a robot file: the force was set, the displacement answered.
    ForceDriven,
    /// A part without a robot file: the displacement was set, the force answered.
    DisplacementDriven,
}

/// The benches on which a law is searched for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SearchedOn(&'static [TestObject]);

impl SearchedOn {
    /// Robots alone: elsewhere a straight line contains the law, or its place is not there.
    pub const ROBOTS: Self = Self(&[TestObject::Robot]);
    /// Wherever a force is set.
    pub const FORCE_DRIVEN: Self = Self(&[TestObject::Robot, TestObject::ForceDriven]);
    /// Parts whose force was set.
    pub const FORCE_DRIVEN_PARTS: Self = Self(&[TestObject::ForceDriven]);
    /// Parts whose displacement was set.
    pub const DISPLACEMENT_DRIVEN_PARTS: Self = Self(&[TestObject::DisplacementDriven]);
    /// Parts, whatever was set.
    pub const PARTS: Self = Self(&[TestObject::ForceDriven, TestObject::DisplacementDriven]);
    /// Everywhere.
    pub const ALL: Self = Self(&[
        TestObject::Robot,
        TestObject::ForceDriven,
        TestObject::DisplacementDriven,
    ]);

    /// Whether one of them is a given one.
    #[must_use]
    pub fn contains(self, object: TestObject) -> bool {
        self.0.contains(&object)
    }
}

/// What a search of a law needs to know besides its parameters.
#[derive(Debug, Clone, Copy)]
pub struct SearchSpec {
    /// Shapes at a place; none where these readings cannot show the law.
    pub shapes: fn(&PlaceScale) -> Vec<Shape>,
    /// Shapes of a second, wide search, which is believed only beyond a limit of its own.
    pub wide_shapes: Option<fn(&PlaceScale) -> Vec<Shape>>,
    /// A parameter that is a phase: with it a shape is a plane of two vectors, a quarter of a turn apart.
    pub phase: Option<usize>,
    /// Whether a joint turns at least as far under this law as under any other: where it cannot be seen, none can.
    pub is_freest: bool,
    /// Whether it claims a bend or a rhythm, which no smooth curve over what was set has: of a part it is named only where such a curve of as
    /// many values is clearly worse.
    pub is_sharp: bool,
    /// On which benches it is searched for.
    pub on: SearchedOn,
    /// What the law needs to be recorded.
    pub needs: Needs,
    /// Why the law cannot be seen at one of its places, and what would make it visible, as clauses.
    pub unseen_at_place: (&'static str, &'static str),
    /// Why the law cannot be seen at all in readings that recorded what it needs, and what would make it visible, as clauses.
    pub unseen: (&'static str, Option<&'static str>),
}

impl SearchSpec {
    /// How laws of a robot are searched for that need no more than force and displacement, but for their shapes.
    pub(super) const OF_ROBOTS: Self = Self {
        shapes: |_| Vec::new(),
        wide_shapes: None,
        phase: None,
        is_freest: false,
        is_sharp: false,
        on: SearchedOn::ROBOTS,
        needs: Needs::Nothing,
        unseen_at_place: (
            "no plausible size would have been distinguishable from noise or from the fitted factors",
            "measure larger loads, more repeats or, of a robot, further poses",
        ),
        unseen: (
            "no plausible size would have been detectable in these readings",
            Some("measure larger loads, more repeats or, of a robot, further poses"),
        ),
    };
}

/// What has to be recorded for a law to be seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Needs {
    /// Force and displacement alone.
    Nothing,
    /// The time under each load.
    Hold,
    /// The time of each reading.
    Clock,
    /// A path that comes back.
    Return,
    /// The temperature at each reading.
    Temperature,
}

impl Needs {
    /// Whether loads that went one way only, at one rate, show nothing of the law: a curve does the same.
    #[must_use]
    pub fn more_than_a_sweep(self) -> bool {
        matches!(self, Self::Hold | Self::Clock | Self::Return)
    }
}
