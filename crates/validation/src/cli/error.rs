//! Errors that only validation has.

use std::path::PathBuf;

use miette::Diagnostic;

/// Errors of validation.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub(crate) enum ValidationError {
    /// A folder of proof data that is not there.
    #[error("{path}: there is no such file or folder, and the validation needs it")]
    #[diagnostic(
        code(stiffbench::input::proof_data),
        help(
            "the concealed sessions and recordings are too large for the program and are in the folder data of its repository: run \
             stiffbench-validate prove in a clone of it, or name that folder with --data"
        )
    )]
    ProofData {
        /// The path.
        path: PathBuf,
    },
    /// A folder in which none of the recordings is.
    #[error("{folder} holds none of the recordings")]
    #[diagnostic(
        code(stiffbench::input::recordings),
        help(
            "data/recordings/recordings.toml names each file and its source; put them below the folder under these names"
        )
    )]
    NoRecordings {
        /// The folder.
        folder: PathBuf,
    },
    /// CalculiX is not there.
    #[error("{program} cannot be run, and the reference needs CalculiX")]
    #[diagnostic(
        code(stiffbench::reference::no_calculix),
        help(
            "apt-get install calculix-ccx, or name the program with --ccx PATH; results that were recorded with it: stiffbench-validate reference compare"
        )
    )]
    NoCalculix {
        /// What was to be run.
        program: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// Something else than CalculiX.
    #[error("{program} is not CalculiX: it does not report its version")]
    #[diagnostic(
        code(stiffbench::reference::no_calculix),
        help("name the solver, ccx, with --ccx PATH; cgx is the viewer")
    )]
    NotCalculix {
        /// What was run.
        program: PathBuf,
    },
}
