//! `report.json`: everything that was measured.

use serde_json::{Map, Value, json};
use shadowgraph_engine::scene::{ParamValue, Params};

use super::data::{AxisReport, Measurement, MotionReport, Outcome, Point, Report, SceneReport, SweepReport};
use super::fit::fit;
use super::tables::axis_points;
use super::totals::Totals;
use crate::compare::json::{error_json, finite, spread_json};
use crate::compare::timing::{FrameTimes, Spread};

pub(super) fn report_json(report: &Report) -> Value {
    let techniques: Vec<Value> = report
        .techniques
        .iter()
        .map(|[type_name, short_name, summary]| {
            json!({ "type": type_name, "name": short_name, "summary": summary })
        })
        .collect();
    json!({
        "shadowgraph": env!("CARGO_PKG_VERSION"),
        "adapter": report.adapter,
        "processors": report.processors,
        "effort": report.effort,
        "size_px": report.size_px,
        "techniques": techniques,
        "scenes": report.scenes.iter().map(scene_json).collect::<Vec<_>>(),
        "scaling": report.axes.iter().map(axis_json).collect::<Vec<_>>(),
        "motion": report.motions.iter().map(motion_json).collect::<Vec<_>>(),
        "sweep_shrink": report.sweep_shrink,
        "sweeps": report.sweeps.iter().map(sweep_json).collect::<Vec<_>>(),
        "failures": report.failures(),
    })
}

fn motion_json(motion: &MotionReport) -> Value {
    let techniques = motion.techniques.iter();
    let techniques = techniques.map(|(name, outcome)| step_json("name", name.as_str(), outcome, frames_json));
    json!({
        "scene": motion.scene,
        "shows": motion.shows,
        "moves": motion.moves,
        "unshadowed": motion.unshadowed.as_ref().map(frames_json),
        "techniques": techniques.collect::<Vec<_>>(),
    })
}

fn frames_json(times: &FrameTimes) -> Value {
    json!({
        "wall": spread_json(&times.wall_ms),
        "plan": spread_json(&times.plan_ms),
        "encode": spread_json(&times.encode_ms),
    })
}

fn scene_json(scene: &SceneReport) -> Value {
    if let Some(failure) = &scene.failure {
        return json!({ "name": scene.name, "shows": scene.shows, "status": "failed", "reason": failure });
    }
    json!({
        "name": scene.name,
        "shows": scene.shows,
        "status": "measured",
        "triangles": scene.triangles,
        "light_count": scene.lights,
        "rounds": scene.rounds,
        "unshadowed": spread_json(&scene.unshadowed_ms),
        "reference_ms": scene.reference_ms,
        "no_shadows": scene.none.as_ref().map(totals_json),
        "points": scene.points.iter().map(point_json).collect::<Vec<_>>(),
    })
}

fn point_json(point: &Point) -> Value {
    let mut entry = Map::new();
    let mut put = |name: &str, value: Value| drop(entry.insert(name.into(), value));
    put("technique", json!(point.technique));
    put("name", json!(point.short_name));
    put("setting", json!(point.setting));
    put("why", json!(point.why));
    put("params", params_json(&point.params));
    put("known_error", json!(point.known_error));
    match &point.outcome {
        Outcome::Refused(reason) => {
            put("status", json!("refused"));
            put("reason", json!(reason));
        }
        Outcome::Failed(reason) => {
            put("status", json!("failed"));
            put("reason", json!(reason));
        }
        Outcome::Measured(measurement) => {
            put("status", json!("measured"));
            let Value::Object(measured) = measurement_json(measurement) else {
                return json!({});
            };
            entry.extend(measured);
        }
    }
    Value::Object(entry)
}

fn measurement_json(measurement: &Measurement) -> Value {
    let passes: Vec<Value> = measurement
        .passes
        .iter()
        .map(|pass| {
            json!({
                "name": pass.name,
                "reason": pass.reason,
                "draws": pass.draws,
                "vertices": pass.vertices,
                "gpu_ms": pass.gpu_ms.map(|ms| ms.median),
                "gpu": pass.gpu_ms.as_ref().map(spread_json),
            })
        })
        .collect();
    let lights: Vec<Value> = measurement
        .lights
        .iter()
        .map(|(technique, error)| {
            json!({ "name": error.name, "technique": technique, "error": error_json(error) })
        })
        .collect();
    let mut frames = spread_json(&measurement.shadowed_ms);
    frames["count"] = json!(measurement.rounds);
    frames["wall"] = spread_json(&measurement.shadowed_ms);
    frames["gpu"] = measurement.gpu_ms.as_ref().map_or(Value::Null, spread_json);
    let [light, map, reference] = match &measurement.worst {
        Some(worst) => worst.clone().map(Value::from),
        None => [Value::Null, Value::Null, Value::Null],
    };
    json!({
        "frames": frames,
        "ratio": numbers_json(&measurement.ratio),
        "passes": passes,
        "gpu_bytes": measurement.gpu_bytes,
        "plan_bytes": measurement.plan_bytes,
        "judged_size_px": measurement.judged_size_px,
        "error": totals_json(&measurement.totals),
        "same_samples": measurement.same_samples.map(|(count, outside)| {
            json!({ "count": count, "outside": outside })
        }),
        "lights": lights,
        "picture": measurement.picture,
        "worst_light": light,
        "error_map": map,
        "reference_picture": reference,
        "plan": measurement.plan,
    })
}

