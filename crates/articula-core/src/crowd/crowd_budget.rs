//! Levels of a crowd as LOD options of the budget allocator.

use super::character_state::CharacterState;
use super::frame::Frame;
use super::model::CrowdModel;
use crate::Mismatch;
use crate::budget::{
    AllocationReport, BudgetAllocator, BudgetPolicy, CostModel, LodOption, LodOptionSetId,
    LodRequest, Workload,
};
use crate::sphere::Sphere;
use crate::visibility::{CullResult, Visibility};
use std::ops::Range;

/// Budget allocator of a crowd, with the LOD option sets of its clips.
#[derive(Debug, Clone)]
pub(crate) struct CrowdBudget {
    budget: BudgetAllocator,
    /// Option set of each clip, and one for blends.
    option_sets: Vec<LodOptionSetId>,
    blends: LodOptionSetId,
}

impl CrowdBudget {
    pub(crate) fn new(
        model: &CrowdModel,
        characters: usize,
        policy: BudgetPolicy,
        costs: &CostModel,
    ) -> Result<Self, Mismatch> {
        let mut budget = BudgetAllocator::new(characters, policy);
        let count = model.parts().clips.clips();
        let option_sets = (0..count)
            .map(|clip| budget.add_options(&lod_options(model, costs, clip..clip + 1)))
            .collect::<Result<_, _>>()?;
        let blends = budget.add_options(&lod_options(model, costs, 0..count))?;
        Ok(Self {
            budget,
            option_sets,
            blends,
        })
    }

    pub(crate) fn reprice(&mut self, model: &CrowdModel, costs: &CostModel) {
        self.budget.reprice(|_, level| cost(model, costs, level));
    }

    /// Chooses a level for every visible character.
    pub(crate) fn spend(
        &mut self,
        budget: f32,
        frame: &Frame<'_>,
        states: &[CharacterState],
        seen: &[CullResult],
        bounds: &[Sphere],
    ) -> AllocationReport {
        for (character, (seen, player)) in seen.iter().zip(states).enumerate() {
            if seen.visibility != Visibility::Visible {
                self.budget.hide(character);
                continue;
            }
            let option_set = if player.is_fading() {
                self.blends
            } else {
                self.option_sets[player.clips().0]
            };
            // The error in pixels, times the pixels that the bound covers; both in model space.
            let pixels_per_metre = seen.pixels_per_metre * frame.scale(character);
            let side = bounds[character].radius * pixels_per_metre;
            let importance = frame.importance.get(character).copied().unwrap_or(1.0);
            let request = LodRequest {
                option_set,
                weight: importance * pixels_per_metre * side * side,
                pixels_per_metre,
            };
            self.budget.request(character, request);
        }
        self.budget.solve(budget)
    }

    /// Level chosen for a character; `None` if it is hidden.
    pub(crate) fn level(&self, character: usize) -> Option<usize> {
        self.budget.choice(character)
    }
}

/// LOD options of all levels, each with its largest error over a range of clips.
fn lod_options(model: &CrowdModel, costs: &CostModel, clips: Range<usize>) -> Vec<LodOption> {
    let error = |level: usize| {
        let errors = clips
            .clone()
            .map(|clip| model.error_metres(clip, clip, level));
        errors.fold(0.0, f32::max)
    };
    (0..model.levels())
        .map(|level| LodOption {
            cost: cost(model, costs, level),
            error_metres: error(level),
        })
        .collect()
}

fn cost(model: &CrowdModel, costs: &CostModel, level: usize) -> f32 {
    costs.cost_ns(&work(model, level, 1)) as f32
}

/// Workload of evaluating `poses` poses at a level.
pub(crate) fn work(model: &CrowdModel, level: usize, poses: u64) -> Workload {
    let kept = model.parts().clips.joint_lods().joint_count(level);
    Workload {
        characters: poses,
        sampled_joints: poses * model.parts().clips.rotations(kept).len() as u64,
        fk_joints: poses * kept as u64,
        matrices: poses * model.parts().palette.len(level) as u64,
    }
}
