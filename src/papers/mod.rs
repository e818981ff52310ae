//! The papers that this project implements, made again: every table and figure that says something about speed or error,
//! measured here and held up beside what was published. `shadowgraph report --papers` writes it as a page.
//!
//! One file is a group of tables and figures; `harness` is what they share. An entry says what is found in a sentence that
//! does not depend on the machine; figures beside it do.

mod glass_figures;
mod glass_letters;
mod glass_table;
mod harness;
mod lights;
mod map_figures;
mod map_scenes;
mod maps;
mod models;
mod open_casters;
mod passes;
mod planar;
mod soft;
mod unmodified;

use shadowgraph_engine::gpu::Gpu;
use shadowgraph_engine::shadow::Catalog;
use shadowgraph_measure::report::{Chapter, Entry, Watch};

pub use harness::{Effort, PaperError};
pub use models::ModelError;

use harness::{Bench, Made};

/// An entry yet to be made.
type Make = fn(&mut Bench<'_>) -> Made<Entry>;

const KIM: &str = "Kim, Kim & Turk, Real Time Shadow of Transparent Casters Using Shadow Volume";
const IJMA: &str = "Real-time shadow generation using stencil and Z-buffer, IJMA 3/3, 2011";
const EON: &str = "Lindrud & Löfgren, Real-Time Volumetric Shadows in EON Studio, 2004";
const SEN: &str = "Sen, Cammarano & Hanrahan, Shadow Silhouette Maps, 2003";

/// Every entry: its short name, its paper, its title, what makes it.
const ENTRIES: [(&str, &str, &str, Make); 20] = [
    ("000-table1", KIM, "000 Table 1: what glass costs", glass_table::table_1),
    ("000-fig2", KIM, "000 Fig. 2: surfaces are counted", glass_figures::counted),
    ("000-fig4", KIM, "000 Fig. 4: products and logarithms", glass_figures::accumulated),
    ("000-fig6", KIM, "000 Fig. 6: the inside shows in the shadow", glass_figures::inside),
    ("000-fig7", KIM, "000 Fig. 7: partial shadows on glass", glass_letters::fig_7),
    ("001-fig8", IJMA, "001 Fig. 8: frames a second against lights", lights::fig_8),
    ("002-fig3", EON, "002 Fig. 3: open casters, unmodified and modified", open_casters::fig_3),
    ("002-overlap", EON, "002 §3.3: 128 and 256 volumes over each other", open_casters::overlap),
    ("002-fig5", EON, "002 Fig. 5: soft shadows on planes", planar::fig_5),
    ("002-fig6", EON, "002 Fig. 6: hard shadows, z-pass and z-fail", open_casters::fig_6),
    ("002-open-closed", EON, "002 §5.3: open against closed", open_casters::open_against_closed),
    ("002-fig7", EON, "002 Fig. 7: soft shadow volumes", soft::fig_7),
    ("002-fig12", EON, "002 Fig. 12: soft beside hard", soft::fig_12),
    ("002-hard-planar", EON, "002 §5.3: hard volumes against planar shadows", planar::hard_against_planar),
    ("002-single-multi", EON, "002 §5.3: single pass against multi pass", passes::single_against_multi),
    ("002-highlight", EON, "002 §6.4: the highlight that darkening leaves", passes::highlight),
    ("004-table1", SEN, "004 Table 1: maps, silhouettes, volumes", maps::table_1),
    ("004-fig7", SEN, "004 Fig. 7: what one point for each texel cannot say", map_figures::fig_7),
    ("004-fig8", SEN, "004 Fig. 8: a closeup of the vehicle", map_figures::fig_8),
    ("004-fig9", SEN, "004 Fig. 9: curved objects, and the map's points", map_figures::fig_9),
];

/// The built-in techniques, and the one that Fig. 3 of paper 002 shows to be wrong.
fn catalog() -> Catalog {
    let mut catalog = shadowgraph_nodes::catalog();
    catalog.register(unmodified::ENTRY);
    catalog
}

/// Makes every entry. What fails is told in its entry, and the rest goes on. `watch` is told how many entries are done, of how
/// many, and what comes next.
pub fn run(gpu: &Gpu, effort: &Effort, watch: &Watch<'_>) -> Chapter {
    let mut entries = Vec::new();
    for (done, (id, source, title, make)) in ENTRIES.into_iter().enumerate() {
        let tell = |what: &str| watch(done, ENTRIES.len(), &format!("{title}: {what}"));
        watch(done, ENTRIES.len(), title);
        let mut bench = Bench::new(gpu, effort, &tell);
        let entry = make(&mut bench)
            .unwrap_or_else(|error| Entry { failure: Some(error.to_string()), ..Entry::default() });
        entries.push(Entry { id, source, title, ..entry });
    }
    Chapter {
        stem: "papers",
        title: "The papers made again",
        lead: "Tables and figures of the papers that this project implements, made again. Times are medians of rounds in which \
               every row draws one frame; ratios are taken within a round. Errors are those of each light’s factor against an \
               exact ray tracer in f64; “wrong” pixels are off by more than one half, outside the ambiguity band of \
               rasterisation unless said otherwise. Their times are those of their machines: ratios can be compared, \
               milliseconds cannot.",
        adapter: gpu.name(),
        processors: std::thread::available_parallelism().map_or(1, usize::from),
        effort: effort.name,
        size_px: effort.size_px,
        entries,
    }
}
