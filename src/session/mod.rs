//! Guided sessions: what the operator does next, the one loop that does it, and the journal that loses nothing.
