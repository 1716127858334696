//! A motion of one figure put onto another.

mod bodies;
mod feet;
mod figure;
mod hostile;
mod rest_poses;
