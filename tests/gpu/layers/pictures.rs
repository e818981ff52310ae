//! Pictures of transparent surfaces: blended in the order of every pixel, with the shadows on them.

use super::*;

#[test]
fn panes_that_pass_through_one_another_are_in_order_at_every_pixel() {
    let Some(mut renderer) = renderer() else { return };
    let unlit = |color: Vec3, alpha: f32| Material { unlit: true, ..blended(color, alpha) };
    let (red, green, floor) = (Vec3::new(1.0, 0.0, 0.1), Vec3::new(0.0, 0.8, 0.1), Vec3::splat(0.5));
    let matt = Material { unlit: true, ..Material::matt("floor", floor) };
    let panes = [(pane(0.3), unlit(red, 0.75)), (pane(-0.3), unlit(green, 0.5))];
    let mut checked = [0, 0];
    for swapped in [false, true] {
        let mut panes = panes.clone();
        if swapped {
            panes.reverse();
        }
        let mut scene = panes_over_floor(&panes, matt.clone(), "HardOnLayers");
        // Something for the light to fall on, aside.
        shadowgraph_testing::add_box(&mut scene, "crate", shadowgraph_testing::at(-2.2, 0.5, -1.3));
        let request = from_above([200, 160]);
        let picture = linear(&mut renderer, &scene, &request);
        let plan = renderer.plan(&scene, &request).unwrap();
        // One more at most, for pixels next to the diagonals.
        assert!((2..=4).contains(&plan.layers), "{plan}");
        let over = |front: (Vec3, f32), behind: Vec3| front.0 * front.1 + behind * (1.0 - front.1);
        let red_above = over((red, 0.75), over((green, 0.5), floor));
        let green_above = over((green, 0.5), over((red, 0.75), floor));
        for (pixel, texel) in picture.chunks_exact(4).enumerate() {
            let (x, y) = (pixel % 200, pixel / 200);
            // Well inside both panes; their common line is at x = 0, near the middle of the picture.
            if !(40..120).contains(&y) || !(60..92).contains(&x) && !(108..140).contains(&x) {
                continue;
            }
            let right = x > 100;
            let expected = if right { red_above } else { green_above };
            let color = Vec3::from_slice(texel);
            assert!((color - expected).abs().max_element() < 2e-3, "({x}, {y}): {color}, not {expected}");
            checked[usize::from(right)] += 1;
        }
    }
    assert!(checked.iter().all(|count| *count > 4000), "{checked:?}");
}

#[test]
fn stacks_blend_from_behind_whatever_the_order_of_drawing() {
    let Some(mut renderer) = renderer() else { return };
    let floor = Vec3::splat(0.5);
    let matt = Material { unlit: true, ..Material::matt("floor", floor) };
    let color = |i: usize| {
        Vec3::new(0.1, 0.2, 0.1)
            + 0.25 * Vec3::from_slice(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]][i % 3])
    };
    let unlit = |i: usize| Material { unlit: true, ..blended(color(i), 0.3 + 0.05 * i as f32) };
    // From below to above; then drawn in other orders.
    let stack: Vec<_> = (0..7).map(|i| (pane(0.0).moved(Vec3::Y * 0.1 * i as f32), unlit(i))).collect();
    let expected = (0..7).fold(floor, |behind, i| {
        let alpha = 0.3 + 0.05 * i as f32;
        color(i) * alpha + behind * (1.0 - alpha)
    });
    for order in [[0, 1, 2, 3, 4, 5, 6], [6, 5, 4, 3, 2, 1, 0], [3, 6, 0, 5, 2, 4, 1]] {
        let panes: Vec<_> = order.iter().map(|i| stack[*i].clone()).collect();
        for node in ["HardOnLayers", "HardOnFirst"] {
            let mut scene = panes_over_floor(&panes, matt.clone(), node);
            shadowgraph_testing::add_box(&mut scene, "crate", shadowgraph_testing::at(-2.2, 0.5, -1.3));
            let picture = linear(&mut renderer, &scene, &from_above([64, 48]));
            let middle = Vec3::from_slice(&picture[4 * (24 * 64 + 32)..]);
            assert!(
                (middle - expected).abs().max_element() < 2e-3,
                "{node}, {order:?}: {middle}, not {expected}"
            );
        }
    }
}

#[test]
fn pictures_are_those_of_the_reference() {
    let Some(mut renderer) = renderer() else { return };
    for name in ["glass-self/shell", "panes-intersecting", "tinted-bottle", "opaque-behind-glass/box-above"] {
        let case = glass_case(name);
        let mut picture = |technique: &str, shadowed: &str| {
            let scene = scene_of(&case, technique, &[("selfShadow", shadowed)]);
            linear(&mut renderer, &scene, &case.request())
        };
        let far = |(a, b): &(&[f32], &[f32])| {
            a.iter().zip(*b).any(|(a, b)| (a - b).abs() > 0.004 * a.abs().max(1.0))
        };
        let differ = |a: &[f32], b: &[f32]| a.chunks_exact(4).zip(b.chunks_exact(4)).filter(far).count();
        let (mut own, mut most) = (Vec::new(), 0);
        for shadowed in ["full", "partial", "none"] {
            own = picture("TransparentShadow", shadowed);
            let differ = differ(&own, &picture("Reference", shadowed));
            // Edges of shadows, where the two judge points a hair apart.
            assert!(differ * 200 < own.len() / 4, "{name}, {shadowed}: {differ} pixels differ");
            most = most.max(differ);
        }
        let shadows = differ(&own, &picture("Reference", "full"));
        assert!(shadows > 100 + 2 * most, "{name}: shadows on layers change {shadows} pixels, {most} differ");
    }
}

#[test]
fn single_panes_look_as_they_do_without_layers() {
    let Some(mut renderer) = renderer() else { return };
    let glass = Material {
        base_color: Vec4::new(0.9, 0.3, 0.2, 1.0),
        transmission: 0.8,
        roughness: 0.3,
        ..Material::default()
    };
    let panes = [
        blended(Vec3::new(0.9, 0.3, 0.2), 0.6),
        glass.clone(),
        Material { alpha_mode: AlphaMode::Blend, base_color: Vec4::new(0.9, 0.3, 0.2, 0.5), ..glass },
    ];
    for pane_material in panes {
        let pane = [(pane(0.2), pane_material)];
        // The hard technique leaves glass alone and casts nothing here but the floor.
        let pictures = ["ShadowVolumeHard", "HardOnLayers"].map(|node| {
            let scene = panes_over_floor(&pane, Material::default(), node);
            let layers = renderer.plan(&scene, &from_above([120, 96])).unwrap().layers;
            assert_eq!(layers > 0, node == "HardOnLayers");
            linear(&mut renderer, &scene, &from_above([120, 96]))
        });
        let [sorted, layered] = pictures;
        let bare = panes_over_floor(&[], Material::default(), "ShadowVolumeHard");
        let bare = linear(&mut renderer, &bare, &from_above([120, 96]));
        let differ = |a: &[f32], b: &[f32]| a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() > 0.02).count();
        assert!(differ(&sorted, &bare) > 3000);
        for (sorted, layered) in sorted.iter().zip(&layered) {
            assert!((sorted - layered).abs() <= 2e-3 * sorted.max(1.0), "{sorted} and {layered}");
        }
    }
}
