//! One RTSI client, over any duplex stream.
//!
//! Replies are never lost; data packages are left out while too much waits for the client. So a slow reader loses
//! packages and holds up nobody, and cycles that come in one go (the pump was held up) are all sent.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::sync::broadcast::error::RecvError;
use tokio::time::{Instant, sleep, sleep_until};

use super::RtsiBackend;
use super::inputs::{InputLatch, InputVariable};
use super::outputs::OutputVariable;
use super::owners::{Claims, Owners};
use crate::ports::ClientId;
use crate::ports::description::{CONTROLLER_VERSION, RobotDescription};
use crate::ports::escape::EscapedLine;
use crate::ports::sample::Sample;
use wire::rtsi::{
    PROTOCOL_VERSION, RtsiValue, TextLevel, append_packet, append_text, decode_text_message,
    packet_type, recipe_names, split_packet,
};

/// Packages a second at most (SDK user guide).
const FREQUENCY_MAX: f64 = 250.0;

/// Recipe ids of a connection go from 1 to this.
const RECIPE_ID_MAX: u8 = 254;

/// Most variables in one recipe. All there are is fewer; a name may stand twice.
const RECIPE_VARIABLES_MAX: usize = 1024;

/// Most variables in all recipes of a connection.
const VARIABLES_MAX: usize = 8192;

/// With so many bytes unsent, data packages are left out: 40 of the SDK's whole recipe, 160 ms. Less than what stops
/// the reading, so that a client that only writes is heard.
const DATA_BYTES_MAX: usize = 32 * 1024;

/// With so many bytes of replies unread, nothing more is read from the client.
const REPLY_BYTES_MAX: usize = 64 * 1024;

/// When no cycle comes for so long (a virtual clock may stand still), data is repeated: after a second without any the
/// SDK's receiver gives up for good.
const SILENCE: Duration = Duration::from_millis(500);

/// A data package waits so long for room among the commands; then it is left out. The client's own data still comes in
/// time.
const ROOM_WITHIN: Duration = Duration::from_millis(300);
/// Time between two looks whether there is room.
const LOOK_AGAIN: Duration = Duration::from_millis(2);

/// What is read at once.
const READ_BYTES: usize = 16 * 1024;

/// Serves one client until it leaves.
///
/// # Errors
/// The connection broke, or what came in is not RTSI.
pub async fn serve(
    stream: impl AsyncRead + AsyncWrite,
    client: ClientId,
    controller: &impl RtsiBackend,
    owners: &Owners,
) -> io::Result<()> {
    let (mut reader, mut writer) = tokio::io::split(stream);
    let mut talk = RtsiSession {
        client,
        controller,
        claims: owners.claims(client),
        outputs: Vec::new(),
        inputs: Vec::new(),
        last_id: 0,
        variables: 0,
        failed: false,
        started: false,
        not_before: 0,
        written: InputLatch::default(),
        out: Vec::new(),
    };
    let mut samples = controller.samples();
    let mut silent_at = Instant::now() + SILENCE;
    let mut received = Vec::new();
    let mut buffer = vec![0; READ_BYTES];
    loop {
        tokio::select! {
            count = writer.write(&talk.out), if !talk.out.is_empty() => match count? {
                0 => return Err(io::ErrorKind::WriteZero.into()),
                count => drop(talk.out.drain(..count)),
            },
            count = reader.read(&mut buffer), if talk.out.len() < REPLY_BYTES_MAX => {
                let count = count?;
                if count == 0 {
                    return Ok(());
                }
                received.extend_from_slice(&buffer[..count]);
                let was_started = talk.started;
                talk.take_packets(&mut received).await?;
                // Others on this thread have a turn, however much waits here.
                tokio::task::yield_now().await;
                if talk.started && !was_started {
                    samples = controller.samples(); // the past is of no interest
                    silent_at = Instant::now() + SILENCE;
                }
            }
            sample = samples.recv(), if talk.started => {
                silent_at = Instant::now() + SILENCE;
                match sample {
                    Ok(sample) if talk.out.len() < DATA_BYTES_MAX => talk.send_data(&sample),
                    Ok(_) => tracing::trace!(%client, "rtsi: a package is left out, the client reads too slowly"),
                    Err(RecvError::Lagged(missed)) => tracing::debug!(%client, missed, "rtsi: cycles were missed"),
                    Err(RecvError::Closed) => return Ok(()),
                }
            }
            () = sleep_until(silent_at), if talk.started => {
                silent_at += SILENCE;
                if talk.out.len() < DATA_BYTES_MAX {
                    talk.repeat_data();
                }
            }
        }
    }
}

/// The state of one conversation.
struct RtsiSession<'a, C> {
    client: ClientId,
    controller: &'a C,
    claims: Claims,
    outputs: Vec<OutputRecipe>,
    inputs: Vec<InputRecipe>,
    last_id: u8,
    variables: usize,
    /// A recipe was refused: the connection cannot be started.
    failed: bool,
    started: bool,
    /// Data begins with this cycle: what the client wrote before the start is in it (the vendor's example reads it
    /// back).
    not_before: u64,
    written: InputLatch,
    /// What waits to be written.
    out: Vec<u8>,
}

