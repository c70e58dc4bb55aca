//! The material point method against closed forms and exact symmetries; each test states its error.

mod account;
mod bits;
mod common;
mod elastic;
mod hard;
