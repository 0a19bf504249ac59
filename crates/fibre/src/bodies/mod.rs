//! Rigid bodies that rods run into, and rods that run into each other (Sutherland 2012 §4.3). The thesis tests rod vertices
//! against bodies and resolves elastic collisions after every step until none is left or a limit is reached. Here the rods
//! between the vertices are tested too, bodies may be free, and rods that no bond connects collide.
//!
//! For the explicit solver contacts are impulses that act on both sides at one point: linear and angular momentum of rods
//! and free bodies are conserved to rounding, and without friction and with restitution 1 so is energy. For solvers that
//! look for equilibrium contacts are penalty springs. Everything runs in order of edges, then bodies, on one thread, so that
//! results do not depend on the number of threads.
//!
//! Rods slide on each other without friction: an impulse across the line between two axes would need the rods' spin to
//! conserve the angular momentum.
//!
//! | module | content |
//! |---|---|
//! | `shape`, `body` | [`Shape`], [`Body`], and bodies in motion |
//! | `system` | [`Bodies`]: all bodies of a world, and which edges are near them |
//! | `state` | what checkpoints hold of bodies |
//! | `contact_point` | a contact between edges or bodies |
//! | `gather` | contacts with bodies; `rod_pairs`: contacts between rods; `segments`: their closest points |
//! | `impulses` | contacts resolved by impulses |
//! | `springs` | contacts as springs; `crushing`: what they bear |
//! | `contacts` | [`crate::Contacts`] for [`Bodies`] |

mod body;
mod contact_point;
mod contacts;
mod crushing;
mod displacement;
mod error;
mod gather;
mod impulses;
mod rod_pairs;
mod segments;
mod shape;
mod springs;
pub(crate) mod state;
mod system;

pub use body::{Body, BodyMotion};
pub use error::BodyError;
pub use shape::{Shape, Surface};
pub use state::{BodiesState, BodyImpulse, BodyState, ContactLedger, ContactsState};
pub(crate) use system::clearance;
pub use system::{Bodies, ContactOptions};
