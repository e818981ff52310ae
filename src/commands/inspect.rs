//! `shadowgraph inspect`: what a scene is made of, and what a frame of it would do. Needs no GPU.
//!
//! A summary that fits a screen, whatever the scene: what casts and how closed it is, what receives, which technique
//! serves which light, what is wrong. `--tree` adds every node, `--plan` the frame plan with its reasons.

use std::collections::{BTreeSet, HashMap, HashSet};

use clap::Args;
use shadowgraph::engine::gltf::{Loaded, few_digits};
use shadowgraph::engine::plan::FramePlan;
use shadowgraph::engine::render::{Adapter, plan_frame};
use shadowgraph::engine::scene::{Instance, NodeKey, SceneSnapshot};
use shadowgraph::engine::shadow::{Cache, Registry};
use shadowgraph::prelude::*;

use super::Failure;
use super::output::out;
use super::scenes::{SceneArgs, catalog, load};
use super::tree::{self, lens, light_text, listed, quoted};
use super::view::empty_text;

/// The arguments of `inspect`.
#[derive(Debug, Args)]
pub(crate) struct InspectArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Lists every node, and everything known of every caster.
    #[arg(long)]
    tree: bool,
    /// Lists every texture, pass and draw of a frame, each with its reason.
    #[arg(long)]
    plan: bool,
}

/// Lines of one kind that the summary has at most.
const MOST_LINES: usize = 16;

/// More solids than this are described together, not one by one.
const MOST_SOLIDS: usize = 8;

/// What the summary calls a solid.
const CLOSED: &str = "closed";

pub(crate) fn run(args: &InspectArgs) -> Result<(), Failure> {
    let mut loaded = load(&args.scene.scene, args.scene.which_scene.as_deref(), args.scene.trust)?;
    let (scene, camera) = args.scene.prepare_loaded(std::mem::take(&mut loaded.scene))?;
    let snapshot = scene.snapshot().map_err(RenderError::from)?;
    let size = args.scene.size.0;
    print_heading(&scene, &snapshot, &camera);
    print_scenes(&loaded);
    print_animations(&scene);
    let planned = Registry::collect(&snapshot, &catalog()).map_err(RenderError::from).and_then(|registry| {
        let request = FrameRequest::new(camera.clone(), size);
        let plan = plan_frame(&snapshot, &registry, &request, &Adapter::imagined(), &Cache::new())?;
        Ok((registry, plan))
    });
    let (registry, plan) = match planned {
        Ok(planned) => planned,
        Err(refused) => {
            // What was asked for and can be told is told; the error says what cannot be.
            if args.tree {
                print_tree(&scene, &snapshot);
            }
            return Err(refused.into());
        }
    };
    print_lights(&snapshot, &registry);
    print_meshes(&snapshot, &registry);
    print_wrong(&wrong(&loaded, &snapshot, &registry, empty_text(&snapshot, &camera, size)));
    print_frame(&plan);
    if args.tree {
        print_tree(&scene, &snapshot);
    }
    if args.plan {
        out!("{plan}");
    }
    Ok(())
}

fn print_tree(scene: &Scene, snapshot: &SceneSnapshot) {
    tree::print_nodes(scene);
    tree::print_casters(snapshot);
}

