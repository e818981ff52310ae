//! The kinds of scene that are searched.

use std::fmt;
use std::str::FromStr;

/// A kind of scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Family {
    /// Solids, open shapes and soups under hard shadows, with lights and eyes in no special place.
    Open,
    /// Triangles that share, coincide, lie in one plane, have no area, hang three and more from one edge.
    Soup,
    /// Sheets in the planes of floors and boxes.
    Ties,
    /// Hard lights on, in and beside corners, edges, faces and planes.
    LampBeside,
    /// Triangles up to 100 000 times as long as wide, under every opaque technique.
    Stretched,
    /// Solids of either winding, single-sided, whose insides may be seen.
    InnerWalls,
    /// Eyes inside solids and close to surfaces.
    CloseEye,
    /// Mirrored, squashed and sheared nodes, far from the origin as well.
    Turned,
    /// Transparent panes and solids, also in one place, judged layer by layer.
    Glass,
    /// Surfaces with holes.
    Masks,
    /// Lights with a size, in no special place.
    SoftOpen,
    /// Lights with a size, tiny and huge, on and beside surfaces, over nothing that casts.
    SoftSpecial,
    /// Lights with a size over planes that are named as receivers.
    Planar,
    /// Several shadow nodes of several types on shared lights, each with casters of its own.
    NodesMixed,
    /// Skins and morph targets.
    Bent,
    /// Solids, open shapes and masks under maps of what lights see. Searched when it is asked for: what is approximate owes no
    /// more than bounds.
    Maps,
}

impl Family {
    /// All of them: in this order seeds take those that are not only asked for by name, which are last.
    pub const ALL: &[Self] = &[
        Self::Open,
        Self::Soup,
        Self::Ties,
        Self::LampBeside,
        Self::Stretched,
        Self::InnerWalls,
        Self::CloseEye,
        Self::Turned,
        Self::Glass,
        Self::Masks,
        Self::SoftOpen,
        Self::SoftSpecial,
        Self::Planar,
        Self::NodesMixed,
        Self::Bent,
        Self::Maps,
    ];

    /// How many of them seeds take by themselves.
    const IN_TURN: usize = 15;

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Soup => "soup",
            Self::Ties => "ties",
            Self::LampBeside => "lamp-beside",
            Self::Stretched => "stretched",
            Self::InnerWalls => "inner-walls",
            Self::CloseEye => "close-eye",
            Self::Turned => "turned",
            Self::Glass => "glass",
            Self::Masks => "masks",
            Self::SoftOpen => "soft-open",
            Self::SoftSpecial => "soft-special",
            Self::Planar => "planar",
            Self::NodesMixed => "nodes-mixed",
            Self::Bent => "bent",
            Self::Maps => "maps",
        }
    }

    /// The family of a seed where `chosen` are searched: they take turns.
    pub fn of_seed(seed: u64, chosen: &[Self]) -> Self {
        let chosen = if chosen.is_empty() { &Self::ALL[..Self::IN_TURN] } else { chosen };
        chosen[(seed % chosen.len() as u64) as usize]
    }
}

impl fmt::Display for Family {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Family {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.iter().copied().find(|family| family.name() == text).ok_or_else(|| {
            let names: Vec<&str> = Self::ALL.iter().map(|family| family.name()).collect();
            format!("no kind of scene is called '{text}' (there are: {})", names.join(", "))
        })
    }
}
