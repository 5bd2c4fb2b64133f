"""An STM32F405 at the level of its registers, around Unicorn's Cortex-M4.

`chip.Chip` is the whole chip; `core` executes instructions and exceptions; each other module is one
peripheral, its registers with their section of the reference manual RM0090.
"""
