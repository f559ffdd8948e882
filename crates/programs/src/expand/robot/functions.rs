//! Functions of RAPID that are followed: of numbers, and of targets.
//!
//! ABB, *Technical reference manual, RAPID Instructions, Functions and Data types*: RelTool turns about x of the tool first, then about the new y,
//! then about the new z. OrientZYX turns about z, the new y and the new x.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::{
    expand::robot::{expression::Argument, value::Value},
    model::robot::RobotFault,
};

/// Returns the value of the function `name` (in capitals); `Err` for one that is not followed.
pub(crate) fn function(name: &str, arguments: &[Argument]) -> Result<Value, RobotFault> {
    const FORM: RobotFault = RobotFault::Form { expected: "the arguments of the function" };
    let mut given = Vec::new();
    for argument in arguments.iter().filter(|argument| argument.name.is_none()) {
        given.push(argument.value.clone()?);
    }
    let option = |name: &str| -> Result<Option<f64>, RobotFault> {
        let found = arguments.iter().find(|argument| argument.name.as_deref() == Some(name));
        found.map(|argument| argument.value.clone()?.number()).transpose()
    };
    let allowed: &[&str] = if name == "RELTOOL" { &["RX", "RY", "RZ"] } else { &[] };
    let is_open = |argument: &Argument| argument.name.as_deref().is_some_and(|name| !allowed.contains(&name));
    if arguments.iter().any(is_open) {
        return RobotFault::not_followed("options of this function are", "the function without them");
    }
    let turns = [option("RX")?, option("RY")?, option("RZ")?].map(|angle| angle.unwrap_or(0.0).to_radians());
    let numbers = || given.iter().map(Value::number).collect::<Result<Vec<f64>, _>>();
    match name {
        "OFFS" | "RELTOOL" => {
            let [target, steps @ ..] = &given[..] else { return Err(FORM) };
            let steps: [f64; 3] = Value::List(steps.to_vec()).numbers()?;
            return moved(target, Vector3::from(steps), (name == "RELTOOL").then_some(turns));
        }
        "ORIENTZYX" => {
            let [z, y, x]: [f64; 3] = numbers()?.try_into().map_err(|_| FORM)?;
            let turned = UnitQuaternion::from_euler_angles(x.to_radians(), y.to_radians(), z.to_radians());
            return Ok(quaternion_value(&turned));
        }
        _ => {}
    }
    let value = match (name, &numbers()?[..]) {
        ("SIN", [x]) => libm::sin(x.to_radians()),
        ("COS", [x]) => libm::cos(x.to_radians()),
        ("TAN", [x]) => libm::tan(x.to_radians()),
        ("ASIN", [x]) => libm::asin(*x).to_degrees(),
        ("ACOS", [x]) => libm::acos(*x).to_degrees(),
        ("ATAN", [x]) => libm::atan(*x).to_degrees(),
        ("ATAN2", [y, x]) => libm::atan2(*y, *x).to_degrees(),
        ("SQRT", [x]) => x.sqrt(),
        ("ABS", [x]) => x.abs(),
        ("POW", [x, y]) => libm::pow(*x, *y),
        ("EXP", [x]) => libm::exp(*x),
        ("TRUNC", [x]) => x.trunc(),
        ("ROUND", [x]) if (x.fract().abs() - 0.5).abs() > 1e-6 => x.round(),
        _ => return Err(RobotFault::NoValue { name: name.to_owned() }),
    };
    Value::Number(value).number().map(Value::Number)
}

/// Returns `target` moved by `steps`: along the axes of the work object, or of the tool, which is turned too.
fn moved(target: &Value, steps: Vector3<f64>, turns: Option<[f64; 3]>) -> Result<Value, RobotFault> {
    let mut target = target.clone();
    let position = Vector3::from(target.part(0)?.numbers::<3>()?);
    let Some([x, y, z]) = turns else {
        *target.part(0)? = Value::list((position + steps).iter().copied());
        return Ok(target);
    };
    let [w, i, j, k] = target.part(1)?.numbers::<4>()?;
    let quaternion = Quaternion::new(w, i, j, k);
    let length = quaternion.norm();
    if (length - 1.0).abs() > 1e-2 {
        return Err(RobotFault::NotUnit { what: "quaternion", length });
    }
    let rotation = UnitQuaternion::from_quaternion(quaternion);
    *target.part(0)? = Value::list((position + rotation * steps).iter().copied());
    if [x, y, z] != [0.0; 3] {
        let about = |axis, angle| UnitQuaternion::from_axis_angle(&axis, angle);
        let turn = about(Vector3::x_axis(), x) * about(Vector3::y_axis(), y) * about(Vector3::z_axis(), z);
        *target.part(1)? = quaternion_value(&(rotation * turn));
    }
    Ok(target)
}

/// Returns the four numbers of a rotation.
fn quaternion_value(rotation: &UnitQuaternion<f64>) -> Value {
    Value::list([rotation.w, rotation.i, rotation.j, rotation.k])
}
