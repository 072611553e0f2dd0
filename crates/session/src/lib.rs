//! Guided sessions: what the operator does next, the one loop that does it, and the journal that loses nothing.

mod answers_file;
mod awake;
mod contradiction;
mod decision;
mod digits;
mod event;
mod flicker;
mod folder;
mod gauge_stream;
mod inside;
mod integrity;
mod journal;
mod link_text;
mod live;
mod lock;
mod operator;
mod plan;
mod raw_bytes;
mod replay;
mod run;
mod run_scatter;
mod state;
mod steps;
mod surroundings;
mod view;
mod whole_file;

pub use answers_file::{
    ANSWERS_SCHEMA, AnswerForm, Answers, AnswersError, QUESTIONS, Question, check_question,
};
pub use awake::KeptAwake;
pub use contradiction::{Contradiction, RepeatCheck};
pub use decision::{
    Flagged, OmittedReadings, SkipCode, Skipped, Superseded, Undone, UndoneAction, last_decision,
};
pub use event::{
    AxisReading, AxisZero, ClockJump, Ended, Event, Gap, InstrumentSeen, JOURNAL_SCHEMA, JointSet,
    LimitCheck, LinkChange, Noted, Paused, PoseSet, Resumed, SessionEnd, SignChecked, Started,
    TakenReading, Warning, ZeroOccasion, Zeroed,
};
pub use folder::{FolderError, ReadFolder, SessionFolder, read_folder, recover, table};
pub use inside::{append_inside, inside, read_inside};
pub use integrity::{Difference, Integrity, integrity};
pub use journal::{
    Damage, Journal, JournalEnd, JournalError, ReadJournal, Record, Store, checksum, read_journal,
    write_line, write_lines,
};
pub use lock::{FolderHolder, JournalFile, folder_holder, host};
pub use operator::{Answer, Bell, Choice, Operator, OperatorEvent, Prompt, PromptKind, SkipScope};
pub use plan::{SessionCell, SessionPlan};
pub use raw_bytes::{RawBytes, RawCheck, WrongBytes, check_raw_bytes};
pub use replay::{RecordedSession, ReplayWatch, replay_session};
pub use run::{RunError, SessionInputs, run};
pub use state::{CurrentZero, KeptReading, SessionState};
pub use steps::{Action, Input, Machine, Settings, lag_s};
pub use surroundings::{Occasion, Surroundings};
pub use view::{
    Band, CellView, GaugeView, Message, PlanPosition, Progress, Purpose, RepeatSpread, SessionView,
    SettleView, StiffnessSoFar, Task, ZeroView,
};
pub use whole_file::write_whole;
