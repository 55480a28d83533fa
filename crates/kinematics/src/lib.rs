//! Poses, robot models, kinematics and dynamics of six-axis arms.
