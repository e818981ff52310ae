//! `TransparentShadow` broken on purpose: what is seen through glass, and on it, turns wrong where it must.

use std::sync::Arc;

use crate::broken::{Broken, Spoil, reword};
use shadowgraph::cases;
use shadowgraph::engine::scene::Params;
use shadowgraph::engine::shadow::{Catalog, ShadowTechnique, TechniqueEntry};
use shadowgraph::engine::shadow::{Draw, Geometry};
use shadowgraph::measure::{evaluate, evaluate_layers};
use shadowgraph::nodes::TransparentShadow;
use shadowgraph::prelude::*;

/// `TransparentShadow`, with something done to every draw of its sums.
fn broken(spoil: fn(&mut Draw)) -> Arc<dyn ShadowTechnique> {
    Arc::new(Broken { technique: Arc::new(TransparentShadow::default()), spoil: Spoil::Volumes(spoil) })
}

/// How many pixels of these cases have a factor outside its bounds when every draw of a volume is spoilt so: on opaque surfaces,
/// and on layers.
fn wrong(from_params: TechniqueFromParams, ids: &[&str]) -> Option<[usize; 2]> {
    let entry = TechniqueEntry { from_params, settings: &[], ..TransparentShadow::ENTRY };
    let mut catalog = Catalog::new();
    catalog.register(entry);
    let mut renderer = Renderer::new(shadowgraph_testing::renderer()?.gpu().clone(), catalog);
    let cases = cases::all().into_iter().filter(|entry| ids.contains(&entry.id));
    let mut wrong = [0, 0];
    for case in cases.flat_map(|entry| entry.build(&shadowgraph::CAST)) {
        let scene = case.scene_with(&entry, &Params::new()).unwrap();
        let request = case.request();
        let opaque = evaluate(&mut renderer, &scene, &request, &|_, _| {}).unwrap();
        let count = renderer.plan(&scene, &request).unwrap().layers;
        let layers = evaluate_layers(&mut renderer, &scene, &request, 0..count, &|_, _| {}).unwrap();
        let compared = layers.iter().flat_map(|layer| &layer.errors).map(|error| error.compared);
        assert!(compared.sum::<usize>() > 0, "{} has no layers", case.name());
        let here = [
            opaque.errors.iter().map(|error| error.outside_bounds).sum::<usize>(),
            layers.iter().flat_map(|layer| &layer.errors).map(|error| error.outside_bounds).sum(),
        ];
        println!("{}: {here:?} wrong on opaque surfaces and on layers", case.name());
        wrong = [0, 1].map(|place| wrong[place] + here[place]);
    }
    Some(wrong)
}

type TechniqueFromParams =
    fn(&Params) -> Result<Arc<dyn ShadowTechnique>, shadowgraph::engine::shadow::OptionError>;

const CASES: [&str; 3] = ["glass-self", "panes-intersecting", "tinted-bottle"];

#[test]
fn sound_nothing_is_wrong() {
    let sound: TechniqueFromParams = |_| Ok(broken(|_| ()));
    let Some(wrong) = wrong(sound, &CASES) else { return };
    assert_eq!(wrong, [0, 0]);
}

#[test]
fn a_missing_cap() {
    // The last triangles of each run of a volume.
    let spoilt: TechniqueFromParams = |_| {
        Ok(broken(|draw| {
            if let Geometry::Indexed { count, .. } | Geometry::Numbered { count, .. } = &mut draw.geometry {
                *count = (*count - 6).max(3);
            }
        }))
    };
    let Some([opaque, layers]) = wrong(spoilt, &CASES) else { return };
    assert!(opaque > 20 && layers > 20, "{opaque} and {layers}");
}

#[test]
fn a_class_counted_twice() {
    // Every surface is two surfaces of its class.
    let spoilt: TechniqueFromParams = |_| {
        Ok(broken(|draw| {
            draw.state.blend_constant = draw.state.blend_constant.map(|weight| 2.0 * weight);
        }))
    };
    let Some([opaque, layers]) = wrong(spoilt, &CASES) else { return };
    assert!(opaque > 500 && layers > 500, "{opaque} and {layers}");
}

#[test]
fn a_layer_shadowed_by_its_own_surface() {
    // What is left at the very depth of what is seen is taken not to be left yet. Opaque surfaces do not mind.
    let spoilt: TechniqueFromParams = |_| {
        Ok(broken(|draw| {
            draw.state.depth_bias = -draw.state.depth_bias.abs();
            reword(draw, "AHEAD_SHIFT, 1.0, lies_in_cap", "AHEAD_SHIFT, 0.0, lies_in_cap");
        }))
    };
    let Some([opaque, layers]) = wrong(spoilt, &CASES) else { return };
    assert!(opaque == 0 && layers > 500, "{opaque} and {layers}");
}
