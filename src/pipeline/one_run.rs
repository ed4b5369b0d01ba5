//! A run on its way, and its two parts: the steps and the files.

use std::ops::ControlFlow;

use super::cores::Core;
use super::part::larger;
use super::progress::{Progress, StepStatistics};
use super::recorders::Recorders;
use super::records::passages;
use super::{COMPUTE, Computed, Outcome, Run};
use crate::calendar::utc_now;
use crate::error::Error;
use crate::output::{Provenance, RecorderPlan};
use crate::scenario::Part;
use crate::version;

impl Run<'_> {
    /// Computes, writes everything, and judges the result; `run.json` says so where files cannot be written.
    pub fn execute(
        mut self,
        core: Core,
        recorded: (Option<Recorders>, StepStatistics),
        plan: RecorderPlan,
        show: bool,
    ) -> Result<Outcome, Error> {
        match self.compute_and_write(core, recorded, plan, show) {
            Ok(ControlFlow::Break(wider)) => {
                let why = larger(wider, self.manifest.simulated_s);
                // Where the larger part is refused, this run has failed.
                let _ = self.manifest.failed(&self.folder, Error::Problems(vec![why.clone()]));
                self.clock.join_phases("on a smaller part of the terrain");
                Ok(Outcome::Beyond { wider, clock: self.clock, why: Box::new(why) })
            }
            Ok(ControlFlow::Continue(computed)) => {
                self.finish(computed).map(|summary| Outcome::Done(Box::new(summary)))
            }
            Err(error) => Err(self.manifest.failed(&self.folder, error)),
        }
    }

    /// Computes, and writes all results but `run.json`; breaks off with a larger part of the terrain where the water asks for it.
    fn compute_and_write(
        &mut self,
        mut core: Core,
        (recorders, steps): (Option<Recorders>, StepStatistics),
        plan: RecorderPlan,
        show: bool,
    ) -> Result<ControlFlow<Part, Computed>, Error> {
        self.folder.write("scenario.resolved.yaml", self.scenario.to_yaml().as_bytes())?;
        self.manifest.write(&self.folder)?;
        let provenance = self.provenance();
        let mut progress = Progress::new(self.scenario.end_time, &self.scene.lattice, show);
        let mut recorders = match recorders {
            Some(mut recorders) => {
                recorders.reopen(self, &provenance)?;
                recorders
            }
            None => {
                let mut recorders = Recorders::open(self, &provenance, plan, core.as_flow())?;
                recorders.start(core.flow(), &mut self.clock)?;
                recorders
            }
        };
        let early = match self.compute(&mut core, &mut recorders, steps, &mut progress) {
            ControlFlow::Continue(early) => early,
            ControlFlow::Break(wider) => return Ok(ControlFlow::Break(wider)),
        };
        let ledger = core.as_flow().ledger();
        self.manifest.boundaries = passages(core.as_flow(), self.scenario, &self.scene);
        // The outputs take memory of their own.
        drop(core);
        self.clock.part("rest");
        self.clock.lap(COMPUTE);
        let computed = self.write_outputs(recorders, &provenance, (ledger, early));
        self.clock.lap("outputs");
        Ok(ControlFlow::Continue(computed))
    }

    fn provenance(&self) -> Provenance {
        let now = utc_now();
        Provenance {
            title: self.scenario.title.clone(),
            institution: String::new(),
            source: format!("floodsim {}", version::with_commit()),
            history: format!("{now} {}", self.manifest.command),
            references: String::new(),
            comment: String::new(),
            date_created: now,
            reference_time: self.scenario.reference_time,
        }
    }
}
