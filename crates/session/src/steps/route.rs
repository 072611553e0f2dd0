//! The way from where the session stands to its next open reading.

use std::collections::VecDeque;

use crate::surroundings::Occasion;
use crate::view::Purpose;
use stiffbench_gauges::Channel;

use super::surroundings::surroundings;
use super::{Job, Machine};

impl Machine {
    /// What has to be done up to the next open reading, it included; the end if there is none.
    pub(super) fn route(&self) -> Vec<Job> {
        let mut jobs = Vec::new();
        if !self.checked {
            let mut jobs = vec![Job::CheckInstruments];
            let by_eye = self.channels.iter().copied().filter(|channel| {
                self.unit_unsure[channel.index()]
                    && self.settings.units_by_eye[channel.index()].is_some()
            });
            jobs.extend(by_eye.map(Job::UnitShown));
            if !self.begun {
                jobs.push(Job::Ready);
                jobs.extend(surroundings(Occasion::Start));
            }
            return jobs;
        }
        // Interrupted at the question about a zero that moved.
        if let Some(zero) = self.state.zero.as_ref()
            && self.open_zero_question().is_some()
        {
            return vec![if self.mounted == Some(zero.set.cell) {
                Job::ZeroMoved
            } else {
                Job::SetUp(zero.set.cell)
            }];
        }
        let open = self.plan.next_open(&self.state, self.focus);
        if self.zero_check_is_due(open) {
            return self.zero_check();
        }
        // Interrupted between the last reading on a zero and the look at it.
        if let Some(zero) = self.state.zero.as_ref()
            && self.mounted.is_none()
            && self.signs_checked
            && self.is_zero_unchecked()
        {
            return vec![Job::SetUp(zero.set.cell)];
        }
        if let Some(cell) = self.unchecked_cell() {
            return vec![Job::CheckRepeats(cell)];
        }
        let Some((cell, index)) = open else {
            return if self.asked_at_end {
                vec![Job::Finish]
            } else {
                surroundings(Occasion::End).into()
            };
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
            jobs.extend(self.zero(cell, index));
            self.walk(cell, index, &mut jobs);
        }
        jobs.push(Job::Read { cell, index });
        jobs
    }

    /// Whether the gauge zero in use is that of a reading.
    pub(super) fn has_zero(&self, cell: usize, index: usize) -> bool {
        let scope = self.plan.zero_scope(&self.plan.cells[cell].readings[index]);
        let zero = self.state.zero.as_ref();
        zero.is_some_and(|zero| zero.set.cell == cell && zero.set.scope == scope)
    }

    /// A look at the zero: after the last reading on it, and after an interruption before the next.
    fn zero_check_is_due(&self, open: Option<(usize, usize)>) -> bool {
        let Some(zero) = self.state.zero.as_ref() else {
            return false;
        };
        if self.mounted != Some(zero.set.cell) || !self.signs_checked {
            return false;
        }
        let still_used = open.is_some_and(|(cell, index)| self.has_zero(cell, index));
        if still_used {
            self.zero_is_unsure()
        } else {
            self.is_zero_unchecked()
        }
    }

    /// Whether there are readings on the zero in use that were taken since it was last checked.
    fn is_zero_unchecked(&self) -> bool {
        self.state.on_zero().any(|kept| !kept.zero_confirmed)
    }

    /// The displacement zero is checked under the preload, the force zero hanging free.
    fn zero_check(&self) -> Vec<Job> {
        let preload = Job::Load {
            target_n: self.plan.procedure.preload_n,
            purpose: Purpose::ZeroCheck,
        };
        let free = Job::Load {
            target_n: 0.0,
            purpose: Purpose::Free,
        };
        vec![preload, free, Job::LookAtZero]
    }

    /// The gauges are zeroed: the force gauge hanging free, the displacement gauges under the preload.
    pub(super) fn zero(&self, cell: usize, index: usize) -> VecDeque<Job> {
        let zero = |channel| Job::Zero {
            channel,
            cell,
            index,
        };
        let free = Job::Load {
            target_n: 0.0,
            purpose: Purpose::Free,
        };
        let preload = Job::Load {
            target_n: self.plan.procedure.preload_n,
            purpose: Purpose::Preload,
        };
        let begin = [free, zero(Channel::Force), preload];
        begin
            .into_iter()
            .chain(self.displacements().map(zero))
            .collect()
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
