//! One machine inspected: at a point (`point`), as a whole (`check`).

pub mod machine_check;
pub mod point;
