//! Tests of the estimator, and of its parts on the echoes of a known staircase.

mod accuracy;
mod cloud;
mod gauss;
mod likelihood;
mod readings;
mod weighing;