/// A spread of values that are no times.
fn numbers_json(values: &Spread) -> Value {
    json!({
        "median": values.median,
        "lower_quartile": values.lower,
        "upper_quartile": values.upper,
        "min": values.min,
        "max": values.max,
    })
}

fn totals_json(totals: &Totals) -> Value {
    json!({
        "compared": totals.compared,
        "different_triangle": totals.different_triangle,
        "boundary_pixels": totals.boundary_pixels,
        "band_pixels": totals.band_pixels,
        "wrong": totals.wrong,
        "leak": totals.leak,
        "false": totals.false_shadow,
        "wrong_outside_band": totals.wrong_outside_band,
        "leak_outside_band": totals.leak_outside_band,
        "false_outside_band": totals.false_outside_band,
        "rmse": totals.rmse,
        "leak_mean": totals.leak_mean,
        "false_mean": totals.false_mean,
        "outside_bounds": totals.outside_bounds,
        "rmse_outside_band": totals.rmse_outside_band,
        "penumbra_pixels": totals.penumbra_pixels,
        "penumbra_rmse": totals.penumbra_rmse,
        "signed_mean": totals.signed_mean,
        "p99": totals.p99,
        "max": totals.max,
        "max_outside_band": totals.max_outside_band,
        "boundary_distance_mean_px": finite(totals.boundary_distance_mean_px),
        "boundary_distance_max_px": finite(totals.boundary_distance_max_px),
        "exact": totals.is_exact,
    })
}

fn params_json(params: &Params) -> Value {
    let value = |value: &ParamValue| match value {
        ParamValue::Text(text) => json!(text),
        ParamValue::Number(number) => json!(number),
        ParamValue::Flag(flag) => json!(flag),
        ParamValue::Numbers(numbers) => json!(numbers),
    };
    Value::Object(params.iter().map(|(name, v)| (name.clone(), value(v))).collect())
}

fn step_json<T>(
    name: &str,
    at: impl Into<Value>,
    outcome: &Outcome<T>,
    measured: impl Fn(&T) -> Value,
) -> Value {
    let at = at.into();
    match outcome {
        Outcome::Measured(value) => {
            json!({ name: at, "status": "measured", "measured": measured(value) })
        }
        Outcome::Refused(reason) => json!({ name: at, "status": "refused", "reason": reason }),
        Outcome::Failed(reason) => json!({ name: at, "status": "failed", "reason": reason }),
    }
}

fn axis_json(axis: &AxisReport) -> Value {
    let techniques: Vec<Value> = axis
        .techniques
        .iter()
        .map(|(name, steps)| {
            let fitted = fit(&axis_points(steps)).map(|fit| {
                json!({
                    "exponent": fit.exponent,
                    "standard_error": fit.standard_error,
                    "from": fit.range[0],
                    "to": fit.range[1],
                    "points": fit.points,
                })
            });
            let steps = steps.iter().map(|step| step_json("value", step.value, &step.outcome, spread_json));
            json!({ "name": name, "added": steps.collect::<Vec<_>>(), "fit": fitted })
        })
        .collect();
    let unshadowed =
        axis.unshadowed_ms.iter().map(|(value, ms)| json!({ "value": value, "measured": spread_json(ms) }));
    json!({
        "parameter": axis.parameter,
        "shows": axis.shows,
        "unshadowed": unshadowed.collect::<Vec<_>>(),
        "techniques": techniques,
    })
}

fn sweep_json(sweep: &SweepReport) -> Value {
    let techniques: Vec<Value> = sweep
        .techniques
        .iter()
        .map(|(name, steps)| {
            let steps = steps.iter().map(|step| step_json("value", step.value, &step.outcome, totals_json));
            json!({ "name": name, "error": steps.collect::<Vec<_>>() })
        })
        .collect();
    json!({
        "id": sweep.id,
        "parameter": sweep.parameter,
        "unit": sweep.unit,
        "scale": if sweep.is_log { "log" } else { "linear" },
        "what_breaks": sweep.what_breaks,
        "f32_loses": sweep.f32_loses,
        "techniques": techniques,
    })
}
