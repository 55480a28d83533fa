//! Tasks, script threads and the robot builtins.
