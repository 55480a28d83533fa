//! The built-in arms against the table of figures they were written from, and what other URDF files do.
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot read its input fails"
)]

use crate::common;

use common::{assert_close, cases, get, q, vectors};
use kinematics::{IkMethod, JointPositions, ModelError, Pose, RobotModel, RpyPose};
use proptest::prelude::*;
use std::f64::consts::FRAC_PI_2;

const CS66: &str = include_str!("../../../robots/cs66/cs66.urdf");

#[test]
fn built_in_arms_carry_the_figures_of_the_table() {
    let figures = vectors("cs_figures.json");
    let table = figures["models"].as_object().unwrap();
    assert_eq!(table.len(), RobotModel::names().count());
    for (name, wanted) in table {
        let arm = RobotModel::built_in(name).unwrap();
        assert_eq!(arm.name(), name);
        assert_eq!(arm.warnings(), [""; 0]);
        assert_eq!(arm.type_number(), Some(get(wanted, "robot_type")));
        assert_eq!(
            arm.rated_payload_kg(),
            Some(get(wanted, "rated_payload_kg"))
        );
        assert!(matches!(arm.ik_method(), IkMethod::ClosedForm(_)));
        for (i, joint) in cases(wanted, "joints").iter().enumerate() {
            assert_eq!(arm.joint_names()[i], joint["name"].as_str().unwrap());
            let limits = arm.limits();
            let degrees = [
                limits.position_min[i],
                limits.position_max[i],
                limits.speed[i],
            ]
            .map(f64::to_degrees);
            let [min, max]: [f64; 2] = get(joint, "position_deg");
            assert_close(
                name,
                &degrees,
                &[min, max, get(joint, "speed_deg_s")],
                1e-12,
            );
            assert_eq!(limits.effort[i], get::<f64>(joint, "effort_nm"));
            assert_eq!(limits.acceleration[i], 10.0);
            let origin = &arm.chain().parent_from_joint[i];
            let xyz: [f64; 3] = get(joint, "origin_xyz");
            assert_eq!(origin.translation.as_slice(), xyz);
            // Quarter turns are exact: nothing but 0, 1 and -1 in the matrix.
            assert!(
                origin
                    .rotation
                    .matrix()
                    .iter()
                    .all(|x| [0.0, 1.0, -1.0].contains(x))
            );
            let turns: [f64; 3] = get(joint, "origin_rpy_quarter_turns");
            let wanted = Pose::from_rpy(&RpyPose {
                xyz,
                rpy: turns.map(|k| k * FRAC_PI_2),
            });
            assert!((origin.rotation.matrix() - wanted.rotation.matrix()).amax() < 1e-15);

            let link = &figures["models"][name]["links"][joint["child"].as_str().unwrap()];
            let body = &arm.link_bodies()[i];
            assert_eq!(body.mass, get::<f64>(link, "mass"));
            assert_close(
                name,
                body.com.as_slice(),
                &get::<[f64; 3]>(link, "com"),
                0.0,
            );
            let t = &link["inertia_about_com"];
            for (row, column, key) in [
                (0, 0, "ixx"),
                (0, 1, "ixy"),
                (0, 2, "ixz"),
                (1, 1, "iyy"),
                (1, 2, "iyz"),
                (2, 2, "izz"),
            ] {
                assert_close(key, &[body.inertia[(row, column)]], &[get(t, key)], 1e-15);
                assert_eq!(body.inertia[(row, column)], body.inertia[(column, row)]);
            }
        }
    }
}

#[test]
fn collision_capsules_come_back_from_cylinders_and_balls() {
    let figures = vectors("cs_figures.json");
    for name in RobotModel::names() {
        let arm = RobotModel::built_in(name).unwrap();
        let links = figures["models"][name]["links"].as_object().unwrap();
        let order = [
            "base_link_inertia",
            "shoulder_link",
            "upperarm_link",
            "forearm_link",
            "wrist_1_link",
            "wrist_2_link",
            "wrist_3_link",
        ];
        for (index, link) in order.iter().enumerate() {
            let wanted = cases(&links[*link], "capsules");
            let mut found = arm.collision().capsules(index).to_vec();
            assert_eq!(found.len(), wanted.len(), "{name} {link}");
            for capsule in wanted {
                let (p0, p1): ([f64; 3], [f64; 3]) = (get(capsule, "p0"), get(capsule, "p1"));
                let radius: f64 = get(capsule, "radius");
                found.retain(|c| {
                    let off = (c.p0 - nalgebra::Vector3::from(p0))
                        .amax()
                        .max((c.p1 - nalgebra::Vector3::from(p1)).amax());
                    !(off < 1e-8 && c.radius == radius)
                });
            }
            assert!(
                found.is_empty(),
                "{name} {link}: {found:?} is not in the table"
            );
        }
        // Neighbours and the two pairs that cannot meet are left out of the 21.
        assert_eq!(arm.collision().tested_pairs().len(), 21 - 6 - 2);
    }
}

