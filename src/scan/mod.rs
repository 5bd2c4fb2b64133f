//! Schedule of angles, mirror motor, radar link, and the loop that ties them to the stages.
