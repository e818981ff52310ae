//! Argument values: sizes, vectors, lights, floors, techniques.

use std::str::FromStr;

use glam::DVec3;
use shadowgraph::engine::scene::{ParamValue, Params};

/// `WxH` in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Size(pub(crate) [u32; 2]);

impl Default for Size {
    fn default() -> Self {
        Self([1280, 720])
    }
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
        match parsed {
            Some(size) if size.iter().all(|n| *n > 0) => Ok(Self(size)),
            _ => Err("a size is two whole numbers above 0 joined by x, as in 1280x720".into()),
        }
    }
}

/// How far from the origin anything on the command line may be: beyond this, squares of distances leave f32.
const FARTHEST_M: f64 = 1e15;

/// `X,Y,Z`.
pub(crate) fn vector(text: &str) -> Result<DVec3, String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|n| n.trim().parse().ok()).collect();
    match numbers[..] {
        // NaN is beyond every bound.
        [x, y, z] if text.split(',').count() == 3 && [x, y, z].iter().all(|n| n.abs() <= FARTHEST_M) => {
            Ok(DVec3::new(x, y, z))
        }
        _ => Err(format!(
            "'{text}' is no vector; accepted: three numbers from -1e15 to 1e15 joined by commas, as in 1,2.5,-3"
        )),
    }
}

/// A time in seconds.
pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds.is_finite() && seconds >= 0.0 => Ok(seconds),
        _ => Err(format!("'{text}' is no time; accepted: a number of seconds from 0, as in 1.25")),
    }
}

/// A light from the command line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LightArg {
    Point { position: DVec3 },
    Directional { direction: DVec3 },
    Spot { position: DVec3, direction: DVec3, outer_rad: f64 },
}

impl FromStr for LightArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let direction = |text: &str| {
            // Scaled first, so that the squares of tiny numbers do not vanish.
            let direction = vector(text)?;
            let scaled = direction / direction.abs().max_element();
            scaled.try_normalize().ok_or_else(|| "a direction must not be zero".to_owned())
        };
        match text.split(':').collect::<Vec<_>>()[..] {
            ["point", position] => Ok(Self::Point { position: vector(position)? }),
            ["directional", travel] => Ok(Self::Directional { direction: direction(travel)? }),
            ["spot", position, travel, degrees] => {
                let outer: f64 =
                    degrees.parse().map_err(|_| format!("'{degrees}' is no angle in degrees"))?;
                if !(outer > 0.0 && outer <= 90.0) {
                    return Err(format!(
                        "a spot's cone opens from above 0 to 90 degrees to each side, not {outer}"
                    ));
                }
                let outer_rad = outer.to_radians();
                Ok(Self::Spot { position: vector(position)?, direction: direction(travel)?, outer_rad })
            }
            _ => Err("accepted: point:X,Y,Z, directional:X,Y,Z (the way the light travels) or \
                      spot:X,Y,Z:DX,DY,DZ:DEG (half the opening angle)"
                .into()),
        }
    }
}

/// The smallest half side of a floor: its area must not vanish in f32.
const SMALLEST_M: f64 = 1e-9;

/// `Y:HALF_SIZE`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Floor {
    pub(crate) y_m: f64,
    pub(crate) half_size_m: f64,
}

impl FromStr for Floor {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text.split_once(':').and_then(|(y, half)| Some((y.parse().ok()?, half.parse().ok()?)));
        match parsed {
            Some((y_m, half_size_m))
                if f64::abs(y_m) <= FARTHEST_M && (SMALLEST_M..=FARTHEST_M).contains(&half_size_m) =>
            {
                Ok(Self { y_m, half_size_m })
            }
            _ => Err("a floor is its height (from -1e15 to 1e15) and half its side (from 1e-9 to 1e15) in \
                      metres, as in 0:12"
                .into()),
        }
    }
}

/// `NAME[:key=value,..]`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TechniqueArg {
    pub(crate) name: String,
    pub(crate) params: Params,
}

impl FromStr for TechniqueArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, options) = text.split_once(':').unwrap_or((text, ""));
        let mut params = Params::new();
        for option in options.split(',').filter(|_| !options.is_empty()) {
            let (key, value) = option.split_once('=').ok_or_else(|| {
                format!("'{option}' is no option; accepted: key=value, several joined by commas")
            })?;
            if params.insert(key.into(), param_value(value)).is_some() {
                return Err(format!("option '{key}' is given twice"));
            }
        }
        Ok(Self { name: name.into(), params })
    }
}

/// What reads as a number or as yes or no is one, everything else is a word; numbers joined by `/` are a list.
fn param_value(text: &str) -> ParamValue {
    if let Ok(number) = text.parse::<f64>()
        && number.is_finite()
    {
        return ParamValue::Number(number);
    }
    if let Ok(flag) = text.parse() {
        return ParamValue::Flag(flag);
    }
    let numbers: Option<Vec<f64>> = text.split('/').map(|n| n.parse().ok()).collect();
    match numbers {
        Some(numbers) if numbers.len() > 1 => ParamValue::Numbers(numbers),
        _ => ParamValue::Text(text.into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn good_values_parse() {
        assert_eq!("640x360".parse::<Size>().unwrap().0, [640, 360]);
        assert_eq!(vector("1,-2.5,3e1").unwrap(), DVec3::new(1.0, -2.5, 30.0));
        assert!(matches!("point:1,2,3".parse(), Ok(LightArg::Point { .. })));
        assert!(matches!("spot:1,2,3:0,-1,0:30".parse(), Ok(LightArg::Spot { .. })));
        assert_eq!(seconds("1.25"), Ok(1.25));
        let tiny = "directional:0,-1e-200,0".parse();
        assert_eq!(tiny, Ok(LightArg::Directional { direction: DVec3::NEG_Y }));
        let technique: TechniqueArg = "soft:radius=0.5,quality=wedge,color=1/0.5/0".parse().unwrap();
        assert_eq!(technique.params["radius"], ParamValue::Number(0.5));
        assert_eq!(technique.params["color"], ParamValue::Numbers(vec![1.0, 0.5, 0.0]));
    }

    #[test]
    fn bad_values_say_what_is_accepted() {
        assert!("640".parse::<Size>().unwrap_err().contains("1280x720"));
        assert!("0x5".parse::<Size>().is_err());
        for text in ["1,2", "1,2,x", "1,2,3,4", "1,2,nan", "1,2,inf", "1e16,0,0", ""] {
            assert!(vector(text).is_err(), "{text}");
        }
        for text in ["nan", "inf", "-1", "1s", ""] {
            assert!(seconds(text).unwrap_err().contains("from 0"), "{text}");
        }
        for text in ["lamp:1,2,3", "directional:0,0,0", "spot:1,2,3:0,1,0:120", "point"] {
            assert!(text.parse::<LightArg>().is_err(), "{text}");
        }
        for text in ["0:-1", "0:0", "0:1e-60", "0:1e16", "1e300:1", "nan:1", "0:nan", "0"] {
            assert!(text.parse::<Floor>().is_err(), "{text}");
        }
        for text in ["hard:depthTest", "hard:,", "hard:a=1,", "hard:a=1,a=2"] {
            assert!(text.parse::<TechniqueArg>().is_err(), "{text}");
        }
    }
}
