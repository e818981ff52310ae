//! The plan as text: what `inspect` prints, to the letter; and the shaders plans name.

use shadowgraph_engine::render::PictureFormat;
use shadowgraph_testing::*;

#[test]
fn a_simple_plan_reads_as_follows() {
    let text = plan(&shadowed_yard(&[]), &request()).to_string();
    assert_eq!(text, EXPECTED, "the text is now:\n{text}");
}

const EXPECTED: &str = "\
frame 64x48: 3 passes, 3 draws, 27856 bytes
  slot 0 'picture' Rgba8UnormSrgb 64x48, 12288 bytes: what was asked for
  slot 1 'volume indices of lamp' index buffer, 144 bytes: 4 silhouette edges, and the caps for views that need them
  slot 2 'volumes of lamp' storage buffer, 64 bytes: where the light is, as each caster sees it, and where its volume ends
  slot 3 'depth' Depth32FloatStencil8 64x48, 15360 bytes: hidden surfaces, and the counts of shadow volumes
  light lamp: ShadowVolumeHard -> Counts
  pass 'depth prepass': shadows need the visible surface before it is shaded
    depth 'depth' clear 0, stencil clear 32
    draw 'opaque surfaces' Depth surfaces, 2 parts, 42 vertices
  pass 'volumes of lamp': what casts between lamp and the view, casters: 1
    depth 'depth' read, stencil write
    draw 'crate closed z-pass to a plane' indexed, 24 vertices by shadow_volume_hard, reads 'volumes of lamp'
  pass 'shading': the only light
    color 'picture' layer 0 clear
    depth 'depth' read, stencil read
    draw 'opaque surfaces' Opaque surfaces, 2 parts, 42 vertices, reads stencil of 'depth'
";

/// Of many draws the first are listed, the rest summed up.
#[test]
fn long_passes_are_summed_up() {
    let mut scene = with_floor();
    for index in 0..12 {
        add_box(&mut scene, &format!("box{index}"), at(0.0, 1.5, f64::from(index) * 1.25 - 9.0));
    }
    add_lamp(&mut scene, "lamp");
    scene.add_shadow("shadows", hard(&[]));
    let plan = plan(&scene, &request());
    let draws = volume_draws(&plan, "lamp");
    assert_eq!(draws.len(), 12);
    let text = plan.to_string();
    let rest = index_count(&draws[8..]);
    assert!(text.contains(&format!("... and 4 draws more, {rest} vertices")), "{text}");
    assert!(text.contains("draw 'box7 ") && !text.contains("draw 'box8 "), "{text}");
}

/// Shaders reach plans as text: an empty one would fail on the GPU only.
#[test]
fn every_shader_of_a_plan_has_its_entry_points() {
    let mut scene = shadowed_yard(&[]);
    add_lamp(&mut scene, "second");
    let mut wanted = request();
    wanted.factors = true;
    wanted.picture = PictureFormat::LinearF32;
    let mut checked = 0;
    for plan in [plan(&scene, &wanted), plan(&yard(), &wanted), plan(&shadowed_yard(&[]), &wanted)] {
        for shader in
            plan.passes.iter().flat_map(|pass| &pass.draws).filter_map(|draw| draw.geometry.shader())
        {
            let module = naga::front::wgsl::parse_str(&shader.source).expect("it parses");
            let has =
                |stage, name: &str| module.entry_points.iter().any(|e| e.stage == stage && e.name == name);
            assert!(has(naga::ShaderStage::Vertex, &shader.vertex), "{} of {}", shader.vertex, shader.name);
            if let Some(fragment) = &shader.fragment {
                assert!(has(naga::ShaderStage::Fragment, fragment), "{fragment} of {}", shader.name);
            }
            checked += 1;
        }
    }
    assert!(checked > 8, "{checked}");
}
