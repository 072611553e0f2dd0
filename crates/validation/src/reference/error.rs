//! What can be wrong with a reference model or its answer.

/// Why a reference model cannot be made, or its answer not be used.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum ReferenceError {
    /// A mesh size that is none.
    #[error("solid elements of {} mm cannot be made", size_m * 1e3)]
    #[diagnostic(
        code(stiffbench::reference::size),
        help("give a length above zero in millimetres, for example --size 20")
    )]
    Size {
        /// The size, m.
        size_m: f64,
    },
    /// A mesh that no machine solves.
    #[error("{member}: with elements of {} mm this member alone has more than two million", size_m * 1e3)]
    #[diagnostic(
        code(stiffbench::reference::size),
        help("give a larger --size; 20 mm are fine for a robot of metres")
    )]
    TooFine {
        /// The member.
        member: String,
        /// The size, m.
        size_m: f64,
    },
    /// A joint that turns.
    #[error("joint {joint} turns, and the joints of the reference are bonded")]
    #[diagnostic(
        code(stiffbench::reference::hinge),
        help("leave out the effect or model that releases it")
    )]
    Turns {
        /// The joint.
        joint: String,
    },
    /// A support that holds some freedoms only.
    #[error("node {node} is held in some freedoms and free in others")]
    #[diagnostic(
        code(stiffbench::reference::support),
        help("nodes of the reference are held or free")
    )]
    PartlyHeld {
        /// The node.
        node: String,
    },
    /// A member without length or plane.
    #[error("member {member} has no length or no plane")]
    #[diagnostic(
        code(stiffbench::reference::no_length),
        help("its two nodes coincide in this pose, or its plane's normal lies along it")
    )]
    NoLength {
        /// The member.
        member: String,
    },
    /// Moduli that no isotropic solid has.
    #[error(
        "member {member}: its E and G mean a Poisson's ratio of {poisson:.3}, and an isotropic solid has 0 to 0.49"
    )]
    #[diagnostic(
        code(stiffbench::reference::poisson),
        help("correct E or G of its material: nu = E/(2G) - 1")
    )]
    Poisson {
        /// The member.
        member: String,
        /// E/(2G) - 1.
        poisson: f64,
    },
    /// An answer without the displacement of the end.
    #[error("{file} holds no displacement of the end node")]
    #[diagnostic(
        code(stiffbench::reference::answer),
        help(
            "CalculiX stopped before the end of the step; its own words are in the file of the same name that ends in .log"
        )
    )]
    NoAnswer {
        /// The file.
        file: String,
    },
    /// An answer under a part of the load.
    #[error("{file} ends at {:.1} % of the load", 100.0 * share)]
    #[diagnostic(
        code(stiffbench::reference::answer),
        help(
            "large displacements did not converge: export the model with smaller loads, or without --large-displacements"
        )
    )]
    PartOfTheLoad {
        /// The file.
        file: String,
        /// Share of the load at which CalculiX stopped, 1.
        share: f64,
    },
    /// An answer whose numbers cannot be read.
    #[error("{file}:{line}: expected a node and three displacements, found `{found}`")]
    #[diagnostic(
        code(stiffbench::reference::answer),
        help(
            "CalculiX writes stars or NaN where a system is singular; read the file of the same name that ends in .log"
        )
    )]
    Answer {
        /// The file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// What stands there.
        found: String,
    },
    /// A record of a run that was stopped.
    #[error("{file}: the run was stopped after {done} of {} cases; {first} is the first without a result", done + missing)]
    #[diagnostic(
        code(stiffbench::reference::unfinished),
        help("stiffbench-validate reference run FOLDER continues where it stopped")
    )]
    Unfinished {
        /// The file.
        file: String,
        /// Cases with a result.
        done: usize,
        /// Cases without one.
        missing: usize,
        /// The first of them.
        first: String,
    },
    /// A record of another format, or none.
    #[error("{file} is not a record of a reference: {problem}")]
    #[diagnostic(
        code(stiffbench::reference::record),
        help(
            "stiffbench-validate reference export writes model.json, stiffbench-validate reference run reference.json"
        )
    )]
    Record {
        /// The file.
        file: String,
        /// What is wrong.
        problem: String,
    },
}
