//! The services of dashboard, inputs, outputs and settings: requests to the controller, its answers back.

use std::collections::BTreeMap;

use ros2_client::{Message, RmwRequestId, Server, ServiceTypeName};

use super::{NodeBuilder, NodeError, service};
use crate::link::{NodeMessage, Order, Trigger};
use crate::messages::{
    SetIoRequest, SetPayloadRequest, SetSpeedSliderRequest, SuccessResponse, TriggerRequest,
    TriggerResponse,
};
use crate::names::IO_AND_STATUS;

/// Requests that may wait for an answer; more are not taken up until some are answered.
const WAITING_MAX: usize = 64;

/// Service that a request without an answer came to; a trigger by its position in the list of triggers.
#[derive(Clone, Copy)]
enum RequestedService {
    Trigger(usize),
    SetIo,
    SetSpeedSlider,
    SetPayload,
}

/// Every service, and the requests that have no answer yet.
pub(super) struct Services {
    triggers: Vec<(Trigger, Server<TriggerRequest, TriggerResponse>)>,
    set_io: Server<SetIoRequest, SuccessResponse>,
    set_speed_slider: Server<SetSpeedSliderRequest, SuccessResponse>,
    set_payload: Server<SetPayloadRequest, SuccessResponse>,
    waiting: BTreeMap<u64, (RequestedService, RmwRequestId)>,
    last: u64,
}

impl NodeBuilder {
    /// A service at `path` of a type.
    pub(super) fn server<Q: Message + Clone + 'static, A: Message + Clone + 'static>(
        &mut self,
        path: &str,
        (package, kind): (&str, &str),
    ) -> Result<Server<Q, A>, NodeError> {
        let kind = ServiceTypeName::new(package, kind);
        let name = self.name(path)?;
        Ok(self
            .node
            .create_server(self.mapping, &name, &kind, service(), service())?)
    }
}

impl Services {
    pub(super) fn new(node: &mut NodeBuilder) -> Result<Self, NodeError> {
        let mut triggers = Vec::new();
        for trigger in Trigger::ALL {
            let (below, name) = trigger.service();
            let path = format!("{below}/{name}");
            triggers.push((*trigger, node.server(&path, ("std_srvs", "Trigger"))?));
        }
        let io = |name: &str| format!("{IO_AND_STATUS}/{name}");
        let driver = |name| ("eli_common_interface", name);
        Ok(Self {
            triggers,
            set_io: node.server(&io("set_io"), driver("SetIO"))?,
            set_speed_slider: node
                .server(&io("set_speed_slider"), driver("SetSpeedSliderFraction"))?,
            set_payload: node.server(&io("set_payload"), driver("SetPayload"))?,
            waiting: BTreeMap::new(),
            last: 0,
        })
    }

    /// Takes up the requests that have come. What cannot be read is left out: DDS has nobody to tell.
    pub(super) fn poll(&mut self, out: &mut Vec<NodeMessage>) {
        let mut found = Vec::new();
        let room = WAITING_MAX.saturating_sub(self.waiting.len());
        for (position, (trigger, server)) in self.triggers.iter().enumerate() {
            while found.len() < room
                && let Ok(Some((id, _))) = server.receive_request()
            {
                found.push((
                    RequestedService::Trigger(position),
                    id,
                    Order::Trigger(*trigger),
                ));
            }
        }
        while found.len() < room
            && let Ok(Some((id, asked))) = self.set_io.receive_request()
        {
            found.push((RequestedService::SetIo, id, Order::SetIo(asked)));
        }
        while found.len() < room
            && let Ok(Some((id, asked))) = self.set_speed_slider.receive_request()
        {
            let order = Order::SetSpeedSlider(asked.speed_slider_fraction);
            found.push((RequestedService::SetSpeedSlider, id, order));
        }
        while found.len() < room
            && let Ok(Some((id, asked))) = self.set_payload.receive_request()
        {
            found.push((RequestedService::SetPayload, id, Order::SetPayload(asked)));
        }
        for (asked, id, order) in found {
            self.last += 1;
            let request = self.last;
            self.waiting.insert(request, (asked, id));
            out.push(NodeMessage::Request { request, order });
        }
    }

    /// Answers a request.
    pub(super) fn answer(&mut self, request: u64, success: bool, message: String) {
        let Some((asked, id)) = self.waiting.remove(&request) else {
            return;
        };
        let done = SuccessResponse { success };
        // A client that has gone is told nothing.
        let _ = match asked {
            RequestedService::Trigger(position) => self.triggers[position]
                .1
                .send_response(id, TriggerResponse { success, message }),
            RequestedService::SetIo => self.set_io.send_response(id, done),
            RequestedService::SetSpeedSlider => self.set_speed_slider.send_response(id, done),
            RequestedService::SetPayload => self.set_payload.send_response(id, done),
        };
    }
}
