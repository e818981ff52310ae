// A point of the visible surface, and how it reflects light: metallic-roughness as glTF 2.0 appendix B defines it
// (Lambert, GGX, height-correlated Smith, Schlick).

struct Surface {
    p_in_view: vec3f,
    // Unit, on the eye's side, normal map included.
    normal_in_view: vec3f,
    towards_eye_in_view: vec3f,
    // Unit normal of the triangle, on the eye's side.
    geometric_in_view: vec3f,
    // What the non-metallic part of the base colour scatters.
    diffuse: vec3f,
    // Mirrored at normal incidence.
    f0: vec3f,
    // Roughness squared, as GGX takes it.
    ggx_alpha: f32,
#if SURFACE_FUNCTION
    // In metres. Its last digits are lost far from the world's origin.
    p_in_world: vec3f,
    // Turns directions from view to world space.
    world_from_view: mat3x3f,
    // The mesh's first texture coordinates.
    uv: vec2f,
    // Linear; texture and vertex colour included.
    base_color: vec4f,
    metallic: f32,
    roughness: f32,
    // Where in the picture, in pixels from its top left corner.
    pixel: vec2f,
#endif
}

#if SURFACE_FUNCTION
// One light at a surface. Shadow is apart from light: what it means is for the surface function to say.
struct LightArriving {
    // Unit direction towards the light.
    towards_in_view: vec3f,
    // On a surface that faces the light, as if nothing shadowed it; times the picture's exposure.
    irradiance: vec3f,
    // What fraction of it passes all casters: 1 lit, 0 dark, also where the surface is turned away from the light. More
    // than passes them where shadow nodes have a weight below 1 or a colour.
    factor: vec3f,
}
#endif

// Outgoing radiance per unit of irradiance from direction `towards_in_view`, cosine included.
fn reflect_light(s: Surface, towards_in_view: vec3f) -> vec3f {
    let n_l = saturate(dot(s.normal_in_view, towards_in_view));
    let n_v = max(dot(s.normal_in_view, s.towards_eye_in_view), 1e-4);
    let h = normalize(towards_in_view + s.towards_eye_in_view);
    let n_h = saturate(dot(s.normal_in_view, h));
    let v_h = saturate(dot(s.towards_eye_in_view, h));
    let a2 = s.ggx_alpha * s.ggx_alpha;
    let d = n_h * n_h * (a2 - 1.0) + 1.0;
    let distribution = a2 / (3.14159265 * d * d);
    let smith = n_l * sqrt(n_v * n_v * (1.0 - a2) + a2) + n_v * sqrt(n_l * n_l * (1.0 - a2) + a2);
    let away = 1.0 - v_h;
    let away_2 = away * away;
    let fresnel = s.f0 + (1.0 - s.f0) * (away_2 * away_2 * away);
    let specular = fresnel * distribution * 0.5 / max(smith, 1e-6);
    return ((1.0 - fresnel) * s.diffuse * 0.31830989 + specular) * n_l;
}
