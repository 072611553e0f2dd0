//! The way from where the session stands to its next open reading.

use crate::view::Purpose;
use stiffbench_gauges::Channel;

use super::{Job, Machine};

impl Machine {
    /// What is to be done up to the next open reading, it included; the end if there is none.
    pub(super) fn route(&self) -> Vec<Job> {
        let mut jobs = Vec::new();
        if !self.checked {
            return vec![Job::CheckInstruments, Job::Ready, Job::Temperature];
        }
        let open = self.plan.next_open(&self.state, self.focus);
        if let Some(check) = self.zero_check(open) {
            return vec![check];
        }
        let Some((cell, index)) = open else {
            return vec![Job::Finish];
        };
        if self.mounted != Some(cell) {
            return vec![Job::SetUp(cell)];
        }
        if !self.signs_checked {
            return vec![Job::SignCheck(cell)];
        }
        if self.has_zero(cell, index) {
            self.way_back(cell, index, &mut jobs);
        } else {
            self.zero(cell, index, &mut jobs);
            self.walk(cell, index, &mut jobs);
        }
        jobs.push(Job::Read { cell, index });
        jobs
    }

    /// Whether the gauge zero in use is that of a reading.
    fn has_zero(&self, cell: usize, index: usize) -> bool {
        let scope = self.plan.zero_scope(&self.plan.cells[cell].readings[index]);
        let zero = self.state.zero.as_ref();
        zero.is_some_and(|zero| zero.set.cell == cell && zero.set.scope == scope)
    }

    /// A look at the zero: after the last reading on it, and after an interruption before the next.
    fn zero_check(&self, open: Option<(usize, usize)>) -> Option<Job> {
        let zero = self.state.zero.as_ref()?;
        if self.mounted != Some(zero.set.cell) || !self.signs_checked {
            return None;
        }
        let still_used = open.is_some_and(|(cell, index)| self.has_zero(cell, index));
        let used = self
            .state
            .readings
            .iter()
            .any(|kept| kept.taken.zero == zero.set.label && kept.taken.cell == zero.set.cell);
        let due = if still_used {
            self.state.unconfirmed
        } else {
            used && !zero.checked
        };
        due.then_some(Job::Load {
            target_n: self.plan.procedure.preload_n,
            purpose: Purpose::ZeroCheck,
        })
    }

    /// Both gauges are zeroed: the force gauge hanging free, the displacement gauge under the preload.
    pub(super) fn zero(&self, cell: usize, index: usize, jobs: &mut Vec<Job>) {
        let zero = |channel| Job::Zero {
            channel,
            cell,
            index,
        };
        jobs.push(Job::Load {
            target_n: 0.0,
            purpose: Purpose::Free,
        });
        jobs.push(zero(Channel::Force));
        jobs.push(Job::Load {
            target_n: self.plan.procedure.preload_n,
            purpose: Purpose::Preload,
        });
        jobs.push(zero(Channel::Displacement));
    }

    /// From the load that is on to that of a reading on the same zero.
    fn way_back(&self, cell: usize, index: usize, jobs: &mut Vec<Job>) {
        let wanted = &self.plan.cells[cell].readings[index];
        let on = self
            .applied
            .filter(|on| on.cell == cell && on.repeat == wanted.repeat);
        let released = self.plan.procedure.release_n().is_some();
        let stays = match on {
            Some(on) if on.step == wanted.step => wanted.extra_hold_s.is_some() || !released,
            Some(on) => on.step < wanted.step && !released,
            None => false,
        };
        if stays {
            return;
        }
        if self.loaded {
            jobs.push(Job::Load {
                target_n: self.plan.procedure.preload_n,
                purpose: Purpose::Release,
            });
        }
        self.walk(cell, index, jobs);
    }

    /// The loads before an open reading in the middle of a run, to be applied again from the preload.
    fn walk(&self, cell: usize, index: usize, jobs: &mut Vec<Job>) {
        if self.plan.procedure.release_n().is_some() {
            return;
        }
        let loads = self.plan.loads_before(cell, index);
        jobs.extend(loads.into_iter().map(|target_n| Job::Load {
            target_n,
            purpose: Purpose::Again,
        }));
    }
}