#[test]
fn denavit_hartenberg_tables_are_those_of_the_figures() {
    let figures = vectors("cs_figures.json");
    for name in RobotModel::names() {
        let dh = RobotModel::built_in(name).unwrap().dh().unwrap();
        let length = |key: &str| get::<f64>(&figures["models"][name]["dh"], key);
        assert_eq!(
            dh.d,
            [
                length("d1"),
                0.0,
                0.0,
                length("d4"),
                length("d5"),
                length("d6")
            ]
        );
        assert_eq!(dh.a, [0.0, length("a2"), length("a3"), 0.0, 0.0, 0.0]);
        assert_eq!(dh.alpha, [FRAC_PI_2, 0.0, 0.0, FRAC_PI_2, -FRAC_PI_2, 0.0]);
        let modified = dh.modified();
        assert_eq!(modified.a, [0.0, 0.0, length("a2"), length("a3"), 0.0, 0.0]);
        assert_eq!(
            modified.alpha,
            [0.0, FRAC_PI_2, 0.0, 0.0, FRAC_PI_2, -FRAC_PI_2]
        );
        assert_eq!(modified.d, dh.d);
    }
}

#[test]
fn unknown_names_are_answered_with_the_known_ones() {
    let message = RobotModel::open("cs67").unwrap_err().to_string();
    assert!(
        message.contains("`cs67`") && message.contains("cs63, cs66, cs612"),
        "{message}"
    );
    for name in ["CS618", "cs68", "CS616-9"] {
        assert!(
            matches!(
                RobotModel::open(name),
                Err(ModelError::UnsupportedModel { .. })
            ),
            "{name}"
        );
    }
    assert_eq!(RobotModel::open("CS66").unwrap().name(), "cs66");
}

#[test]
fn a_file_gives_the_same_arm_as_the_name() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/cs612/cs612.urdf");
    let arm = RobotModel::open(path).unwrap();
    assert_eq!(arm.chain(), RobotModel::built_in("cs612").unwrap().chain());
    let missing = RobotModel::open("/no/such/arm.urdf")
        .unwrap_err()
        .to_string();
    assert!(missing.contains("/no/such/arm.urdf"), "{missing}");
}

/// The message for the CS66 with one piece of text replaced.
#[track_caller]
fn complaint(from: &str, to: &str) -> String {
    assert!(CS66.contains(from), "nothing to replace: {from}");
    RobotModel::from_urdf(&CS66.replacen(from, to, 1))
        .unwrap_err()
        .to_string()
}

