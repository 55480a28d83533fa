//! Functions that a translated program brings along, each only where it is used.

/// A helper: its name, and its text in EliteScript.
pub struct Helper {
    /// Name of the helper.
    pub name: &'static str,
    /// Definition of the helper in EliteScript.
    pub text: &'static str,
}

const fn helper(name: &'static str, text: &'static str) -> Helper {
    Helper { name, text }
}

/// All helpers; one that uses another one stands after it.
pub const HELPERS: &[Helper] = &[
    helper(
        "not_available",
        "\
def not_available(text):
    raise NotImplementedError(text)
end
",
    ),
    helper(
        "critical_section",
        "\
import threading
critical_section = threading.RLock()
",
    ),
    helper(
        "Struct",
        "\
class Struct:
    def __init__(self, **fields):
        for name in fields:
            setattr(self, name, fields[name])
        end
    end

    def __getitem__(self, index):
        return self.__dict__[list(self.__dict__)[index]]
    end

    def __setitem__(self, index, value):
        self.__dict__[list(self.__dict__)[index]] = value
    end

    def __eq__(self, other):
        return isinstance(other, Struct) and self.__dict__ == other.__dict__
    end
end
",
    ),
    helper(
        "Pose",
        "\
# A pose: x, y, z, roll, pitch, yaw for the robot's functions; its items 3 to 5 are the rotation vector.
class Pose(list):
    def __init__(self, position, rotation_vector):
        list.__init__(self, position + rotvec2rpy(rotation_vector))
        self.rotation_vector = rotation_vector
    end

    def __getitem__(self, index):
        if isinstance(index, int) and index > 2:
            return self.rotation_vector[index - 3]
        end
        return list.__getitem__(self, index)
    end

    def __setitem__(self, index, value):
        if index < 3:
            list.__setitem__(self, index, value)
            return
        end
        self.rotation_vector[index - 3] = value
        rpy = rotvec2rpy(self.rotation_vector)
        for axis in range(3):
            list.__setitem__(self, axis + 3, rpy[axis])
        end
    end

    def __deepcopy__(self, _copied):
        return Pose(self[0:3], list(self.rotation_vector))
    end
end
",
    ),
    helper(
        "pose_object",
        "\
def pose_object(pose):
    return Pose(pose[0:3], rpy2rotvec(pose[3:6]))
end
",
    ),
    helper(
        "tcp_pose",
        "\
def tcp_pose(target):
    if isinstance(target, Pose):
        return target
    end
    return get_forward_kin(target)
end
",
    ),
    helper(
        "joint_positions",
        "\
def joint_positions(target):
    if isinstance(target, Pose):
        return get_inverse_kin(target)
    end
    return target
end
",
    ),
    helper(
        "text_of",
        "\
def text_of(value):
    if isinstance(value, Pose):
        return pose_text(value)
    end
    return value
end
",
    ),
    helper(
        "pose_text",
        "\
def pose_text(pose):
    turn = getattr(pose, \"rotation_vector\", None)
    if turn is None:
        turn = rpy2rotvec(pose[3:6])
    end
    return \"p\" + to_str(pose[0:3] + turn)
end
",
    ),
    helper(
        "pose_from_rotvec",
        "\
def pose_from_rotvec(x, y, z, rx, ry, rz):
    return [x, y, z] + rotvec2rpy([rx, ry, rz])
end
",
    ),
    helper(
        "turned_distance",
        "\
# The distance of two poses: metres and the angle of the turn between them.
def turned_distance(p_from, p_to):
    difference = pose_sub(p_to, p_from)
    return norm(difference[0:3] + rpy2rotvec(difference[3:6]))
end
",
    ),
    helper(
        "rpc_pose",
        "\
def rpc_pose(pose):
    turn = rpy2rotvec(pose[3:6])
    return {\"x\": pose[0], \"y\": pose[1], \"z\": pose[2], \"rx\": turn[0], \"ry\": turn[1], \"rz\": turn[2]}
end
",
    ),
    helper(
        "rpc_result",
        "\
def rpc_result(value):
    if isinstance(value, dict) and \"rx\" in value:
        return rpc_pose_of(value)
    end
    return value
end
",
    ),
    helper(
        "rpc_pose_of",
        "\
def rpc_pose_of(value):
    turn = rotvec2rpy([value[\"rx\"], value[\"ry\"], value[\"rz\"]])
    return [value[\"x\"], value[\"y\"], value[\"z\"]] + turn
end
",
    ),
    helper(
        "rpc_object",
        "\
def rpc_object(value):
    if isinstance(value, dict) and \"rx\" in value:
        position = [value[\"x\"], value[\"y\"], value[\"z\"]]
        return Pose(position, [value[\"rx\"], value[\"ry\"], value[\"rz\"]])
    end
    return value
end
",
    ),
    helper(
        "elementwise",
        "\
# Lists and matrices are added and scaled number by number; a product with a matrix is that of matrices.
def elementwise(operator, a, b):
    if isinstance(a, list) and isinstance(b, list):
        if operator == \"*\" and isinstance(a[0], list):
            if isinstance(b[0], list):
                return transposed([elementwise(\"*\", a, column) for column in transposed(b)])
            end
            return [sum([x * y for x, y in zip(row, b)]) for row in a]
        end
        if operator == \"*\" and isinstance(b[0], list):
            return elementwise(\"*\", transposed(b), a)
        end
        if len(a) != len(b):
            raise ValueError(\"lists of \" + str(len(a)) + \" and \" + str(len(b)) + \" items cannot be combined\")
        end
        return [elementwise(operator, x, y) for x, y in zip(a, b)]
    end
    if isinstance(a, list):
        return [elementwise(operator, x, b) for x in a]
    end
    if isinstance(b, list):
        return [elementwise(operator, a, y) for y in b]
    end
    if operator == \"+\":
        return a + b
    elif operator == \"-\":
        return a - b
    elif operator == \"*\":
        return a * b
    elif operator == \"/\":
        return a / b
    end
    return a % b
end
",
    ),
    helper(
        "transposed",
        "\
def transposed(matrix):
    return [[row[column] for row in matrix] for column in range(len(matrix[0]))]
end
",
    ),
    helper(
        "inverse_matrix",
        "\
def inverse_matrix(matrix):
    count = len(matrix)
    rows = [list(matrix[i]) + [float(i == j) for j in range(count)] for i in range(count)]
    for i in range(count):
        best = max(range(i, count), key=lambda row: abs(rows[row][i]))
        rows[i], rows[best] = rows[best], rows[i]
        if rows[i][i] == 0:
            raise ValueError(\"the matrix has no inverse\")
        end
        rows[i] = [value / rows[i][i] for value in rows[i]]
        for j in range(count):
            if j != i:
                factor = rows[j][i]
                rows[j] = [x - factor * y for x, y in zip(rows[j], rows[i])]
            end
        end
    end
    return [row[count:] for row in rows]
end
",
    ),
    helper(
        "inverse_of",
        "\
def inverse_of(value):
    if isinstance(value[0], list):
        return inverse_matrix(value)
    end
    return pose_inv(value)
end
",
    ),
    helper(
        "size_of",
        "\
def size_of(value):
    if len(value) > 0 and isinstance(value[0], list):
        return [len(value), len(value[0])]
    end
    return len(value)
end
",
    ),
    helper(
        "new_list",
        "\
def new_list(length, value):
    return [elicopy.deepcopy(value) for _ in range(length)]
end
",
    ),
    helper(
        "tcp_force_in_base",
        "\
# The force at the TCP in axes of the base.
def tcp_force_in_base():
    wrench = get_tcp_force(True)
    turn = [0, 0, 0] + get_actual_tcp_pose()[3:6]
    force_vector = pose_trans(turn, wrench[0:3] + [0, 0, 0])
    torque_vector = pose_trans(turn, wrench[3:6] + [0, 0, 0])
    return force_vector[0:3] + torque_vector[0:3]
end
",
    ),
    helper(
        "force_type",
        "\
# Types of force mode: 1 point, 2 fixed frame, 3 motion.
def force_type(number):
    return {1: 1, 2: 0, 3: 2}[number]
end
",
    ),
    helper(
        "arc_mode",
        "\
# Orientation along arcs: 0 turns evenly, 1 keeps to the arc.
def arc_mode(mode):
    return {0: 1, 1: 0}[mode]
end
",
    ),
    helper(
        "conveyor_input",
        "\
# Channel B is used in quadrature mode only.
def conveyor_input(decoder_type):
    if decoder_type == 1:
        return 17
    end
    return 0
end
",
    ),
    helper(
        "modbus_error",
        "\
# The error of the device, else that of the connection, else 0.
def modbus_error(signal_name):
    device, connection = modbus_get_error(signal_name)
    if device != 0:
        return device
    end
    return connection
end
",
    ),
    helper(
        "is_steady",
        "\
def is_steady():
    return norm(get_target_joint_speeds()) == 0 and norm(get_actual_joint_speeds()) < 0.01
end
",
    ),
    helper(
        "digital_in",
        "\
# Inputs 8 and 9 are those of the tool.
def digital_in(number):
    if number < 8:
        return get_standard_digital_in(number)
    end
    return tool_digital_in(number - 8)
end
",
    ),
    helper(
        "digital_out",
        "\
# Outputs 8 and 9 are those of the tool.
def digital_out(number):
    if number < 8:
        return get_standard_digital_out(number)
    end
    return get_tool_digital(number - 8)
end
",
    ),
    helper(
        "switch_digital_out",
        "\
# Outputs 8 and 9 are those of the tool.
def switch_digital_out(number, level):
    if number < 8:
        set_standard_digital_out(number, level)
    else:
        switch_tool_digital_out(number - 8, level)
    end
end
",
    ),
    helper(
        "tool_digital_in",
        "\
# The pins of the tool: 0 and 1 are its outputs, 2 and 3 its inputs.
def tool_digital_in(number):
    set_tool_digital_io_config(number + 2, 0, True, False)
    return get_tool_digital(number + 2)
end
",
    ),
    helper(
        "switch_tool_digital_out",
        "\
# The pins of the tool: 0 and 1 are its outputs, 2 and 3 its inputs.
tool_output_modes = [0, 0]

def switch_tool_digital_out(number, level):
    set_tool_digital_io_config(number, tool_output_modes[number], True, True)
    set_tool_digital(number, level)
end
",
    ),
    helper(
        "configure_tool_pin",
        "\
# Modes of outputs: 1 sinking, 2 sourcing, 3 push and pull.
def configure_tool_pin(number, mode):
    tool_output_modes[number] = {1: 2, 2: 1, 3: 0}[mode]
end
",
    ),
    helper(
        "analog_in",
        "\
# Input 2 is that of the tool.
def analog_in(number):
    if number < 2:
        return get_standard_analog_in(number)
    end
    return tool_analog_in(number - 2)
end
",
    ),
    helper(
        "tool_analog_in",
        "\
def tool_analog_in(number):
    if number != 0:
        raise NotImplementedError(\"get_tool_analog_in: the tool has one analog input\")
    end
    return get_tool_analog_in()
end
",
    ),
    helper(
        "tool_input_domain",
        "\
def tool_input_domain(number, domain):
    if number == 0:
        set_tool_analog_input_domain(domain)
    end
end
",
    ),
];

/// The definitions of the helpers that a text uses, and of those that these use.
pub fn definitions(text: &str) -> Vec<&'static Helper> {
    let mut used = vec![false; HELPERS.len()];
    let mut texts = vec![text];
    while let Some(text) = texts.pop() {
        for (helper, used) in HELPERS.iter().zip(&mut used) {
            if !*used && has_word(text, helper.name) {
                *used = true;
                texts.push(helper.text);
            }
        }
    }
    // What `configure_tool_pin` writes to comes with the outputs.
    let position = |name: &str| HELPERS.iter().position(|helper| helper.name == name);
    if let (Some(pin), Some(output)) = (
        position("configure_tool_pin"),
        position("switch_tool_digital_out"),
    ) {
        used[output] |= used[pin];
    }
    HELPERS
        .iter()
        .zip(used)
        .filter_map(|(helper, used)| used.then_some(helper))
        .collect()
}

/// Whether a name stands in a text, not as a part of another one and not as text of a comment or a string.
fn has_word(text: &str, word: &str) -> bool {
    text.match_indices(word).any(|(at, _)| {
        let is_part = |c: char| c == '_' || c.is_alphanumeric();
        let before = text[..at].chars().next_back();
        let after = text[at + word.len()..].chars().next();
        let starts_name = before.is_none_or(|c| !is_part(c) && c != '.');
        starts_name && after.is_none_or(|c| !is_part(c))
    })
}
