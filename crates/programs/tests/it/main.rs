//! The tests of programs, in one binary; those that compensate or judge one are the root package's.

mod support;

mod arcs;
mod centre_path;
mod composed_frames;
mod contours;
mod dialect_cycles;
mod dialect_errors;
mod dialect_properties;
mod dialects;
mod five_axis;
mod gcode_cycles;
mod gcode_errors;
mod gcode_expanded;
mod gcode_modes;
mod gcode_properties;
mod gcode_readings;
mod gcode_round_trip;
mod gcode_second_reading;
mod gcode_words;
mod gcode_writing;
mod heidenhain_programs;
mod inclined_planes;
mod krl_expanded;
mod krl_splines;
mod pieces;
mod plane_kinds;
mod robot_expanded;
mod robot_programs;
mod rotary_axes;
mod sinumerik_programs;
mod split_words;
mod tool_comments;
mod toolpaths;
