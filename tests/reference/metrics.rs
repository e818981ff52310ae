//! The comparator itself: what must fail does fail, and what is counted is counted right.

use shadowgraph::measure::pictures::{self, PictureError};
use shadowgraph::measure::{
    CompareError, ErrorTable, Hit, LightError, LightReference, Measured, ReferenceImage, SoftBounds, Verdict,
    compare, expect_shadow,
};

const SIZE: [u32; 2] = [64, 48];
const PIXELS: usize = 64 * 48;

/// A square shadow from (20, 15) to (40, 30) on a floor of two triangles, with nothing in the top four rows, the
/// shadow's outline in the band where `band` says so.
fn reference(band: bool) -> ReferenceImage {
    let at = |pixel: usize| (pixel % 64, pixel / 64);
    let is_dark = |(x, y): (usize, usize)| (20..40).contains(&x) && (15..30).contains(&y);
    let hits: Vec<_> = (0..PIXELS)
        .map(at)
        .map(|(x, y)| (y >= 4).then_some(Hit { instance: 3, triangle: u32::from(x > y) }))
        .collect();
    let factor = |hit: &Option<Hit>, dark: bool| hit.map_or(f32::NAN, |_| if dark { 0.0 } else { 1.0 });
    let at_edge = |(x, y): (usize, usize)| {
        let corners = [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
        corners.iter().any(|corner| is_dark(*corner) != is_dark((x, y)))
    };
    let light = LightReference {
        name: "sun".into(),
        factor: hits.iter().enumerate().map(|(pixel, hit)| factor(hit, is_dark(at(pixel)))).collect(),
        compared: hits.iter().map(Option::is_some).collect(),
        ambiguous: (0..PIXELS).map(|p| band && hits[p].is_some() && at(p).0 > 0 && at_edge(at(p))).collect(),
        ..LightReference::default()
    };
    ReferenceImage { size_px: SIZE, hits, lights: vec![light], ..ReferenceImage::default() }
}

fn measured(reference: &ReferenceImage) -> Measured {
    let ids = reference.hits.iter().map(|h| h.map_or([u32::MAX; 2], |h| [h.instance, h.triangle]));
    let light = &reference.lights[0];
    Measured {
        size_px: reference.size_px,
        ids: ids.collect(),
        lights: vec![(light.name.clone(), light.factor.clone())],
    }
}

/// The errors when each measured factor is changed by `change(pixel, factor)`.
fn errors(band: bool, change: impl Fn(usize, f32) -> f32) -> LightError {
    let reference = reference(band);
    let mut measured = measured(&reference);
    let factors = reference.lights[0].factor.iter().enumerate();
    measured.lights[0].1 = factors.map(|(pixel, factor)| change(pixel, *factor)).collect();
    compare(&measured, &reference).expect("the pictures belong together").remove(0)
}

#[test]
fn an_equal_picture_passes_with_all_errors_zero() {
    let error = errors(true, |_, f| f);
    assert!(error.passes(), "{error:?}");
    assert_eq!((error.wrong, error.rmse, error.max, error.p99), (0, 0.0, 0.0, 0.0));
    assert_eq!((error.compared, error.shadow_pixels), (64 * 44, 300));
    // Left and upper neighbours of the edge carry the mark: 2·20 + 2·15, less the corner inside that has both.
    assert_eq!(error.boundary_pixels, 69);
    expect_shadow(&[error]).unwrap();
}

#[test]
fn an_inverted_picture_fails() {
    let error = errors(true, |_, f| 1.0 - f);
    assert!(!error.passes());
    assert_eq!((error.wrong, error.leak, error.false_shadow), (64 * 44, 300, 64 * 44 - 300));
    assert_eq!((error.rmse, error.max), (1.0, 1.0));
}

#[test]
fn a_blank_picture_fails() {
    let error = errors(true, |_, _| 1.0);
    assert!(!error.passes());
    assert_eq!((error.leak, error.false_shadow), (300, 0));
    assert!(error.leak_outside_band > 0 && error.leak_outside_band < 300);
    assert!((error.signed_mean - 300.0 / error.compared as f64).abs() < 1e-12);
    let picture = "measured picture";
    assert_eq!(
        expect_shadow(&[error]),
        Err(CompareError::NoShadow { light: "sun".into(), picture, compared: 64 * 44 })
    );
}

#[test]
fn a_shifted_picture_fails_unless_the_band_covers_the_shift() {
    let exact = reference(false).lights[0].factor.clone();
    let shifted = |by: usize| {
        let exact = exact.clone();
        move |pixel: usize, _: f32| {
            let from = exact[pixel.saturating_sub(by)];
            if from.is_nan() { 1.0 } else { from }
        }
    };
    let error = errors(false, shifted(1));
    assert_eq!((error.leak, error.false_shadow, error.leak_outside_band), (15, 15, 15));
    assert!(!error.passes());
    assert!(error.boundary_distance_max_px <= 1.0);
    assert!(errors(true, shifted(1)).passes());
    // Along the rows as well as across them.
    assert!(!errors(true, shifted(2)).passes() && !errors(true, shifted(64 * 2)).passes());
    let error = errors(true, shifted(5));
    assert!(!error.passes());
    assert!(error.boundary_distance_max_px >= 4.0 && error.boundary_distance_mean_px > 1.0);
}

#[test]
fn wrong_shapes_and_names_are_refused() {
    let reference = reference(true);
    let good = measured(&reference);
    let refused = |change: &dyn Fn(&mut Measured)| {
        let mut bad = good.clone();
        change(&mut bad);
        compare(&bad, &reference).unwrap_err()
    };
    assert!(matches!(refused(&|m| m.size_px = [48, 64]), CompareError::Size { .. }));
    // Another size with all its pixels, too.
    let smaller = |m: &mut Measured| {
        m.size_px = [64, 47];
        m.ids.truncate(64 * 47);
        m.lights[0].1.truncate(64 * 47);
    };
    assert!(matches!(refused(&smaller), CompareError::Size { measured: [64, 47], reference: SIZE }));
    assert!(matches!(refused(&|m| m.ids.truncate(5)), CompareError::Length { count: 5, .. }));
    assert!(matches!(refused(&|m| m.lights[0].1.truncate(6)), CompareError::Length { count: 6, .. }));
    assert!(matches!(refused(&|m| m.lights.clear()), CompareError::MissingLight { .. }));
    assert!(matches!(refused(&|m| m.lights[0].0 = "moon".into()), CompareError::UnknownLight { .. }));
    assert!(matches!(
        refused(&|m| m.lights[0].1[64 * 20] = f32::NAN),
        CompareError::NotFinite { x: 0, y: 20, .. }
    ));
}

#[test]
fn hollow_comparisons_do_not_pass() {
    let reference = reference(true);
    // Another triangle everywhere: nothing is compared.
    let mut elsewhere = measured(&reference);
    elsewhere.ids = vec![[9, 9]; PIXELS];
    let error = compare(&elsewhere, &reference).unwrap().remove(0);
    assert_eq!((error.compared, error.different_triangle, error.wrong), (0, PIXELS, 0));
    assert!(!error.passes());
    assert!(matches!(expect_shadow(&[error]), Err(CompareError::NothingCompared { .. })));
    assert_eq!(errors_of(&elsewhere, &reference).verdict(), Verdict::SeesOtherSurfaces);
    // Nothing within the light's range: that is no mistake, and nothing exact either.
    let mut out_of_range = reference.clone();
    out_of_range.lights[0].compared.fill(false);
    let error = errors_of(&measured(&reference), &out_of_range);
    assert_eq!((error.verdict(), error.passes(), error.fails()), (Verdict::NothingCompared, false, false));
    assert!(ErrorTable(std::slice::from_ref(&error)).to_string().ends_with("nothing compared"));
    // A scene without shadow.
    let mut lit = reference.clone();
    lit.lights[0].factor.iter_mut().filter(|f| !f.is_nan()).for_each(|f| *f = 1.0);
    let errors = compare(&measured(&lit), &lit).unwrap();
    assert!(matches!(expect_shadow(&errors), Err(CompareError::NoShadow { picture: "reference", .. })));
    // A band that swallows the picture.
    let mut wide = reference.clone();
    wide.lights[0].ambiguous.fill(true);
    let error = compare(&measured(&wide), &wide).unwrap().remove(0);
    assert!(error.band_too_wide && !error.passes());
}

fn errors_of(measured: &Measured, reference: &ReferenceImage) -> LightError {
    compare(measured, reference).expect("the pictures belong together").remove(0)
}

#[test]
fn a_whole_lights_band_is_held_to_its_limit_too() {
    // Every pixel may be anything, and nothing is excused by that.
    let mut wide = reference(false);
    for same_samples in [None, Some(16)] {
        let bounds = vec![[0.0, 1.0]; PIXELS];
        wide.lights[0].ambiguous.fill(true);
        wide.lights[0].soft = Some(SoftBounds { same_samples, bounds, boundary_px: 69.0 });
        let error = errors_of(&measured(&wide), &wide);
        assert!(error.band_too_wide && error.verdict() == Verdict::BandTooWide, "{error:?}");
        assert!(error.band_px == (64 * 44) as f64 && error.band_limit_px < 250.0, "{error:?}");
    }
}

#[test]
fn a_light_has_one_verdict() {
    let error = errors(true, |_, _| 1.0);
    assert!(error.fails());
    let judged = |by_samples| LightError { by_samples: Some(by_samples), ..error.clone() };
    assert!(
        judged(Verdict::Exact).passes()
            && judged(Verdict::NothingCompared).verdict() == Verdict::NothingCompared
    );
    let fine = errors(true, |_, f| f);
    assert!(LightError { by_samples: Some(Verdict::Wrong), ..fine.clone() }.fails());
    // What owes no more than to come near says so, and is not called exact for it.
    let near = |error: LightError| LightError { approximates: true, ..error };
    assert_eq!((error.verdict(), near(error.clone()).verdict()), (Verdict::Wrong, Verdict::Approximates));
    assert!(near(error).fails() && near(fine).passes());
}

/// Three channels from one: what `change(channel, pixel, factor)` makes of it.
fn colored(factor: &[f32], change: impl Fn(usize, usize, f32) -> f32) -> Vec<f32> {
    let channels = |(pixel, factor): (usize, &f32)| [0, 1, 2].map(|channel| change(channel, pixel, *factor));
    factor.iter().enumerate().flat_map(channels).collect()
}

#[test]
fn a_colored_factor_is_judged_by_channel_and_by_its_worst() {
    // Red glass: it takes green and blue away, half of the red and all but a tenth of the blue.
    let mut reference = reference(true);
    let tint =
        |channel: usize, _: usize, factor: f32| if factor == 0.0 { [0.5, 0.0, 0.1][channel] } else { factor };
    let grey = reference.lights[0].factor.clone();
    reference.lights[0].factor = colored(&grey, tint);
    let judge = |factor: Vec<f32>| {
        let mut picture = measured(&reference);
        picture.lights[0].1 = factor;
        compare(&picture, &reference).unwrap().remove(0)
    };
    let error = judge(colored(&grey, tint));
    assert!(error.passes() && error.max == 0.0, "{error:?}");
    assert_eq!((error.shadow_pixels, error.boundary_pixels), (300, 69));
    let penumbra = error.channels.iter().map(|channel| channel.penumbra_pixels);
    assert_eq!(penumbra.collect::<Vec<_>>(), [300, 0, 300]);
    let names = error.channels.iter().map(|channel| channel.name.as_str());
    assert_eq!(names.collect::<Vec<_>>(), ["sun red", "sun green", "sun blue"]);

    // Green lit where it is dark: a leak of the light, and of green alone.
    let error = judge(colored(
        &grey,
        |channel, pixel, f| if channel == 1 { f.max(1.0) } else { tint(channel, pixel, f) },
    ));
    assert!(!error.passes());
    let leaks = error.channels.iter().map(|channel| (channel.leak, channel.passes()));
    assert_eq!(leaks.collect::<Vec<_>>(), [(0, true), (300, false), (0, true)]);
    assert_eq!((error.leak, error.false_shadow, error.max), (300, 0, 1.0));

    // A tenth too dark in red is not wrong by a half, but exact it is not either.
    let error = judge(colored(&grey, |channel, pixel, f| {
        tint(channel, pixel, f) - if channel == 0 && f == 0.0 { 0.1 } else { 0.0 }
    }));
    assert_eq!((error.wrong, error.channels[0].wrong), (0, 0));
    assert!(!error.passes() && !error.channels[0].passes() && error.channels[1].passes());
    assert!((error.max_outside_band - 0.1).abs() < 1e-6 && error.signed_mean < 0.0);

    // Red and green exchanged.
    let error = judge(colored(&grey, |channel, pixel, f| tint([1, 0, 2][channel], pixel, f)));
    assert!(!error.passes());
    let max = error.channels.iter().map(|channel| channel.max);
    assert_eq!(max.collect::<Vec<_>>(), [0.5, 0.5, 0.0]);

    // A grey picture of a coloured shadow, and the other way round.
    assert!(!judge(grey.clone()).passes());
    let hard = self::reference(true);
    let mut picture = measured(&hard);
    picture.lights[0].1 = colored(&grey, |_, _, factor| factor);
    let error = compare(&picture, &hard).unwrap().remove(0);
    assert!(error.passes() && error.channels.len() == 3);
    picture.lights[0].1.truncate(2 * PIXELS);
    assert!(matches!(compare(&picture, &hard), Err(CompareError::Length { .. })));
}

#[test]
fn penumbrae_have_an_error_of_their_own() {
    // A ramp of 20 columns from dark to lit instead of the square's right edge.
    let mut reference = reference(false);
    let ramp = |pixel: usize| (pixel % 64) as f32 / 20.0 - 1.0;
    let soft = |pixel: usize, factor: f32| if factor == 0.0 { ramp(pixel).clamp(0.0, 1.0) } else { factor };
    let factors = reference.lights[0].factor.iter().enumerate();
    reference.lights[0].factor = factors.map(|(pixel, factor)| soft(pixel, *factor)).collect();
    let exact = measured(&reference);
    let error = compare(&exact, &reference).unwrap().remove(0);
    // The first column of the square is umbra, the other 19 are penumbra.
    assert_eq!((error.penumbra_pixels, error.penumbra_rmse, error.shadow_pixels), (285, 0.0, 300));

    let mut darker = exact.clone();
    let in_penumbra = |factor: &f32| *factor > 0.0 && *factor < 1.0;
    darker.lights[0].1.iter_mut().filter(|f| in_penumbra(f)).for_each(|f| *f -= 0.04);
    let error = compare(&darker, &reference).unwrap().remove(0);
    assert!((error.penumbra_rmse - 0.04).abs() < 1e-6, "{}", error.penumbra_rmse);
    let share = 285.0 / (64.0 * 44.0_f64);
    assert!(
        (error.rmse - 0.04 * share.sqrt()).abs() < 1e-6 && (error.signed_mean + 0.04 * share).abs() < 1e-6
    );
    assert!((error.p99 - 0.04).abs() < 1e-6 && error.wrong == 0 && !error.passes());

    // A hard edge in the middle of the ramp.
    let mut hard = exact.clone();
    hard.lights[0].1.iter_mut().filter(|f| in_penumbra(f)).for_each(|f| *f = f.round());
    let error = compare(&hard, &reference).unwrap().remove(0);
    assert!(error.penumbra_rmse > 0.25 && error.penumbra_rmse < 0.32, "{}", error.penumbra_rmse);
}

#[test]
fn the_table_has_a_line_for_each_light() {
    let errors = [errors(true, |_, f| f), errors(true, |_, _| 1.0)];
    let table = ErrorTable(&errors).to_string();
    let lines: Vec<_> = table.lines().collect();
    assert_eq!(lines.len(), 3, "{table}");
    assert!(
        lines[0].starts_with("light") && lines[1].ends_with("ok") && lines[2].ends_with("FAILS"),
        "{table}"
    );
    assert!(lines.iter().all(|line| line.chars().count() == lines[0].chars().count()), "{table}");
}

#[test]
fn pictures_hold_what_was_written() {
    let folder = std::env::temp_dir().join(format!("shadowgraph-pictures-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let reference = reference(true);
    let factor = &reference.lights[0].factor;
    let exr = folder.join("sun.exr");
    pictures::write_factor(&exr, SIZE, factor).unwrap();
    let read = image::open(&exr).unwrap().into_rgb32f();
    assert_eq!(read.dimensions(), (64, 48));
    for (pixel, exact) in read.pixels().zip(factor) {
        assert!(pixel.0.iter().all(|c| c.to_bits() == exact.to_bits() || c.is_nan() && exact.is_nan()));
    }

    let mut bad = measured(&reference);
    bad.lights[0].1[64 * 20 + 30] = 1.0;
    bad.lights[0].1[64 * 40 + 30] = 0.0;
    bad.ids[64 * 45 + 30] = [0, 0];
    let png = folder.join("sun.png");
    pictures::write_error_map(&png, &bad, &reference, "sun").unwrap();
    let map = image::open(&png).unwrap().into_rgb8();
    let at = |x, y| map.get_pixel(x, y).0;
    assert!(at(30, 20)[0] > 200 && at(30, 20)[2] < 100, "leak");
    assert!(at(30, 40)[2] > 200 && at(30, 40)[0] < 100, "false shadow");
    assert_eq!(at(30, 45), [128; 3], "different triangle");
    assert!(at(20, 20)[0] > 200 && at(20, 20)[1] > 150, "band");
    assert_eq!([at(0, 0), at(30, 22), at(5, 40)], [[0; 3], [20; 3], [90; 3]], "nothing, dark, lit");

    let wrong_size = pictures::write_factor(&exr, [64, 47], factor);
    assert!(matches!(wrong_size, Err(PictureError::Size { .. })));
    let no_folder = pictures::write_factor(&folder.join("none/sun.exr"), SIZE, factor);
    assert!(matches!(no_folder, Err(PictureError::Write { .. })));
    let no_light = pictures::write_error_map(&png, &bad, &reference, "moon");
    assert!(matches!(no_light, Err(PictureError::MissingLight { .. })));
    let left = std::fs::read_dir(&folder).unwrap().count();
    assert_eq!(left, 2, "no half-written file stays");
    std::fs::remove_dir_all(&folder).unwrap();
}
