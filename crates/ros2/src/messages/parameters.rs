//! Parameters of a node (rcl_interfaces).

use super::messages;

/// Numbers of `ParameterType`.
pub mod parameter_type {
    /// There is no such parameter.
    pub const NOT_SET: u8 = 0;
    /// A truth.
    pub const BOOL: u8 = 1;
    /// A whole number.
    pub const INTEGER: u8 = 2;
    /// A number.
    pub const DOUBLE: u8 = 3;
    /// A text.
    pub const STRING: u8 = 4;
}

messages! {
    /// A value with its type.
    ParameterValue = "rcl_interfaces" / "ParameterValue" {
        r#type: u8 = "uint8 type",
        bool_value: bool = "bool bool_value",
        integer_value: i64 = "int64 integer_value",
        double_value: f64 = "float64 double_value",
        string_value: String = "string string_value",
        byte_array_value: Vec<u8> = "byte[] byte_array_value",
        bool_array_value: Vec<bool> = "bool[] bool_array_value",
        integer_array_value: Vec<i64> = "int64[] integer_array_value",
        double_array_value: Vec<f64> = "float64[] double_array_value",
        string_array_value: Vec<String> = "string[] string_array_value",
    }

    /// A name and a value.
    Parameter = "rcl_interfaces" / "Parameter" {
        name: String = "string name",
        value: ParameterValue = "rcl_interfaces/ParameterValue value",
    }

    /// A range of numbers.
    FloatingPointRange = "rcl_interfaces" / "FloatingPointRange" {
        from_value: f64 = "float64 from_value",
        to_value: f64 = "float64 to_value",
        step: f64 = "float64 step",
    }

    /// A range of whole numbers.
    IntegerRange = "rcl_interfaces" / "IntegerRange" {
        from_value: i64 = "int64 from_value",
        to_value: i64 = "int64 to_value",
        step: u64 = "uint64 step",
    }

    /// What a parameter is.
    ParameterDescriptor = "rcl_interfaces" / "ParameterDescriptor" {
        name: String = "string name",
        r#type: u8 = "uint8 type",
        description: String = "string description",
        additional_constraints: String = "string additional_constraints",
        read_only: bool = "bool read_only",
        dynamic_typing: bool = "bool dynamic_typing",
        floating_point_range: Vec<FloatingPointRange> = "rcl_interfaces/FloatingPointRange[<=1] floating_point_range",
        integer_range: Vec<IntegerRange> = "rcl_interfaces/IntegerRange[<=1] integer_range",
    }

    /// Whether a parameter was set, or why not.
    SetParametersResult = "rcl_interfaces" / "SetParametersResult" {
        successful: bool = "bool successful",
        reason: String = "string reason",
    }

    /// Names of parameters.
    ParameterNames = "rcl_interfaces" / "GetParameters_Request" {
        names: Vec<String> = "string[] names",
    }

    /// Values in the order of the names.
    ParameterValues = "rcl_interfaces" / "GetParameters_Response" {
        values: Vec<ParameterValue> = "rcl_interfaces/ParameterValue[] values",
    }

    /// Types in the order of the names.
    ParameterTypes = "rcl_interfaces" / "GetParameterTypes_Response" {
        types: Vec<u8> = "uint8[] types",
    }

    /// Descriptions in the order of the names.
    ParameterDescriptors = "rcl_interfaces" / "DescribeParameters_Response" {
        descriptors: Vec<ParameterDescriptor> = "rcl_interfaces/ParameterDescriptor[] descriptors",
    }

    /// Prefixes and depth of the parameters that a list is to have.
    ListParametersRequest = "rcl_interfaces" / "ListParameters_Request" {
        prefixes: Vec<String> = "string[] prefixes",
        depth: u64 = "uint64 depth",
    }

    /// The parameters there are.
    ListParametersResult = "rcl_interfaces" / "ListParametersResult" {
        names: Vec<String> = "string[] names",
        prefixes: Vec<String> = "string[] prefixes",
    }

    /// The answer of `ListParameters`.
    ListParametersResponse = "rcl_interfaces" / "ListParameters_Response" {
        result: ListParametersResult = "rcl_interfaces/ListParametersResult result",
    }

    /// Parameters to set.
    SetParametersRequest = "rcl_interfaces" / "SetParameters_Request" {
        parameters: Vec<Parameter> = "rcl_interfaces/Parameter[] parameters",
    }

    /// One result a parameter.
    SetParametersResponse = "rcl_interfaces" / "SetParameters_Response" {
        results: Vec<SetParametersResult> = "rcl_interfaces/SetParametersResult[] results",
    }

    /// One result for all parameters.
    SetParametersAtomicallyResponse = "rcl_interfaces" / "SetParametersAtomically_Response" {
        result: SetParametersResult = "rcl_interfaces/SetParametersResult result",
    }
}
