//! Requests of services, carried out: those of the dashboard as its lines, so that they are answered alike.

use kinematics::Payload;
use motion_api::{
    AnalogDomain, CommandKind, DigitalBank, IoChange, SensingCommand, SettingCommand,
};
use ros2::link::{Order, Trigger};
use ros2::messages::{SetIoRequest, SetPayloadRequest};

use super::Ros2Backend;
use crate::ports::ClientId;
use crate::ports::dashboard::session::answer;

/// Whom the dashboard's log names.
const CLIENT: ClientId = ClientId(0);

/// Largest payload that the driver's service takes, kg: more than any arm of the series bears.
const MASS_MAX: f64 = 100.0;
/// Farthest centre of gravity, m.
const COG_MAX: f64 = 10.0;

/// Carries out an order: whether it was done, and what there is to say.
pub(super) async fn carry_out<B: Ros2Backend>(order: Order, backend: &B) -> (bool, String) {
    match order {
        Order::Trigger(trigger) => match dashboard_line(trigger) {
            Some((line, expected)) => {
                let (reply, _) = answer(line, CLIENT, backend).await;
                (reply.starts_with(expected), reply)
            }
            None => {
                backend
                    .command(CommandKind::Sensing(SensingCommand::ZeroFtSensor))
                    .await;
                (true, "the force sensor reads zero from now on".to_owned())
            }
        },
        Order::SetSpeedSlider(fraction) => {
            // The driver refuses less than a hundredth: the arm would seem to be dead.
            let is_allowed = (0.01..=1.0).contains(&fraction);
            if is_allowed {
                backend
                    .command(CommandKind::Setting(SettingCommand::SetSpeedFraction(
                        fraction,
                    )))
                    .await;
            }
            (is_allowed, String::new())
        }
        Order::SetPayload(asked) => match payload(&asked) {
            Some(payload) => {
                backend
                    .command(CommandKind::Setting(SettingCommand::SetPayload(payload)))
                    .await;
                (true, String::new())
            }
            None => (false, String::new()),
        },
        Order::SetIo(asked) => match io_changes(&asked) {
            Some(changes) => {
                for change in changes {
                    backend
                        .command(CommandKind::Setting(SettingCommand::SetIo(change)))
                        .await;
                }
                (true, String::new())
            }
            None => (false, String::new()),
        },
    }
}

/// The line of the dashboard that a service stands for, and how the reply of success begins.
fn dashboard_line(trigger: Trigger) -> Option<(&'static str, &'static str)> {
    Some(match trigger {
        Trigger::PowerOn => ("robotControl -on", "Powering on"),
        Trigger::PowerOff => ("robotControl -off", "Powering off"),
        Trigger::BrakeRelease => ("brakeRelease", "Brake"),
        Trigger::UnlockProtectiveStop => ("unlockProtectiveStop", "Protective stop unlocking"),
        Trigger::Play => ("play", "Starting task"),
        Trigger::Pause => ("pause", "Pausing task"),
        Trigger::Stop => ("stop", "Stopping task"),
        Trigger::CloseSafetyDialog => ("closeSafetyDialog", "closing"),
        Trigger::RestartSafety => ("safety -r", "Restarting safety board"),
        Trigger::TaskPath => ("task", "Relative path:"),
        Trigger::ZeroFtSensor => return None,
    })
}

fn payload(asked: &SetPayloadRequest) -> Option<Payload> {
    let cog = &asked.center_of_gravity;
    let cog = [cog.x, cog.y, cog.z];
    let is_near = |x: &f64| (-COG_MAX..=COG_MAX).contains(x);
    let fits = (0.0..=MASS_MAX).contains(&asked.mass) && cog.iter().all(is_near);
    fits.then(|| Payload {
        mass: asked.mass,
        cog: cog.into(),
        ..Payload::default()
    })
}

/// What `SetIO` changes: levels 0 and 1, analog values in A or V, the tool's voltage 0, 12 or 24 V.
fn io_changes(asked: &SetIoRequest) -> Option<Vec<IoChange>> {
    let pin = u8::try_from(asked.pin).ok()?;
    let digital = |bank: DigitalBank, count: u8| {
        let mask = 1_u32 << bank.bit(pin.min(count - 1));
        let levels = match asked.state {
            0.0 => 0,
            1.0 => mask,
            _ => return None,
        };
        (pin < count).then(|| vec![IoChange::DigitalOut { mask, levels }])
    };
    match asked.fun {
        1 => digital(DigitalBank::Standard, 16),
        2 => digital(DigitalBank::Configurable, 8),
        3 => digital(DigitalBank::Tool, 4),
        4 if pin < 2 => {
            let domain = match asked.analog_type {
                0 => AnalogDomain::Current,
                1 => AnalogDomain::Voltage,
                _ => return None,
            };
            let is_in_range = (0.0..=domain.measurable_max()).contains(&asked.state);
            is_in_range.then(|| {
                let ratio = domain.ratio(asked.state);
                vec![
                    IoChange::AnalogOutDomain { port: pin, domain },
                    IoChange::AnalogOut { port: pin, ratio },
                ]
            })
        }
        5 => {
            let volts = [0_u8, 12, 24]
                .into_iter()
                .find(|volts| f64::from(*volts) == asked.state)?;
            Some(vec![IoChange::ToolVoltage(volts)])
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ros2::messages::Vector3;

    fn asked(fun: i8, pin: i8, analog_type: i8, state: f64) -> SetIoRequest {
        SetIoRequest {
            fun,
            pin,
            analog_type,
            state,
        }
    }

    #[test]
    fn outputs_are_those_of_the_driver_and_wrong_ones_are_refused() {
        let one = |mask, levels| Some(vec![IoChange::DigitalOut { mask, levels }]);
        assert_eq!(io_changes(&asked(1, 3, 0, 1.0)), one(1 << 3, 1 << 3));
        assert_eq!(io_changes(&asked(2, 0, 0, 0.0)), one(1 << 16, 0));
        assert_eq!(io_changes(&asked(3, 1, 0, 1.0)), one(1 << 25, 1 << 25));
        assert_eq!(io_changes(&asked(4, 1, 1, 5.0)).unwrap().len(), 2);
        assert_eq!(
            io_changes(&asked(5, 0, 0, 24.0)),
            Some(vec![IoChange::ToolVoltage(24)])
        );
        for wrong in [
            asked(1, 16, 0, 1.0),
            asked(1, -1, 0, 1.0),
            asked(2, 8, 0, 1.0),
            asked(3, 4, 0, 1.0),
            asked(1, 0, 0, 0.5),
            asked(1, 0, 0, f64::NAN),
            asked(4, 2, 1, 5.0),
            asked(4, 0, 1, 11.0),
            asked(4, 0, 2, 1.0),
            asked(5, 0, 0, 5.0),
            asked(6, 0, 0, 1.0),
        ] {
            assert_eq!(io_changes(&wrong), None, "{wrong:?}");
        }
    }

    #[test]
    fn a_payload_that_cannot_be_is_refused() {
        let at = |mass, z| SetPayloadRequest {
            mass,
            center_of_gravity: Vector3 { x: 0.0, y: 0.0, z },
        };
        assert_eq!(payload(&at(2.0, 0.1)).unwrap().mass, 2.0);
        for wrong in [at(-1.0, 0.0), at(f64::NAN, 0.0), at(1.0, f64::INFINITY)] {
            assert!(payload(&wrong).is_none());
        }
    }
}
