//! The functions of `test` that see and change the parts of the cell: `part`, `parts`, `place`, `remove`, `add`,
//! `gripper`, `count`, `fault`.
//!
//! A test and the world take turns, so what a test changes is there before the next cycle.

use controller::CellWorld;
use controller::cell_world::{FingerState, OrderError, WorldOrder};
use elite_lang::{ExceptionKind, NativeCall, Unwind, Value};
use messages::{Text, text};

use crate::test_object::{CallContext, argument_error, number, raise, text};

type NativeResult<T = Value> = Result<T, Unwind>;

/// Largest coordinate of a pose, m, or angle, rad.
const COORDINATE_MAX: f64 = 1e3;
/// Longest duration of a fault, s.
const DURATION_MAX: f64 = 1e6;

fn world<'a>(site: &'a CallContext, call: &NativeCall<'_>) -> NativeResult<&'a CellWorld> {
    site.bench.world.as_ref().ok_or_else(|| {
        let text = text!(
            "the cell has no parts: none of its tables is [world], [[part]], [[gripper]] and their like",
            "单元中没有工件：没有 [world]、[[part]]、[[gripper]] 等表"
        );
        raise(call, ExceptionKind::RuntimeError, &text)
    })
}

fn refused(call: &NativeCall<'_>, error: &OrderError) -> Unwind {
    argument_error(call, &Text::of(&error))
}

/// `parts()`: names of the parts that are there.
pub(crate) fn parts(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let world = world(site, call)?.lock();
    let names = world
        .state()
        .parts
        .iter()
        .map(|part| Value::str(&*part.name));
    Ok(Value::list(names.collect()))
}

/// `part(name)`: pose, speed, held_by, touching, present.
pub(crate) fn part(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let name = text(call, 0, "name")?;
    let shared = world(site, call)?;
    let world = shared.lock();
    let part = world.part(&name).map_err(|error| refused(call, &error))?;
    let Some(part) = part else {
        let nothing = [
            ("pose", Value::None),
            ("speed", Value::None),
            ("held_by", Value::None),
        ];
        let rest = [
            ("touching", Value::list(Vec::new())),
            ("present", Value::Bool(false)),
        ];
        return Ok(call.object(
            "part",
            Vec::new(),
            nothing.into_iter().chain(rest).collect(),
        ));
    };
    let touching = world
        .touching(&name)
        .map_err(|error| refused(call, &error))?;
    let grippers = &shared.description().grippers;
    let holder = part.held_by.and_then(|number| grippers.get(number));
    let attributes = vec![
        ("pose", Value::list_of_f64(&part.pose.to_rpy().to_array())),
        ("speed", Value::Float(part.velocity.linear.norm())),
        (
            "held_by",
            holder.map_or(Value::None, |gripper| Value::str(&gripper.name)),
        ),
        (
            "touching",
            Value::list(touching.into_iter().map(Value::str).collect()),
        ),
        ("present", Value::Bool(true)),
    ];
    Ok(call.object("part", Vec::new(), attributes))
}

/// `gripper(name)`: holding, pressure, sealed, width.
pub(crate) fn gripper(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let name = text(call, 0, "name")?;
    let shared = world(site, call)?;
    let mut names = shared
        .description()
        .grippers
        .iter()
        .map(|gripper| &gripper.name);
    let Some(number) = names.position(|given| *given == name) else {
        return Err(argument_error(
            call,
            &text!("there is no gripper {name:?}", "没有夹爪 {name:?}"),
        ));
    };
    let world = shared.lock();
    let state = &world.state().grippers[number];
    let sealed = state.sealed.iter().map(|seals| Value::Bool(*seals));
    let attributes = vec![
        (
            "holding",
            state
                .holding
                .as_ref()
                .map_or(Value::None, |part| Value::str(&**part)),
        ),
        ("pressure", Value::Float(state.pressure)),
        ("sealed", Value::list(sealed.collect())),
        ("width", Value::Float(state.width)),
        ("moving", Value::Bool(state.fingers == FingerState::Moving)),
    ];
    Ok(call.object("gripper", Vec::new(), attributes))
}

/// `count(sink)`: how many parts it has removed.
pub(crate) fn count(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let name = text(call, 0, "sink")?;
    let facts = world(site, call)?.facts();
    match facts.count(&name) {
        Some(count) => Ok(Value::from(i64::try_from(count).unwrap_or(i64::MAX))),
        None => Err(argument_error(
            call,
            &text!("there is no sink {name:?}", "没有工件出口 {name:?}"),
        )),
    }
}

fn order(site: &CallContext, call: &NativeCall<'_>, order: WorldOrder) -> NativeResult {
    match world(site, call)?.order(order) {
        Ok(None) => Ok(Value::None),
        Ok(Some(name)) => Ok(Value::str(name)),
        Err(error) => Err(argument_error(call, &Text::of(&error))),
    }
}

/// `place(name, pose)`
pub(crate) fn place(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let (name, pose) = (text(call, 0, "name")?, pose(call, 1)?);
    order(site, call, WorldOrder::Place { name, pose })
}

/// `remove(name)`
pub(crate) fn remove(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let name = text(call, 0, "name")?;
    order(site, call, WorldOrder::Remove { name })
}

/// `add(template, pose)`: the name of the new part.
pub(crate) fn add(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let (template, pose) = (text(call, 0, "template")?, pose(call, 1)?);
    order(site, call, WorldOrder::Add { template, pose })
}

/// `fault(what, name, duration=None)`
pub(crate) fn fault(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let (what, name) = (text(call, 0, "what")?, text(call, 1, "name")?);
    let duration = match call.arg(2) {
        None | Some(Value::None) => None,
        Some(_) => Some(number(call, 2, "duration", (1e-6, DURATION_MAX), None)?),
    };
    let fault = WorldOrder::Fault {
        what,
        name,
        duration,
    };
    order(site, call, fault)
}

/// Six numbers, as poses of scripts.
fn pose(call: &NativeCall<'_>, index: usize) -> NativeResult<[f64; 6]> {
    let given = call.arg(index).cloned().unwrap_or_default();
    let numbers = given.as_items().and_then(|items| {
        let numbers: Option<Vec<f64>> = items.iter().map(Value::as_f64).collect();
        <[f64; 6]>::try_from(numbers?).ok()
    });
    match numbers.filter(|numbers| numbers.iter().all(|x| x.abs() <= COORDINATE_MAX)) {
        Some(numbers) => Ok(numbers),
        None => {
            let shown = call.repr(&given)?;
            let text = text!(
                "pose is {shown}; six numbers of at most {COORDINATE_MAX} are needed: x, y, z in m, Rx, Ry, Rz in rad",
                "pose 为 {shown}；需要六个绝对值不超过 {COORDINATE_MAX} 的数：x、y、z（m），Rx、Ry、Rz（rad）"
            );
            Err(argument_error(call, &text))
        }
    }
}
