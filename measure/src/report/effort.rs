//! How much is measured.

use std::time::Duration;

use crate::compare::timing::Pace;

/// Which parts a report has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parts {
    /// Time and error on the scenes.
    pub scenes: bool,
    /// Cost against the size of things.
    pub scaling: bool,
    /// Cost of motion.
    pub motion: bool,
    /// Error against parameters.
    pub sweeps: bool,
}

/// The sizes that cost is measured at, smallest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Steps {
    /// Triangles of one mesh.
    pub triangles: &'static [u32],
    /// Lights.
    pub lights: &'static [u32],
    /// Instances of one small mesh.
    pub casters: &'static [u32],
    /// Width and height of the frame.
    pub sizes_px: &'static [[u32; 2]],
}

/// How much is measured, and for how long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Effort {
    /// `quick`, `default` or `full`.
    pub name: &'static str,
    /// Which parts there are.
    pub parts: Parts,
    /// The size of the scenes' frames.
    pub size_px: [u32; 2],
    /// The size of the frames at which techniques that give lights a size are judged on scenes, unless frames are smaller.
    pub soft_size_px: [u32; 2],
    /// How many samples stand for a whole light there, and in sweeps.
    pub whole_light_samples: [u32; 2],
    /// How long each scene's settings take turns.
    pub scene_pace: Pace,
    /// Frames with every pass apart.
    pub pass_frames: usize,
    /// The size of the frames on axes other than that of sizes.
    pub axis_size_px: [u32; 2],
    /// How long each size's settings take turns.
    pub axis_pace: Pace,
    /// The sizes.
    pub steps: Steps,
    /// Every how many steps of a sweep are taken; its last always is.
    pub sweep_stride: usize,
    /// How many times smaller, along each side, a sweep's frames are than its cases say. Where they are smaller, steps that are slow
    /// are left out, too ([`slow_from`](crate::cases::sweeps::Sweep::slow_from)).
    pub sweep_shrink: u32,
    /// Whether scenes try every setting of a technique, or its default only.
    pub scene_settings: bool,
    /// Whether axes and sweeps try every setting of a technique, or its default only.
    pub all_settings: bool,
}

const fn pace(min_rounds: usize, max_rounds: usize, budget_ms: u64) -> Pace {
    Pace { min_rounds, max_rounds, budget: Duration::from_millis(budget_ms) }
}

impl Effort {
    /// Under two minutes on two cores and the software driver, with defaults only.
    pub const QUICK: Self = Self {
        name: "quick",
        size_px: [256, 144],
        soft_size_px: [128, 72],
        whole_light_samples: [256, 64],
        scene_pace: pace(3, 9, 400),
        pass_frames: 1,
        axis_size_px: [256, 144],
        axis_pace: pace(3, 9, 200),
        steps: Steps {
            triangles: &[1_000, 3_000, 10_000, 30_000],
            lights: &[1, 2, 4, 8],
            casters: &[1, 8, 32, 128, 256],
            sizes_px: &[[181, 181], [256, 256], [362, 362], [512, 512]],
        },
        sweep_stride: 8,
        sweep_shrink: 3,
        ..Self::DEFAULT
    };

    /// Every setting on every scene; with soft shadows in a furnished room that takes the software driver a while.
    pub const DEFAULT: Self = Self {
        name: "default",
        parts: Parts { scenes: true, scaling: true, motion: true, sweeps: true },
        size_px: [1280, 720],
        soft_size_px: [320, 180],
        whole_light_samples: [4096, 1024],
        scene_pace: pace(9, 31, 15_000),
        pass_frames: 7,
        axis_size_px: [640, 360],
        axis_pace: pace(9, 21, 2_500),
        steps: Steps {
            triangles: &[1_000, 3_000, 10_000, 20_000, 40_000, 70_000, 100_000],
            lights: &[1, 2, 4, 8, 12, 16],
            casters: &[1, 4, 16, 64, 128, 256, 512, 1024],
            sizes_px: &[[256, 256], [362, 362], [512, 512], [724, 724], [1024, 1024], [1448, 1448]],
        },
        sweep_stride: 1,
        sweep_shrink: 1,
        scene_settings: true,
        all_settings: false,
    };

    /// Everything, the largest sizes too.
    pub const FULL: Self = Self {
        name: "full",
        soft_size_px: [640, 360],
        whole_light_samples: [4096, 4096],
        scene_pace: pace(15, 101, 60_000),
        pass_frames: 15,
        axis_size_px: [1280, 720],
        axis_pace: pace(9, 31, 15_000),
        steps: Steps {
            triangles: &[1_000, 3_000, 10_000, 30_000, 100_000, 200_000, 400_000, 700_000, 1_000_000],
            lights: &[1, 2, 4, 8, 16, 24, 32, 48, 64],
            casters: &[1, 4, 16, 64, 256, 512, 1024, 2048, 4096],
            sizes_px: &[
                [256, 256],
                [362, 362],
                [512, 512],
                [724, 724],
                [1024, 1024],
                [1448, 1448],
                [2048, 2048],
                [3840, 2160],
            ],
        },
        all_settings: true,
        ..Self::DEFAULT
    };
}
