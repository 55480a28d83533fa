//! Examples at the end of the help texts of commands.

pub(super) const SERVE: &str = "\
Examples:
  eliteserver serve                            the page is at http://127.0.0.1:8080/
  eliteserver serve --model cs612 --cell cell.toml
  eliteserver serve --bind 0.0.0.0 --record-rotate 8h --record-budget 20GB";
pub(super) const RUN: &str = "\
Examples:
  eliteserver run pick.script
  eliteserver run pick.script --set speed=0.25 --record pick.mcap
  eliteserver run pick.script --cell cell.toml --timeout 120";
pub(super) const CHECK: &str = "\
Examples:
  eliteserver check pick.script
  eliteserver check programs/                  every *.script below the folder
  eliteserver check --model cs66 --language zh pick.script";
pub(super) const TEST: &str = "\
Examples:
  eliteserver test
  eliteserver test tests/ -k gripper --timeout 120
  eliteserver test --junit results.xml --record-failed failed/";
pub(super) const DEBUG: &str = "\
Examples:
  eliteserver debug pick.script --cell cell.toml
  eliteserver debug pick.mcap                  a recording, backwards as well
  eliteserver debug --port 4711                for an editor";
pub(super) const REPLAY: &str = "\
Examples:
  eliteserver replay pick.mcap
  eliteserver replay pick.mcap --find 'norm(tcp_force[0:3]) > 20'
  eliteserver replay pick.mcap --plot pick.png --from 10 --to 20
  eliteserver replay pick.mcap --serve         on the page, as if live";
pub(super) const BUILTINS: &str = "\
Examples:
  eliteserver builtins movej
  eliteserver builtins blend radius
  eliteserver builtins --language zh 力";
pub(super) const SEND: &str = "\
Examples:
  eliteserver send pick.script
  eliteserver send pick.script --robot 192.168.1.10 --yes";
pub(super) const SHELL: &str = "\
Examples:
  eliteserver shell
  echo 'get_actual_tcp_pose()' | eliteserver shell";
pub(super) const CALIBRATE: &str = "\
Examples:
  eliteserver calibrate --robot 192.168.1.10 --out arm.toml";
pub(super) const RECORD: &str = "\
Examples:
  eliteserver record --robot 192.168.1.10 --out real.mcap --duration 30";
pub(super) const COMPARE: &str = "\
Examples:
  eliteserver compare real.mcap simulated.mcap --within 0.02
  eliteserver compare real.mcap --run pick.script --plot both.png";
pub(super) const DOCTOR: &str = "\
Examples:
  eliteserver doctor
  eliteserver doctor --config robot.toml --format json";
pub(super) const COMPLETIONS: &str = "\
Examples:
  eliteserver completions bash > ~/.local/share/bash-completion/completions/eliteserver";
pub(super) const FLEET: &str = "\
Examples:
  eliteserver fleet cell.toml --check
  eliteserver fleet cell.toml";
pub(super) const WAIT: &str = "\
Examples:
  eliteserver serve & eliteserver wait && eliteserver send pick.script";
pub(super) const IDENTIFY: &str = "\
Examples:
  eliteserver identify payload excite.mcap
  eliteserver identify friction excite.mcap -o arm.toml
  eliteserver identify tool touch.mcap --orientation --format json";
pub(super) const EXCITE: &str = "\
Examples:
  eliteserver excite payload --cell cell.toml -o excite.script
  eliteserver excite friction --speed 0.5 -o excite.script";
pub(super) const IMPORT: &str = "\
Examples:
  eliteserver import part.ngc --frame -0.5,-0.2,0.1,0,0,0 --check -o part.script
  eliteserver import plate.dxf --layer CUT --lead-in 0.02 -o plate.script";
pub(super) const TRANSLATE: &str = "\
Examples:
  eliteserver translate pick.urscript -o pick.script --report pick.md";
