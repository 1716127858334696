//! Retargeting of motions from one figure to another.

mod bodies;
mod feet;
mod figure;
mod findings;
mod hands;
mod hostile;
mod rest_poses;
mod self_contact;
