//! The parameters of the node and their six services. All of them say how the controller was started, so none can be
//! set while it runs; the reason is told.
//!
//! The services of the DDS crate come with a subscription of `/clock` of another type than the one that is published
//! there, hence services of our own.

use ros2_client::Server;

use super::{NodeBuilder, NodeError};
use crate::link::NodeSetup;
use crate::messages::{
    ListParametersRequest, ListParametersResponse, ListParametersResult, Parameter,
    ParameterDescriptor, ParameterDescriptors, ParameterNames, ParameterTypes, ParameterValue,
    ParameterValues, SetParametersAtomicallyResponse, SetParametersRequest, SetParametersResponse,
    SetParametersResult, parameter_type,
};
use crate::names::NODE;

/// A parameter with its description.
struct DescribedParameter {
    name: &'static str,
    description: &'static str,
    value: ParameterValue,
}

/// The six services.
pub(super) struct ParameterServices {
    known: Vec<DescribedParameter>,
    get: Server<ParameterNames, ParameterValues>,
    get_types: Server<ParameterNames, ParameterTypes>,
    describe: Server<ParameterNames, ParameterDescriptors>,
    list: Server<ListParametersRequest, ListParametersResponse>,
    set: Server<SetParametersRequest, SetParametersResponse>,
    set_atomically: Server<SetParametersRequest, SetParametersAtomicallyResponse>,
}

fn text(value: &str) -> ParameterValue {
    ParameterValue {
        r#type: parameter_type::STRING,
        string_value: value.to_owned(),
        ..ParameterValue::default()
    }
}

fn number(value: f64) -> ParameterValue {
    ParameterValue {
        r#type: parameter_type::DOUBLE,
        double_value: value,
        ..ParameterValue::default()
    }
}

fn truth(value: bool) -> ParameterValue {
    ParameterValue {
        r#type: parameter_type::BOOL,
        bool_value: value,
        ..ParameterValue::default()
    }
}

impl ParameterServices {
    pub(super) fn new(node: &mut NodeBuilder, setup: &NodeSetup) -> Result<Self, NodeError> {
        let known = |name, description, value| DescribedParameter {
            name,
            description,
            value,
        };
        let path = |service: &str| format!("{NODE}/{service}");
        let kind = |name| ("rcl_interfaces", name);
        Ok(Self {
            known: vec![
                known(
                    "model",
                    "The arm: --model of the controller.",
                    text(&setup.model),
                ),
                known(
                    "robot_ip",
                    "Where the robot is: in the controller itself.",
                    text("127.0.0.1"),
                ),
                known(
                    "step_ms",
                    "Length of a control cycle, ms: --step-ms of the controller.",
                    number(setup.step_ms),
                ),
                known(
                    "tf_prefix",
                    "What joints and frames begin with: --ros-tf-prefix of the controller.",
                    text(&setup.prefix),
                ),
                // A controller makes simulated time, so it follows none.
                known(
                    "use_sim_time",
                    "The controller follows nobody's clock; under the virtual one it publishes /clock.",
                    truth(false),
                ),
            ],
            get: node.server(&path("get_parameters"), kind("GetParameters"))?,
            get_types: node.server(&path("get_parameter_types"), kind("GetParameterTypes"))?,
            describe: node.server(&path("describe_parameters"), kind("DescribeParameters"))?,
            list: node.server(&path("list_parameters"), kind("ListParameters"))?,
            set: node.server(&path("set_parameters"), kind("SetParameters"))?,
            set_atomically: node.server(
                &path("set_parameters_atomically"),
                kind("SetParametersAtomically"),
            )?,
        })
    }

    fn find(&self, name: &str) -> Option<&DescribedParameter> {
        self.known.iter().find(|known| known.name == name)
    }

    /// Answers what has come. Unanswered requests are those of clients that have gone.
    pub(super) fn poll(&self) {
        while let Ok(Some((id, asked))) = self.get.receive_request() {
            let value =
                |name: &String| self.find(name).map(|k| k.value.clone()).unwrap_or_default();
            let values = asked.names.iter().map(value).collect();
            let _ = self.get.send_response(id, ParameterValues { values });
        }
        while let Ok(Some((id, asked))) = self.get_types.receive_request() {
            let kind = |name: &String| self.find(name).map_or(0, |known| known.value.r#type);
            let types = asked.names.iter().map(kind).collect();
            let _ = self.get_types.send_response(id, ParameterTypes { types });
        }
        while let Ok(Some((id, asked))) = self.describe.receive_request() {
            let descriptors = asked.names.iter().map(|name| self.describe(name)).collect();
            let answer = ParameterDescriptors { descriptors };
            let _ = self.describe.send_response(id, answer);
        }
        while let Ok(Some((id, asked))) = self.list.receive_request() {
            let result = self.list(&asked);
            let _ = self
                .list
                .send_response(id, ListParametersResponse { result });
        }
        while let Ok(Some((id, asked))) = self.set.receive_request() {
            let results = asked.parameters.iter().map(|p| self.refusal(p)).collect();
            let _ = self
                .set
                .send_response(id, SetParametersResponse { results });
        }
        while let Ok(Some((id, asked))) = self.set_atomically.receive_request() {
            let results = asked.parameters.iter().map(|p| self.refusal(p));
            let result = results.into_iter().find(|r| !r.successful);
            let result = result.unwrap_or(SetParametersResult {
                successful: true,
                reason: String::new(),
            });
            let answer = SetParametersAtomicallyResponse { result };
            let _ = self.set_atomically.send_response(id, answer);
        }
    }

    fn describe(&self, name: &str) -> ParameterDescriptor {
        let mut descriptor = ParameterDescriptor {
            name: name.to_owned(),
            ..ParameterDescriptor::default()
        };
        if let Some(known) = self.find(name) {
            descriptor.r#type = known.value.r#type;
            descriptor.description = known.description.to_owned();
            descriptor.read_only = true;
        }
        descriptor
    }

    fn list(&self, asked: &ListParametersRequest) -> ListParametersResult {
        // No name has parts, so a prefix only finds the parameter that has its name.
        let is_asked = |name: &&str| {
            asked.prefixes.is_empty() || asked.prefixes.iter().any(|prefix| prefix == name)
        };
        let names = self.known.iter().map(|known| known.name);
        ListParametersResult {
            names: names.filter(is_asked).map(str::to_owned).collect(),
            prefixes: Vec::new(),
        }
    }

    fn refusal(&self, parameter: &Parameter) -> SetParametersResult {
        let name = &parameter.name;
        let reason = match self.find(name) {
            Some(known) if known.value == parameter.value => {
                return SetParametersResult {
                    successful: true,
                    reason: String::new(),
                };
            }
            Some(known) => format!(
                "{name} cannot be set while the controller runs. {}",
                known.description
            ),
            None => {
                let names: Vec<&str> = self.known.iter().map(|known| known.name).collect();
                format!(
                    "there is no parameter {:?}; there are {}",
                    name.chars().take(64).collect::<String>(),
                    names.join(", ")
                )
            }
        };
        SetParametersResult {
            successful: false,
            reason,
        }
    }
}
