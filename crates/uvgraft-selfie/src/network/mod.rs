//! Small convolutional networks, run on the CPU.