struct OutputRecipe {
    id: u8,
    frequency: f64,
    variables: Vec<OutputVariable>,
    /// The first cycle in which the next package is due.
    due_cycle: u64,
}

impl OutputRecipe {
    fn append(&self, out: &mut Vec<u8>, sample: &Sample, robot: &RobotDescription) {
        append_packet(out, packet_type::DATA, |out| {
            out.push(self.id);
            for output in &self.variables {
                output.value(sample, robot).write(out);
            }
        });
    }
}

struct InputRecipe {
    id: u8,
    variables: Vec<InputVariable>,
}

impl<C: RtsiBackend> RtsiSession<'_, C> {
    /// Answers every whole packet and keeps the rest.
    async fn take_packets(&mut self, received: &mut Vec<u8>) -> io::Result<()> {
        let mut start = 0;
        let not_rtsi = |error| io::Error::new(io::ErrorKind::InvalidData, error);
        while let Some(packet) = split_packet(&received[start..]).map_err(not_rtsi)? {
            self.answer(packet.letter, packet.payload).await;
            start += packet.bytes;
        }
        received.drain(..start);
        Ok(())
    }

    async fn answer(&mut self, letter: u8, payload: &[u8]) {
        match letter {
            packet_type::PROTOCOL => {
                let accepted = payload == PROTOCOL_VERSION.to_be_bytes();
                self.reply(letter, &[u8::from(accepted)]);
            }
            packet_type::VERSION => {
                let version = CONTROLLER_VERSION.map(u32::to_be_bytes).concat();
                self.reply(letter, &version);
            }
            packet_type::OUTPUTS => self.set_up_outputs(payload),
            packet_type::INPUTS => self.set_up_inputs(payload).await,
            packet_type::START => {
                self.started = !self.failed;
                for recipe in &mut self.outputs {
                    recipe.due_cycle = 0;
                }
                self.reply(letter, &[u8::from(self.started)]);
            }
            packet_type::PAUSE => {
                self.started = false;
                self.reply(letter, &[1]);
            }
            packet_type::DATA => self.take_data(payload).await,
            packet_type::TEXT => match decode_text_message(payload) {
                Some(message) => tracing::info!(
                    client = %self.client,
                    level = ?message.level,
                    "rtsi: {} says {}",
                    EscapedLine(&message.source),
                    EscapedLine(&message.text)
                ),
                None => self.warn("a text message is two texts with their lengths and a level"),
            },
            other => self.warn(&format!("packets of type {other} are not known")),
        }
    }

    fn set_up_outputs(&mut self, payload: &[u8]) {
        let Some((frequency, list)) = payload.split_first_chunk::<8>() else {
            self.warn("a set-up of outputs begins with a frequency of 8 bytes");
            return;
        };
        let frequency = match f64::from_be_bytes(*frequency) {
            wanted if wanted > 0.0 => wanted.min(FREQUENCY_MAX),
            _ => FREQUENCY_MAX, // not a number, zero or negative: as fast as there is
        };
        let Some((id, names)) = self.next_recipe(packet_type::OUTPUTS, list) else {
            return;
        };
        let found: Vec<Option<OutputVariable>> = names
            .iter()
            .map(|name| OutputVariable::by_name(name))
            .collect();
        let kinds = found
            .iter()
            .map(|output| output.map_or("NOT_FOUND", |o| o.kind().name()));
        self.reply_recipe(packet_type::OUTPUTS, id, kinds);
        match found.into_iter().collect() {
            Some(variables) => self.outputs.push(OutputRecipe {
                id,
                frequency,
                variables,
                due_cycle: 0,
            }),
            None => self.failed = true,
        }
    }

    async fn set_up_inputs(&mut self, list: &[u8]) {
        let Some((id, names)) = self.next_recipe(packet_type::INPUTS, list) else {
            return;
        };
        let found: Vec<Option<InputVariable>> = names
            .iter()
            .map(|name| InputVariable::by_name(name))
            .collect();
        if let Some(reason) = self.controller.read_only() {
            self.failed = true;
            let kinds = found
                .iter()
                .map(|input| input.map_or("NOT_FOUND", |_| "IN_USE"));
            self.reply_recipe(packet_type::INPUTS, id, kinds);
            append_text(&mut self.out, TextLevel::Error, reason);
            return;
        }
        let known: Vec<InputVariable> = found.iter().flatten().copied().collect();
        let all_known = known.len() == found.len();
        let taken = if all_known {
            self.claims.claim(&known).await
        } else {
            Vec::new()
        };
        let kinds = found.iter().map(|input| match input {
            None => "NOT_FOUND",
            Some(input) if taken.contains(input) => "IN_USE",
            Some(input) => input.kind().name(),
        });
        self.reply_recipe(packet_type::INPUTS, id, kinds);
        if all_known && taken.is_empty() {
            self.inputs.push(InputRecipe {
                id,
                variables: known,
            });
        } else {
            self.failed = true;
        }
    }

    /// The id of the next recipe and its names, unless there would be too many of either.
    fn next_recipe<'n>(&mut self, letter: u8, list: &'n [u8]) -> Option<(u8, Vec<&'n str>)> {
        let names: Vec<&str> = recipe_names(list).take(RECIPE_VARIABLES_MAX + 1).collect();
        let too_many = if self.last_id == RECIPE_ID_MAX {
            Some(format!("{RECIPE_ID_MAX} recipes"))
        } else if names.len() > RECIPE_VARIABLES_MAX {
            Some(format!("{RECIPE_VARIABLES_MAX} variables in a recipe"))
        } else if self.variables + names.len() > VARIABLES_MAX {
            Some(format!("{VARIABLES_MAX} variables in all recipes"))
        } else {
            None
        };
        if let Some(limit) = too_many {
            self.failed = true;
            self.reply_recipe(letter, 0, ["NOT_FOUND"].into_iter());
            append_text(
                &mut self.out,
                TextLevel::Error,
                &format!("more than {limit} are not possible"),
            );
            return None;
        }
        self.last_id += 1;
        self.variables += names.len();
        Some((self.last_id, names))
    }

    fn reply_recipe<'k>(&mut self, letter: u8, id: u8, kinds: impl Iterator<Item = &'k str>) {
        let kinds = kinds.collect::<Vec<_>>().join(",");
        self.reply(letter, &[&[id][..], kinds.as_bytes()].concat());
    }

    /// Values from the client; applied also while paused.
    async fn take_data(&mut self, payload: &[u8]) {
        let Some((id, mut values)) = payload.split_first() else {
            self.warn("a data package begins with the id of its recipe");
            return;
        };
        let Some(recipe) = self.inputs.iter().find(|recipe| recipe.id == *id) else {
            self.warn(&format!("there is no input recipe {id}"));
            return;
        };
        let wanted: usize = recipe
            .variables
            .iter()
            .map(|input| input.kind().bytes())
            .sum();
        if values.len() != wanted {
            let given = values.len();
            self.warn(&format!(
                "input recipe {id} has {wanted} bytes of values, not {given}"
            ));
            return;
        }
        // The length was checked, so every value is there.
        let package: Vec<(InputVariable, RtsiValue)> = recipe
            .variables
            .iter()
            .filter_map(|input| Some((*input, RtsiValue::read(input.kind(), &mut values)?)))
            .collect();
        let changes = self.written.take(&package);
        // A client that floods the controller is slowed down to what that can do.
        let patience = Instant::now() + ROOM_WITHIN;
        let in_effect = loop {
            let variables = &recipe.variables;
            match self.controller.apply(self.client, &changes, variables) {
                Ok(cycle) => break cycle,
                Err(full) if Instant::now() >= patience => {
                    self.warn(&format!("a data package was left out: {full}"));
                    return;
                }
                Err(_full) => sleep(LOOK_AGAIN).await,
            }
        };
        if !self.started {
            self.not_before = in_effect;
        }
    }

    /// The packages that are due in this cycle.
    fn send_data(&mut self, sample: &Arc<Sample>) {
        let robot = self.controller.description();
        for recipe in &mut self.outputs {
            let cycle = sample.state.cycle;
            if cycle < recipe.due_cycle.max(self.not_before) {
                continue;
            }
            let every = cycles_between(recipe.frequency, sample.state.step_time);
            // A package that comes late does not move the ones after it.
            let first = if recipe.due_cycle == 0 {
                cycle
            } else {
                recipe.due_cycle
            };
            let periods = (cycle - first) / every + 1;
            recipe.due_cycle = first.saturating_add(every.saturating_mul(periods));
            recipe.append(&mut self.out, sample, robot);
        }
    }

    /// A package of every recipe, whether due or not.
    fn repeat_data(&mut self) {
        let (sample, robot) = (self.controller.sample(), self.controller.description());
        for recipe in &self.outputs {
            recipe.append(&mut self.out, &sample, robot);
        }
    }

    fn reply(&mut self, letter: u8, payload: &[u8]) {
        append_packet(&mut self.out, letter, |out| out.extend(payload));
    }

    fn warn(&mut self, text: &str) {
        tracing::debug!(client = %self.client, "rtsi: {text}");
        append_text(&mut self.out, TextLevel::Warning, text);
    }
}

/// Every how many cycles a package goes out: at least 1.
fn cycles_between(frequency: f64, step_time: f64) -> u64 {
    // The conversion saturates: a frequency close to 0 gives a package once in an age.
    (1.0 / (step_time * frequency)).round().max(1.0) as u64
}

#[cfg(test)]
mod tests;
