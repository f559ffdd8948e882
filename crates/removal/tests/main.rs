//! Removal and engagement against closed forms, brute force and exact booleans.

mod closed_forms;
mod patches;
mod paths;
mod properties;
mod regions;
mod split;
mod stock;
mod surface;
mod volumes;
