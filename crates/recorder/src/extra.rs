//! Topics of a recording that are not ours: what a robot elsewhere says beside its cycles.
//!
//! Whoever records names them and makes their messages, in JSON; here they get a channel in every part of the recording
//! and their place in time. Readers see them as tables, as any topic that they do not know.

/// A topic with messages in JSON.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CustomTopic {
    /// Name of the topic, with the slash; none of [`Topic`](crate::Topic)'s.
    pub name: String,
    /// What its messages are called, `elite.RtsiOutputs` for instance.
    pub schema_name: String,
    /// A JSON Schema of its messages, as text.
    pub schema: String,
}

/// The number of an extra topic: its place in [`RecorderConfig::extra`](crate::RecorderConfig::extra).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CustomTopicId(pub usize);