#[test]
fn files_that_are_no_six_joint_arm_are_refused_with_the_reason() {
    let cases = [
        (
            r#"name="wrist_3_joint" type="revolute""#,
            r#"name="wrist_3_joint" type="fixed""#,
            "5 revolute joints",
        ),
        (
            r#"name="elbow_joint" type="revolute""#,
            r#"name="elbow_joint" type="prismatic""#,
            "`elbow_joint` is prismatic",
        ),
        (
            r#"name="elbow_joint" type="revolute""#,
            r#"name="elbow_joint" type="continuous""#,
            "give it limits",
        ),
        (
            r#"<parent link="forearm_link"/>"#,
            r#"<parent link="upperarm_link"/>"#,
            "must not branch",
        ),
        (
            r#"<parent link="forearm_link"/>"#,
            r#"<parent link="nowhere"/>"#,
            "`nowhere`, which does not exist",
        ),
        (
            r#"<parent link="base_link"/>"#,
            r#"<parent link="tool0"/>"#,
            "not connected",
        ),
        (
            r#"<link name="flange"/>"#,
            r#"<link name="flange"/><link name="flange"/>"#,
            "two links `flange`",
        ),
        (
            r#"<link name="flange"/>"#,
            r#"<link name="flange"/><link name="loose"/>"#,
            "not connected",
        ),
        (
            r#"<axis xyz="0 0 1"/>"#,
            r#"<axis xyz="0 0 0"/>"#,
            "no direction",
        ),
        (
            r#"<mass value="4.521"/>"#,
            r#"<mass value="-1"/>"#,
            "mass of -1 kg",
        ),
        (
            r#"<mass value="4.521"/>"#,
            r#"<mass value="nan"/>"#,
            "mass of NaN kg",
        ),
        (r#"ixx="0.012014"#, r#"ixx="0.9"#, "no rigid body has"),
        (
            r#"velocity="3.14"#,
            r#"velocity="-3.14"#,
            "velocity limit of -3.14",
        ),
        (
            r#"lower="-6.28"#,
            r#"lower="16.28"#,
            "a lower one below an upper one",
        ),
        (r#"radius="0.0806""#, r#"radius="0""#, "radius of 0 m"),
        (r#"type="6206""#, r#"type="CS66""#, "not a number"),
        (
            r#"rated_payload="6""#,
            r#"rated_payload="-6""#,
            "must be a positive number",
        ),
        (
            r#"joint="elbow_joint" limit"#,
            r#"joint="elbow" limit"#,
            "`elbow`, which is not one of the six",
        ),
        (
            r#"link1="base_link_inertia""#,
            r#"link1="base""#,
            "`base`, which does not exist",
        ),
        (
            "<never_collide",
            "<never_colide",
            "<never_colide> is not known",
        ),
        ("</robot>", "", "not well-formed"),
    ];
    for (from, to, expected) in cases {
        let message = complaint(from, to);
        assert!(message.contains(expected), "{to}: {message}");
    }
    let deep = "<robot>".to_owned() + &"<a>".repeat(100_000);
    assert!(matches!(
        RobotModel::from_urdf(&deep),
        Err(ModelError::TooDeep { .. })
    ));
    assert!(matches!(
        RobotModel::from_urdf(&" ".repeat(5 << 20)),
        Err(ModelError::TooLarge { .. })
    ));
    for text in [
        "",
        "not xml",
        "<robot/>",
        "<robot name='x'><link name='a'/></robot>",
    ] {
        RobotModel::from_urdf(text).unwrap_err();
    }
}

#[test]
fn what_a_file_leaves_open_is_said() {
    let bare = CS66
        .replacen(
            r#"<joint_acceleration joint="elbow_joint" limit="10"/>"#,
            "",
            1,
        )
        .replacen(
            r#"<geometry><sphere radius="0.0806"/></geometry>"#,
            r#"<geometry><mesh filename="base.stl"/></geometry>"#,
            1,
        );
    let arm = RobotModel::from_urdf(&bare).unwrap();
    assert_eq!(arm.warnings().len(), 2);
    assert!(
        arm.warnings()
            .iter()
            .any(|w| w.english().contains("elbow_joint"))
    );
    assert!(
        arm.warnings()
            .iter()
            .any(|w| w.english().contains("base.stl"))
    );
}

#[test]
fn what_is_fixed_to_a_link_adds_to_its_mass() {
    let gripper = r#"<link name="gripper"><inertial><origin xyz="0 0 0.1"/><mass value="2"/>
        <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <joint name="grip" type="fixed"><origin xyz="0 0 0.05"/><parent link="tool0"/>
        <child link="gripper"/></joint></robot>"#;
    let arm = RobotModel::from_urdf(&CS66.replacen("</robot>", gripper, 1)).unwrap();
    let plain = RobotModel::built_in("cs66").unwrap();
    let payload =
        kinematics::Payload::new(2.0, [0.0, 0.0, 0.15], [0.01, 0.01, 0.01, 0.0, 0.0, 0.0]).unwrap();
    let gravity = kinematics::GRAVITY_UPRIGHT;
    let at = JointPositions([0.1, -1.0, 1.2, 0.3, 0.4, 0.5]);
    assert_close(
        "gravity",
        &arm.dynamics(&kinematics::Payload::NONE, gravity)
            .gravity_torques(&at)
            .0,
        &plain.dynamics(&payload, gravity).gravity_torques(&at).0,
        1e-12,
    );
    assert_eq!(arm.flange_pose(&at), plain.flange_pose(&at));
}

/// The CS66 turned on its base, with a turned tool frame, as other vendors describe their arms.
#[test]
fn a_turned_base_and_flange_keep_the_closed_form() {
    let turned = CS66
        .replacen(
            r#"<origin xyz="0 0 0" rpy="0 0 0"/>
    <parent link="base_link"/>"#,
            r#"<origin xyz="0 0 0.5" rpy="0 0 3.141592653589793"/>
    <parent link="base_link"/>"#,
            1,
        )
        .replacen(
            r#"<origin xyz="0 0 0" rpy="0 0 0"/>
    <parent link="flange"/>"#,
            r#"<origin xyz="0 0 0" rpy="1.5707963267948966 0 1.5707963267948966"/>
    <parent link="flange"/>"#,
            1,
        );
    let arm = RobotModel::from_urdf(&turned).unwrap();
    assert_ne!(arm.chain(), RobotModel::built_in("cs66").unwrap().chain());
    assert!(matches!(arm.ik_method(), IkMethod::ClosedForm(_)));
    assert_eq!(arm.dh(), None, "the table has no place for the turns");
    let at = JointPositions([0.1, -1.0, 1.2, 0.3, 0.4, 0.5]);
    let pose = arm.flange_pose(&at);
    let back = arm.inverse_nearest(&pose, &Pose::IDENTITY, &at).unwrap();
    assert!(back.distance_squared(&at) < 1e-20);
}

/// The vendor writes pi/2 as 1.570796326589793.
#[test]
fn a_nearly_right_arm_is_solved_exactly_for_what_it_is() {
    let misprinted = CS66.replace("1.5707963267948966", "1.570796326589793");
    let calibrated = CS66
        .replace(r#"xyz="-0.427 0 0""#, r#"xyz="-0.4283 0.0004 0""#)
        .replace(
            r#"rpy="1.5707963267948966 0 0""#,
            r#"rpy="1.5712 0.0003 -0.0002""#,
        );
    for text in [misprinted, calibrated] {
        let arm = RobotModel::from_urdf(&text).unwrap();
        assert!(
            matches!(arm.ik_method(), IkMethod::RefinedClosedForm(_)),
            "{:?}",
            arm.ik_method()
        );
        let truth = vectors("truth.json");
        for case in cases(&truth["models"]["cs66"], "fk").iter().take(30) {
            let pose = arm.flange_pose(&q(case));
            let found = arm.inverse_all(&pose, &Pose::IDENTITY);
            assert!(
                !found.is_empty(),
                "{case} {}",
                arm.chain().parent_from_joint[4].rotation
            );
            for solution in &found {
                let off = arm.flange_pose(solution);
                assert!((off.translation - pose.translation).amax() < 1e-10);
                assert!((off.rotation.matrix() - pose.rotation.matrix()).amax() < 1e-10);
            }
            let near = arm
                .inverse_nearest(&pose, &Pose::IDENTITY, &q(case))
                .unwrap();
            assert!(near.distance_squared(&q(case)) < 1e-14, "{near:?}");
        }
    }
}

#[test]
fn an_arm_of_another_shape_is_solved_by_iteration() {
    // The last axis along x: no two wrist axes at right angles any more.
    let other = CS66.replace(
        r#"<child link="wrist_3_link"/>
    <axis xyz="0 0 1"/>"#,
        r#"<child link="wrist_3_link"/>
    <axis xyz="0.6 0 0.8"/>"#,
    );
    let arm = RobotModel::from_urdf(&other).unwrap();
    assert_eq!(*arm.ik_method(), IkMethod::Iterative);
    let at = JointPositions([0.3, -1.2, 1.9, -0.7, 1.5, 0.2]);
    let pose = arm.flange_pose(&at);
    let near = JointPositions(at.0.map(|x| x + 0.1));
    let found = arm.inverse_nearest(&pose, &Pose::IDENTITY, &near).unwrap();
    assert!(found.distance_squared(&at) < 1e-16, "{found:?}");
    let all = arm.inverse_all(&pose, &Pose::IDENTITY);
    assert!(!all.is_empty());
    for solution in &all {
        assert!((arm.flange_pose(solution).translation - pose.translation).amax() < 1e-9);
    }
    let outside = Pose::from_translation(9.0, 0.0, 0.0);
    assert!(
        arm.inverse_nearest(&outside, &Pose::IDENTITY, &near)
            .is_none()
    );
}

#[test]
fn an_axis_that_is_not_z_turns_about_itself() {
    let text = CS66.replacen(r#"<axis xyz="0 0 1"/>"#, r#"<axis xyz="0 0 -1"/>"#, 1);
    let arm = RobotModel::from_urdf(&text).unwrap();
    let plain = RobotModel::built_in("cs66").unwrap();
    let at = JointPositions([0.4, -1.0, 1.2, 0.3, 0.4, 0.5]);
    let mut mirrored = at;
    mirrored[0] = -at[0];
    let off = arm.flange_pose(&at).translation - plain.flange_pose(&mirrored).translation;
    assert!(off.amax() < 1e-12, "{off}");
    let torques = |arm: &RobotModel, q: &JointPositions| {
        arm.dynamics(&kinematics::Payload::NONE, kinematics::GRAVITY_UPRIGHT)
            .gravity_torques(q)
    };
    assert_close(
        "gravity",
        &torques(&arm, &at).0,
        &torques(&plain, &mirrored).0,
        1e-9,
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn damaged_files_never_panic(at in 0..CS66.len(), length in 0_usize..200, with in "[<>/\"a-z0-9 .=-]{0,12}") {
        prop_assume!(CS66.is_char_boundary(at));
        let end = (at + length).min(CS66.len());
        prop_assume!(CS66.is_char_boundary(end));
        let mut text = CS66.to_owned();
        text.replace_range(at..end, &with);
        let _ = RobotModel::from_urdf(&text);
    }
}
