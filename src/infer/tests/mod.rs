//! The estimator as a whole, and its parts on echoes that a known staircase made.

mod cloud;
mod gauss;
mod likelihood;
mod readings;
mod weighing;
