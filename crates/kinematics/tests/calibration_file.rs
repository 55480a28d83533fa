//! The calibration file: what is read, what is refused, and in which words.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use kinematics::{Calibration, CalibrationError};
use std::path::Path;

const GOOD: &str = "model = 'cs66'
[modified_dh]
a = [0, 0, -0.42752, -0.391601, 0, 0]
d = [0.160861, 0, 0, 0.147568, 0.0964976, 0.112116]
alpha = [0, 1.5708, 0, 0, 1.5708, -1.5708]
";

fn open(text: &str) -> Result<kinematics::RobotModel, CalibrationError> {
    Calibration::from_text(text, Path::new("arm.toml"))?.open()
}

fn error(text: &str) -> String {
    open(text).unwrap_err().to_string()
}

/// `GOOD` with one line replaced.
fn with(key: &str, line: &str) -> String {
    let lines = GOOD.lines().map(|old| {
        let is_it = old.split('=').next().is_some_and(|k| k.trim() == key);
        if is_it { line } else { old }
    });
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn a_good_file_is_read_and_written_back_bit_for_bit() {
    let read = |text: &str| Calibration::from_text(text, Path::new("arm.toml")).unwrap();
    let first = read(GOOD);
    assert_eq!(first.model(), "cs66");
    assert_eq!(first.theta(), &[0.0; 6]);
    assert_eq!(first, read(&first.to_toml()));
    let odd = with(
        "alpha",
        "alpha = [1e-7, 1.5707963267948966, -0.0, 2e-3, 1.5708, -1.5708]\n\
         theta = [0.1, -1e-300, 0, 0, 0, 0.0123456789012345678]",
    );
    let odd = read(&odd);
    assert_eq!(odd, read(&odd.to_toml()));
    let bits = |c: &Calibration| c.modified_dh().alpha.map(f64::to_bits);
    assert_eq!(bits(&odd), bits(&read(&odd.to_toml())));
}

#[test]
fn what_is_wrong_is_said_with_file_table_and_key() {
    let wrong = [
        (
            with("a", "a = [0, 0, -0.4, -0.39, 0]"),
            "[modified_dh] has a = [0, 0, -0.4, -0.39, 0]; six lengths in m are needed, these are 5",
        ),
        (
            with("a", ""),
            "[modified_dh] has no `a`; six lengths in m are needed",
        ),
        (
            with("d", "d = [0.16, nan, 0, 0.147, 0.0965, 0.112]"),
            "[modified_dh] has d[1] = NaN; finite numbers are needed",
        ),
        (
            with("d", "d = [0.16, 'x', 0, 0.147, 0.0965, 0.112]"),
            "[modified_dh] has d[1] = \"x\"; a number is needed",
        ),
        (
            with("d", "d = 3"),
            "[modified_dh] has d = 3; a list of six lengths in m is needed",
        ),
        (
            with("alpha", "beta = [0, 0, 0, 0, 0, 0]"),
            "[modified_dh] has an unknown key `beta`; the keys are a, d, alpha and optionally theta",
        ),
        (
            with("model", "models = 'cs66'"),
            "the file has an unknown key `models`; the keys are model and [modified_dh]",
        ),
        (with("model", ""), "the file has no `model`"),
        (
            with("model", "model = 66"),
            "the file has model = 66; a name as \"cs66\" is needed",
        ),
        (
            with("model", "model = 'cs67'"),
            "model = \"cs67\": there is no built-in robot model",
        ),
        ("model = 'cs66'".to_owned(), "the file has no `modified_dh`"),
        (with("a", "a = [0, 0"), "is not TOML"),
        (
            format!("{GOOD}\ntheta = [0, 0, 0, 0, 0, inf]"),
            "[modified_dh] has theta[5] = inf",
        ),
    ];
    for (text, sentence) in wrong {
        let error = error(&text);
        assert!(error.starts_with("arm.toml"), "{error}");
        assert!(error.contains(sentence), "{error}\n instead of {sentence}");
    }
}

#[test]
fn numbers_far_from_the_models_are_refused_with_a_guess_at_why() {
    let far = [
        (
            with("a", "a = [0, 0, -0.615, -0.571, 0, 0]"),
            "a[2] = -0.615; the cs66 has -0.427 m there",
        ),
        (
            with("d", "d = [162.5, 0, 0, 147.5, 96.5, 92]"),
            "d[0] = 162.5; the cs66 has 0.1625 m there, and a measured arm is within 0.05 m of it; this looks like mm",
        ),
        (
            with("d", "d = [0.1625, 0, 0, 147.5, 0.0965, 0.092]"),
            "d[1] + d[2] + d[3] = 147.5; the cs66 has 0.1475 m there, and a measured arm is within 0.05 m of it; \
             this looks like mm",
        ),
        (
            with("alpha", "alpha = [0, 90, 0, 0, 90, -90]"),
            "alpha[1] = 90; the cs66 has 1.5707963267948966 rad there, and a measured arm is within 0.1 rad of it; \
             this looks like degrees",
        ),
        (
            with("a", "a = [0, -0.427, -0.3905, 0, 0, 0]"),
            "a looks like the standard layout",
        ),
        (
            with("alpha", "alpha = [1.5708, 0, 0, 1.5708, -1.5708, 0]"),
            "alpha looks like the standard layout",
        ),
        (
            format!("{GOOD}\ntheta = [0, 0, 3.14, 0, 0, 0]"),
            "theta[2] = 3.14; the cs66 has 0 rad there",
        ),
        (
            with("d", "d = [0.1625, 5, -5, 0.1475, 0.0965, 0.092]")
                .replace("1.5708, 0, 0,", "1.5708, 0.05, 0,"),
            "d[1] = 5; with alpha[2] = 0.05 it puts the axis of joint 3",
        ),
    ];
    for (text, sentence) in far {
        let error = error(&text);
        assert!(error.starts_with("arm.toml: [modified_dh] has "), "{error}");
        assert!(error.contains(sentence), "{error}\n instead of {sentence}");
    }
}

#[test]
fn the_model_that_counts_is_the_files() {
    let calibration = Calibration::from_text(GOOD, Path::new("arm.toml")).unwrap();
    assert_eq!(calibration.model_for(None).unwrap(), "cs66");
    assert_eq!(calibration.model_for(Some("CS66")).unwrap(), "cs66");
    let error = calibration.model_for(Some("cs63")).unwrap_err().to_string();
    assert_eq!(
        error,
        "the calibration file arm.toml is for the model cs66, but the model cs63 is asked for; leave the model out, \
         or give cs66"
    );
    let missing = Calibration::load(Path::new("/nowhere/arm.toml")).unwrap_err();
    assert!(
        missing
            .to_string()
            .starts_with("cannot read the calibration file /nowhere/arm.toml"),
        "{missing}"
    );
}
