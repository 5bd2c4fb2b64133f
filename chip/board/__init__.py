"""What is on the pins of the chip: shaft, report port, radar modules, motor driver, encoder."""
