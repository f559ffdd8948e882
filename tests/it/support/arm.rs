//! A machine whose drives control all six coordinates.

/// A six-axis arm with elastic drives and an elastic forearm.
pub const ARM: &str = r#"
schema = 1
name = "arm"
title = "Six-axis arm with elastic drives and an elastic forearm"

[platform]
tool_tip_mm = [0.0, 0.0, 100.0]
controls = ["x", "y", "z", "rotation_x", "rotation_y", "rotation_z"]

[home]
position_mm = [730.0, 0.0, 420.0]

[workspace]
min_mm = [500.0, -200.0, 300.0]
max_mm = [800.0, 200.0, 500.0]

[[chain]]
name = "arm"
elements = [
  { revolute_drive = { name = "j1", axis = "z", stiffness_Nmm_per_rad = 2e9 } },
  { fixed = { translation_mm = [0.0, 0.0, 400.0] } },
  { revolute_drive = { name = "j2", axis = "y", stiffness_Nmm_per_rad = 2e9, home_deg = -30.0 } },
  { fixed = { translation_mm = [0.0, 0.0, 450.0] } },
  { revolute_drive = { name = "j3", axis = "y", stiffness_Nmm_per_rad = 1e9, home_deg = 70.0 } },
  { link = { advance_mm = 420.0, stiffness_N_mm_rad = [
    [1e5, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 2e4, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 2e4, 0.0, 0.0, 0.0],
    [0.0, 0.0, 0.0, 5e8, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 8e8, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 8e8]] } },
  { revolute_drive = { name = "j4", axis = "x", stiffness_Nmm_per_rad = 5e8, home_deg = 10.0 } },
  { revolute_drive = { name = "j5", axis = "y", stiffness_Nmm_per_rad = 5e8, home_deg = -40.0 } },
  { fixed = { translation_mm = [90.0, 0.0, 0.0] } },
  { revolute_drive = { name = "j6", axis = "x", stiffness_Nmm_per_rad = 3e8 } },
]

[[mount]]
name = "arm"
chain = "arm"
"#;
