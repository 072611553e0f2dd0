//! Guided sessions: what the operator does next, the one loop that does it, and the journal that loses nothing.

mod operator;
mod view;

pub use operator::{Answer, Bell, Choice, Operator, OperatorEvent, Prompt, PromptKind, SkipScope};
pub use view::{
    Band, CellReading, CellView, GaugeView, Message, Place, Progress, Purpose, RepeatSpread,
    SettleView, StiffnessSoFar, Task, View, ZeroView,
};