/// "1 mesh", "2 meshes".
fn count(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

fn print_heading(scene: &Scene, snapshot: &SceneSnapshot, camera: &CameraSnapshot) {
    let triangles: usize = snapshot.instances.iter().map(|instance| instance.mesh.triangle_count()).sum();
    out!(
        "{}, {} of {triangles} triangles, {}, {}",
        count(scene.nodes().count(), "node", "nodes"),
        count(snapshot.instances.len(), "mesh", "meshes"),
        count(snapshot.lights.len(), "light", "lights"),
        count(snapshot.shadow_nodes.len(), "shadow node", "shadow nodes")
    );
    let size = snapshot.world_bounds.max - snapshot.world_bounds.min;
    if !snapshot.world_bounds.is_empty() {
        let [x, y, z] = size.to_array().map(few_digits);
        out!("size {x} by {y} by {z} m");
    }
    out!("seen by {}: {}", quoted(&camera.name), lens(&camera.projection));
    let others = snapshot.cameras.iter().filter(|other| other.name != camera.name);
    let others: Vec<String> = others.map(|other| quoted(&other.name)).collect();
    if !others.is_empty() {
        out!("other cameras: {}", listed(others.into_iter()));
    }
}

/// The file's scenes, where there are several to choose from.
fn print_scenes(loaded: &Loaded) {
    if loaded.scene_names.len() < 2 {
        return;
    }
    out!("scenes");
    print_some(loaded.scene_names.iter().enumerate().map(|(index, name)| {
        let shown = if loaded.scene_index == Some(index) { ", shown" } else { "" };
        format!("{index} {}{shown}", quoted(name))
    }));
}

/// What moves: clips with how long they last, and skins.
fn print_animations(scene: &Scene) {
    let animations: Vec<_> = scene.animations().map(|(_, animation)| animation).collect();
    if !animations.is_empty() {
        out!("animations");
    }
    print_some(animations.iter().map(|animation| {
        let nodes: HashSet<NodeKey> = animation.channels.iter().map(|channel| channel.node).collect();
        let (name, channels) = (quoted(&animation.name), animation.channels.len());
        format!("{name} {:.3} s, {channels} channels, {} nodes", animation.duration_s(), nodes.len())
    }));
    let skins: Vec<_> = scene.skins().map(|(_, skin)| skin).collect();
    if !skins.is_empty() {
        out!("skins");
    }
    print_some(skins.iter().map(|skin| format!("{} {} joints", quoted(&skin.name), skin.joints.len())));
}

/// Lines below a heading, and how many more there are.
fn print_some(lines: impl ExactSizeIterator<Item = String>) {
    let more = lines.len().saturating_sub(MOST_LINES);
    lines.take(MOST_LINES).for_each(|line| out!("  {line}"));
    if more > 0 {
        out!("  and {more} more");
    }
}

/// Every light, and what serves it.
fn print_lights(snapshot: &SceneSnapshot, registry: &Registry) {
    out!("lights");
    print_some(snapshot.lights.iter().zip(&registry.lights).map(|(light, claims)| {
        let served = claims.iter().map(|claim| {
            let changed = claim.label.strip_prefix(claim.type_name).unwrap_or_default();
            let casters = count(claim.casters.len(), "caster", "casters");
            let onto = match claim.technique.traits().shades_receivers_only {
                true => format!(" onto {}", count(claim.receivers.len(), "receiver", "receivers")),
                false => String::new(),
            };
            format!("{}{changed} by {} for {casters}{onto}", claim.type_name, quoted(&claim.node))
        });
        let served = if claims.is_empty() { "casts no shadow".into() } else { listed(served) };
        format!("{} {}: {served}", quoted(&light.name), light_text(&light.light))
    }));
    let claims = registry.lights.iter().flatten();
    let known: BTreeSet<(&str, &str)> =
        claims.map(|claim| (claim.type_name, claim.technique.traits().known_error)).collect();
    if !known.is_empty() {
        out!("techniques");
    }
    for (name, error) in known {
        out!("  {name}; known error: {error}");
    }
}

/// What casts, alike meshes together, then what does not, and what does not receive.
fn print_meshes(snapshot: &SceneSnapshot, registry: &Registry) {
    let mut casts = vec![false; snapshot.instances.len()];
    for claim in registry.lights.iter().flatten() {
        claim.casters.iter().for_each(|caster| casts[*caster] = true);
    }
    let mut groups: Vec<(String, Vec<&Instance>)> = Vec::new();
    let mut places: HashMap<(u64, String), usize> = HashMap::new();
    for (instance, _) in snapshot.instances.iter().zip(&casts).filter(|(_, casts)| **casts) {
        let text = closedness(instance);
        let place = *places.entry((instance.mesh.id(), text.clone())).or_insert_with(|| {
            groups.push((text, Vec::new()));
            groups.len() - 1
        });
        groups[place].1.push(instance);
    }
    // What is no solid first: that is what a technique may refuse, or draw at twice the cost.
    let (solids, others): (Vec<_>, Vec<_>) = groups.into_iter().partition(|(text, _)| text == CLOSED);
    out!(
        "casters: {} of {}",
        casts.iter().filter(|casts| **casts).count(),
        count(casts.len(), "mesh", "meshes")
    );
    let line = |(text, alike): &(String, Vec<&Instance>)| {
        let more = if alike.len() > 1 { format!(" and {} alike", alike.len() - 1) } else { String::new() };
        let triangles = count(alike[0].mesh.triangle_count(), "triangle", "triangles");
        format!("{}{more} {text}, {triangles}", quoted(&alike[0].name))
    };
    print_some(others.iter().map(line));
    if solids.len() <= MOST_SOLIDS {
        print_some(solids.iter().map(line));
    } else {
        let alike: Vec<&Instance> = solids.into_iter().flat_map(|(_, alike)| alike).collect();
        let names = listed(alike.iter().map(|instance| quoted(&instance.name)));
        out!("  closed: {} casters, {names}", alike.len());
    }
    let names = |wanted: &dyn Fn(usize) -> bool| -> Vec<String> {
        let chosen = snapshot.instances.iter().enumerate().filter(|(index, _)| wanted(*index));
        chosen.map(|(_, instance)| quoted(&instance.name)).collect()
    };
    let idle = names(&|index| !casts[index]);
    if !idle.is_empty() {
        out!("cast nothing: {}", listed(idle.into_iter()));
    }
    let deaf = names(&|index| !snapshot.instances[index].shadow.receives);
    if deaf.is_empty() {
        out!("receivers: all");
    } else {
        let all = snapshot.instances.len();
        out!("receivers: {} of {all}, all but {}", all - deaf.len(), listed(deaf.into_iter()));
    }
}

/// How closed a caster is, in a few words: what is not said is not there.
fn closedness(instance: &Instance) -> String {
    let topology = instance.mesh.topology();
    let found = topology.closedness();
    let faults = [
        (found.boundary_edges, "boundary edge"),
        (found.non_manifold_edges, "non-manifold edge"),
        (found.inconsistent_edges, "inconsistent edge"),
        (found.degenerate_triangles, "triangle without area"),
    ];
    let faults = faults.iter().filter(|(number, _)| *number > 0);
    let plural = |number: usize, what: &str| match what.split_once(' ') {
        _ if number == 1 => format!("{number} {what}"),
        Some(("triangle", rest)) => format!("{number} triangles {rest}"),
        _ => format!("{number} {what}s"),
    };
    let faults: Vec<String> = faults.map(|(number, what)| plural(*number, what)).collect();
    let solid = topology.orientation(&instance.world_from_local).is_some();
    let alpha = match (instance.is_opaque(), instance.is_masked()) {
        (false, _) => ", blended or transmissive",
        (true, true) => ", alpha-masked",
        (true, false) => "",
    };
    let state = if solid { CLOSED } else { "open" };
    if faults.is_empty() {
        format!("{state}{alpha}")
    } else {
        format!("{state} ({}){alpha}", faults.join(", "))
    }
}

/// Everything a person may want to mend.
fn wrong(
    loaded: &Loaded,
    snapshot: &SceneSnapshot,
    registry: &Registry,
    empty: Option<String>,
) -> Vec<String> {
    let mut wrong: Vec<String> = empty.into_iter().collect();
    wrong.extend(loaded.warnings.iter().cloned());
    for (light, claims) in snapshot.lights.iter().zip(&registry.lights) {
        if !claims.is_empty() && claims.iter().all(|claim| claim.casters.is_empty()) {
            wrong.push(format!("light {} has shadow nodes, but no casters", quoted(&light.name)));
        }
    }
    for node in &snapshot.shadow_nodes {
        if node.lights.is_empty() {
            wrong.push(format!("shadow node {} serves no light", quoted(&node.name)));
        }
    }
    let coloured = registry.lights.iter().flatten().any(|claim| claim.technique.traits().casts_transparent);
    let clear = snapshot.instances.iter().filter(|instance| instance.shadow.casts && !instance.is_opaque());
    let clear: Vec<String> = clear.map(|instance| quoted(&instance.name)).collect();
    if !clear.is_empty() && !coloured {
        let names = listed(clear.into_iter());
        wrong.push(format!("{names}: blended or transmissive parts cast only through a coloured technique"));
    }
    wrong.extend(loaded.remarks.iter().map(|remark| format!("{remark} (does no harm)")));
    wrong
}

fn print_wrong(wrong: &[String]) {
    if wrong.is_empty() {
        out!("wrong: nothing");
        return;
    }
    out!("wrong");
    print_some(wrong.iter().cloned());
}

fn print_frame(plan: &FramePlan) {
    let [width, height] = plan.size_px;
    let draws: usize = plan.passes.iter().map(|pass| pass.draws.len()).sum();
    out!(
        "a frame of {width}x{height}: {}, {}, {:.1} MiB (--plan lists them, --tree lists every node)",
        count(plan.passes.len(), "pass", "passes"),
        count(draws, "draw", "draws"),
        plan.bytes() as f64 / f64::from(1 << 20)
    );
    if !plan.notes.is_empty() {
        out!("not in that frame");
        print_some(plan.notes.iter().cloned());
    }
}
