//! Messages and services of the vendor's driver (eli_common_interface 1.0.3), and those of std_srvs that it uses.

use super::{Vector3, messages};

messages! {
    /// What the arm as a machine is doing, with the numbers of the dashboard.
    RosRobotMode = "eli_common_interface" / "RobotMode" {
        mode: i8 = "int8 mode",
    }

    /// What the safety system allows, with the numbers of the dashboard.
    RosSafetyMode = "eli_common_interface" / "SafetyMode" {
        mode: i8 = "int8 mode",
    }

    /// An analog point: 0 current in A, 1 voltage in V.
    Analog = "eli_common_interface" / "Analog" {
        r#type: u8 = "uint8 type",
        value: f64 = "float64 value",
    }

    /// Levels of all points.
    IoState = "eli_common_interface" / "IOState" {
        standard_out: Vec<bool> = "bool[] standard_out",
        config_out: Vec<bool> = "bool[] config_out",
        tool_out: Vec<bool> = "bool[] tool_out",
        standard_in: Vec<bool> = "bool[] standard_in",
        config_in: Vec<bool> = "bool[] config_in",
        tool_in: Vec<bool> = "bool[] tool_in",
        standard_analog_out: Vec<Analog> = "eli_common_interface/Analog[] standard_analog_out",
        standard_analog_in: Vec<Analog> = "eli_common_interface/Analog[] standard_analog_in",
    }

    /// The connector of the tool.
    ToolData = "eli_common_interface" / "ToolData" {
        mode: u8 = "uint8 mode",
        output_voltage: f64 = "float64 output_voltage",
        output_current: f64 = "float64 output_current",
        temperature: f64 = "float64 temperature",
        analog_input_type: u8 = "uint8 analog_input_type",
        analog_input: f64 = "float64 analog_input",
        analog_output_type: u8 = "uint8 analog_output_type",
        analog_output: f64 = "float64 analog_output",
    }

    /// The request of `std_srvs/Trigger`: a request without fields carries one byte.
    TriggerRequest = "std_srvs" / "Trigger_Request" {
        structure_needs_at_least_one_member: u8 = "uint8 structure_needs_at_least_one_member",
    }

    /// The answer of `std_srvs/Trigger`.
    TriggerResponse = "std_srvs" / "Trigger_Response" {
        success: bool = "bool success",
        message: String = "string message",
    }

    /// The request of `SetIO`: function 1 standard output, 2 configurable output, 3 tool output, 4 analog output, 5
    /// voltage of the tool.
    SetIoRequest = "eli_common_interface" / "SetIO_Request" {
        fun: i8 = "int8 fun",
        pin: i8 = "int8 pin",
        analog_type: i8 = "int8 analog_type",
        state: f64 = "float64 state",
    }

    /// The request of `SetSpeedSliderFraction`.
    SetSpeedSliderRequest = "eli_common_interface" / "SetSpeedSliderFraction_Request" {
        speed_slider_fraction: f64 = "float64 speed_slider_fraction",
    }

    /// The request of `SetPayload`: kg, and m in the flange's frame.
    SetPayloadRequest = "eli_common_interface" / "SetPayload_Request" {
        mass: f64 = "float64 mass",
        center_of_gravity: Vector3 = "geometry_msgs/Vector3 center_of_gravity",
    }

    /// The answer of the driver's services that set something.
    SuccessResponse = "eli_common_interface" / "SetIO_Response" {
        success: bool = "bool success",
    }
}
