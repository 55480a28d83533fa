//! Programs and toolpaths from elsewhere as EliteScript, text to text.
//!
//! Knows no robot, no file and no port: a text goes in, a text and remarks about it come out.
//!
//! # A program of Universal Robots
//!
//! ```
//! use program_import::translate;
//!
//! let program = "def demo():\n  set_digital_out(1, True)\n  movel(p[0.1, -0.4, 0.3, 3.14159, 0, 0], v=0.1)\nend\n";
//! let translation = translate::translate(program, "demo.urscript").unwrap();
//! assert!(translation.is_complete());
//! assert!(translation.text.ends_with(
//!     "set_standard_digital_out(1, True)\nmovel([0.1, -0.4, 0.3, 3.14159, 0, 0], v=0.1)\n"
//! ));
//! ```
//!
//! # A toolpath
//!
//! ```
//! use program_import::toolpath::{StepKind, gcode};
//!
//! let path = gcode::read("G21 G90\nG1 X10 F600\nG2 X20 Y10 R10\n", 1e-5).unwrap();
//! assert_eq!(path.steps[0].kind, StepKind::Speed(0.01));
//! assert_eq!(path.steps[1].kind, StepKind::Line([0.01, 0.0, 0.0]));
//! assert!(matches!(path.steps[2].kind, StepKind::Arc { to, .. } if to == [0.02, 0.01, 0.0]));
//! ```

pub mod toolpath;
pub mod translate;
pub mod urscript;
