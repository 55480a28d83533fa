//! Tests of the motion crate as its users see it: moves, blends, stops, force, plants, in one binary: a file each.

mod common;
#[path = "random_programs/way.rs"]
#[allow(dead_code, reason = "judges of random programs use the rest")]
mod way;

mod any_commands;
mod asked_in_every_mode;
mod asked_when;
mod belts;
mod blend_edges;
mod blend_smooth;
mod blend_zone;
mod blends;
mod border;
mod chains;
mod clocks;
mod commands;
mod contact;
mod conveyor;
mod directions;
mod every_stop;
mod faults;
mod force_mode;
mod force_motion;
mod hand;
mod input_actions;
mod limits_of_any_size;
mod movej;
mod movel;
mod moveml;
mod no_alloc;
mod online;
mod pace;
mod pace_oracle;
mod path_offset;
mod rigid;
mod safety_agreement;
mod scalar;
mod self_collision;
mod sensor;
mod servo;
mod stop_laws;
mod stop_matrix;
mod stops;
mod throughput;
mod timed_blends;
mod tools;
mod trajectory;
mod truth;
mod wild_commands;
